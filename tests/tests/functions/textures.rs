//! Textures as kernels see them, against the same images blended in f64 on the host; and on a GPU.

use glam::{Mat3, Vec2};
use midway_device::DeviceKind;
use midway_kernels::{constants::PROBE_STRIDE, layout::Params};
use midway_render::{PackedScene, RenderSettings};
use midway_scene::{
    Channel, Filter, Image, Material, Opacity, ScalarInput, Scene, Surface, Texels, Texture, Wrap,
};
use midway_tests::{
    estimate::{cpu, gpu},
    shapes::{Shape, add, camera, diffuse},
};

use crate::{
    support::{Random, assert_near},
    twins::device::run,
};

/// Points for each texture.
const POINTS: usize = 64;
const STRIDE: usize = 4 * PROBE_STRIDE as usize;

fn images(random: &mut Random) -> Vec<Image> {
    let mut image = |width: u32, height: u32, kind: u32| {
        let n = (width * height) as usize;
        let mut bytes = || [0; 4].map(|_| random.bits() as u8);
        let texels = match kind {
            0 => Texels::Srgb8((0..n).map(|_| bytes()).collect()),
            1 => Texels::Linear8((0..n).map(|_| bytes()).collect()),
            2 => Texels::Linear16((0..n).map(|_| [0; 4].map(|_| random.bits() as u16)).collect()),
            _ => {
                Texels::Float((0..n).map(|_| [0; 4].map(|_| random.between(-10.0, 1000.0) as f32)).collect())
            }
        };
        Image { name: String::new(), width, height, texels }
    };
    // Odd sizes and single rows too; 8-bit images share a texel of the store between 2 x 2.
    [(5, 3), (1, 1), (16, 8), (7, 1), (1, 4)]
        .into_iter()
        .flat_map(|(width, height)| (0..4).map(move |kind| (width, height, kind)))
        .map(|(width, height, kind)| image(width, height, kind))
        .collect()
}

/// Every wrap and filter on every image, transforms and UV sets at random.
fn textures(random: &mut Random, n_images: usize) -> Vec<Texture> {
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp, Wrap::Black];
    let mut textures = Vec::new();
    for image in 0..n_images as u32 {
        for wrap in wraps {
            for filter in [Filter::Nearest, Filter::Bilinear] {
                let scale = Vec2::new(random.between(-3.0, 3.0) as f32, random.between(0.2, 2.0) as f32);
                let offset = Vec2::new(random.between(-2.0, 2.0) as f32, random.between(-2.0, 2.0) as f32);
                let angle = random.between(0.0, 6.0) as f32;
                textures.push(Texture {
                    image,
                    uv_set: random.bits() as u32 & 1,
                    image_from_uv: Mat3::from_scale_angle_translation(scale, angle, offset),
                    wrap: [wrap, wraps[random.bits() as usize % 4]],
                    filter,
                });
            }
        }
    }
    textures
}

/// A scene with a material for each texture: its colour, and by one channel its opacity.
fn scene(images: Vec<Image>, textures: &[Texture]) -> Scene {
    let mut scene = Scene { images, ..Scene::default() };
    let square = Shape::parallelogram(glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y);
    add(&mut scene, square, diffuse(glam::Vec3::ONE, glam::Vec3::ONE));
    scene.materials.clear();
    for (i, texture) in textures.iter().enumerate() {
        let mut surface = diffuse(glam::Vec3::ONE, glam::Vec3::ZERO).surface;
        if let Surface::Diffuse { reflectance } = &mut surface {
            reflectance.texture = Some(texture.clone());
        }
        let opacity = ScalarInput { value: 0.5, texture: Some((texture.clone(), CHANNELS[i % 4])) };
        scene.materials.push(Material { opacity: Opacity::Mask(opacity, 0.25), ..Material::new(surface) });
    }
    scene
}

const CHANNELS: [Channel; 4] = [Channel::R, Channel::G, Channel::B, Channel::A];

/// The texel that a place stands for, by the definition of each wrap; none beyond a black edge.
fn wrapped(i: i64, size: u32, wrap: Wrap) -> Option<usize> {
    let n = i64::from(size);
    let j = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let j = i.rem_euclid(2 * n);
            if j < n { j } else { 2 * n - 1 - j }
        }
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Black => i,
    };
    (0..n).contains(&j).then_some(j as usize)
}

fn texel(image: &Image, texture: &Texture, x: i64, y: i64) -> [f64; 4] {
    let place = wrapped(x, image.width, texture.wrap[0]).zip(wrapped(y, image.height, texture.wrap[1]));
    place.map_or([0.0; 4], |(x, y)| image.texels.linear(y * image.width as usize + x).map(f64::from))
}

/// A texture at a place of its image, by definition.
fn expected(image: &Image, texture: &Texture, place: Vec2) -> [f64; 4] {
    let x = f64::from(place.x) * f64::from(image.width);
    let y = f64::from(place.y) * f64::from(image.height);
    if texture.filter == Filter::Nearest {
        return texel(image, texture, x.floor() as i64, y.floor() as i64);
    }
    let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
    let (fx, fy) = (x - 0.5 - left, y - 0.5 - top);
    let mut sum = [0.0; 4];
    for (dx, wx) in [(0, 1.0 - fx), (1, fx)] {
        for (dy, wy) in [(0, 1.0 - fy), (1, fy)] {
            let t = texel(image, texture, left as i64 + dx, top as i64 + dy);
            sum.iter_mut().zip(t).for_each(|(sum, t)| *sum += wx * wy * t);
        }
    }
    sum
}

struct Case {
    scene: Scene,
    textures: Vec<Texture>,
    inputs: Vec<f32>,
}

impl Case {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let images = images(&mut random);
        let textures = textures(&mut random, images.len());
        let mut inputs = vec![0.0; textures.len() * POINTS * STRIDE];
        for (point, input) in inputs.chunks_mut(STRIDE).enumerate() {
            input[..4].fill_with(|| random.between(-2.0, 2.0) as f32);
            input[4] = (point / POINTS) as f32;
        }
        Self { scene: scene(images, &textures), textures, inputs }
    }

    fn probe(&self, device: &dyn midway_device::Device) -> Vec<f32> {
        let eye = camera(glam::Vec3::Z, glam::Vec3::ZERO, 40.0);
        let packed =
            PackedScene::new(&self.scene, &eye, &RenderSettings::default(), DeviceKind::Cpu).expect("packs");
        let params = Params {
            slots_at: packed.slots_at,
            textures_at: packed.textures_at,
            srgb_at: packed.srgb_at,
            ..bytemuck::Zeroable::zeroed()
        };
        let store = packed.images.to_words();
        let zeros = vec![0u32; self.inputs.len()];
        let buffers: [(&str, &[u8]); 5] = [
            ("params", bytemuck::bytes_of(&params)),
            ("scene", bytemuck::cast_slice(&packed.scene)),
            ("texels", bytemuck::cast_slice(&store)),
            ("probe_in", bytemuck::cast_slice(&self.inputs)),
            ("probe_out", bytemuck::cast_slice(&zeros)),
        ];
        let n = (self.inputs.len() / STRIDE) as u32;
        let mut outputs = run(device, "probe_texture", &buffers, n);
        outputs.remove("probe_out").expect("written").into_iter().map(f32::from_bits).collect()
    }
}

/// Whether a place is so near an edge between texels that rounding decides.
fn is_at_an_edge(image: &Image, place: Vec2) -> bool {
    let near = |x: f32, size: u32| {
        let x = f64::from(x) * f64::from(size);
        (x - x.round()).abs() < 1e-4
    };
    near(place.x, image.width) || near(place.y, image.height)
}

#[test]
fn textures_are_blended_as_defined() {
    let case = Case::new(5);
    let outputs = case.probe(&*cpu());
    let mut checked = 0;
    for (point, (input, output)) in case.inputs.chunks(STRIDE).zip(outputs.chunks(STRIDE)).enumerate() {
        let texture = &case.textures[point / POINTS];
        let image = &case.scene.images[texture.image as usize];
        let uv = if texture.uv_set == 0 { [input[0], input[1]] } else { [input[2], input[3]] };
        let place = texture.place(Vec2::from_array(uv));
        if texture.filter == Filter::Nearest && is_at_an_edge(image, place) {
            continue;
        }
        let expected = expected(image, texture, place);
        // A coordinate's rounding, times the steepest slope between texels.
        let tolerance = if matches!(image.texels, Texels::Float(_)) { 0.05 } else { 5e-5 };
        for c in 0..4 {
            assert_near(f64::from(output[c]), expected[c], tolerance, &format!("{texture:?} at {uv:?}, {c}"));
        }
        assert_near(f64::from(output[4]), expected[point / POINTS % 4], tolerance, "one channel");
        assert_eq!(output[5..8], [0.0, 0.5, 0.25], "normal scale, opacity, cutoff");
        checked += 1;
    }
    assert!(checked > case.textures.len() * POINTS * 9 / 10, "{checked}");
}

#[test]
fn a_gpu_sees_the_same_textures() {
    let Some(gpu) = gpu() else { return };
    let case = Case::new(6);
    let (a, b) = (case.probe(&*cpu()), case.probe(&*gpu));
    let far = a.iter().zip(&b).filter(|(a, b)| (**a - **b).abs() > 1e-4 * (1.0 + a.abs())).count();
    // The nearest texel of a place at an edge is either.
    assert!(far * 500 < a.len(), "{far} of {} numbers differ", a.len());
    assert!(a.iter().any(|x| *x != 0.0));
}

/// The curve's inverse (IEC 61966-2-1) gives each byte back.
#[test]
fn srgb_bytes_come_back() {
    for byte in 0..=255u8 {
        let x = f64::from(midway_scene::srgb_to_linear(byte));
        let srgb = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        assert_near(255.0 * srgb, f64::from(byte), 2e-2, "byte");
    }
}
