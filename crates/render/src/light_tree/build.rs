//! Building: lights at infinity apart, the others as pbrt-v4 splits them (section 12.6.3), by the least
//! sum of costs over twelve buckets along each axis.

use rayon::join;

use super::bound::{LightBound, Reach};

/// Levels below the root at most: a way has two bits for two of them.
const MAX_DEPTH: u32 = 32;
/// Buckets along an axis.
const BUCKETS: usize = 12;
/// Two subtrees of more lights than this together are built at once.
const PARALLEL: usize = 4096;

/// What is known of a node's lights, and what is below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Of all of them.
    pub bound: LightBound,
    /// A light, or two nodes.
    pub link: Link,
}

/// What is below a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// This light.
    Light(u32),
    /// The node of this index and the one after it.
    Children(u32),
}

/// The tree over `lights`, indices into `all`, the root first; none over none.
pub fn build(all: &[LightBound], mut lights: Vec<u32>) -> Vec<Node> {
    let Some(&light) = lights.first() else { return Vec::new() };
    let blank = Node { bound: all[light as usize], link: Link::Light(light) };
    let mut nodes = vec![blank; 2 * lights.len() - 1];
    nodes[0] = grow(all, &mut lights, 0, &mut nodes[1..], 1);
    nodes
}

/// A node at `depth` over these lights; those below it are put into `below`, the first of which has the
/// index `first`.
fn grow(all: &[LightBound], lights: &mut [u32], depth: u32, below: &mut [Node], first: u32) -> Node {
    if let [light] = *lights {
        return Node { bound: all[light as usize], link: Link::Light(light) };
    }
    // A split leaves fewer lights, so that what fits a balanced tree in the levels left goes on fitting.
    let balanced = lights.len().next_power_of_two().trailing_zeros();
    let middle = if balanced < MAX_DEPTH - depth { split(all, lights) } else { halve(all, lights) };
    let n_lights = lights.len();
    let (left, right) = lights.split_at_mut(middle);
    let (pair, rest) = below.split_at_mut(2);
    let (below_left, below_right) = rest.split_at_mut(2 * left.len() - 2);
    let (at_left, at_right) = (first + 2, first + 2 * left.len() as u32);
    let mut a = || grow(all, left, depth + 1, below_left, at_left);
    let mut b = || grow(all, right, depth + 1, below_right, at_right);
    let (a, b) = if n_lights > PARALLEL { join(a, b) } else { (a(), b()) };
    pair.copy_from_slice(&[a, b]);
    Node { bound: a.bound.union(&b.bound), link: Link::Children(first) }
}

/// Orders lights, two at least, so that the first so many are those of the first child: some, not all.
fn split(all: &[LightBound], lights: &mut [u32]) -> usize {
    let n_near = order(lights, |light| all[light as usize].reach != Reach::Infinite);
    if n_near == 0 {
        return lights.len() / 2;
    }
    if n_near < lights.len() {
        return n_near;
    }
    let centres = extent(all, lights);
    let cheapest = (0..3).filter_map(|axis| cheapest(all, lights, axis, centres[axis]));
    match cheapest.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
        Some(Split { axis, last, .. }) => {
            order(lights, |light| bucket(&all[light as usize], axis, centres[axis]) <= last)
        }
        None => halve(all, lights),
    }
}

/// The same by halves, along the axis where they are farthest apart.
fn halve(all: &[LightBound], lights: &mut [u32]) -> usize {
    let centres = extent(all, lights);
    let width = |axis: &usize| centres[*axis][1] - centres[*axis][0];
    let axis = (0..3).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or_default();
    let place = |light: u32| centre(&all[light as usize], axis);
    let middle = lights.len() / 2;
    lights.select_nth_unstable_by(middle, |&a, &b| place(a).total_cmp(&place(b)).then(a.cmp(&b)));
    middle
}

/// Puts those that are first first, in the order that they have; how many they are.
fn order(lights: &mut [u32], is_first: impl Fn(u32) -> bool) -> usize {
    let (first, second): (Vec<u32>, Vec<u32>) = lights.iter().partition(|&&light| is_first(light));
    lights[..first.len()].copy_from_slice(&first);
    lights[first.len()..].copy_from_slice(&second);
    first.len()
}

fn centre(bound: &LightBound, axis: usize) -> f32 {
    bound.bounds.centre()[axis]
}

/// The least and the greatest of their centres along each axis.
fn extent(all: &[LightBound], lights: &[u32]) -> [[f32; 2]; 3] {
    let mut extent = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
    for &light in lights {
        for (axis, [least, most]) in extent.iter_mut().enumerate() {
            let place = centre(&all[light as usize], axis);
            (*least, *most) = (least.min(place), most.max(place));
        }
    }
    extent
}

fn bucket(bound: &LightBound, axis: usize, [least, most]: [f32; 2]) -> usize {
    let share = (centre(bound, axis) - least) / (most - least); // > 0: such axes are passed over
    ((share * BUCKETS as f32) as usize).min(BUCKETS - 1)
}

/// Where to split along an axis: after this bucket.
struct Split {
    axis: usize,
    last: usize,
    cost: f64,
}

/// The cheapest split along an axis; none where all centres are one. The first and the last bucket have
/// a light each, so that no side is empty.
fn cheapest(all: &[LightBound], lights: &[u32], axis: usize, centres: [f32; 2]) -> Option<Split> {
    let width = centres[1] - centres[0];
    if !(width > 0.0 && width.is_finite()) {
        return None;
    }
    let mut buckets = [None; BUCKETS];
    for &light in lights {
        let bound = &all[light as usize];
        let bucket = &mut buckets[bucket(bound, axis, centres)];
        *bucket = with(*bucket, bound);
    }
    let left = costs(&buckets, 0..BUCKETS);
    let right = costs(&buckets, (0..BUCKETS).rev());
    // Over the width: thin slices of a wide set are no gain.
    let cost = |last: usize| (left[last] + right[last + 1]) / f64::from(width);
    let last = (0..BUCKETS - 1).min_by(|&a, &b| cost(a).total_cmp(&cost(b)))?;
    Some(Split { axis, last, cost: cost(last) })
}

fn with(set: Option<LightBound>, bound: &LightBound) -> Option<LightBound> {
    Some(set.map_or(*bound, |set| set.union(bound)))
}

/// For each bucket the cost of it and all before it in this order.
fn costs(buckets: &[Option<LightBound>; BUCKETS], order: impl Iterator<Item = usize>) -> [f64; BUCKETS] {
    let (mut set, mut costs) = (None, [0.0; BUCKETS]);
    for i in order {
        set = buckets[i].as_ref().map_or(set, |bound| with(set, bound));
        costs[i] = set.as_ref().map_or(0.0, LightBound::cost);
    }
    costs
}
