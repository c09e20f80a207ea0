//! A hierarchy of either kind, as one of two levels is.

use glam::Vec3;
use midway_scene::Bounds;

use crate::{
    AccelError, BALANCED_DEPTH, BuildOptions, Bvh, Child, Hierarchy, STACK_SIZE, Statistics,
    WIDE_BALANCED_DEPTH, WIDE_STACK_SIZE, WideBvh, WideNode, build_wide_with_instances, build_with_instances,
};

/// How many children nodes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Two: [`Bvh`].
    Binary,
    /// Up to eight: [`WideBvh`].
    Wide,
}

impl Width {
    /// vec4 that a node takes.
    pub fn node_vec4(self) -> usize {
        match self {
            Self::Binary => Bvh::NODE_VEC4,
            Self::Wide => WideNode::VEC4,
        }
    }

    /// Entries of a traversal's stack: a hierarchy has fewer levels.
    pub fn stack_size(self) -> usize {
        match self {
            Self::Binary => STACK_SIZE,
            Self::Wide => WIDE_STACK_SIZE,
        }
    }

    /// Levels of a balanced hierarchy at most.
    pub fn balanced_depth(self) -> usize {
        match self {
            Self::Binary => BALANCED_DEPTH,
            Self::Wide => WIDE_BALANCED_DEPTH,
        }
    }

    /// Levels that a hierarchy is built with at most.
    pub(crate) fn max_depth(self, options: &BuildOptions) -> usize {
        options.max_depth.clamp(self.balanced_depth(), self.stack_size() - 1)
    }
}

/// A hierarchy of either kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Level {
    /// Two children a node.
    Binary(Bvh),
    /// Up to eight.
    Wide(WideBvh),
}

impl Level {
    /// Builds over triangles and over instances, which are never split. `instances`: around each, finite.
    ///
    /// # Errors
    ///
    /// As [`crate::build`].
    pub fn build(
        width: Width,
        triangles: &[[Vec3; 3]],
        instances: &[Bounds],
        options: &BuildOptions,
    ) -> Result<Self, AccelError> {
        match width {
            Width::Binary => build_with_instances(triangles, instances, options).map(Self::Binary),
            Width::Wide => build_wide_with_instances(triangles, instances, options).map(Self::Wide),
        }
    }

    /// Which kind it is of.
    pub fn width(&self) -> Width {
        match self {
            Self::Binary(_) => Width::Binary,
            Self::Wide(_) => Width::Wide,
        }
    }

    /// Nodes on the longest way from the root down.
    pub fn max_depth(&self) -> usize {
        match self {
            Self::Binary(bvh) => bvh.max_depth,
            Self::Wide(bvh) => bvh.max_depth,
        }
    }

    /// Around everything, padded; inverted where there is nothing.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Binary(bvh) => bvh.bounds,
            Self::Wide(bvh) => bvh.bounds,
        }
    }

    /// What the build did.
    pub fn statistics(&self) -> &Statistics {
        match self {
            Self::Binary(bvh) => &bvh.statistics,
            Self::Wide(bvh) => &bvh.statistics,
        }
    }

    /// How many nodes there are.
    pub fn n_nodes(&self) -> usize {
        match self {
            Self::Binary(bvh) => bvh.nodes.len() / Bvh::NODE_VEC4,
            Self::Wide(bvh) => bvh.nodes.len(),
        }
    }

    /// Bytes that nodes and leaf slots take, without triangles.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Self::Binary(bvh) => bvh.memory_bytes(),
            Self::Wide(bvh) => bvh.memory_bytes(),
        }
    }

    /// Its nodes as kernels read them where this many nodes and leaf slots lie before its own.
    pub fn append_nodes(&self, first_node: u32, first_slot: u32, words: &mut Vec<[u32; 4]>) {
        match self {
            Self::Binary(bvh) => words.extend(bvh.moved_nodes(first_node, first_slot)),
            Self::Wide(bvh) => {
                words.extend(bvh.nodes.iter().flat_map(|node| node.moved(first_node, first_slot).0));
            }
        }
    }

    /// Checks it, as [`WideBvh::validate_with_instances`] and [`Bvh::validate_with_instances`] do.
    ///
    /// # Errors
    ///
    /// [`AccelError::Invalid`] says what is broken first.
    pub fn validate_with_instances(
        &self,
        triangles: &[[Vec3; 3]],
        instances: &[Bounds],
    ) -> Result<(), AccelError> {
        match self {
            Self::Binary(bvh) => bvh.validate_with_instances(triangles, instances),
            Self::Wide(bvh) => bvh.validate_with_instances(triangles, instances),
        }
    }
}

impl Hierarchy for Level {
    fn children(&self, node: u32) -> impl Iterator<Item = (Bounds, Child)> {
        let children = match self {
            Self::Binary(bvh) => {
                let [left, right] = bvh.children(node);
                [Some(left), Some(right), None, None, None, None, None, None]
            }
            Self::Wide(bvh) => bvh.nodes[node as usize].children(),
        };
        children.into_iter().flatten()
    }

    fn primitives(&self) -> &[u32] {
        match self {
            Self::Binary(bvh) => &bvh.primitives,
            Self::Wide(bvh) => &bvh.primitives,
        }
    }

    fn n_triangles(&self) -> u32 {
        self.statistics().triangles as u32
    }
}
