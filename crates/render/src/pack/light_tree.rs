//! The tree over lights as records of vec4 (`bindings/light_tree.wgsl`).

use midway_kernels::constants as k;

use super::{Word4, Words, word4};
use crate::light_tree::{LightReach, LightTree, Link, Node};

/// By how much angles are widened, radians, so that rounding in the kernels hides no light: cosines near 1
/// are off by a few units in the last place, which angles near 0 are by the square root of.
const WIDENING: f64 = 2e-3;

/// Where nodes and ways begin; NONE where there is no tree.
pub(super) struct LightTreeAt {
    pub nodes: u32,
    pub ways: u32,
}

/// Appends the tree, where there is one with any light.
pub(super) fn pack_light_tree(tree: Option<&LightTree>, words: &mut Words) -> LightTreeAt {
    let Some((tree, root)) = tree.and_then(|tree| Some((tree, tree.nodes.first()?))) else {
        return LightTreeAt { nodes: k::NONE, ways: k::NONE };
    };
    let nodes = words.next();
    // In shares of all: floats then have room, whatever the scene's unit of power.
    words.extend(tree.nodes.iter().flat_map(|node| pack_node(node, root.bound.intensity)));
    let ways = words.next();
    words.extend(tree.ways.chunks(4).map(|ways| {
        let mut word = [0; 4];
        word[..ways.len()].copy_from_slice(ways);
        word
    }));
    LightTreeAt { nodes, ways }
}

fn pack_node(node: &Node, all: f64) -> [Word4; k::LIGHT_NODE_STRIDE as usize] {
    let bound = &node.bound;
    let cosine = |angle: f64| ((angle + WIDENING).min(std::f64::consts::PI).cos() as f32).to_bits();
    let sphere = bound.bounds.sphere();
    let kind = match bound.reach {
        LightReach::Front => k::LIGHT_NODE_FRONT,
        LightReach::Both => k::LIGHT_NODE_BOTH,
        LightReach::Infinite => k::LIGHT_NODE_INFINITE,
    };
    let link = match node.link {
        Link::Light(light) => k::LIGHT_NODE_LEAF | light,
        Link::Children(first) => first,
    };
    // A light's share may be beyond f32; of none of them the chance is 0 for that.
    let intensity = ((bound.intensity / all) as f32).max(f32::MIN_POSITIVE);
    [
        word4(sphere.centre, sphere.radius.to_bits()),
        word4(bound.normals.axis.as_vec3(), cosine(bound.normals.angle)),
        [intensity.to_bits(), cosine(bound.emission), kind, link],
    ]
}
