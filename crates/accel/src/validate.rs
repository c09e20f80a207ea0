//! Checks a hierarchy against its triangles.

use glam::Vec3;
use midway_scene::Bounds;

use crate::{
    AccelError, Bvh, Child, MAX_LEAF_SIZE, STACK_SIZE,
    met::{Met, invalid},
};

impl Bvh {
    /// Checks that every node and slot is reached exactly once, that every triangle is in a leaf,
    /// that boxes contain what is below them (of a split triangle: that its leaves' boxes together
    /// hold it), and that `max_depth` holds and is below [`STACK_SIZE`].
    ///
    /// # Errors
    ///
    /// [`AccelError::Invalid`] says what is broken first.
    pub fn validate(&self, triangles: &[[Vec3; 3]]) -> Result<(), AccelError> {
        self.validate_with_instances(triangles, &[])
    }

    /// As [`Bvh::validate`], and that every instance is reached exactly once, in boxes that hold it.
    ///
    /// # Errors
    ///
    /// As [`Bvh::validate`].
    pub fn validate_with_instances(
        &self,
        triangles: &[[Vec3; 3]],
        instances: &[Bounds],
    ) -> Result<(), AccelError> {
        if self.nodes.is_empty() || !self.nodes.len().is_multiple_of(4) {
            return invalid(format!("{} vec4 are not whole nodes", self.nodes.len()));
        }
        if self.max_depth >= STACK_SIZE {
            return invalid(format!("depth {} needs a larger stack", self.max_depth));
        }
        let mut walk = Walk {
            bvh: self,
            met: Met::new(self.nodes.len() / 4, self.primitives.len(), triangles, instances),
            leaf_boxes: vec![Bounds::EMPTY; triangles.len()],
        };
        walk.node(0, &self.bounds, 1)?;
        walk.met.finish()?;
        let outside = |(triangle, held): (&[Vec3; 3], &Bounds)| !held.contains(&Bounds::of_points(triangle));
        match triangles.iter().zip(&walk.leaf_boxes).position(outside) {
            Some(triangle) => invalid(format!("triangle {triangle} is not within the leaves that hold it")),
            None => Ok(()),
        }
    }
}

struct Walk<'a> {
    bvh: &'a Bvh,
    met: Met<'a>,
    /// Around all leaves that hold a triangle.
    leaf_boxes: Vec<Bounds>,
}

impl Walk<'_> {
    fn node(&mut self, node: u32, bounds: &Bounds, depth: usize) -> Result<(), AccelError> {
        self.met.node(node)?;
        if depth > self.bvh.max_depth {
            return invalid(format!(
                "node {node} lies at depth {depth}, below max_depth {}",
                self.bvh.max_depth
            ));
        }
        for (child_bounds, child) in self.bvh.children(node) {
            if !bounds.contains(&child_bounds) {
                return invalid(format!("node {node}'s box does not hold its child's"));
            }
            match child {
                Child::Inner(inner) => self.node(inner, &child_bounds, depth + 1)?,
                Child::Leaf { first, count } => self.leaf(first, count, &child_bounds)?,
            }
        }
        Ok(())
    }

    fn leaf(&mut self, first: u32, count: u32, bounds: &Bounds) -> Result<(), AccelError> {
        let slots = self.met.slots(first, count)?;
        if slots.len() > MAX_LEAF_SIZE || (slots.is_empty() && !bounds.is_empty()) {
            return invalid(format!("leaf at slot {first} has {count} and an unfit box"));
        }
        for slot in slots {
            let primitive = self.bvh.primitives[slot] as usize;
            self.met.primitive(primitive, bounds)?;
            if let Some(held) = self.leaf_boxes.get_mut(primitive) {
                *held = held.union(*bounds);
            }
        }
        Ok(())
    }
}
