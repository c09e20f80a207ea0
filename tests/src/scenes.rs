//! Scenes with known answers: the radiance of each pixel in closed form.

use glam::{Vec2, Vec3};
use midway_film::Image;
use midway_scene::{
    Channel, CoatNormal, ConductorFresnel, Filter, Image as Picture, Material, MetallicRoughness, NormalMap,
    Opacity, Roughness, ScalarInput, Scene, Surface, Texels, Texture,
};

use crate::{
    estimate::{Expected, combine},
    lit,
    shapes::{Shape, add, camera, diffuse, glass, mirror},
};

/// A scene and its image.
#[derive(Clone, Debug)]
pub struct Known {
    /// What it is, for messages.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// Its image, exact.
    pub expected: Expected,
    /// Whether the integrator `light` sees all of it: neither a specular surface nor the environment
    /// is in view.
    pub light_sees: bool,
    /// Whether `path-naive` does: all light comes from what a path can hit.
    pub naive_sees: bool,
}

/// Pixels along both sides: whole blocks.
pub const SIZE: usize = 32;

impl Known {
    /// A scene of area lights and environments; `radiance` at points of the film in [-1, 1]², y up.
    pub fn new(
        name: &'static str,
        scene: Scene,
        light_sees: bool,
        radiance: impl Fn(f64, f64) -> Vec3,
    ) -> Self {
        let mean = Image::from_fn(SIZE, SIZE, |x, y| pixel_mean(x, y, &radiance).to_array());
        Self { name, scene, expected: Expected { mean, standard_error: None }, light_sees, naive_sees: true }
    }
}

/// All of them.
pub fn all() -> Vec<Known> {
    vec![
        white_furnace(),
        specular_furnace(),
        closed_sphere(),
        closed_sphere_with_an_area_light(),
        facing_squares(),
        facing_squares_through_a_veil(),
        textured_squares(),
        mirror_box(),
        lamp_in_glass(),
        camera_in_glass(),
    ]
    .into_iter()
    .chain(lit::all())
    .collect()
}

/// The mean over a pixel of what is seen at points of the film in [-1, 1]², y up.
fn pixel_mean(x: usize, y: usize, radiance: impl Fn(f64, f64) -> Vec3) -> Vec3 {
    // Midpoints of 8 x 8 cells: for images as smooth as these an error below 1e-5.
    const CELLS: usize = 8;
    let place = |pixel: usize, cell: usize| {
        2.0 * (pixel as f64 + (cell as f64 + 0.5) / CELLS as f64) / SIZE as f64 - 1.0
    };
    let cells = (0..CELLS * CELLS).map(|i| radiance(place(x, i % CELLS), -place(y, i / CELLS)));
    cells.sum::<Vec3>() / (CELLS * CELLS) as f32
}

/// Radiance 1 everywhere, by surfaces that each emit what they do not reflect.
fn furnace(reflectance: Vec3) -> Material {
    diffuse(reflectance, Vec3::ONE - reflectance)
}

/// White furnace: a room and things in it, each emitting 1 - ρ. Radiance is 1 everywhere, whatever
/// the shapes. Diffuse things in view, a mirror and glass behind the camera.
pub fn white_furnace() -> Known {
    let mut scene = furnace_room();
    add(
        &mut scene,
        Shape::icosphere(1, Vec3::new(-0.4, -0.6, -0.4), 0.35),
        furnace(Vec3::new(0.9, 0.5, 0.2)),
    );
    let (least, most) = (Vec3::new(0.1, -1.0, -0.6), Vec3::new(0.5, -0.1, -0.2));
    add(&mut scene, Shape::cuboid(least, most), furnace(Vec3::splat(0.7)));
    add(&mut scene, Shape::icosphere(1, Vec3::new(-0.6, 0.3, 1.6), 0.25), mirror(1.0));
    add(&mut scene, Shape::icosphere(2, Vec3::new(0.6, -0.4, 1.6), 0.3), glass(1.5));
    Known::new("white furnace", scene, true, |_, _| Vec3::ONE)
}

/// White furnace with a mirror of reflectance 1 and clear glass in view.
pub fn specular_furnace() -> Known {
    let mut scene = furnace_room();
    add(&mut scene, Shape::icosphere(2, Vec3::new(-0.45, -0.5, -0.4), 0.4), mirror(1.0));
    add(&mut scene, Shape::icosphere(3, Vec3::new(0.45, -0.4, -0.2), 0.4), glass(1.5));
    Known::new("specular furnace", scene, false, |_, _| Vec3::ONE)
}

/// White furnace with a ball of glass in view that is rough along and nearly smooth across, by all bounces
/// between its facets or by single ones alone, which lose light.
pub fn stretched_furnace(single_bounce: bool) -> Known {
    let mut scene = furnace_room();
    let roughness = Roughness { along: 1.0.into(), across: 0.04.into(), squared: false, single_bounce };
    let mut surface = dielectric(false, 0.0);
    if let Surface::Dielectric { transmission, sigma_a, roughness: of_surface, .. } = &mut surface {
        (*transmission, *sigma_a, *of_surface) = (Vec3::ONE.into(), Vec3::ZERO, roughness);
    }
    let ball = Shape::icosphere(3, Vec3::new(0.0, 0.0, -0.1), 0.7);
    add(&mut scene, ball, Material::new(surface));
    Known::new("stretched furnace", scene, false, |_, _| Vec3::ONE)
}

fn furnace_room() -> Scene {
    let mut scene = Scene::default();
    let room = Shape::cuboid(Vec3::splat(-1.0), Vec3::new(1.0, 1.0, 2.0)).inside_out();
    add(&mut scene, room, furnace(Vec3::new(0.4, 0.5, 0.6)));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 1.2), Vec3::ZERO, 60.0));
    scene
}

/// Emission of [`closed_sphere`].
pub const SPHERE_EMISSION: [f32; 3] = [1.0, 0.5, 0.25];
/// Its albedo.
pub const SPHERE_ALBEDO: [f32; 3] = [0.8, 0.5, 0.2];

/// A closed surface, everywhere of emission Le and albedo ρ: radiance is Le / (1 - ρ). The camera is
/// inside, off the centre.
pub fn closed_sphere() -> Known {
    let (reflectance, emission) = (Vec3::from_array(SPHERE_ALBEDO), Vec3::from_array(SPHERE_EMISSION));
    let mut scene = Scene::default();
    add(&mut scene, Shape::icosphere(2, Vec3::ZERO, 1.0).inside_out(), diffuse(reflectance, emission));
    scene.cameras.push(camera(Vec3::new(0.3, 0.2, 0.1), -Vec3::Z, 70.0));
    Known::new("closed sphere", scene, true, move |_, _| emission / (Vec3::ONE - reflectance))
}

/// An integrating sphere: a twentieth of it emits Le. As every point of a sphere sees every other
/// alike, a wall that does not emit has radiance ρ / (1 - ρ) times the mean of Le over the sphere.
/// Of 5120 triangles: the mean over its walls is exact (all that is emitted lands), and facets of
/// 0.04 radians change the uniformity by their square.
pub fn closed_sphere_with_an_area_light() -> Known {
    let (reflectance, emission) = (Vec3::new(0.8, 0.5, 0.2), Vec3::new(20.0, 20.0, 40.0));
    let sphere = Shape::icosphere(4, Vec3::ZERO, 1.0).inside_out();
    // Cuts keep the triangles of a face together: this is one face of the icosahedron.
    let (lamp, wall) = sphere.split(|triangle| triangle < 256);
    let share = (lamp.area() / (lamp.area() + wall.area())) as f32;
    let [a, b, c] = [0, 1, 2].map(|i| lamp.positions[lamp.triangles[255][i] as usize]);
    let mut scene = Scene::default();
    scene.cameras.push(camera(Vec3::ZERO, -(a + b + c), 70.0));
    add(&mut scene, lamp, diffuse(reflectance, emission));
    add(&mut scene, wall, diffuse(reflectance, Vec3::ZERO));
    let indirect = share * emission * reflectance / (Vec3::ONE - reflectance);
    Known::new("closed sphere with an area light", scene, true, move |_, _| indirect)
}

/// A grey room with a plate whose shading normals all lean by 30 degrees towards a lamp on one side:
/// the walls are lit by the plate, brighter or darker as its scattering is.
pub fn leaning_normals() -> Scene {
    let mut scene = Scene::default();
    let room = Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out();
    let mut plate = Shape::parallelogram(Vec3::new(-0.7, -0.6, 0.7), 1.4 * Vec3::X, -1.4 * Vec3::Z);
    plate.normals = vec![Vec3::new(0.5, 0.75f32.sqrt(), 0.0); 4];
    let lamp = Shape::parallelogram(Vec3::new(0.9, -0.2, -0.4), 0.8 * Vec3::Z, 0.6 * Vec3::Y);
    add(&mut scene, room, diffuse(Vec3::splat(0.3), Vec3::ZERO));
    add(&mut scene, plate, diffuse(Vec3::new(0.9, 0.7, 0.5), Vec3::ZERO));
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::splat(4.0)));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.95), Vec3::new(0.0, -0.2, 0.0), 90.0));
    scene
}

/// Balls and a sheet of every model that is rough, below a wide lamp in a grey room; with `smooth`,
/// some with delta lobes beside others or alone, and a surface that is not there.
pub fn materials_room(smooth: bool) -> Scene {
    let mut scene = Scene::default();
    let room = Shape::cuboid(-Vec3::ONE, Vec3::ONE).inside_out();
    let lamp = Shape::parallelogram(Vec3::new(-0.7, 0.9, -0.7), 1.4 * Vec3::X, 1.4 * Vec3::Z);
    add(&mut scene, room, diffuse(Vec3::splat(0.5), Vec3::ZERO));
    add(&mut scene, lamp, diffuse(Vec3::ZERO, Vec3::splat(4.0)));
    let surfaces = if smooth { smooth_surfaces() } else { rough_surfaces() };
    for (i, surface) in surfaces.into_iter().enumerate() {
        let place = Vec3::new([-0.6, 0.0, 0.6][i % 3], [-0.6, 0.0, 0.5][i / 3], -0.3 + 0.1 * (i % 2) as f32);
        add(&mut scene, Shape::icosphere(2, place, 0.26), Material::new(surface));
    }
    let sheet = Shape::parallelogram(Vec3::new(-0.9, -0.9, 0.2), 0.7 * Vec3::X, 0.5 * Vec3::Y);
    add(&mut scene, sheet, Material::new(dielectric(true, if smooth { 0.0 } else { 0.4 })));
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.95), Vec3::new(0.0, -0.1, 0.0), 85.0));
    scene
}

pub(crate) fn dielectric(thin: bool, alpha: f32) -> Surface {
    Surface::Dielectric {
        ior: 1.5,
        dispersion: 0.0,
        reflection: Vec3::ONE.into(),
        transmission: Vec3::new(0.8, 0.9, 1.0).into(),
        sigma_a: Vec3::new(1.0, 0.5, 0.1),
        thin,
        roughness: Roughness::alpha(alpha),
    }
}

fn plastic(alpha: f32) -> Surface {
    Surface::Plastic {
        reflectance: Vec3::new(0.8, 0.3, 0.1).into(),
        specular: Vec3::ONE.into(),
        ior: 1.5,
        nonlinear: true,
        roughness: Roughness::alpha(alpha),
    }
}

/// The rough ones with a normal map that leans by 40 degrees, so that normals face away from the eye,
/// and from lights, over a good part of each ball.
pub fn leaning_materials_room() -> Scene {
    let mut scene = materials_room(false);
    let texel = [0.5 + 0.5 * 0.55, 0.5 + 0.5 * 0.33, 0.5 + 0.5 * 0.77, 1.0];
    let image = scene.images.len() as u32;
    let texels = Texels::Float(vec![texel].into());
    scene.images.push(Picture { name: String::new(), width: 1, height: 1, texels });
    for material in scene.materials.iter_mut().skip(2) {
        material.normal_map = Some(NormalMap { texture: Texture::new(image), scale: 1.0 });
        // A coat leans to the other side.
        if let Surface::MetallicRoughness(model) = &mut material.surface {
            model.clearcoat_normal = CoatNormal::Map(NormalMap { texture: Texture::new(image), scale: -1.0 });
        }
    }
    scene
}

pub(crate) fn rough_surfaces() -> Vec<Surface> {
    let copper = ConductorFresnel::Complex {
        eta: Vec3::new(0.2, 0.92, 1.1),
        k: Vec3::new(3.91, 2.45, 2.14),
        tint: Vec3::ONE.into(),
    };
    let brushed = Roughness { along: 0.7.into(), across: 0.4.into(), squared: true, single_bounce: false };
    let base =
        MetallicRoughness { base_color: Vec3::new(0.3, 0.7, 0.9).into(), ..MetallicRoughness::default() };
    let coated = MetallicRoughness {
        roughness: 0.6.into(),
        metallic: 0.3.into(),
        clearcoat: 1.0.into(),
        clearcoat_roughness: 0.5.into(),
        anisotropy: 0.5.into(),
        ..base.clone()
    };
    let velvet =
        MetallicRoughness { sheen_color: Vec3::ONE.into(), sheen_roughness: 0.6.into(), ..base.clone() };
    let wax = MetallicRoughness {
        transmission: 0.8.into(),
        thin: false,
        sigma_a: Vec3::splat(0.5),
        roughness: 0.6.into(),
        ..base
    };
    vec![
        Surface::Conductor { fresnel: copper, roughness: brushed },
        dielectric(false, 0.35),
        plastic(0.3),
        Surface::MetallicRoughness(Box::new(coated)),
        Surface::MetallicRoughness(Box::new(velvet)),
        Surface::MetallicRoughness(Box::new(wax)),
    ]
}

pub(crate) fn smooth_surfaces() -> Vec<Surface> {
    let base = MetallicRoughness {
        base_color: Vec3::new(0.3, 0.7, 0.9).into(),
        clearcoat: 1.0.into(),
        ..MetallicRoughness::default()
    };
    let half_thin = MetallicRoughness { roughness: 0.0.into(), transmission: 0.5.into(), ..base.clone() };
    let ice = MetallicRoughness { thin: false, sigma_a: Vec3::splat(0.5), ..half_thin.clone() };
    vec![
        Surface::mirror(Vec3::new(0.9, 0.8, 0.5)),
        dielectric(false, 0.0),
        plastic(0.0),
        Surface::MetallicRoughness(Box::new(base)),
        Surface::MetallicRoughness(Box::new(half_thin)),
        Surface::MetallicRoughness(Box::new(ice)),
        Surface::Null,
    ]
}

/// Half the side of the facing squares; they are 1 apart.
const HALF: f64 = 0.5;

/// A black square that emits, and one of albedo ρ that faces it and fills the film: one bounce, of
/// radiance ρ Le F with F the form factor of a point and a rectangle.
pub fn facing_squares() -> Known {
    let (reflectance, emission) = (Vec3::new(0.9, 0.5, 0.3), Vec3::new(3.0, 4.0, 5.0));
    let (x, y) = (Vec3::X, Vec3::Y);
    let mut scene = Scene::default();
    add(&mut scene, Shape::parallelogram(Vec3::new(-0.5, -0.5, 0.0), x, y), diffuse(reflectance, Vec3::ZERO));
    add(&mut scene, Shape::parallelogram(Vec3::new(-0.5, -0.5, 1.0), y, x), diffuse(Vec3::ZERO, emission));
    // From 0.8 above, half the field of view is atan(0.5 / 0.8).
    let fov = 2.0 * (HALF as f32 / 0.8).atan().to_degrees();
    scene.cameras.push(camera(Vec3::new(0.0, 0.0, 0.8), Vec3::ZERO, fov));
    Known::new("facing squares", scene, true, move |x, y| {
        point_to_square(x * HALF, y * HALF, 1.0) as f32 * reflectance * emission
    })
}

/// Texels along each side of [`textured_squares`]: each covers whole pixels.
const TEXELS: usize = 4;

/// The facing squares, the one in view of a texture's colours, with a second texture's normals that
/// stand straight up and a sheet of nothing between the two.
pub fn textured_squares() -> Known {
    let mut known = facing_squares();
    let shade = |i: usize| [0.2, 0.9, 0.5, 0.7, 0.4][i % 5];
    let texel = |i: usize| [shade(i), shade(i + 1), shade(i + 2), 1.0];
    let image = |side: usize, texels: Vec<[f32; 4]>| Picture {
        name: String::new(),
        width: side as u32,
        height: side as u32,
        texels: Texels::Float(texels.into()),
    };
    known.scene.images.push(image(TEXELS, (0..TEXELS * TEXELS).map(texel).collect()));
    known.scene.images.push(image(1, vec![[0.5, 0.5, 1.0, 1.0]]));
    let floor = &mut known.scene.materials[0];
    let Surface::Diffuse { reflectance } = &mut floor.surface else {
        unreachable!("facing squares are diffuse")
    };
    reflectance.texture = Some(Texture { filter: Filter::Nearest, ..Texture::new(0) });
    floor.normal_map = Some(NormalMap { texture: Texture::new(1), scale: 1.0 });
    known.scene.meshes[0].uvs[0] = vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO];
    let sheet = Shape::parallelogram(Vec3::new(-1.0, -1.0, 0.5), 2.0 * Vec3::X, 2.0 * Vec3::Y);
    add(&mut known.scene, sheet, Material::new(Surface::Null));
    let plain = &known.expected.mean;
    known.expected.mean = Image::from_fn(SIZE, SIZE, |x, y| {
        let place = |pixel: usize| pixel * TEXELS / SIZE;
        let shade = texel(place(y) * TEXELS + place(x));
        let plain = plain.pixels[y * SIZE + x];
        [0, 1, 2].map(|c| plain[c] * shade[c])
    });
    Known { name: "textured squares", ..known }
}

/// The facing squares with a black sheet before the lamp that is there by a chance of 0.4, by a texture:
/// light of every strategy passes it, or not, on its way.
pub fn facing_squares_through_a_veil() -> Known {
    const OPACITY: f32 = 0.4;
    let mut known = facing_squares();
    let texel = Texels::Float(vec![[0.0, 0.0, 0.0, 2.0 * OPACITY]].into());
    known.scene.images.push(Picture { name: String::new(), width: 1, height: 1, texels: texel });
    let alpha = ScalarInput { value: 0.5, texture: Some((Texture::new(0), Channel::A)) };
    let veil = Material { opacity: Opacity::Blend(alpha), ..diffuse(Vec3::ZERO, Vec3::ZERO) };
    let sheet = Shape::parallelogram(Vec3::new(-1.0, -1.0, 0.9), 2.0 * Vec3::X, 2.0 * Vec3::Y);
    add(&mut known.scene, sheet, veil);
    let seen = &known.expected.mean;
    known.expected.mean = combine(seen, seen, |radiance, _| radiance * f64::from(1.0 - OPACITY));
    Known { name: "facing squares through a veil", ..known }
}

/// The form factor from a point to the parallel square of side 1 about the axis, at a distance, by
/// its four corners (Howell, Menguc and Siegel 2010, factor B-3).
fn point_to_square(x: f64, y: f64, distance: f64) -> f64 {
    let corner = |x: f64, y: f64| {
        let (a, b) = (x / distance, y / distance);
        let (p, q) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        (a / p * (b / p).atan() + b / q * (a / q).atan()) / std::f64::consts::TAU
    };
    let (left, right, low, high) = (HALF + x, HALF - x, HALF + y, HALF - y);
    corner(left, low) + corner(left, high) + corner(right, low) + corner(right, high)
}

/// A box of perfect mirrors but for one wall, black and emitting, behind the camera: radiance is Le
/// everywhere.
pub fn mirror_box() -> Known {
    let emission = Vec3::new(1.0, 2.0, 0.5);
    // The last wall is at +z. Nearer side walls than -z: most of the film shows several mirrors.
    let walls = Shape::cuboid(Vec3::new(-0.4, -0.5, -1.0), Vec3::new(0.6, 0.5, 1.0)).inside_out();
    let (mirrors, lamp) = walls.split(|triangle| triangle < 10);
    let mut scene = Scene::default();
    add(&mut scene, mirrors, mirror(1.0));
    add(&mut scene, lamp, diffuse(Vec3::ZERO, emission));
    scene.cameras.push(camera(Vec3::new(0.0, 0.1, 0.5), Vec3::new(0.0, 0.1, -1.0), 70.0));
    Known::new("mirror box", scene, false, move |_, _| emission)
}

/// Index of the glass of the two scenes below.
const IOR: f64 = 1.5;

/// A specular sphere lit from within: glass about a black ball that emits Le, larger than 1 / n of
/// the sphere, so that every ray that enters meets it. Radiance is (1 - F) Le / n² by Fresnel's F at
/// the place where the sphere is seen.
pub fn lamp_in_glass() -> Known {
    const DISTANCE: f64 = 3.0;
    const HALF_WIDTH: f64 = 0.2; // at distance 1
    let emission = Vec3::new(1.0, 2.0, 4.0);
    let mut scene = Scene::default();
    add(&mut scene, Shape::icosphere(5, Vec3::ZERO, 1.0).smooth(Vec3::ZERO), glass(IOR as f32));
    add(&mut scene, Shape::icosphere(4, Vec3::ZERO, 0.8), diffuse(Vec3::ZERO, emission));
    let fov = 2.0 * (HALF_WIDTH as f32).atan().to_degrees();
    scene.cameras.push(camera(Vec3::Z * DISTANCE as f32, Vec3::ZERO, fov));
    Known::new("lamp in glass", scene, false, move |x, y| {
        let tan2 = HALF_WIDTH * HALF_WIDTH * (x * x + y * y);
        // The ray's distance from the centre is the sine of the angle at the sphere of radius 1.
        let sin2_i = DISTANCE * DISTANCE * tan2 / (1.0 + tan2);
        emission * ((1.0 - fresnel(sin2_i)) / (IOR * IOR)) as f32
    })
}

/// Fresnel's reflectance of the glass from outside, unpolarised.
fn fresnel(sin2_i: f64) -> f64 {
    let (cos_i, cos_t) = ((1.0 - sin2_i).sqrt(), (1.0 - sin2_i / (IOR * IOR)).sqrt());
    let parallel = (IOR * cos_i - cos_t) / (IOR * cos_i + cos_t);
    let perpendicular = (cos_i - IOR * cos_t) / (cos_i + IOR * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// A camera in the middle of glass in a room of radiance 1: it sees n².
pub fn camera_in_glass() -> Known {
    let mut scene = furnace_room();
    add(&mut scene, Shape::icosphere(3, Vec3::ZERO, 0.5), glass(IOR as f32));
    scene.cameras = vec![camera(Vec3::new(0.01, 0.02, 0.0), -Vec3::Z, 60.0)];
    Known::new("camera in glass", scene, false, |_, _| Vec3::splat((IOR * IOR) as f32))
}

/// The same in rough glass, whose facets scatter in all directions: it sees n² nevertheless.
pub fn camera_in_rough_glass() -> Known {
    let mut scene = furnace_room();
    let rough = Surface::Dielectric {
        ior: IOR as f32,
        dispersion: 0.0,
        reflection: Vec3::ONE.into(),
        transmission: Vec3::ONE.into(),
        sigma_a: Vec3::ZERO,
        thin: false,
        roughness: Roughness::alpha(0.4),
    };
    add(&mut scene, Shape::icosphere(3, Vec3::ZERO, 0.5), Material::new(rough));
    scene.cameras = vec![camera(Vec3::new(0.01, 0.02, 0.0), -Vec3::Z, 60.0)];
    Known::new("camera in rough glass", scene, false, |_, _| Vec3::splat((IOR * IOR) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over the receiver is the form factor of two squares (factor C-11).
    #[test]
    fn both_form_factors_of_squares_agree() {
        let known = facing_squares();
        let mean = known.expected.mean.mean();
        let pair = 2.0 / std::f64::consts::PI
            * (0.5 * (4.0f64 / 3.0).ln() + 2.0 * 2.0f64.sqrt() * (1.0 / 2.0f64.sqrt()).atan()
                - 2.0 * 1.0f64.atan());
        assert!((pair - 0.199_825).abs() < 1e-6, "{pair}");
        for (mean, factor) in mean.into_iter().zip([2.7, 2.0, 1.5]) {
            assert!((mean / (factor * pair) - 1.0).abs() <= 1e-5, "{mean}");
        }
    }

    #[test]
    fn fresnel_at_normal_incidence_is_4_percent() {
        assert!((fresnel(0.0) - 0.04).abs() < 1e-12);
        assert!((fresnel(1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn scenes_are_valid() {
        for known in all() {
            assert!(known.scene.validate().is_ok(), "{}", known.name);
        }
    }
}
