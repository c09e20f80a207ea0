//! The tree over lights of a packed scene: its chances, its draws, and that it leaves no light out that
//! shines.

use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::{DVec3, Vec3};
use midway_device::{Device, DeviceKind};
use midway_kernels::{
    constants::{FLAG_LIGHT_TREE, PROBE_STRIDE},
    layout::Params,
};
use midway_render::{LightSampling, PackedScene, RenderSettings};
use midway_scene::Scene;
use midway_tests::{
    estimate::{cpu, gpu},
    lit,
};

use crate::{
    chi_square::ChiSquare,
    support::{Random, assert_near},
    twins::{
        compare::{Results, Tolerance, compare},
        device,
    },
};

/// Words of an invocation.
const STRIDE: usize = 4 * PROBE_STRIDE as usize;

fn packed(scene: &Scene) -> PackedScene {
    let settings = RenderSettings { light_sampling: LightSampling::Tree, ..RenderSettings::default() };
    PackedScene::new(scene, &scene.cameras[0], &settings, DeviceKind::Cpu).expect("packs")
}

/// What lights are drawn for.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: Vec3,
    /// Unit, the side that is lit, or 0.
    facing: Vec3,
}

/// What the probe is asked: for a place and a light, by numbers of its own.
fn question(place: Place, light: u32, random: &mut Random) -> [f32; STRIDE] {
    let mut question = [0.0; STRIDE];
    question[..3].copy_from_slice(&place.at.to_array());
    question[3] = light as f32;
    question[4..8].fill_with(|| random.unit());
    question[8..11].copy_from_slice(&random.direction().as_vec3().to_array());
    question[12..15].copy_from_slice(&place.facing.to_array());
    question
}

/// A place in the room, or somewhat outside, mostly lit on one side.
fn place(random: &mut Random) -> Place {
    let at = DVec3::from_array([0; 3].map(|_| random.between(-1.1, 1.1))).as_vec3();
    let facing = if random.chance(0.8) { random.direction().as_vec3() } else { Vec3::ZERO };
    Place { at, facing }
}

fn ask(device: &dyn Device, packed: &PackedScene, questions: &[[f32; STRIDE]]) -> Vec<u32> {
    let params = Params {
        flags: FLAG_LIGHT_TREE,
        lights_at: packed.lights_at,
        light_tree_at: packed.light_tree_at,
        light_ways_at: packed.light_ways_at,
        n_lights: packed.n_lights,
        environment_at: packed.environment_at,
        surfaces_at: packed.surfaces_at,
        instances_at: packed.instances_at,
        n_baked: packed.n_baked,
        n_instances: packed.n_instances,
        slots_at: packed.slots_at,
        textures_at: packed.textures_at,
        srgb_at: packed.srgb_at,
        scene_centre: packed.sphere.centre.to_array(),
        scene_radius: packed.sphere.radius,
        ..Params::zeroed()
    };
    let store = packed.images.to_words();
    let zeros = vec![0u32; questions.len() * STRIDE];
    let buffers: [(&str, &[u8]); 5] = [
        ("params", bytes_of(&params)),
        ("scene", cast_slice(&packed.scene)),
        ("texels", cast_slice(&store)),
        ("probe_in", cast_slice(questions)),
        ("probe_out", cast_slice(&zeros)),
    ];
    let mut outputs = device::run(device, "probe_light_tree", &buffers, questions.len() as u32);
    outputs.remove("probe_out").expect("every probe writes probe_out")
}

/// What the probe answers.
struct Answer {
    /// The light that was drawn, if any.
    drawn: Option<usize>,
    /// Its chance over that by power, by the draw and by its way.
    drawn_ratio: [f32; 2],
    drawn_pmf: f32,
    /// The same of the light that was asked for.
    ratio: f32,
    pmf: f32,
    /// What the place would receive from a point of it, for its density.
    arriving: f32,
    /// The light's chance over that by power, as its sample has it.
    sample_ratio: f32,
}

impl Answer {
    fn chance(&self) -> f64 {
        f64::from(self.ratio) * f64::from(self.pmf)
    }
}

fn answers(packed: &PackedScene, questions: &[[f32; STRIDE]]) -> Vec<Answer> {
    let words = ask(&*cpu(), packed, questions);
    let answer = |row: &[u32]| {
        let x = |i: usize| f32::from_bits(row[i]);
        Answer {
            drawn: (x(0) >= 0.0).then_some(x(0) as usize),
            drawn_ratio: [x(1), x(2)],
            drawn_pmf: x(3),
            ratio: x(4),
            pmf: x(5),
            arriving: x(6),
            sample_ratio: x(7),
        }
    };
    words.chunks(STRIDE).map(answer).collect()
}

/// Each light once, for one place.
fn all_lights(packed: &PackedScene, place: Place, random: &mut Random) -> Vec<Answer> {
    let questions: Vec<_> = (0..packed.n_lights).map(|light| question(place, light, random)).collect();
    answers(packed, &questions)
}

/// The side that lights are drawn for is kept in 32 bits.
#[test]
fn sides_survive_packing() {
    let mut random = Random::new(125);
    let packed = packed(&lit::room_with_many_lights());
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [axis, -axis]);
    let directions = (0..10_000).map(|_| random.direction().as_vec3());
    let directions: Vec<Vec3> = axes.into_iter().flatten().chain(directions).collect();
    let question = |direction: &Vec3| {
        let mut question = [0.0; STRIDE];
        question[8..11].copy_from_slice(&direction.to_array());
        question
    };
    let words = ask(&*cpu(), &packed, &directions.iter().map(question).collect::<Vec<_>>());
    for (row, direction) in words.chunks(STRIDE).zip(&directions) {
        let back = Vec3::from_array([8, 9, 10].map(|i| f32::from_bits(row[i])));
        // As `probe_unit` makes it.
        let expected = (*direction + 1e-3 * Vec3::Z).normalize();
        assert!(back.distance(expected) <= 1e-4, "{back} for {expected}");
    }
}

/// A little may be left of 1: where a node may shine, and none of its children does, none is drawn.
#[test]
fn chances_sum_to_one_at_most() {
    let mut random = Random::new(120);
    let packed = packed(&lit::room_with_many_lights());
    assert!(packed.n_lights > 60);
    let mut mean = 0.0;
    for _ in 0..200 {
        let place = place(&mut random);
        let sum: f64 = all_lights(&packed, place, &mut random).iter().map(Answer::chance).sum();
        assert!((0.0..=1.0 + 1e-5).contains(&sum), "{sum} at {place:?}");
        mean += sum / 200.0;
    }
    assert!(mean >= 0.95, "the mean of the sums is {mean}");
}

#[test]
fn draws_have_their_chances() {
    const N: usize = 100_000;
    let mut random = Random::new(121);
    let packed = packed(&lit::room_with_many_lights());
    for _ in 0..6 {
        let place = place(&mut random);
        let lights = all_lights(&packed, place, &mut random);
        let questions: Vec<_> = (0..N).map(|_| question(place, 0, &mut random)).collect();
        // The last is none of them.
        let mut observed = vec![0u64; lights.len() + 1];
        for answer in answers(&packed, &questions) {
            let [drawn, by_way] = answer.drawn_ratio;
            let is_drawn = drawn > 0.0 && drawn == by_way && answer.drawn_pmf > 0.0;
            assert_eq!(is_drawn, answer.drawn.is_some(), "{drawn} and {by_way}");
            observed[answer.drawn.unwrap_or(lights.len())] += 1;
        }
        let expected = |chance: &dyn Fn(&Answer) -> f64| -> Vec<f64> {
            let sum: f64 = lights.iter().map(chance).sum();
            let none = (1.0 - sum).max(0.0);
            let all = lights.iter().map(chance).chain([none]);
            all.map(|chance| chance / (sum + none) * N as f64).collect()
        };
        ChiSquare::of(&observed, &expected(&Answer::chance)).assert_holds("draw_light");
        let by_power = expected(&|light| light.pmf.into());
        ChiSquare::of(&observed, &by_power).assert_rejects("draws by the tree held to power");
    }
}

/// Where a light shines it may be drawn, however near the edge of its cone or its plane; where it does not
/// there are many that are not drawn.
#[test]
fn no_light_that_shines_is_left_out() {
    let mut random = Random::new(122);
    let packed = packed(&lit::room_with_many_lights());
    let mut questions: Vec<_> = (0..400_000)
        .map(|i| {
            let place = place(&mut random);
            question(place, i % packed.n_lights, &mut random)
        })
        .collect();
    // Places along the edges of what lights see are few: crowd them about one lamp's plane.
    questions.iter_mut().step_by(2).for_each(|question| question[1] = 0.9 - 1e-5 * question[4]);
    let (mut n_lit, mut n_left_out) = (0, 0);
    for (answer, question) in answers(&packed, &questions).iter().zip(&questions) {
        assert!(answer.arriving == 0.0 || answer.ratio > 0.0, "{question:?}");
        assert_near(
            answer.sample_ratio.into(),
            answer.ratio.into(),
            1e-5 * f64::from(answer.ratio),
            "the sample's",
        );
        n_lit += u32::from(answer.arriving > 0.0);
        n_left_out += u32::from(answer.ratio == 0.0);
    }
    assert!(n_lit > 100_000 && n_left_out > 50_000, "{n_lit} shine, {n_left_out} are left out");
}

/// The second moment of the light that a draw finds, blockers and cosines left out, is a fraction of that by
/// power: it would not be if nodes' bounds were loose.
#[test]
fn the_tree_prefers_what_arrives() {
    let mut random = Random::new(123);
    let packed = packed(&lit::room_with_many_lights());
    let (mut n_places, mut ratios) = (0, 0.0);
    for _ in 0..300 {
        let place = place(&mut random);
        let lights = all_lights(&packed, place, &mut random);
        let moment = |chance: &dyn Fn(&Answer) -> f64| -> f64 {
            let shines = lights.iter().filter(|light| light.arriving > 0.0);
            shines.map(|light| f64::from(light.arriving).powi(2) / chance(light)).sum()
        };
        // By place: those near a light would outweigh all others.
        let by_power = moment(&|light| light.pmf.into());
        if by_power > 0.0 {
            n_places += 1;
            ratios += moment(&Answer::chance) / by_power;
        }
    }
    assert!(n_places > 250, "{n_places} are lit");
    let ratio = ratios / f64::from(n_places);
    println!("the second moment is {ratio:.3} of that by power");
    assert!(ratio <= 0.5, "{ratio}");
}

#[test]
fn trees_agree_on_both_devices() {
    let Some(gpu) = gpu() else { return };
    let mut random = Random::new(124);
    let packed = packed(&lit::room_with_many_lights());
    let questions: Vec<_> = (0..20_011)
        .map(|i| {
            let place = place(&mut random);
            question(place, i % packed.n_lights, &mut random)
        })
        .collect();
    let results = |device: &dyn Device| Results {
        device: device.info().name.clone(),
        words: ask(device, &packed, &questions),
    };
    // Rounding may draw the light beside, or see a place on the other side of a node's bound.
    let tolerance = Tolerance::Float { relative: 1e-3, absolute: 1e-4, outliers: 2e-3 };
    let compared = compare(&results(&*cpu()), &results(&*gpu), STRIDE, tolerance);
    assert!(compared.is_ok(), "{}", compared.unwrap_err());
}
