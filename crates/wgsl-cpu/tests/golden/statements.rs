use ::wgsl_cpu::runtime::{self as rt, Mat, Vec2, Vec3, Vec4};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum {
    pub total: f32,
    pub gen_: u32,
}

impl rt::Zero for Sum {
    const ZERO: Self = Self {
        total: rt::zero(),
        gen_: rt::zero(),
    };
}

pub const LIMIT: u32 = 10u32;
pub static TABLE: [f32; 3] = [0.5f32, -0.0f32, 9.536743e-7f32];

#[inline]
pub fn sum_up(values: &mut [f32; 4], box_: u32) -> Sum {
    let mut sum: Sum = rt::zero::<Sum>();
    let mut i: u32 = 0u32;
    'loop_1: loop {
        'continue_1: {
            if !((i < 4u32) && (sum.total < 10000000000.0f32)) {
                break 'loop_1;
            }
            if i == box_ {
                break 'continue_1;
            }
            let part = values[rt::index(i, 4)];
            sum.total = sum.total + (part * TABLE[rt::index(i, 3)]);
            'switch_2: { match i {
                0u32 | 1u32 => {
                    if part < 0.0f32 {
                        break 'switch_2;
                    }
                    sum.gen_ = sum.gen_ | 1u32.wrapping_shl(i);
                }
                _ => {
                    sum.gen_ = rt::rem(sum.gen_, LIMIT);
                }
            } }
        }
        i = i.wrapping_add(1u32);
    }
    loop {
        let half = 0.5f32 * sum.total;
        if half < 1.0f32 {
            break;
        }
        sum.total = half;
        if sum.gen_ == 3u32 { break; }
    }
    if sum.gen_ == 0u32 {
        return Sum { total: 1.0f32, gen_: 0u32 };
    } else if sum.gen_ == 1u32 {
        sum.gen_ = 2u32;
    } else {
        sum.gen_ = 5u32;
    }
    sum
}
