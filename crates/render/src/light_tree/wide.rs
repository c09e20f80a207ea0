//! The tree as kernels descend it: four children a node, which are two levels or more of the tree of two.

use super::{
    bound::LightBound,
    build::{self, Node},
};

/// Children of a node at most.
pub const WIDTH: usize = 4;

/// A child of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Child {
    /// Of all its lights.
    pub bound: LightBound,
    /// What it is.
    pub link: Link,
}

/// What a child is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// This light.
    Light(u32),
    /// The node of this index.
    Node(u32),
}

/// A node's children, the first at least.
pub type WideNode = [Option<Child>; WIDTH];

/// The tree of four over the lights of a tree of two, the root first. No light is deeper than half as many
/// levels, rounded up.
pub fn widen(nodes: &[Node]) -> Vec<WideNode> {
    let mut roots: Vec<u32> = nodes.first().map(|_| 0).into_iter().collect();
    let mut wide: Vec<WideNode> = Vec::new();
    while let Some(&root) = roots.get(wide.len()) {
        let mut children = [None; WIDTH];
        for (child, below) in children.iter_mut().zip(below(nodes, root)) {
            let Node { bound, link } = nodes[below as usize];
            let link = match link {
                build::Link::Light(light) => Link::Light(light),
                build::Link::Children(_) => {
                    roots.push(below);
                    Link::Node(roots.len() as u32 - 1)
                }
            };
            *child = Some(Child { bound, link });
        }
        wide.push(children);
    }
    wide
}

/// The four nodes at most that have all lights of one between them: two levels down, then in place of the
/// costliest its children while there is room.
fn below(nodes: &[Node], root: u32) -> Vec<u32> {
    let children = |node: u32| match nodes[node as usize].link {
        build::Link::Children(first) => Some([first, first + 1]),
        build::Link::Light(_) => None,
    };
    let open = |all: Vec<u32>| -> Vec<u32> {
        all.into_iter().flat_map(|node| children(node).map_or(vec![node], Vec::from)).collect()
    };
    let mut below = open(open(vec![root]));
    let cost = |node: u32| nodes[node as usize].bound.cost();
    while below.len() < WIDTH {
        let costliest = (0..below.len())
            .filter(|&i| children(below[i]).is_some())
            .max_by(|&a, &b| cost(below[a]).total_cmp(&cost(below[b])));
        let Some(place) = costliest else { break };
        below.splice(place..=place, children(below[place]).into_iter().flatten());
    }
    below
}
