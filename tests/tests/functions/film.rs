//! The film's sums through the kernel that adds to them: exact to the quantum, with carry, in any
//! order, on both devices; what cannot be added is counted.

use bytemuck::{bytes_of, cast_slice};
use midway_accel::{BuildOptions, build_wide};
use midway_kernels::{constants as k, layout::Params};
use midway_tests::estimate::{cpu, gpu};

use crate::{
    support::Random,
    twins::device::{Outputs, run},
};

const N_PIXELS: u32 = 3;

/// A contribution to a pixel.
type Addition = (u32, [f32; 3]);

/// Adds contributions, by shadow rays through an empty scene.
fn add_all(device: &dyn midway_device::Device, additions: &[Addition], clamp: f32) -> Outputs {
    let params = Params {
        n_pixels: N_PIXELS,
        crop_width: N_PIXELS,
        film_width: N_PIXELS,
        clamp,
        ..bytemuck::Zeroable::zeroed()
    };
    let empty = build_wide(&[], &BuildOptions::default()).expect("an empty hierarchy");
    let nodes: Vec<[u32; 4]> = empty.nodes.iter().flat_map(|node| node.0).collect();
    let mut counters = [0u32; k::N_COUNTERS as usize];
    counters[k::COUNT_SHADOW_TRACE as usize] = additions.len() as u32;
    let rays: Vec<[u32; 4]> = additions
        .iter()
        .flat_map(|(pixel, rgb)| {
            let [r, g, b] = rgb.map(f32::to_bits);
            [[0, 0, 0, *pixel], [0, 0, 1.0f32.to_bits(), 0], [r, g, b, 0]]
        })
        .collect();
    let film = vec![0u32; (N_PIXELS * k::FILM_STRIDE) as usize];
    let inputs: [(&str, &[u8]); 8] = [
        ("params", bytes_of(&params)),
        ("scene", &[0; 16]),
        ("texels", &[0; 16]),
        ("nodes", cast_slice(&nodes)),
        ("triangles", &[0; 48]),
        ("counters", bytes_of(&counters)),
        ("shadow_rays", cast_slice(&rays)),
        ("film", cast_slice(&film)),
    ];
    run(device, "trace_shadow", &inputs, additions.len() as u32)
}

/// What a pixel's channel must hold: quanta of 2^-32, modulo 2^64.
fn quanta(additions: &[Addition], pixel: u32, channel: usize) -> u64 {
    let values = additions.iter().filter(|(p, _)| *p == pixel).map(|(_, rgb)| rgb[channel]);
    values.fold(0u64, |sum, value| sum.wrapping_add((f64::from(value) * 4_294_967_296.0).floor() as u64))
}

fn stored(film: &[u32], pixel: u32, channel: usize) -> u64 {
    let at = pixel as usize * k::FILM_STRIDE as usize + 2 * channel;
    u64::from(film[at]) | (u64::from(film[at + 1]) << 32)
}

/// Values over all magnitudes, so that low words carry often.
fn additions(n: usize, seed: u64) -> Vec<Addition> {
    let mut random = Random::new(seed);
    let value = |random: &mut Random| 10f32.powf(random.between(-9.0, 4.0) as f32);
    (0..n).map(|i| (i as u32 % N_PIXELS, [0; 3].map(|_| value(&mut random)))).collect()
}

#[test]
fn sums_are_exact_to_the_quantum_on_both_devices() {
    let additions = additions(50_000, 60);
    for device in [Some(cpu()), gpu()].into_iter().flatten() {
        let outputs = add_all(&*device, &additions, f32::INFINITY);
        for pixel in 0..N_PIXELS {
            for channel in 0..3 {
                let (actual, expected) =
                    (stored(&outputs["film"], pixel, channel), quanta(&additions, pixel, channel));
                assert_eq!(actual, expected, "pixel {pixel}, channel {channel} on {}", device.info().name);
            }
        }
        assert_eq!(outputs["counters"][k::COUNT_REJECTED as usize], 0);
        assert_eq!(outputs["counters"][k::COUNT_OVERFLOW as usize], 0);
    }
}

#[test]
fn sums_do_not_depend_on_the_order() {
    let mut additions = additions(20_000, 61);
    let forwards = add_all(&*cpu(), &additions, f32::INFINITY);
    additions.reverse();
    assert_eq!(forwards["film"], add_all(&*cpu(), &additions, f32::INFINITY)["film"]);
    additions[0].1[1] += 1.0;
    assert_ne!(forwards["film"], add_all(&*cpu(), &additions, f32::INFINITY)["film"]);
}

#[test]
fn what_is_not_radiance_is_counted_and_not_added() {
    let bad = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, -1e-30, 5e9];
    let mut additions: Vec<Addition> = bad.iter().map(|&x| (0, [1.0, x, 1.0])).collect();
    additions.extend(bad.iter().map(|&x| (1, [x, 1.0, 1.0])));
    additions.push((0, [0.25, 0.5, -0.0]));
    for device in [Some(cpu()), gpu()].into_iter().flatten() {
        let outputs = add_all(&*device, &additions, f32::INFINITY);
        assert_eq!(outputs["counters"][k::COUNT_REJECTED as usize], 2 * bad.len() as u32);
        let expected = [1 << 30, 0, 1 << 31, 0, 0, 0];
        assert_eq!(outputs["film"][..6], expected, "on {}", device.info().name);
        assert!(outputs["film"][6..].iter().all(|word| *word == 0));
    }
}

#[test]
fn overflow_is_counted() {
    let additions = [(0, [4.0e9, 0.0, 0.0]), (0, [4.0e9, 0.0, 0.0]), (0, [1.0, 0.0, 0.0])];
    let outputs = add_all(&*cpu(), &additions, f32::INFINITY);
    assert_eq!(outputs["counters"][k::COUNT_OVERFLOW as usize], 1);
}

#[test]
fn clamping_keeps_the_hue() {
    let outputs = add_all(&*cpu(), &[(0, [8.0, 4.0, 2.0]), (1, [0.5, 1.0, 0.25])], 2.0);
    let channels = |pixel| [0, 1, 2].map(|channel| stored(&outputs["film"], pixel, channel));
    assert_eq!(channels(0), [2 << 32, 1 << 32, 1 << 31]);
    assert_eq!(channels(1), [1 << 31, 1 << 32, 1 << 30]);
}
