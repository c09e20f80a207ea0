//! From a tree to the layout kernels read.

use glam::Vec3;
use midway_scene::Bounds;

use crate::{
    Bvh, LEAF_BIT, Statistics,
    references::Reference,
    topology::{Tree, TreeNode},
};

/// A decoded child reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Index of a node.
    Inner(u32),
    /// A range of [`Bvh::primitives`].
    Leaf {
        /// Its first slot.
        first: u32,
        /// Slots, 0 for an absent child.
        count: u32,
    },
}

impl Child {
    const ABSENT: Self = Self::Leaf { first: 0, count: 0 };

    /// From the bits in a node.
    pub fn decode(bits: u32) -> Self {
        if bits & LEAF_BIT == 0 {
            return Self::Inner(bits);
        }
        Self::Leaf { first: (bits & !LEAF_BIT) >> 4, count: bits & 0xf }
    }

    /// To the bits in a node.
    pub fn encode(self) -> u32 {
        match self {
            Self::Inner(node) => node,
            Self::Leaf { first, count } => LEAF_BIT | (first << 4) | count,
        }
    }
}

impl Bvh {
    /// A node's children with their boxes, left first.
    ///
    /// # Panics
    ///
    /// Where `node` is not an index of a node.
    pub fn children(&self, node: u32) -> [(Bounds, Child); 2] {
        let base = node as usize * 4;
        let v = &self.nodes[base..base + 4];
        let corner = |i: usize| Vec3::from_array([v[i][0], v[i][1], v[i][2]].map(f32::from_bits));
        let child = |i: usize, bits: u32| {
            let bounds = Bounds { min: corner(i), max: corner(i + 1) };
            (bounds, Child::decode(bits))
        };
        [child(0, v[0][3]), child(2, v[1][3])]
    }

    /// Its nodes where this many nodes and leaf slots lie before its own.
    pub(crate) fn moved_nodes(&self, first_node: u32, first_slot: u32) -> impl Iterator<Item = [u32; 4]> {
        let moved = move |bits: u32| match Child::decode(bits) {
            Child::Inner(node) => Child::Inner(first_node + node).encode(),
            Child::Leaf { first, count } => Child::Leaf { first: first_slot + first, count }.encode(),
        };
        // References are in the first two.
        let move_row =
            move |row: usize, [x, y, z, w]: [u32; 4]| [x, y, z, if row < 2 { moved(w) } else { w }];
        self.nodes.iter().enumerate().map(move |(at, &words)| move_row(at % Self::NODE_VEC4, words))
    }

    fn write_node(&mut self, node: u32, children: [(Bounds, Child); 2]) {
        let base = node as usize * 4;
        let [(left, left_child), (right, right_child)] = children;
        let vec4 = |corner: Vec3, w: u32| {
            let [x, y, z] = corner.to_array().map(f32::to_bits);
            [x, y, z, w]
        };
        self.nodes[base] = vec4(left.min, left_child.encode());
        self.nodes[base + 1] = vec4(left.max, right_child.encode());
        self.nodes[base + 2] = vec4(right.min, 0);
        self.nodes[base + 3] = vec4(right.max, 0);
    }
}

/// Packs depth first, so that a node's left child follows it in memory.
pub(crate) fn pack(tree: &Tree, references: &[Reference], n_triangles: usize) -> Bvh {
    let bvh = Bvh {
        nodes: Vec::new(),
        primitives: Vec::with_capacity(references.len()),
        max_depth: 0,
        bounds: Bounds::EMPTY,
        statistics: Statistics {
            triangles: n_triangles,
            balanced_fallback: tree.balanced_fallback,
            ..Statistics::default()
        },
    };
    let mut packer = Packer { tree, references, bvh, area_cost: 0.0 };
    match tree.root {
        Some(root) if matches!(tree.nodes[root], TreeNode::Inner { .. }) => {
            packer.bvh.bounds = packer.visit(root, 0).0;
        }
        root => packer.lone_root(root),
    }
    packer.finish()
}

struct Packer<'a> {
    tree: &'a Tree,
    references: &'a [Reference],
    bvh: Bvh,
    /// Σ half area × (1 for a node, its count for a leaf).
    area_cost: f64,
}

impl Packer<'_> {
    /// Emits a subtree; the recursion is as deep as the tree, which is below `STACK_SIZE`.
    fn visit(&mut self, node: usize, inner_above: usize) -> (Bounds, Child) {
        match self.tree.nodes[node] {
            TreeNode::Leaf { first, count } => self.leaf(first, count),
            TreeNode::Inner { left, right } => {
                let index = self.new_node();
                self.bvh.max_depth = self.bvh.max_depth.max(inner_above + 1);
                let left = self.visit(left, inner_above + 1);
                let right = self.visit(right, inner_above + 1);
                self.bvh.write_node(index, [left, right]);
                let bounds = left.0.union(right.0);
                self.area_cost += bounds.half_area();
                (bounds, Child::Inner(index))
            }
        }
    }

    fn leaf(&mut self, first: usize, count: usize) -> (Bounds, Child) {
        let members = &self.tree.order[first..first + count];
        let slots = self.bvh.primitives.len();
        let mut bounds = Bounds::EMPTY;
        for &member in members {
            let reference = &self.references[member as usize];
            bounds = bounds.union(reference.bounds);
            self.bvh.primitives.push(reference.primitive);
        }
        // Pieces of one triangle that met again in this leaf are one slot.
        let mut own = self.bvh.primitives.split_off(slots);
        own.sort_unstable();
        own.dedup();
        let count = own.len() as u32;
        self.bvh.primitives.extend(own);
        self.bvh.statistics.leaves += 1;
        self.area_cost += bounds.half_area() * f64::from(count);
        let first = slots as u32;
        (bounds, Child::Leaf { first, count })
    }

    fn new_node(&mut self) -> u32 {
        let index = self.bvh.statistics.inner_nodes as u32;
        self.bvh.statistics.inner_nodes += 1;
        self.bvh.nodes.resize(self.bvh.nodes.len() + 4, [0; 4]);
        index
    }

    /// A root above fewer than two leaves.
    fn lone_root(&mut self, leaf: Option<usize>) {
        let index = self.new_node();
        let absent = (Bounds::EMPTY, Child::ABSENT);
        let left = leaf.map_or(absent, |leaf| self.visit(leaf, 1));
        self.bvh.write_node(index, [left, absent]);
        self.bvh.bounds = left.0;
        self.bvh.max_depth = 1;
        self.area_cost += left.0.half_area();
    }

    fn finish(mut self) -> Bvh {
        let root_area = self.bvh.bounds.half_area();
        let statistics = &mut self.bvh.statistics;
        if root_area > 0.0 {
            statistics.sah_cost = (self.area_cost / root_area) as f32;
        }
        statistics.duplicated_references = self.bvh.primitives.len() - statistics.triangles;
        self.bvh
    }
}
