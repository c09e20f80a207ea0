use ::wgsl_cpu::runtime::{self as rt, Mat, Vec2, Vec3, Vec4};

#[inline]
pub fn expressions(a: Vec3<f32>, b: Vec3<f32>, i: i32, u: u32, c: bool) -> Vec4<f32> {
    let m = Mat::new([a, b, Vec3::new(a.z, a.y, a.x)]);
    let scaled = (2.0f32 * (m * b)) - (a / (b + Vec3::splat(1.0f32)));
    let ints = rt::shift_left(Vec2::new(i, i / 3i32), Vec2::splat(u));
    let e31 = (((rt::rem(i, -1i32) as f32) + ((u / 7u32) as f32)) + rt::bitcast_f32(u)) + (i.wrapping_neg() as f32);
    let x = e31 + rt::to_f32(c);
    let y = if c || ((i < 3i32) && (u > 2u32)) { b.y } else { a.x };
    let any_less = rt::any(rt::less(a, b));
    let k = rt::to_i32(a).at(u).wrapping_add(ints.y);
    Vec4::new(scaled.x, scaled.y, rt::mix(x, y, 0.25f32) + rt::min(a, b).z, ((k as f32) + rt::select(a, b, rt::greater_equal(a, b)).x) + rt::to_f32(any_less))
}
