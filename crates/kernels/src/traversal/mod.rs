//! The CPU's own traversal of the wide hierarchy, in place of what would be translated of
//! `wgsl/bindings/geometry_wide.wgsl`: the eight boxes of a node at once, nearer nodes first by distance,
//! and none that lies behind a hit. Triangles are intersected by the kernels' own function, so that
//! a hit has the same bits; of triangles at the same distance another one may win.

mod boxes;

use std::{mem::MaybeUninit, ops::Range};

use wgsl_cpu::runtime::{Storage, Vec3, Vec4};

use crate::{
    constants::{FAR_FACTOR, SLOT_CUTOUT, SLOT_INSTANCE, TRIANGLE_STRIDE, WIDE_STACK_SIZE, WIDE_STRIDE},
    native::lib,
};
use boxes::{Boxes, Entry, Planes};

/// Nodes that wait: of each level all but one of eight.
const MOST_WAITING: usize = 7 * WIDE_STACK_SIZE as usize + 1;
/// Bytes of a vec4.
const VEC4: usize = 16;
const NODE_BYTES: usize = WIDE_STRIDE as usize * VEC4;

/// Expands to a trace, in a module that has the kernels' `passes`: the nearest hit, or any one.
macro_rules! found {
    ($any:literal, $globals:expr, $origin:expr, $direction:expr, $t_max:expr) => {{
        let (globals, origin, direction) = ($globals, $origin, $direction);
        // SAFETY: the buffers hold a hierarchy, by `Globals::new`'s contract.
        unsafe {
            crate::traversal::trace::<$any>(
                globals.nodes,
                globals.triangles,
                origin,
                direction,
                $t_max,
                |id, u, v| passes(globals, id, u, v, origin, direction),
            )
        }
    }};
}
pub(crate) use found;

/// The body of the kernels' `closest_hit`.
macro_rules! closest_hit {
    ($globals:expr, $origin:expr, $direction:expr, $t_max:expr) => {{
        let found = crate::traversal::found!(false, $globals, $origin, $direction, $t_max);
        Hit { t: found.t, u: found.u, v: found.v, triangle: found.triangle }
    }};
}
pub(crate) use closest_hit;

/// The body of the kernels' `any_hit`.
macro_rules! any_hit {
    ($globals:expr, $origin:expr, $direction:expr, $t_max:expr) => {
        crate::traversal::found!(true, $globals, $origin, $direction, $t_max).triangle != NONE
    };
}
pub(crate) use any_hit;

/// A hit, or none.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Barycentric coordinate of the second vertex.
    pub u: f32,
    /// Barycentric coordinate of the third vertex.
    pub v: f32,
    /// The kernels' NONE where there is none.
    pub triangle: u32,
}

/// The nearest triangle at 0 < t < `t_max`, or any if `ANY`. `passes` says of one that is not solid
/// whether the ray does.
///
/// # Safety
/// The buffers hold a wide hierarchy as `wgsl/bindings/geometry.wgsl` says, and nothing writes them meanwhile.
#[inline]
pub unsafe fn trace<const ANY: bool>(
    nodes: Storage<'_>,
    triangles: Storage<'_>,
    origin: Vec3<f32>,
    direction: Vec3<f32>,
    t_max: f32,
    passes: impl Fn(u32, f32, f32) -> bool,
) -> Found {
    let search = Search { nodes, triangles, origin, direction, t_max };
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: AVX2 is there; else this function's contract.
        return unsafe { trace_avx2::<ANY>(&search, passes) };
    }
    // SAFETY: this function's contract.
    unsafe { search.run::<ANY, boxes::Portable>(passes) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn trace_avx2<const ANY: bool>(search: &Search<'_>, passes: impl Fn(u32, f32, f32) -> bool) -> Found {
    // SAFETY: the caller's contract.
    unsafe { search.run::<ANY, boxes::Avx2>(passes) }
}

struct Search<'a> {
    nodes: Storage<'a>,
    triangles: Storage<'a>,
    origin: Vec3<f32>,
    direction: Vec3<f32>,
    t_max: f32,
}

/// A ray in the frame of a hierarchy.
#[derive(Clone, Copy)]
struct LocalRay {
    origin: Vec3<f32>,
    direction: Vec3<f32>,
    inverse: Vec3<f32>,
    first_id: u32,
}

impl LocalRay {
    #[inline(always)]
    fn new(origin: Vec3<f32>, direction: Vec3<f32>, first_id: u32) -> Self {
        Self { origin, direction, inverse: lib::safe_inverse(direction), first_id }
    }
}

impl Search<'_> {
    /// # Safety
    /// As [`trace`]; the instructions of `B` are there.
    #[inline(always)]
    unsafe fn run<const ANY: bool, B: Boxes>(&self, passes: impl Fn(u32, f32, f32) -> bool) -> Found {
        let mut found = Found { t: self.t_max, u: 0.0, v: 0.0, triangle: crate::constants::NONE };
        let world = LocalRay::new(self.origin, self.direction, 0);
        // SAFETY: this function's contract.
        unsafe { self.descend::<ANY, true, B>(0, world, &mut found, &passes) };
        found
    }

    /// Searches one hierarchy from its root; true ends the whole search.
    ///
    /// # Safety
    /// As [`Search::run`].
    #[inline(always)]
    unsafe fn descend<const ANY: bool, const WORLD: bool, B: Boxes>(
        &self,
        root: u32,
        ray: LocalRay,
        found: &mut Found,
        passes: &impl Fn(u32, f32, f32) -> bool,
    ) -> bool {
        let mut stack = [const { MaybeUninit::<Entry>::uninit() }; MOST_WAITING];
        stack[0].write(Entry::new(0.0, root));
        let mut top = 1;
        while top > 0 {
            top -= 1;
            // SAFETY: below `top` all are written.
            let entry = unsafe { stack[top].assume_init() };
            if entry.distance() > found.t {
                continue;
            }
            // SAFETY: references in nodes lead to nodes.
            let node = unsafe { Node::load(self.nodes, entry.node()) };
            let mut met = [0.0; 8];
            // SAFETY: the instructions of `B` are there.
            let mask = unsafe { B::meet(&node.planes(&ray), FAR_FACTOR, found.t, &mut met) };
            let first = top;
            for slot in bits(mask & node.inner) {
                let child = node.child(slot);
                self.nodes.prefetch(child as usize * NODE_BYTES);
                // Few: the farthest at the bottom.
                let new = Entry::new(met[slot as usize], child);
                let mut place = top;
                // SAFETY: below `top` all are written.
                while place > first && unsafe { stack[place - 1].assume_init() }.is_nearer(new) {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
                stack[place].write(new);
                top += 1;
            }
            for slot in bits(mask & !node.inner) {
                for slot in node.leaf(slot) {
                    // SAFETY: leaves refer to slots.
                    if unsafe { self.slot::<ANY, WORLD, B>(slot, &ray, found, passes) } {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Tries a leaf slot; true ends the whole search.
    ///
    /// # Safety
    /// As [`Search::run`].
    #[inline(always)]
    unsafe fn slot<const ANY: bool, const WORLD: bool, B: Boxes>(
        &self,
        slot: u32,
        ray: &LocalRay,
        found: &mut Found,
        passes: &impl Fn(u32, f32, f32) -> bool,
    ) -> bool {
        let stride = TRIANGLE_STRIDE as usize * VEC4;
        // SAFETY: a slot is in range, by this function's contract.
        let [v0, e1, e2]: [Vec4<f32>; 3] = unsafe {
            let at = self.triangles.at(slot as usize * stride);
            [at.load(), at.at(VEC4).load(), at.at(2 * VEC4).load()]
        };
        let kind = e1.w.to_bits();
        if WORLD && kind == SLOT_INSTANCE {
            // SAFETY: this function's contract.
            return unsafe { self.enter::<ANY, B>(v0.w.to_bits(), found, passes) };
        }
        let xyz = |v: Vec4<f32>| Vec3::new(v.x, v.y, v.z);
        let tuv = lib::intersect_triangle(xyz(v0), xyz(e1), xyz(e2), ray.origin, ray.direction);
        if !(tuv.x > 0.0 && tuv.x < found.t) {
            return false;
        }
        let id = ray.first_id.wrapping_add(v0.w.to_bits());
        if kind == SLOT_CUTOUT && passes(id, tuv.y, tuv.z) {
            return false;
        }
        *found = Found { t: tuv.x, u: tuv.y, v: tuv.z, triangle: id };
        ANY
    }

    /// Searches the mesh that a record places.
    ///
    /// # Safety
    /// As [`Search::run`].
    #[inline(never)]
    unsafe fn enter<const ANY: bool, B: Boxes>(
        &self,
        record: u32,
        found: &mut Found,
        passes: &impl Fn(u32, f32, f32) -> bool,
    ) -> bool {
        // SAFETY: a record is in range, by this function's contract.
        let ([x, y, z], ids): ([Vec4<f32>; 3], Vec4<u32>) = unsafe {
            let at = self.nodes.at(record as usize * VEC4);
            ([at.load(), at.at(VEC4).load(), at.at(2 * VEC4).load()], at.at(3 * VEC4).load())
        };
        let from_mesh = self.origin - Vec3::new(x.w, y.w, z.w);
        let along = |v: Vec3<f32>| {
            let dot = |row: Vec4<f32>| wgsl_cpu::runtime::dot(Vec3::new(row.x, row.y, row.z), v);
            Vec3::new(dot(x), dot(y), dot(z))
        };
        let ray = LocalRay::new(along(from_mesh), along(self.direction), ids.y);
        // SAFETY: this function's contract.
        unsafe { self.descend::<ANY, false, B>(ids.x, ray, found, passes) }
    }
}

/// The places of a word's bits, from the lowest.
#[inline(always)]
fn bits(mut word: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let place = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (place < 32).then_some(place)
    })
}

/// A node's words.
struct Node {
    origin: [f32; 3],
    step: [f32; 3],
    /// Least and greatest of each child along each axis: bytes.
    least: [u64; 3],
    greatest: [u64; 3],
    meta: u64,
    /// Which children are nodes.
    inner: u32,
    first_node: u32,
    first_slot: u32,
}

impl Node {
    /// # Safety
    /// There is a node of this index.
    #[inline(always)]
    unsafe fn load(nodes: Storage<'_>, index: u32) -> Self {
        // SAFETY: this function's contract.
        let n: [Vec4<u32>; 5] = unsafe {
            let at = nodes.at(index as usize * NODE_BYTES);
            std::array::from_fn(|i| at.at(i * VEC4).load())
        };
        let wide = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        let step = |shift: u32| f32::from_bits((n[0].w >> shift & 0xff) << 23);
        Self {
            origin: [n[0].x, n[0].y, n[0].z].map(f32::from_bits),
            step: [step(0), step(8), step(16)],
            least: [wide(n[2].x, n[2].y), wide(n[2].z, n[2].w), wide(n[3].x, n[3].y)],
            greatest: [wide(n[3].z, n[3].w), wide(n[4].x, n[4].y), wide(n[4].z, n[4].w)],
            meta: wide(n[1].z, n[1].w),
            inner: n[0].w >> 24,
            first_node: n[1].x,
            first_slot: n[1].y,
        }
    }

    /// The node that a child is.
    #[inline(always)]
    fn child(&self, slot: u32) -> u32 {
        self.first_node + (self.inner & !(u32::MAX << slot)).count_ones()
    }

    /// The leaf slots of a child that is a leaf.
    #[inline(always)]
    fn leaf(&self, slot: u32) -> Range<u32> {
        let meta = (self.meta >> (8 * slot)) as u32 & 0xff;
        let first = self.first_slot + (meta & 0x1f);
        first..first + (meta >> 5).count_ones()
    }

    /// Its planes as a ray meets them.
    #[inline(always)]
    fn planes(&self, ray: &LocalRay) -> Planes {
        let (origin, inverse) = (ray.origin.to_array(), ray.inverse.to_array());
        let sorted = |axis: usize| {
            let (least, greatest) = (self.least[axis], self.greatest[axis]);
            if inverse[axis] < 0.0 { (greatest, least) } else { (least, greatest) }
        };
        Planes {
            near: std::array::from_fn(|axis| sorted(axis).0),
            far: std::array::from_fn(|axis| sorted(axis).1),
            scale: std::array::from_fn(|axis| self.step[axis] * inverse[axis]),
            offset: std::array::from_fn(|axis| (self.origin[axis] - origin[axis]) * inverse[axis]),
        }
    }
}
