//! A scene for measuring that needs no file.

use glam::{Mat4, Quat, Vec3};
use midway_kernels::native;
use midway_scene::{Camera, Instance, Light, LightKind, Material, Mesh, Scene, Surface};

/// Rows of a ball; it has twice as many columns and two triangles a cell.
const ROWS: u32 = 16;
/// Triangles of a ball.
const BALL: u32 = ROWS * ROWS * 4;

/// Bumpy balls in a cubic lattice, jittered, `n_triangles` in all or up to a ball's 1024 more; the same
/// ones every time. Rays pass several balls before they meet one.
pub fn generated_scene(n_triangles: u32) -> Scene {
    let n_balls = n_triangles.div_ceil(BALL).max(1);
    let side = (1..).find(|side: &u32| side.pow(3) >= n_balls).unwrap_or(1);
    let mut mesh = Mesh { name: "balls".to_owned(), ..Mesh::default() };
    for ball in 0..n_balls {
        let place = Vec3::new((ball % side) as f32, (ball / side % side) as f32, (ball / side / side) as f32);
        let [x, y, z, size] = native::random4(ball, 0, 0, 0);
        add_ball(&mut mesh, place + 0.4 * Vec3::new(x, y, z), 0.15 + 0.2 * size, ball);
    }
    let mut scene = Scene {
        meshes: vec![mesh],
        instances: vec![Instance { mesh: 0, world_from_mesh: Mat4::IDENTITY, light_group: None }],
        materials: vec![Material::new(Surface::diffuse(Vec3::splat(0.7)))],
        ..Scene::default()
    };
    scene.cameras.push(Camera::framing(&scene.bounds(), 1.0));
    scene
}

/// `n` point lights in and around the scene; the sum of their power does not depend on `n`.
pub fn add_point_lights(scene: &mut Scene, n: u32) {
    let bounds = scene.bounds();
    let size = bounds.diagonal();
    let intensity = Vec3::splat(size.length_squared() / n.max(1) as f32);
    scene.lights.extend((0..n).map(|light| {
        let [x, y, z, _] = native::random4(light, 0, 0, 2);
        let position = bounds.centre() + 1.2 * size * (Vec3::new(x, y, z) - 0.5);
        Light { name: String::new(), kind: LightKind::Point { position, intensity }, group: None }
    }));
}

/// `n` small triangles that emit, every which way, in and around the scene; neither their area nor the
/// sum of their power depends on `n`.
pub fn add_lamps(scene: &mut Scene, n: u32) {
    let bounds = scene.bounds();
    let size = bounds.diagonal();
    let side = 0.1 * size.length() / (n.max(1) as f32).sqrt();
    let mut mesh =
        Mesh { name: "lamps".to_owned(), material: scene.materials.len() as u32, ..Mesh::default() };
    for lamp in 0..n {
        let [x, y, z, turn] = native::random4(lamp, 0, 0, 3);
        let [u, v, ..] = native::random4(lamp, 0, 0, 4);
        let place = bounds.centre() + 1.2 * size * (Vec3::new(x, y, z) - 0.5);
        let height = 2.0 * u - 1.0;
        let azimuth = std::f32::consts::TAU * v;
        let normal =
            Vec3::new(azimuth.cos(), azimuth.sin(), 0.0) * (1.0 - height * height).sqrt() + height * Vec3::Z;
        let along = normal.any_orthonormal_vector();
        let along = side * Quat::from_axis_angle(normal, std::f32::consts::TAU * turn).mul_vec3(along);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([place, place + along, place + normal.cross(along)]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let mut material = Material::new(Surface::diffuse(Vec3::ZERO));
    material.emission.value = Vec3::splat(400.0);
    scene.materials.push(material);
    scene.instances.push(Instance {
        mesh: scene.meshes.len() as u32,
        world_from_mesh: Mat4::IDENTITY,
        light_group: None,
    });
    scene.meshes.push(mesh);
}

fn add_ball(mesh: &mut Mesh, centre: Vec3, radius: f32, seed: u32) {
    let columns = 2 * ROWS;
    let first = mesh.positions.len() as u32;
    for row in 0..=ROWS {
        for column in 0..columns {
            let theta = std::f32::consts::PI * row as f32 / ROWS as f32;
            let phi = std::f32::consts::TAU * column as f32 / columns as f32;
            let bump = 0.9 + 0.2 * native::random4(seed, row, column, 1)[0];
            let direction = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            mesh.positions.push(centre + radius * bump * direction);
        }
    }
    for row in 0..ROWS {
        for column in 0..columns {
            let vertex = |row: u32, column: u32| first + row * columns + column % columns;
            let [a, b] = [vertex(row, column), vertex(row, column + 1)];
            let [c, d] = [vertex(row + 1, column), vertex(row + 1, column + 1)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
}
