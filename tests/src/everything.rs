//! Every light and every material in one room.

use glam::{Vec2, Vec3};
use midway_film::Image;
use midway_render::RenderSettings;
use midway_scene::{
    Channel, Image as Picture, Light, LightKind, Material, NormalMap, Opacity, ScalarInput, Scene, Sides,
    Surface, Texels, Texture,
};

use crate::{
    estimate::{cpu, render},
    integrators, lit,
    scenes::{SIZE, dielectric, rough_surfaces, smooth_surfaces},
    shapes::{Shape, add, camera, diffuse},
};

/// A room 4 wide, with a partition in its middle that stops short of the camera. To the left are all models
/// with delta lobes, below a lamp with a texture; to the right the rough ones, a lamp of both sides, points,
/// spots, and a window that the sun and a sky shine through. The partition keeps lights without an area
/// from what is smooth: a camera path finds no caustic of theirs, and all integrators are to agree.
pub struct Everything {
    /// The scene.
    pub scene: Scene,
    /// The materials with delta lobes, by which `light` sees nothing.
    smooth: Vec<usize>,
}

impl Everything {
    /// The pixels of a square film of [`SIZE`] that see nothing by way of a delta lobe: those that `light`
    /// sees.
    pub fn seen_by_light(&self) -> Vec<bool> {
        let mut marked = self.scene.clone();
        marked.lights.clear();
        marked.environment = None;
        for (number, material) in marked.materials.iter_mut().enumerate() {
            material.emission = Vec3::ZERO.into();
            if self.smooth.contains(&number) {
                *material = Material { emits: Sides::Both, ..diffuse(Vec3::ZERO, Vec3::ONE) };
            }
        }
        let settings = RenderSettings {
            width: SIZE as u32,
            height: SIZE as u32,
            integrator: integrators::path().settings,
            max_path_length: Some(1),
            ..RenderSettings::default()
        };
        let image: Image = render(&cpu(), &marked, &settings, 256);
        image.pixels.iter().map(|pixel| pixel.iter().all(|value| *value == 0.0)).collect()
    }
}

/// That room.
pub fn everything() -> Everything {
    let mut scene = Scene::default();
    let images = Pictures::add(&mut scene);
    add_walls(&mut scene, &images);
    let mut smooth = Vec::new();
    for (i, surface) in smooth_surfaces().into_iter().chain([dispersive_glass()]).enumerate() {
        if surface != Surface::Null {
            smooth.push(scene.materials.len());
        }
        add(&mut scene, Shape::icosphere(2, place(-1.0, i), 0.24), Material::new(surface));
    }
    for (i, surface) in rough_surfaces().into_iter().enumerate() {
        let mut material = Material::new(surface);
        // The metal and the coated one lean, by a map.
        let map = NormalMap { texture: Texture::new(images.leaning), scale: 1.0 };
        material.normal_map = [0, 3].contains(&i).then_some(map);
        add(&mut scene, Shape::icosphere(2, place(1.0, i), 0.24), material);
    }
    add_thin(&mut scene, Vec3::new(1.2, -0.9, 0.1), 0.4);
    smooth.push(scene.materials.len());
    add_thin(&mut scene, Vec3::new(-1.9, -0.2, -0.15), 0.0);
    add_sheets(&mut scene, &images);
    add_lights(&mut scene, &images);
    scene.cameras.push(camera(Vec3::new(0.05, 0.0, 0.95), Vec3::new(0.05, -0.1, 0.0), 86.0));
    Everything { scene, smooth }
}

/// Of the i-th ball on a side, x = ±1 in its middle: three to a row, all behind z = -0.1.
fn place(side: f32, i: usize) -> Vec3 {
    let x = [-0.6, 0.0, 0.6][i % 3];
    Vec3::new(side + x, [-0.65, -0.05, 0.5][i / 3], -0.45 + 0.1 * (i % 2) as f32)
}

fn dispersive_glass() -> Surface {
    let Surface::Dielectric { ior, reflection, transmission, sigma_a, thin, roughness, .. } =
        Surface::glass(1.5)
    else {
        unreachable!("glass is a dielectric")
    };
    Surface::Dielectric { ior, dispersion: 2.0, reflection, transmission, sigma_a, thin, roughness }
}

/// Numbers of the scene's images.
struct Pictures {
    /// Colours of a wall.
    colours: u32,
    /// A normal that leans.
    leaning: u32,
    /// A lamp's brightness.
    lamp: u32,
    /// What is there of a sheet, in alpha.
    holes: u32,
}

impl Pictures {
    fn add(scene: &mut Scene) -> Self {
        let mut add = |side: u32, texels: Vec<[f32; 4]>| {
            let texels = Texels::Float(texels.into());
            scene.images.push(Picture { name: String::new(), width: side, height: side, texels });
            scene.images.len() as u32 - 1
        };
        let shade = |i: usize| [0.2, 0.8, 0.5, 0.7, 0.4][i % 5];
        Self {
            colours: add(4, (0..16).map(|i| [shade(i), shade(i + 1), shade(i + 2), 1.0]).collect()),
            leaning: add(1, vec![[0.5 + 0.2, 0.5 - 0.15, 0.93, 1.0]]),
            lamp: add(2, [1.0, 0.5, 0.3, 0.8].map(|i| [i, 0.8 * i, 0.6, 1.0]).into()),
            holes: add(2, [1.0, 0.2, 0.4, 0.9].map(|alpha| [0.0, 0.0, 0.0, alpha]).into()),
        }
    }
}

/// A parallelogram with the corners of a texture at its own.
fn add_textured(scene: &mut Scene, [corner, u, v]: [Vec3; 3], material: Material) {
    add(scene, Shape::parallelogram(corner, u, v), material);
    if let Some(mesh) = scene.meshes.last_mut() {
        mesh.uvs[0] = vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO];
    }
}

fn add_walls(scene: &mut Scene, images: &Pictures) {
    let (least, most) = (Vec3::new(-2.0, -1.0, -1.0), Vec3::new(2.0, 1.0, 1.0));
    // Walls in the order -x, +x, -y, +y, -z, +z: in the one at +x there is a window.
    let (others, _) = Shape::cuboid(least, most).inside_out().split(|triangle| triangle / 2 != 1);
    let grey = diffuse(Vec3::new(0.6, 0.55, 0.5), Vec3::ZERO);
    add(scene, others, grey.clone());
    add(scene, Shape::parallelogram(Vec3::new(2.0, -1.0, -1.0), 2.0 * Vec3::Z, 1.3 * Vec3::Y), grey);
    let mut painted = diffuse(Vec3::ONE, Vec3::ZERO);
    let Surface::Diffuse { reflectance } = &mut painted.surface else { unreachable!("it is diffuse") };
    reflectance.texture = Some(Texture::new(images.colours));
    add_textured(scene, [Vec3::new(0.0, -1.0, -1.0), 2.0 * Vec3::Y, 1.2 * Vec3::Z], painted);
}

fn add_thin(scene: &mut Scene, corner: Vec3, alpha: f32) {
    let sheet = Shape::parallelogram(corner, 0.5 * Vec3::X, 0.4 * Vec3::Y);
    add(scene, sheet, Material::new(dielectric(true, alpha)));
}

/// What is there in part: by chance, or by a mask.
fn add_sheets(scene: &mut Scene, images: &Pictures) {
    let alpha = ScalarInput { value: 1.0, texture: Some((Texture::new(images.holes), Channel::A)) };
    let veil =
        Material { opacity: Opacity::Blend(alpha.clone()), ..diffuse(Vec3::new(0.8, 0.4, 0.3), Vec3::ZERO) };
    let grate = Material {
        opacity: Opacity::Mask(alpha, 0.5),
        scatters: Sides::Front,
        ..diffuse(Vec3::new(0.3, 0.4, 0.8), Vec3::ZERO)
    };
    add_textured(scene, [Vec3::new(-1.8, -0.9, -0.9), 0.8 * Vec3::X, 0.8 * Vec3::Y], veil.clone());
    add_textured(scene, [Vec3::new(1.5, -0.9, 0.0), 0.4 * Vec3::X, 0.6 * Vec3::Y], veil);
    add_textured(scene, [Vec3::new(0.3, 0.3, -0.95), 0.8 * Vec3::X, 0.6 * Vec3::Y], grate);
}

fn add_lights(scene: &mut Scene, images: &Pictures) {
    let mut lamp = diffuse(Vec3::ZERO, Vec3::splat(9.0));
    lamp.emission.texture = Some(Texture::new(images.lamp));
    add_textured(scene, [Vec3::new(-1.6, 0.95, -0.7), 1.2 * Vec3::X, 1.0 * Vec3::Z], lamp);
    let both = Material { emits: Sides::Both, ..diffuse(Vec3::splat(0.4), Vec3::new(1.0, 2.0, 3.0)) };
    let hanging = Shape::parallelogram(Vec3::new(1.2, 0.4, -0.6), 0.3 * Vec3::X, Vec3::new(0.0, 0.15, 0.3));
    add(scene, hanging, both);
    // All behind z = -0.3, as the balls are: the partition is between.
    let mut kinds = vec![
        LightKind::Point { position: Vec3::new(0.6, 0.7, -0.5), intensity: Vec3::new(0.2, 0.3, 0.4) },
        LightKind::Directional { direction: Vec3::new(-0.7, -0.7, 0.14), irradiance: Vec3::splat(1.5) },
    ];
    for (i, falloff) in lit::FALLOFFS.into_iter().enumerate() {
        kinds.push(LightKind::Spot {
            position: Vec3::new(0.5 + 0.6 * i as f32, 0.9, -0.35),
            direction: Vec3::new(0.0, -0.9, -0.3 + 0.2 * i as f32).normalize(),
            intensity: Vec3::new(0.8, 0.6, 0.1 + 0.3 * i as f32),
            inner_angle: 0.15,
            outer_angle: 0.5,
            falloff,
        });
    }
    scene.lights.extend(kinds.into_iter().map(|kind| Light { name: String::new(), kind, group: None }));
    lit::add_sky(scene);
}
