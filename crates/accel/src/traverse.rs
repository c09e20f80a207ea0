//! The closest hit on the host: the reference that kernels are tested against, and what answers
//! the host's own questions (which medium a camera is in).

use glam::{DVec3, Vec3};

use crate::{Bounds, Bvh, Child, STACK_SIZE, WideBvh};

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// The placement that the triangle belongs to; none for the world's own.
    pub placement: Option<u32>,
    /// Index into the triangles given to the build, of the placed mesh or of the world.
    pub triangle: u32,
    /// Barycentric coordinate of the second vertex.
    pub u: f32,
    /// Barycentric coordinate of the third vertex.
    pub v: f32,
}

/// Far distances are scaled by 1 + 2γ(3) (Ize 2013), so that rounding loses no hit.
const ROBUST_FAR: f32 = 1.0 + 6.0 * f32::EPSILON;
/// Stands for a zero component of a direction, so that no slab is 0 × ∞.
const SMALLEST_COMPONENT: f32 = 1e-30;

/// What the host needs to know of a hierarchy.
pub trait Hierarchy {
    /// A node's children with their boxes; node 0 is the root.
    fn children(&self, node: u32) -> impl Iterator<Item = (Bounds, Child)>;
    /// The triangle in each leaf slot, or from the number of triangles on an instance.
    fn primitives(&self) -> &[u32];
    /// How many triangles there are.
    fn n_triangles(&self) -> u32;
}

impl Hierarchy for Bvh {
    fn children(&self, node: u32) -> impl Iterator<Item = (Bounds, Child)> {
        self.children(node).into_iter()
    }

    fn primitives(&self) -> &[u32] {
        &self.primitives
    }

    fn n_triangles(&self) -> u32 {
        self.statistics.triangles as u32
    }
}

impl Hierarchy for WideBvh {
    fn children(&self, node: u32) -> impl Iterator<Item = (Bounds, Child)> {
        self.nodes[node as usize].children().into_iter().flatten()
    }

    fn primitives(&self) -> &[u32] {
        &self.primitives
    }

    fn n_triangles(&self) -> u32 {
        self.statistics.triangles as u32
    }
}

/// The closest hit with 0 < t < `t_max`, both faces counting; none where there is none, or where
/// the ray is not finite. Of hits at the same distance the lowest triangle index. `triangles` are
/// those that the hierarchy was built over, without instances.
///
/// # Panics
///
/// Where `triangles` are fewer than that.
pub fn closest_hit(
    bvh: &impl Hierarchy,
    triangles: &[[Vec3; 3]],
    origin: Vec3,
    dir: Vec3,
    t_max: f32,
) -> Option<Hit> {
    traverse(bvh, |t| triangles[t as usize], |_, _| None, origin, dir, t_max)
}

/// As [`closest_hit`]; `instance` gives the closest hit on an instance nearer than a distance.
pub(crate) fn traverse(
    bvh: &impl Hierarchy,
    triangle: impl Fn(u32) -> [Vec3; 3],
    instance: impl Fn(u32, f32) -> Option<Hit>,
    origin: Vec3,
    dir: Vec3,
    t_max: f32,
) -> Option<Hit> {
    if !origin.is_finite() || !dir.is_finite() {
        return None;
    }
    let inv_dir =
        dir.map(|c| if c.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(c) } else { c }).recip();
    let mut closest: Option<Hit> = None;
    let mut stack = Vec::with_capacity(STACK_SIZE);
    stack.push(0u32);
    while let Some(node) = stack.pop() {
        for (bounds, child) in bvh.children(node) {
            let limit = closest.map_or(t_max, |h| h.t);
            if !meets(&bounds, origin, inv_dir, limit) {
                continue;
            }
            match child {
                Child::Inner(inner) => stack.push(inner),
                Child::Leaf { first, count } => {
                    for &index in &bvh.primitives()[first as usize..(first + count) as usize] {
                        let limit = closest.map_or(t_max, |h| h.t);
                        let hit = match index.checked_sub(bvh.n_triangles()) {
                            None => intersect(&triangle(index), origin, dir, index),
                            Some(index) => instance(index, limit.next_up()),
                        };
                        closest = nearer(closest, hit, t_max);
                    }
                }
            }
        }
    }
    closest
}

fn nearer(old: Option<Hit>, new: Option<Hit>, t_max: f32) -> Option<Hit> {
    let order = |h: &Hit| (h.t, h.placement, h.triangle);
    match (old, new) {
        (_, Some(n)) if n.t >= t_max => old,
        (Some(o), Some(n)) if order(&o) <= order(&n) => Some(o),
        (old, new) => new.or(old),
    }
}

fn meets(bounds: &Bounds, origin: Vec3, inv_dir: Vec3, limit: f32) -> bool {
    let a = (bounds.min - origin) * inv_dir;
    let b = (bounds.max - origin) * inv_dir;
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element() * ROBUST_FAR;
    near <= far && near <= limit * ROBUST_FAR
}

/// Möller and Trumbore (1997), in f64. None where the triangle has no area or is seen edge on.
fn intersect(vertices: &[Vec3; 3], origin: Vec3, dir: Vec3, triangle: u32) -> Option<Hit> {
    let [v0, v1, v2] = vertices.map(Vec3::as_dvec3);
    let d: DVec3 = dir.as_dvec3();
    let (e1, e2) = (v1 - v0, v2 - v0);
    let p = d.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let s = origin.as_dvec3() - v0;
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = d.dot(q) / det;
    let t = (e2.dot(q) / det) as f32;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t.is_finite();
    inside.then_some(Hit { t, placement: None, triangle, u: u as f32, v: v as f32 })
}
