//! Wide nodes from the decisions of a collapse, with boxes of our own.

use midway_scene::Bounds;
use rayon::prelude::*;

use super::{WideBvh, WideNode, collapse::Collapse};
use crate::{Child, Statistics, references::Reference};

/// Levels of wide nodes whose subtrees are packed at once: up to 64.
const PARALLEL_LEVELS: usize = 2;

/// What lies below a node: nodes, of which its own children come first, and what is in leaves. Numbered from
/// its own first.
#[derive(Default)]
struct Below {
    nodes: Vec<WideNode>,
    primitives: Vec<u32>,
    leaves: usize,
    /// The sum of areas by what a visit costs.
    area_cost: f64,
}

/// A node that is packed.
struct Root {
    node: WideNode,
    bounds: Bounds,
    depth: usize,
}

/// A node whose leaves are packed, and whose children that are nodes have their places.
struct Open {
    children: [Option<(Bounds, Child)>; 8],
    /// Slots and binary nodes of those that are nodes.
    inner: [(usize, u32); 8],
    n_inner: usize,
    first_node: usize,
    depth: usize,
}

/// Packs all nodes; references are those that the binary tree is over.
pub(super) fn pack(collapse: &Collapse<'_>, references: &[Reference]) -> WideBvh {
    let packer = Packer { collapse, references };
    let mut below = Below { nodes: vec![WideNode::EMPTY], ..Below::default() };
    let root = packer.grow(0, PARALLEL_LEVELS, &mut below);
    below.nodes[0] = root.node;
    let area = root.bounds.half_area();
    let statistics = Statistics {
        inner_nodes: below.nodes.len(),
        leaves: below.leaves,
        sah_cost: if area > 0.0 { (below.area_cost / area) as f32 } else { 0.0 },
        ..Statistics::default()
    };
    let Below { nodes, primitives, .. } = below;
    WideBvh { nodes, primitives, max_depth: root.depth, bounds: root.bounds, statistics }
}

struct Packer<'a> {
    collapse: &'a Collapse<'a>,
    references: &'a [Reference],
}

impl Packer<'_> {
    /// Packs a subtree, on all cores as long as `levels` are left.
    fn grow(&self, source: u32, levels: usize, below: &mut Below) -> Root {
        if levels == 0 {
            return self.fill(source, below);
        }
        let mut open = self.open(source, below);
        let grow = |&(_, source): &(usize, u32)| {
            let mut below = Below::default();
            (self.grow(source, levels - 1, &mut below), below)
        };
        let grown: Vec<(Root, Below)> = open.inner().par_iter().map(grow).collect();
        below.nodes.reserve_exact(grown.iter().map(|(_, more)| more.nodes.len()).sum());
        below.primitives.reserve_exact(grown.iter().map(|(_, more)| more.primitives.len()).sum());
        for (place, (mut root, more)) in grown.into_iter().enumerate() {
            root.node = below.append(root.node, more);
            open.place(place, &root, below);
        }
        open.close(below)
    }

    /// Packs a subtree, one node after another.
    fn fill(&self, source: u32, below: &mut Below) -> Root {
        let mut open = self.open(source, below);
        for place in 0..open.n_inner {
            let root = self.fill(open.inner[place].1, below);
            open.place(place, &root, below);
        }
        open.close(below)
    }

    fn open(&self, source: u32, below: &mut Below) -> Open {
        let first_node = below.nodes.len();
        let mut open = Open { children: [None; 8], inner: [(0, 0); 8], n_inner: 0, first_node, depth: 1 };
        for (slot, child) in self.collapse.children(source).into_iter().enumerate() {
            let Some(child) = child else { continue };
            if !self.collapse.is_leaf(child) {
                open.inner[open.n_inner] = (slot, child);
                open.n_inner += 1;
                continue;
            }
            let (first, mut around) = (below.primitives.len(), Bounds::EMPTY);
            self.collapse.for_each_reference(child, &mut |reference| {
                let Reference { primitive, bounds } = self.references[reference as usize];
                below.primitives.push(primitive);
                around = around.union(bounds);
            });
            let count = (below.primitives.len() - first) as u32;
            below.leaves += 1;
            below.area_cost += around.half_area() * f64::from(count);
            open.children[slot] = Some((around, Child::Leaf { first: first as u32, count }));
        }
        below.nodes.resize(first_node + open.n_inner, WideNode::EMPTY);
        open
    }
}

impl Open {
    fn inner(&self) -> &[(usize, u32)] {
        &self.inner[..self.n_inner]
    }

    /// Puts the child that is the `place`th node to where it was waited for.
    fn place(&mut self, place: usize, root: &Root, below: &mut Below) {
        let node = self.first_node + place;
        below.nodes[node] = root.node;
        self.children[self.inner[place].0] = Some((root.bounds, Child::Inner(node as u32)));
        self.depth = self.depth.max(1 + root.depth);
    }

    fn close(self, below: &mut Below) -> Root {
        let around = |all: Bounds, child: &(Bounds, Child)| all.union(child.0);
        let bounds = self.children.iter().flatten().fold(Bounds::EMPTY, around);
        below.area_cost += bounds.half_area();
        Root { node: WideNode::new(&bounds, &self.children), bounds, depth: self.depth }
    }
}

impl Below {
    /// Appends what lies below a node; the node as it then is.
    fn append(&mut self, node: WideNode, more: Self) -> WideNode {
        let (first_node, first_slot) = (self.nodes.len() as u32, self.primitives.len() as u32);
        self.nodes.extend(more.nodes.iter().map(|node| node.moved(first_node, first_slot)));
        self.primitives.extend(more.primitives);
        self.leaves += more.leaves;
        self.area_cost += more.area_cost;
        node.moved(first_node, first_slot)
    }
}
