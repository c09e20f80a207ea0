//! Which references are near which: `obvhs` where it serves, a balanced tree where it cannot.

use std::collections::HashMap;

use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, leaf_collapser::collapse, reinsertion::ReinsertionOptimizer},
    ploc::PlocBuilder,
};
use rayon::prelude::*;

use crate::{
    BuildOptions, MAX_LEAF_SIZE, Quality, STACK_SIZE, Width,
    references::{Normalisation, Reference},
};

/// Cost of a node visit over that of a triangle test, as `obvhs` weighs them when it collapses
/// leaves; its own presets' value.
const COLLAPSE_TRAVERSAL_COST: f32 = 3.0;

/// Fewer references with the same centre than this are not clustered.
const MIN_CLUSTER_SIZE: u32 = 16;

/// A binary tree over references.
pub(crate) struct Tree {
    pub nodes: Vec<TreeNode>,
    /// Indices of references; leaves are ranges of it.
    pub order: Vec<u32>,
    /// None where there are no references.
    pub root: Option<usize>,
    pub balanced_fallback: bool,
    limits: Limits,
}

/// What a tree has to keep to.
#[derive(Clone)]
struct Limits {
    max_leaf_size: usize,
    max_depth: usize,
    /// For each reference whether it may share a leaf; empty where all may.
    is_alone: Vec<bool>,
}

impl Limits {
    fn of(references: &[Reference], n_triangles: usize, options: &BuildOptions) -> Self {
        let is_instance = |r: &Reference| r.primitive as usize >= n_triangles;
        // Instances come last.
        let any = references.last().is_some_and(is_instance);
        Self {
            max_leaf_size: options.max_leaf_size.clamp(1, MAX_LEAF_SIZE),
            max_depth: Width::Binary.max_depth(options),
            is_alone: if any { references.iter().map(is_instance).collect() } else { Vec::new() },
        }
    }

    fn is_leaf(&self, members: &[u32]) -> bool {
        let is_alone = |&m: &u32| self.is_alone.get(m as usize).is_some_and(|&alone| alone);
        members.len() == 1 || (members.len() <= self.max_leaf_size && !members.iter().any(is_alone))
    }
}

#[derive(Clone, Copy)]
pub(crate) enum TreeNode {
    Inner { left: usize, right: usize },
    Leaf { first: usize, count: usize },
}

fn boxes(references: &[Reference], normalisation: &Normalisation) -> Vec<Aabb> {
    references.par_iter().map(|r| normalisation.bounds(&r.bounds)).collect()
}

/// A tree whose leaves hold one reference each, as `obvhs` made it, however deep; none where there is
/// nothing, or where [`build`] has to have a hand in it.
pub(crate) fn build_singles(
    references: &[Reference],
    normalisation: &Normalisation,
    options: &BuildOptions,
) -> Option<Bvh2> {
    let boxes = boxes(references, normalisation);
    if boxes.is_empty() || Clusters::of(&boxes).is_some() {
        return None;
    }
    Some(build_obvhs(&boxes, options.quality, 1))
}

pub(crate) fn build(
    references: &[Reference],
    n_triangles: usize,
    normalisation: &Normalisation,
    options: &BuildOptions,
) -> Tree {
    let limits = Limits::of(references, n_triangles, options);
    Tree::optimised(&boxes(references, normalisation), options.quality, limits)
        .unwrap_or_else(|| balanced(references, n_triangles, normalisation, options))
}

/// A tree no deeper than [`BALANCED_DEPTH`](crate::BALANCED_DEPTH), over references, one at least.
pub(crate) fn balanced(
    references: &[Reference],
    n_triangles: usize,
    normalisation: &Normalisation,
    options: &BuildOptions,
) -> Tree {
    let mut tree = Tree::new(Limits::of(references, n_triangles, options));
    tree.balanced_fallback = true;
    let mut all: Vec<u32> = (0..references.len() as u32).collect();
    tree.root = Some(tree.balanced(&mut all, &boxes(references, normalisation)));
    tree
}

impl Tree {
    fn new(limits: Limits) -> Self {
        Self { nodes: Vec::new(), order: Vec::new(), root: None, balanced_fallback: false, limits }
    }

    /// By `obvhs`; none where that is too deep for a traversal's stack.
    fn optimised(boxes: &[Aabb], quality: Quality, limits: Limits) -> Option<Self> {
        let Limits { max_leaf_size, max_depth, .. } = limits;
        let mut tree = Self::new(limits);
        if boxes.is_empty() {
            return Some(tree);
        }
        let clusters = Clusters::of(boxes);
        let bvh = match &clusters {
            Some(clusters) => build_obvhs(&clusters.boxes(boxes), quality, max_leaf_size),
            None => build_obvhs(boxes, quality, max_leaf_size),
        };
        if depth(bvh.nodes.len(), 0, |i| children(&bvh, i)) > max_depth {
            return None;
        }
        tree.convert(&bvh, clusters.as_ref(), boxes);
        let root = tree.root?;
        let inner_levels = depth(tree.nodes.len(), root, |i| match tree.nodes[i] {
            TreeNode::Inner { left, right } => Some((left, right)),
            TreeNode::Leaf { .. } => None,
        });
        (inner_levels <= max_depth).then_some(tree)
    }

    /// Takes over a topology, with clusters, and leaves that may not be one, opened
    /// into balanced subtrees.
    fn convert(&mut self, bvh: &Bvh2, clusters: Option<&Clusters>, boxes: &[Aabb]) {
        // Inner nodes keep their index; leaves become links to what is appended.
        let placeholder = TreeNode::Leaf { first: 0, count: 0 };
        self.nodes = vec![placeholder; bvh.nodes.len()];
        self.order.reserve(boxes.len());
        let mut members: Vec<u32> = Vec::new();
        for (i, node) in bvh.nodes.iter().enumerate() {
            if let Some((left, right)) = children(bvh, i) {
                self.nodes[i] = TreeNode::Inner { left, right };
                continue;
            }
            let first = node.first_index as usize;
            let slots = first..first + node.prim_count as usize;
            let slots = &bvh.primitive_indices[slots];
            members.clear();
            match clusters {
                Some(clusters) => members.extend(slots.iter().flat_map(|&c| clusters.members(c))),
                None => members.extend(slots),
            }
            let subtree = self.balanced(&mut members, boxes);
            self.nodes[i] = self.nodes[subtree];
        }
        self.root = Some(0);
    }

    /// Appends a tree of least depth, halved at the median of its widest axis; returns its root.
    fn balanced(&mut self, members: &mut [u32], boxes: &[Aabb]) -> usize {
        if self.limits.is_leaf(members) {
            let first = self.order.len();
            self.order.extend_from_slice(members);
            self.nodes.push(TreeNode::Leaf { first, count: members.len() });
            return self.nodes.len() - 1;
        }
        let centres =
            Aabb::from_points(&members.iter().map(|&m| boxes[m as usize].center()).collect::<Vec<_>>());
        let axis = centres.largest_axis();
        let key = |m: &u32| boxes[*m as usize].center()[axis];
        let middle = members.len() / 2;
        members.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then_with(|| a.cmp(b)));
        let (low, high) = members.split_at_mut(middle);
        let left = self.balanced(low, boxes);
        let right = self.balanced(high, boxes);
        self.nodes.push(TreeNode::Inner { left, right });
        self.nodes.len() - 1
    }
}

fn children(bvh: &Bvh2, i: usize) -> Option<(usize, usize)> {
    let node = &bvh.nodes[i];
    (!node.is_leaf()).then_some((node.first_index as usize, node.first_index as usize + 1))
}

/// Inner nodes on the longest way down. Iterative: what it measures may be thousands deep.
fn depth(n_nodes: usize, root: usize, children: impl Fn(usize) -> Option<(usize, usize)>) -> usize {
    let mut deepest = 0;
    let mut stack = Vec::with_capacity(STACK_SIZE.min(n_nodes));
    stack.push((root, 0));
    while let Some((node, above)) = stack.pop() {
        deepest = deepest.max(above);
        if let Some((left, right)) = children(node) {
            stack.push((left, above + 1));
            stack.push((right, above + 1));
        }
    }
    deepest
}

fn build_obvhs(boxes: &[Aabb], quality: Quality, max_leaf_size: usize) -> Bvh2 {
    let preset = match quality {
        Quality::Fast => BvhBuildParams::fast_build(),
        Quality::Balanced => BvhBuildParams::medium_build(),
        Quality::Best => BvhBuildParams::slow_build(),
    };
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        preset.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        preset.sort_precision,
        preset.search_depth_threshold,
    );
    let ratio = preset.reinsertion_batch_ratio;
    let mut reinsertion = ReinsertionOptimizer::default();
    reinsertion.run(&mut bvh, ratio, None);
    if max_leaf_size == 1 {
        return bvh;
    }
    collapse(&mut bvh, max_leaf_size as u32, COLLAPSE_TRAVERSAL_COST);
    let after = ratio * preset.post_collapse_reinsertion_batch_ratio_multiplier;
    reinsertion.run(&mut bvh, after, None);
    bvh
}

/// A centre as what it is told apart by; adding zero takes -0 to +0.
fn centre_bits(b: &Aabb) -> [u32; 3] {
    (b.center() + 0.0).to_array().map(f32::to_bits)
}

/// All boxes whose centre many may have, and some more: those of full buckets, by a hash of the
/// centre. In most scenes there are none, which is found out in one pass.
fn crowded(boxes: &[Aabb]) -> Vec<usize> {
    let n_buckets = boxes.len().next_power_of_two();
    let bucket = |b: &Aabb| {
        let [x, y, z] = centre_bits(b).map(u64::from);
        // Odd multipliers from the digits of the golden ratio; the high bits are mixed best.
        let mixed = (x ^ y.rotate_left(21) ^ z.rotate_left(42)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 32) as usize & (n_buckets - 1)
    };
    let buckets: Vec<u32> = boxes.par_iter().map(|b| bucket(b) as u32).collect();
    let mut counts = vec![0u32; n_buckets];
    buckets.iter().for_each(|&bucket| counts[bucket as usize] += 1);
    (0..boxes.len()).filter(|&i| counts[buckets[i] as usize] >= MIN_CLUSTER_SIZE).collect()
}

/// Many references with exactly the same centre, taken as one: PLOC pairs a run of equal costs one
/// merge a pass, which makes ten thousand copies of a triangle quadratic in time and as deep as
/// they are many. Few are left apart, since PLOC places them better.
struct Clusters {
    starts: Vec<usize>,
    members: Vec<u32>,
}

impl Clusters {
    /// None where there is nothing to cluster.
    fn of(boxes: &[Aabb]) -> Option<Self> {
        let crowded = crowded(boxes);
        let mut counts: HashMap<[u32; 3], u32> = HashMap::new();
        for &i in &crowded {
            *counts.entry(centre_bits(&boxes[i])).or_default() += 1;
        }
        counts.retain(|_, count| *count >= MIN_CLUSTER_SIZE);
        if counts.is_empty() {
            return None;
        }
        let mut ids: HashMap<[u32; 3], usize> = HashMap::new();
        let mut n_clusters = 0;
        let mut lists: Vec<usize> = Vec::with_capacity(boxes.len());
        for b in boxes {
            let (key, next) = (centre_bits(b), n_clusters);
            let id = if counts.contains_key(&key) { *ids.entry(key).or_insert(next) } else { next };
            n_clusters += usize::from(id == next);
            lists.push(id);
        }
        Some(Self::from_lists(&lists, n_clusters))
    }

    /// From the cluster of each reference.
    fn from_lists(lists: &[usize], n_clusters: usize) -> Self {
        let mut starts = vec![0; n_clusters + 1];
        for &id in lists {
            starts[id + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut members = vec![0; lists.len()];
        for (reference, &id) in (0u32..).zip(lists) {
            members[next[id]] = reference;
            next[id] += 1;
        }
        Self { starts, members }
    }

    fn members(&self, cluster: u32) -> &[u32] {
        let i = cluster as usize;
        &self.members[self.starts[i]..self.starts[i + 1]]
    }

    fn boxes(&self, boxes: &[Aabb]) -> Vec<Aabb> {
        (0..self.starts.len() as u32 - 1)
            .map(|c| {
                self.members(c)
                    .iter()
                    .map(|&m| boxes[m as usize].aabb())
                    .reduce(|a, b| a.union(&b))
                    .unwrap_or(Aabb::INVALID)
            })
            .collect()
    }
}
