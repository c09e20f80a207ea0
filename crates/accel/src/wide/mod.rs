//! The compressed wide hierarchy: eight children a node, whose boxes take a byte a plane (Ylitie,
//! Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
//! HPG 2017).
//!
//! The binary tree is `obvhs`' doing; boxes are taken anew from the triangles' own padded ones, so that they
//! hold in the kernels' arithmetic.

mod collapse;
mod node;
mod pack;
mod validate;

use std::time::Instant;

use glam::Vec3;
use midway_scene::Bounds;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};

use self::{collapse::Collapse, pack::pack};
use crate::{
    AccelError, BuildOptions, STACK_SIZE, Statistics, Width,
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
    /// Nodes on the longest way from the root down; below [`crate::WIDE_STACK_SIZE`].
    pub max_depth: usize,
    /// Around everything, padded; inverted where there is nothing.
    pub bounds: Bounds,
    /// What the build did.
    pub statistics: Statistics,
}

impl WideBvh {
    /// Over nothing.
    fn empty() -> Self {
        let statistics = Statistics { inner_nodes: 1, ..Statistics::default() };
        let (nodes, bounds) = (vec![WideNode::EMPTY], Bounds::EMPTY);
        Self { nodes, primitives: Vec::new(), max_depth: 1, bounds, statistics }
    }

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
    let binary = BuildOptions { max_leaf_size: 1, max_depth: STACK_SIZE - 1, ..*options };
    let (references, normalisation) = crate::collect(triangles, instances, &binary)?;
    if references.is_empty() {
        return Ok(WideBvh::empty());
    }
    let mut balanced_fallback = false;
    let most = Width::Wide.max_depth(options);
    let by_cost = |bvh: Bvh2| {
        let collapse = Collapse::by_cost(&bvh, max_leaf_size as u32, binary.max_depth)?;
        Some(pack(&collapse, &references)).filter(|wide| wide.max_depth <= most)
    };
    let singles = topology::build_singles(&references, &normalisation, &binary);
    let wide = singles.and_then(by_cost).or_else(|| {
        let tree = topology::build(&references, triangles.len(), &normalisation, &binary);
        balanced_fallback = tree.balanced_fallback;
        by_cost(to_obvhs(&tree, &references, &normalisation)?)
    });
    let wide = wide.or_else(|| {
        let tree = topology::balanced(&references, triangles.len(), &normalisation, &binary);
        balanced_fallback = true;
        Some(pack(&Collapse::by_levels(&to_obvhs(&tree, &references, &normalisation)?), &references))
    });
    let mut wide = wide.unwrap_or_else(WideBvh::empty);
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
