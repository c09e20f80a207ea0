//! One channel of a throughput, drawn by its shares.

use midway_kernels::native::lib;
use wgsl_cpu::runtime::Vec3;

use crate::support::Random;

/// The largest that `unit_float` gives.
const LAST: f32 = 1.0 - 1.0 / 16_777_216.0;

fn array(v: Vec3<f32>) -> [f32; 3] {
    [v.x, v.y, v.z]
}

#[test]
fn one_channel_is_kept_and_the_mean_is_the_throughput() {
    const DRAWS: usize = 1 << 14;
    let mut random = Random::new(61);
    for _ in 0..32 {
        let plain = Vec3::new(random.between(0.0, 2.0) as f32, random.unit(), random.unit());
        let mut sums = [0f64; 3];
        for i in 0..DRAWS {
            let kept = array(lib::keep_one_channel(plain, (i as f32 + 0.5) / DRAWS as f32));
            assert_eq!(kept.iter().filter(|value| **value > 0.0).count(), 1, "{plain:?}: {kept:?}");
            assert!(kept[lib::channel_of(Vec3::from(kept)) as usize] > 0.0);
            sums.iter_mut().zip(kept).for_each(|(sum, value)| *sum += f64::from(value));
        }
        // Strata of the draws: each edge is missed by less than one, and each draw is worth the sum.
        let bound = 3.0 * f64::from(plain.x + plain.y + plain.z) / DRAWS as f64;
        for (sum, value) in sums.iter().zip(array(plain)) {
            assert!((sum / DRAWS as f64 - f64::from(value)).abs() <= bound, "{plain:?}: {sums:?}");
        }
    }
}

#[test]
fn a_channel_that_is_kept_stays() {
    let mut random = Random::new(62);
    for _ in 0..1000 {
        let value = random.between(1e-6, 1e3) as f32;
        for channel in 0..3 {
            let mut one = [0.0; 3];
            one[channel] = value;
            for u in [0.0, random.unit() * LAST, LAST] {
                let kept = lib::keep_one_channel(Vec3::from(one), u);
                assert_eq!((array(kept), lib::channel_of(kept)), (one, channel as u32), "by {u}");
            }
        }
        let two = Vec3::new(value, 0.3 * value, 0.0);
        assert_eq!(lib::keep_one_channel(two, LAST).z, 0.0);
    }
    assert_eq!(array(lib::keep_one_channel(Vec3::splat(0.0), 0.5)), [0.0; 3]);
}

#[test]
fn indices_are_those_of_the_extension() {
    let of = |channel| lib::channel_ior(1.5, 0.1, channel);
    assert_eq!([0, 1, 2].map(of), [1.4, 1.5, 1.6]);
}
