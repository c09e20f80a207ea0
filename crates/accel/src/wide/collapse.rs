//! Which nodes of a binary tree become children of one wide node, and in which slot each lies: the least cost
//! by the surface area heuristic, and children where rays of their octant meet them first (Ylitie et al.,
//! sections 3.1 and 3.2). The same tree as `obvhs`' own conversion makes, by all cores, and with a byte for
//! each decision where that keeps its cost too.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Vec3A, vec3a};
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

/// Children of a node at most.
const WIDTH: usize = 8;
/// The least numbers of slots a subtree is costed for: 1 to 7, so that its sibling has one at least.
const N_SHARES: usize = WIDTH - 1;
/// The test of a triangle, where a visit of a node is 1.
const TRIANGLE_COST: f32 = 0.3;
/// Subtrees below the first levels are costed one after another, those above at once.
const PARALLEL_LEVELS: usize = 12;
/// Set in the first of a node's bytes where it becomes a leaf.
const LEAF: u8 = 0x80;
/// In place of a split: the node itself takes the slot.
const WHOLE: u8 = 0xff;
/// The decisions for a leaf of the binary tree.
const AS_LEAF: [u8; WIDTH] = [LEAF, WHOLE, WHOLE, WHOLE, WHOLE, WHOLE, WHOLE, 0];

/// The decisions for each node of a binary tree whose leaves hold one reference each.
pub(super) struct Collapse<'a> {
    bvh: &'a Bvh2,
    /// A byte for each number of slots. The first: how many more than one the left child has of eight, and
    /// [`LEAF`]. The others: [`WHOLE`], or slots of both children together less one, shifted by 3, and those
    /// of the left one less one.
    decisions: Vec<AtomicU64>,
    max_leaf_size: u32,
    max_depth: usize,
}

/// What a subtree costs.
struct Cost {
    /// By the number of slots that it may take, less one.
    by_slots: [f32; N_SHARES],
    n_references: u32,
}

/// The slots of both children of a node, each less one.
type Split = (usize, usize);

impl<'a> Collapse<'a> {
    /// Decides for all nodes by what they cost; none where there are none, or where a leaf lies deeper than
    /// `max_depth`.
    pub fn by_cost(bvh: &'a Bvh2, max_leaf_size: u32, max_depth: usize) -> Option<Self> {
        let decisions = (0..bvh.nodes.len()).map(|_| AtomicU64::new(0)).collect();
        let collapse = Self { bvh, decisions, max_leaf_size, max_depth };
        if !bvh.nodes.is_empty() && collapse.decide(0, 0).is_some() { Some(collapse) } else { None }
    }

    /// Three levels of the binary tree a node, each reference in a leaf of its own: for a balanced tree, whose
    /// third part it is as deep.
    pub fn by_levels(bvh: &'a Bvh2) -> Self {
        // Of m slots the left child has half, rounded up; each number is one less.
        let halved = |more: usize| ((more << 3) | (more / 2)) as u8;
        let as_node = std::array::from_fn(|more| if more == 0 { (N_SHARES / 2) as u8 } else { halved(more) });
        let decision = |node: &Bvh2Node| u64::from_le_bytes(if node.is_leaf() { AS_LEAF } else { as_node });
        let decisions = bvh.nodes.iter().map(|node| AtomicU64::new(decision(node))).collect();
        Self { bvh, decisions, max_leaf_size: 1, max_depth: usize::MAX }
    }

    /// Decides for a subtree whose root is at `level`; none where it is too deep.
    fn decide(&self, index: usize, level: usize) -> Option<Cost> {
        let node = &self.bvh.nodes[index];
        let area = node.aabb().half_area();
        if node.is_leaf() {
            debug_assert_eq!(node.prim_count, 1);
            self.keep(index, AS_LEAF);
            return Some(Cost { by_slots: [area * TRIANGLE_COST; N_SHARES], n_references: 1 });
        }
        if level >= self.max_depth {
            return None;
        }
        let child = |place| self.decide(node.first_index as usize + place, level + 1);
        let (left, right) = match level < PARALLEL_LEVELS {
            true => rayon::join(|| child(0), || child(1)),
            false => (child(0), child(1)),
        };
        let (left, right) = (left?, right?);
        let n_references = left.n_references + right.n_references;
        let mut bytes = [0; WIDTH];
        let mut by_slots = [0.0; N_SHARES];
        let (inside, split) = cheapest_split(&left, &right, N_SHARES, f32::INFINITY);
        let fits = n_references <= self.max_leaf_size;
        let as_leaf = if fits { n_references as f32 * area * TRIANGLE_COST } else { f32::INFINITY };
        let as_node = inside + area;
        bytes[0] = split.unwrap_or(0) as u8 | if as_leaf < as_node { LEAF } else { 0 };
        by_slots[0] = as_leaf.min(as_node);
        for more in 1..N_SHARES {
            let (cost, split) = cheapest_split(&left, &right, more, by_slots[more - 1]);
            let fewer = if more == 1 { WHOLE } else { bytes[more - 1] };
            by_slots[more] = cost;
            bytes[more] = split.map_or(fewer, |left| (more << 3 | left) as u8);
        }
        self.keep(index, bytes);
        Some(Cost { by_slots, n_references })
    }

    fn keep(&self, index: usize, bytes: [u8; WIDTH]) {
        self.decisions[index].store(u64::from_le_bytes(bytes), Ordering::Relaxed);
    }

    fn decision(&self, index: u32, slots: usize) -> u8 {
        self.decisions[index as usize].load(Ordering::Relaxed).to_le_bytes()[slots]
    }

    fn node(&self, index: u32) -> &Bvh2Node {
        &self.bvh.nodes[index as usize]
    }

    /// Whether a child is a leaf.
    pub fn is_leaf(&self, index: u32) -> bool {
        self.decision(index, 0) & LEAF != 0
    }

    /// Calls `one` with each reference of a leaf.
    pub fn for_each_reference(&self, index: u32, one: &mut impl FnMut(u32)) {
        let node = self.node(index);
        if node.is_leaf() {
            return one(self.bvh.primitive_indices[node.first_index as usize]);
        }
        self.for_each_reference(node.first_index, one);
        self.for_each_reference(node.first_index + 1, one);
    }

    /// The children of the wide node that a binary one becomes, by their slots.
    pub fn children(&self, index: u32) -> [Option<u32>; WIDTH] {
        let mut found = Found { children: [index; WIDTH], n: 0 };
        if self.node(index).is_leaf() {
            found.n = 1;
        } else {
            let left = usize::from(self.decision(index, 0) & !LEAF);
            self.gather(index, (left, N_SHARES - 1 - left), &mut found);
        }
        self.ordered(index, &found.children[..found.n])
    }

    fn gather(&self, index: u32, (left, right): Split, found: &mut Found) {
        let first = self.node(index).first_index;
        for (child, slots) in [(first, left), (first + 1, right)] {
            let byte = if slots == 0 { WHOLE } else { self.decision(child, slots) };
            if byte == WHOLE {
                found.children[found.n] = child;
                found.n += 1;
            } else {
                let (both, left) = (usize::from(byte >> 3), usize::from(byte & 7));
                self.gather(child, (left, both - left - 1), found);
            }
        }
    }

    /// Each child in the slot in whose direction it lies farthest from the middle: greedily, the farthest
    /// of all first.
    fn ordered(&self, index: u32, children: &[u32]) -> [Option<u32>; WIDTH] {
        let middle = self.node(index).aabb().center();
        let mut costs = [[f32::MAX; WIDTH]; WIDTH];
        for (slot, direction) in DIRECTIONS.iter().enumerate() {
            for (costs, &child) in costs.iter_mut().zip(children) {
                costs[slot] = direction.dot(self.node(child).aabb().center() - middle);
            }
        }
        let mut slots = [None; WIDTH];
        let mut is_placed = [false; WIDTH];
        for _ in children {
            let (mut least, mut best) = (f32::MAX, None);
            for (child, costs) in costs[..children.len()].iter().enumerate().filter(|(c, _)| !is_placed[*c]) {
                for (slot, &cost) in costs.iter().enumerate() {
                    if slots[slot].is_none() && cost < least {
                        (least, best) = (cost, Some((child, slot)));
                    }
                }
            }
            // There are as many slots as children at least, and costs in a normalised scene are finite.
            if let Some((child, slot)) = best {
                is_placed[child] = true;
                slots[slot] = Some(children[child]);
            }
        }
        slots
    }
}

/// Children found so far.
struct Found {
    children: [u32; WIDTH],
    n: usize,
}

/// The octant of each slot: where its child is met first.
const DIRECTIONS: [Vec3A; WIDTH] = [
    vec3a(1.0, 1.0, 1.0),
    vec3a(1.0, 1.0, -1.0),
    vec3a(1.0, -1.0, 1.0),
    vec3a(1.0, -1.0, -1.0),
    vec3a(-1.0, 1.0, 1.0),
    vec3a(-1.0, 1.0, -1.0),
    vec3a(-1.0, -1.0, 1.0),
    vec3a(-1.0, -1.0, -1.0),
];

/// The least cost of two subtrees in `n` + 1 slots, and the left one's share less one; where none is below
/// `bound`, that.
fn cheapest_split(left: &Cost, right: &Cost, n: usize, bound: f32) -> (f32, Option<usize>) {
    let (mut least, mut share) = (bound, None);
    for k in 0..n {
        let cost = left.by_slots[k] + right.by_slots[n - 1 - k];
        if cost < least {
            (least, share) = (cost, Some(k));
        }
    }
    (least, share)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use obvhs::cwbvh::{bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode};

    use super::*;
    use crate::{BuildOptions, Child, topology, wide::pack::pack};

    /// Triangles of all sizes, from a generator of digits.
    fn triangles(n: usize) -> Vec<[Vec3; 3]> {
        let mut state = 0x9e37_79b9_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut point = |scale: f32| scale * Vec3::new(next(), next(), next());
        (0..n).map(|i| [point(1.0); 3].map(|p| p + point(0.5 / (1 + i % 30) as f32))).collect()
    }

    fn child_of(theirs: &CwBvhNode, slot: usize) -> Option<Child> {
        let (first, count) = theirs.child_primitives(slot);
        let inner = || Child::Inner(theirs.child_node_index(slot));
        let leaf = theirs.is_leaf(slot);
        (!theirs.is_child_empty(slot)).then(|| if leaf { Child::Leaf { first, count } } else { inner() })
    }

    #[test]
    fn the_tree_is_that_of_obvhs() {
        for n in [1, 2, 3, 4, 9, 57, 1000, 40_000] {
            let options = BuildOptions { max_leaf_size: 1, ..BuildOptions::default() };
            let (references, normalisation) = crate::collect(&triangles(n), &[], &options).expect("finite");
            let bvh = topology::build_singles(&references, &normalisation, &options).expect("no clusters");
            for max_leaf_size in 1..=3 {
                let theirs = bvh2_to_cwbvh(&bvh, max_leaf_size, true, false);
                let collapse = Collapse::by_cost(&bvh, max_leaf_size, usize::MAX).expect("not empty");
                let ours = pack(&collapse, &references);
                let primitive = |&r: &u32| references[r as usize].primitive;
                assert_eq!(
                    ours.primitives,
                    theirs.primitive_indices.iter().map(primitive).collect::<Vec<_>>()
                );
                assert_eq!(ours.nodes.len(), theirs.nodes.len());
                for (ours, theirs) in ours.nodes.iter().zip(&theirs.nodes) {
                    let ours = ours.children().map(|child| child.map(|(_, child)| child));
                    assert_eq!(ours, std::array::from_fn(|slot| child_of(theirs, slot)));
                }
            }
        }
    }

    #[test]
    fn what_is_too_deep_is_refused() {
        let options = BuildOptions { max_leaf_size: 1, ..BuildOptions::default() };
        let (references, normalisation) = crate::collect(&triangles(500), &[], &options).expect("finite");
        let bvh = topology::build_singles(&references, &normalisation, &options).expect("no clusters");
        let deepest =
            (1..64).find(|&depth| Collapse::by_cost(&bvh, 3, depth).is_some()).expect("is that deep");
        fn depth(bvh: &Bvh2, index: u32) -> usize {
            let node = &bvh.nodes[index as usize];
            let below = |place| 1 + depth(bvh, node.first_index + place);
            if node.is_leaf() { 0 } else { below(0).max(below(1)) }
        }
        assert_eq!(deepest, depth(&bvh, 0));
    }
}
