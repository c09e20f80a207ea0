//! `traverse.wgsl` written in Rust by hand: what the translated kernel is measured and tested
//! against.

use crate::scene::LEAF;

type Vec3 = [f32; 3];

fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn xyz([x, y, z, _]: [f32; 4]) -> Vec3 {
    [x, y, z]
}

/// The distance to a box, 1e30 if it is missed.
#[inline(always)]
fn enter(low: Vec3, high: Vec3, origin: Vec3, inverse: Vec3, t_max: f32) -> f32 {
    let (mut near, mut far) = (0.0f32, t_max);
    for axis in 0..3 {
        let a = (low[axis] - origin[axis]) * inverse[axis];
        let b = (high[axis] - origin[axis]) * inverse[axis];
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    if near <= far { near } else { 1e30 }
}

/// `(t, u, v, triangle)` if the triangle is hit before `t_max`.
#[inline(always)]
fn intersect(
    triangles: &[[f32; 4]],
    triangle: u32,
    origin: Vec3,
    direction: Vec3,
    t_max: f32,
) -> Option<[f32; 4]> {
    let first = 3 * triangle as usize;
    let [v0, e1, e2] = [0, 1, 2].map(|i| xyz(triangles[first + i]));
    let p = cross(direction, e2);
    let det = dot(e1, p);
    if det == 0.0 {
        return None;
    }
    let inverse = 1.0 / det;
    let s = sub(origin, v0);
    let u = dot(s, p) * inverse;
    let q = cross(s, e1);
    let v = dot(direction, q) * inverse;
    let t = dot(e2, q) * inverse;
    let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < t_max;
    is_hit.then_some([t, u, v, f32::from_bits(triangle)])
}

/// The closest hit, `(1e30, 0, 0, NONE)` if there is none.
pub fn closest(
    nodes: &[[f32; 4]],
    triangles: &[[f32; 4]],
    origin: [f32; 4],
    direction: [f32; 4],
) -> [f32; 4] {
    let (origin, direction) = (xyz(origin), xyz(direction));
    let inverse = direction.map(|d| 1.0 / d);
    let mut hit = [1e30, 0.0, 0.0, f32::from_bits(u32::MAX)];
    let mut stack = [0u32; 64];
    let mut depth = 0;
    let mut at = 0u32;
    loop {
        while at & LEAF == 0 {
            let first = 4 * at as usize;
            let [n0, n1, n2, n3] = [nodes[first], nodes[first + 1], nodes[first + 2], nodes[first + 3]];
            let t_left = enter(xyz(n0), [n0[3], n1[0], n1[1]], origin, inverse, hit[0]);
            let t_right = enter([n1[2], n1[3], n2[0]], [n2[1], n2[2], n2[3]], origin, inverse, hit[0]);
            let (left, right) = (n3[0].to_bits(), n3[1].to_bits());
            let (near, far) = if t_left <= t_right { (left, right) } else { (right, left) };
            if t_left.max(t_right) < 1e30 {
                stack[depth] = far;
                depth += 1;
            }
            if t_left.min(t_right) < 1e30 {
                at = near;
            } else if depth == 0 {
                return hit;
            } else {
                depth -= 1;
                at = stack[depth];
            }
        }
        if let Some(closer) = intersect(triangles, at & !LEAF, origin, direction, hit[0]) {
            hit = closer;
        }
        if depth == 0 {
            return hit;
        }
        depth -= 1;
        at = stack[depth];
    }
}
