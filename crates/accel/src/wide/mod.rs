//! The compressed wide hierarchy: eight children a node, whose boxes take a byte a plane (Ylitie,
//! Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
//! HPG 2017).
//!
//! Which nodes become children of one, and in which slot a child lies, is `obvhs`' doing; boxes are
//! taken anew from the triangles' own padded ones, so that they hold in the kernels' arithmetic.

mod node;
mod validate;

use std::time::Instant;

use glam::Vec3;
use midway_scene::Bounds;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode},
};
use rayon::prelude::*;

use crate::{
    AccelError, BuildOptions, Child, Statistics,
    references::{Normalisation, Reference},
    topology::{self, Tree, TreeNode},
};

pub use node::WideNode;

/// The most triangles of a child: their number is in unary, in three bits.
const MAX_WIDE_LEAF: usize = 3;

/// A compressed wide hierarchy, packed for kernels.
#[derive(Clone, Debug, PartialEq)]
pub struct WideBvh {
    /// Nodes, the root first: see [`WideNode`].
    pub nodes: Vec<WideNode>,
    /// The triangle in each leaf slot; with spatial splits one may be in several leaves. From the
    /// number of triangles on: instances.
    pub primitives: Vec<u32>,
    /// Nodes on the longest way from the root down; below [`crate::STACK_SIZE`], since each holds one of the
    /// binary tree's at least.
    pub max_depth: usize,
    /// Around everything, padded; inverted where there is nothing.
    pub bounds: Bounds,
    /// What the build did.
    pub statistics: Statistics,
}

impl WideBvh {
    /// Bytes that `nodes` and `primitives` take.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.primitives.as_slice())
    }
}

/// Builds a compressed wide hierarchy over triangles, as [`crate::build`] does a binary one.
///
/// # Errors
///
/// As [`crate::build`].
pub fn build_wide(triangles: &[[Vec3; 3]], options: &BuildOptions) -> Result<WideBvh, AccelError> {
    build_wide_with_instances(triangles, &[], options)
}

/// As [`build_wide`], over instances too, which are never split. `instances`: around each, finite and not
/// empty.
///
/// # Errors
///
/// As [`crate::build`].
pub fn build_wide_with_instances(
    triangles: &[[Vec3; 3]],
    instances: &[Bounds],
    options: &BuildOptions,
) -> Result<WideBvh, AccelError> {
    let start = Instant::now();
    let max_leaf_size = options.max_leaf_size.clamp(1, MAX_WIDE_LEAF);
    // A wide leaf is gathered from binary ones that hold one reference each.
    let binary = BuildOptions { max_leaf_size: 1, ..*options };
    let (references, normalisation) = crate::collect(triangles, instances, &binary)?;
    let mut balanced_fallback = false;
    let bvh = topology::build_singles(&references, &normalisation, &binary).or_else(|| {
        let tree = topology::build(&references, triangles.len(), &normalisation, &binary);
        balanced_fallback = tree.balanced_fallback;
        to_obvhs(&tree, &references, &normalisation)
    });
    let wide = bvh.map_or_else(CwBvh::default, |bvh| bvh2_to_cwbvh(&bvh, max_leaf_size as u32, true, false));
    let mut wide = pack(&wide, &references);
    wide.statistics = Statistics {
        triangles: triangles.len(),
        duplicated_references: wide.primitives.len().saturating_sub(triangles.len() + instances.len()),
        balanced_fallback,
        build_time: start.elapsed(),
        ..wide.statistics
    };
    Ok(wide)
}

/// A tree whose leaves hold one reference each, as `obvhs` has them; none where it is empty.
fn to_obvhs(tree: &Tree, references: &[Reference], normalisation: &Normalisation) -> Option<Bvh2> {
    let mut sources = vec![tree.root?];
    let mut nodes = vec![Bvh2Node::default()];
    let mut at = 0;
    while at < nodes.len() {
        match tree.nodes[sources[at]] {
            TreeNode::Inner { left, right } => {
                nodes[at] = Bvh2Node::new(Aabb::INVALID, 0, nodes.len() as u32);
                sources.extend([left, right]);
                nodes.extend([Bvh2Node::default(); 2]);
            }
            TreeNode::Leaf { first, count } => {
                debug_assert_eq!(count, 1);
                let bounds = &references[tree.order[first] as usize].bounds;
                nodes[at] = Bvh2Node::new(normalisation.bounds(bounds), 1, first as u32);
            }
        }
        at += 1;
    }
    // Children come after their parents.
    for i in (0..nodes.len()).rev().filter(|&i| tree_is_inner(tree, sources[i])) {
        let first = nodes[i].first_index as usize;
        let bounds = nodes[first].aabb().union(nodes[first + 1].aabb());
        nodes[i].set_aabb(bounds);
    }
    Some(Bvh2 { nodes, primitive_indices: tree.order.clone(), ..Bvh2::default() })
}

fn tree_is_inner(tree: &Tree, node: usize) -> bool {
    matches!(tree.nodes[node], TreeNode::Inner { .. })
}

/// Takes over a topology, with boxes of our own. Primitives of `wide` are references.
fn pack(wide: &CwBvh, references: &[Reference]) -> WideBvh {
    let n_nodes = wide.nodes.len();
    let (mut bounds, mut depths) = (vec![Bounds::EMPTY; n_nodes], vec![1; n_nodes]);
    let leaf = |source: &CwBvhNode, slot: usize| {
        let (first, count) = source.child_primitives(slot);
        let members = &wide.primitive_indices[first as usize..(first + count) as usize];
        let around = |all: Bounds, &member: &u32| all.union(references[member as usize].bounds);
        (members.iter().fold(Bounds::EMPTY, around), Child::Leaf { first, count })
    };
    let children = |source: &CwBvhNode, bounds: &[Bounds]| -> [Option<(Bounds, Child)>; 8] {
        std::array::from_fn(|slot| {
            (!source.is_child_empty(slot)).then(|| {
                if source.is_leaf(slot) {
                    return leaf(source, slot);
                }
                let node = source.child_node_index(slot);
                (bounds[node as usize], Child::Inner(node))
            })
        })
    };
    let mut statistics = Statistics { inner_nodes: n_nodes.max(1), ..Statistics::default() };
    let mut area_cost = 0.0;
    // Children come after their parents.
    for (index, source) in wide.nodes.iter().enumerate().rev() {
        let mut all = Bounds::EMPTY;
        for (around, child) in children(source, &bounds).into_iter().flatten() {
            all = all.union(around);
            match child {
                Child::Inner(node) => depths[index] = depths[index].max(1 + depths[node as usize]),
                Child::Leaf { count, .. } => {
                    statistics.leaves += 1;
                    area_cost += around.half_area() * f64::from(count);
                }
            }
        }
        area_cost += all.half_area();
        bounds[index] = all;
    }
    let packed = |(source, around): (&CwBvhNode, &Bounds)| WideNode::new(around, &children(source, &bounds));
    let mut nodes: Vec<WideNode> = wide.nodes.par_iter().zip(&bounds).map(packed).collect();
    nodes.resize(n_nodes.max(1), WideNode::EMPTY);
    let root = bounds.first().copied().unwrap_or(Bounds::EMPTY);
    if root.half_area() > 0.0 {
        statistics.sah_cost = (area_cost / root.half_area()) as f32;
    }
    WideBvh {
        nodes,
        primitives: wide.primitive_indices.par_iter().map(|&r| references[r as usize].primitive).collect(),
        max_depth: depths.first().copied().unwrap_or(1),
        bounds: root,
        statistics,
    }
}
