//! The tree over lights as records of vec4 (`bindings/light_tree.wgsl`).

use midway_kernels::constants as k;

use super::{Word4, Words};
use crate::light_tree::{Child, LightReach, LightTree, Link, WIDTH, WideNode};

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
    let Some((tree, all)) = tree.and_then(|tree| Some((tree, tree.bound?))) else {
        return LightTreeAt { nodes: k::NONE, ways: k::NONE };
    };
    let nodes = words.next();
    // In shares of all: floats then have room, whatever the scene's unit of power.
    words.extend(tree.nodes.iter().flat_map(|node| pack_node(node, all.intensity)));
    let ways = words.next();
    words.extend(tree.ways.chunks(4).map(|ways| {
        let mut word = [0; 4];
        word[..ways.len()].copy_from_slice(ways);
        word
    }));
    LightTreeAt { nodes, ways }
}

/// Words of a child in a node, one in each of its vec4.
const CHILD: usize = k::LIGHT_NODE_STRIDE as usize;

fn pack_node(node: &WideNode, all: f64) -> [Word4; CHILD] {
    let children: [[u32; CHILD]; WIDTH] =
        node.map(|child| child.map_or([0; CHILD], |child| pack_child(&child, all)));
    std::array::from_fn(|word| children.map(|child| child[word]))
}

fn pack_child(Child { bound, link }: &Child, all: f64) -> [u32; CHILD] {
    let cosine = |angle: f64| (angle + WIDENING).min(std::f64::consts::PI).cos() as f32;
    let sphere = bound.bounds.sphere();
    let axis = bound.normals.axis.as_vec3();
    let reach = match bound.reach {
        LightReach::Front => 0,
        LightReach::Both => k::LIGHT_NODE_BOTH,
        LightReach::Infinite => k::LIGHT_NODE_INFINITE,
    };
    let link = match *link {
        Link::Light(light) => k::LIGHT_NODE_LEAF | light,
        Link::Node(node) => node,
    };
    // A light's share may be beyond f32; of none of them the chance is 0 for that.
    let intensity = ((bound.intensity / all) as f32).max(f32::MIN_POSITIVE);
    let [x, y, z] = sphere.centre.to_array();
    let (square, normals, emission) =
        (sphere.radius * sphere.radius, cosine(bound.normals.angle), cosine(bound.emission));
    let numbers = [x, y, z, square, axis.x, axis.y, axis.z, normals, emission, intensity];
    let mut words = [link | reach; CHILD];
    words[..numbers.len()].copy_from_slice(&numbers.map(f32::to_bits));
    words
}
