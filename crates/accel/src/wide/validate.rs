//! Checks a wide hierarchy against its triangles.

use glam::Vec3;
use midway_scene::Bounds;

use super::WideBvh;
use crate::{
    AccelError, Child, WIDE_STACK_SIZE,
    met::{Met, invalid},
};

impl WideBvh {
    /// Checks that every node and slot is reached exactly once, that every triangle is in a leaf, that
    /// its corners and its middle are in a leaf that holds it and in all boxes above that leaf, and
    /// that `max_depth` holds.
    ///
    /// # Errors
    ///
    /// [`AccelError::Invalid`] says what is broken first.
    pub fn validate(&self, triangles: &[[Vec3; 3]]) -> Result<(), AccelError> {
        self.validate_with_instances(triangles, &[])
    }

    /// As [`WideBvh::validate`], and that every instance is reached exactly once, in boxes that hold it.
    ///
    /// # Errors
    ///
    /// As [`WideBvh::validate`].
    pub fn validate_with_instances(
        &self,
        triangles: &[[Vec3; 3]],
        instances: &[Bounds],
    ) -> Result<(), AccelError> {
        if self.nodes.is_empty() || self.max_depth >= WIDE_STACK_SIZE {
            return invalid(format!("depth {} needs a larger stack", self.max_depth));
        }
        let met = Met::new(self.nodes.len(), self.primitives.len(), triangles, instances);
        let mut walk = Walk { bvh: self, met };
        walk.node(0, &self.bounds, 1)?;
        walk.met.finish()
    }
}

struct Walk<'a> {
    bvh: &'a WideBvh,
    met: Met<'a>,
}

impl Walk<'_> {
    /// `within`: what all boxes above have in common.
    fn node(&mut self, node: u32, within: &Bounds, depth: usize) -> Result<(), AccelError> {
        self.met.node(node)?;
        if depth > self.bvh.max_depth {
            return invalid(format!("node {node} lies below max_depth {}", self.bvh.max_depth));
        }
        for (bounds, child) in self.bvh.nodes[node as usize].children().into_iter().flatten() {
            let common = Bounds { min: bounds.min.max(within.min), max: bounds.max.min(within.max) };
            match child {
                Child::Inner(inner) => self.node(inner, &common, depth + 1)?,
                Child::Leaf { first, count } => {
                    for slot in self.met.slots(first, count)? {
                        self.met.primitive(self.bvh.primitives[slot] as usize, &common)?;
                    }
                }
            }
        }
        Ok(())
    }
}
