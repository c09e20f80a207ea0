//! Eight boxes at once.

/// A node's boxes along a ray: a plane is met at its byte times `scale` plus `offset`.
pub struct Planes {
    /// Along each axis the plane of each child that is met first.
    pub near: [u64; 3],
    /// And the other.
    pub far: [u64; 3],
    /// Along each axis.
    pub scale: [f32; 3],
    /// Along each axis.
    pub offset: [f32; 3],
}

/// A node that waits, and where the ray meets it. Packed, so that sorting moves one word.
#[derive(Clone, Copy)]
pub struct Entry(u64);

impl Entry {
    #[inline(always)]
    pub const fn new(distance: f32, node: u32) -> Self {
        Self((distance.to_bits() as u64) << 32 | node as u64)
    }

    #[inline(always)]
    pub fn distance(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    /// Distances are not negative: their bits are in their order.
    #[inline(always)]
    pub fn is_nearer(self, other: Self) -> bool {
        self.0 < other.0
    }

    #[inline(always)]
    pub fn node(self) -> u32 {
        self.0 as u32
    }
}

/// How eight boxes are met.
pub trait Boxes {
    /// Which children a ray meets before `t_max`, and where it enters each. An exit counts as `far`
    /// times as far.
    ///
    /// # Safety
    /// The machine has the instructions.
    unsafe fn meet(planes: &Planes, far: f32, t_max: f32, enter: &mut [f32; 8]) -> u32;
}

/// What every machine has.
pub struct Portable;

impl Boxes for Portable {
    #[inline(always)]
    unsafe fn meet(planes: &Planes, far: f32, t_max: f32, enter: &mut [f32; 8]) -> u32 {
        let distances = |bytes: u64, axis: usize| -> [f32; 8] {
            bytes.to_le_bytes().map(|byte| f32::from(byte) * planes.scale[axis] + planes.offset[axis])
        };
        let lesser = |a: f32, b: f32| if a < b { a } else { b };
        let greater = |a: f32, b: f32| if a > b { a } else { b };
        let near: [[f32; 8]; 3] = std::array::from_fn(|axis| distances(planes.near[axis], axis));
        let exit: [[f32; 8]; 3] = std::array::from_fn(|axis| distances(planes.far[axis], axis));
        let mut mask = 0;
        for i in 0..8 {
            enter[i] = greater(greater(near[0][i], near[1][i]), greater(near[2][i], 0.0));
            let leave = lesser(lesser(lesser(exit[0][i], exit[1][i]), exit[2][i]) * far, t_max);
            mask |= u32::from(enter[i] <= leave) << i;
        }
        mask
    }
}

/// AVX2.
#[cfg(target_arch = "x86_64")]
pub struct Avx2;

#[cfg(target_arch = "x86_64")]
impl Boxes for Avx2 {
    #[inline(always)]
    unsafe fn meet(planes: &Planes, far: f32, t_max: f32, enter: &mut [f32; 8]) -> u32 {
        // SAFETY: this function's contract.
        unsafe { meet_avx2(planes, far, t_max, enter) }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
fn meet_avx2(planes: &Planes, far: f32, t_max: f32, enter: &mut [f32; 8]) -> u32 {
    use std::arch::x86_64::{
        _CMP_LE_OQ, _mm_cvtsi64_si128, _mm256_add_ps, _mm256_cmp_ps, _mm256_cvtepi32_ps,
        _mm256_cvtepu8_epi32, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
        _mm256_set1_ps, _mm256_setzero_ps, _mm256_storeu_ps,
    };
    let distances = |bytes: u64, axis: usize| {
        let places = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(bytes as i64)));
        let scaled = _mm256_mul_ps(places, _mm256_set1_ps(planes.scale[axis]));
        _mm256_add_ps(scaled, _mm256_set1_ps(planes.offset[axis]))
    };
    let near: [_; 3] = std::array::from_fn(|axis| distances(planes.near[axis], axis));
    let exit: [_; 3] = std::array::from_fn(|axis| distances(planes.far[axis], axis));
    let at = _mm256_max_ps(_mm256_max_ps(near[0], near[1]), _mm256_max_ps(near[2], _mm256_setzero_ps()));
    let last = _mm256_min_ps(_mm256_min_ps(exit[0], exit[1]), exit[2]);
    let leave = _mm256_min_ps(_mm256_mul_ps(last, _mm256_set1_ps(far)), _mm256_set1_ps(t_max));
    // SAFETY: eight numbers.
    unsafe { _mm256_storeu_ps(enter.as_mut_ptr(), at) };
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(at, leave)) as u32
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    /// Numbers that are as good as random, in [-1, 1).
    fn number(state: &mut u64) -> f32 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    #[test]
    fn all_instructions_give_the_same_bits() {
        if !std::arch::is_x86_feature_detected!("avx2") {
            println!("skipped: no AVX2");
            return;
        }
        let (mut state, mut n_met) = (7, 0);
        for _ in 0..20_000 {
            let mut bytes =
                || u64::from_le_bytes(std::array::from_fn(|_| (number(&mut state) * 64.0 + 64.0) as u8));
            let near: [u64; 3] = std::array::from_fn(|_| bytes());
            let far = near.map(|word| word + bytes());
            let mut numbers = || std::array::from_fn(|_| number(&mut state));
            let (scale, offset) = (numbers().map(|x: f32| 1.0 + 0.5 * x), numbers().map(|x: f32| 64.0 * x));
            let planes = Planes { near, far, scale, offset };
            let t_max = 100.0 * number(&mut state).abs();
            let (mut portable, mut avx2) = ([0.0; 8], [0.0; 8]);
            // SAFETY: the instructions are there.
            let masks = unsafe {
                let portable = Portable::meet(&planes, 1.000001, t_max, &mut portable);
                (portable, Avx2::meet(&planes, 1.000001, t_max, &mut avx2))
            };
            assert_eq!(masks.0, masks.1);
            assert_eq!(portable.map(f32::to_bits), avx2.map(f32::to_bits));
            n_met += masks.0.count_ones();
        }
        assert!(n_met > 5_000, "only {n_met} boxes were met");
    }
}
