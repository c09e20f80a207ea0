//! Checks a wide hierarchy against its triangles.

use glam::Vec3;
use midway_scene::Bounds;

use super::WideBvh;
use crate::{AccelError, Child, STACK_SIZE};

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
        if self.nodes.is_empty() || self.max_depth >= STACK_SIZE {
            return invalid(format!("depth {} needs a larger stack", self.max_depth));
        }
        let mut walk = Walk {
            bvh: self,
            triangles,
            instances,
            instances_seen: vec![false; instances.len()],
            nodes_seen: vec![false; self.nodes.len()],
            slots_seen: vec![false; self.primitives.len()],
            corners_held: vec![0; triangles.len()],
        };
        walk.node(0, &self.bounds, 1)?;
        if let Some(node) = walk.nodes_seen.iter().position(|seen| !seen) {
            return invalid(format!("node {node} cannot be reached"));
        }
        if let Some(slot) = walk.slots_seen.iter().position(|seen| !seen) {
            return invalid(format!("slot {slot} cannot be reached"));
        }
        if let Some(instance) = walk.instances_seen.iter().position(|seen| !seen) {
            return invalid(format!("instance {instance} cannot be reached"));
        }
        match walk.corners_held.iter().position(|&held| held != 0b1111) {
            Some(triangle) => invalid(format!("triangle {triangle} is not within the leaves that hold it")),
            None => Ok(()),
        }
    }
}

fn invalid<T>(what: String) -> Result<T, AccelError> {
    Err(AccelError::Invalid(what))
}

struct Walk<'a> {
    bvh: &'a WideBvh,
    triangles: &'a [[Vec3; 3]],
    instances: &'a [Bounds],
    instances_seen: Vec<bool>,
    nodes_seen: Vec<bool>,
    slots_seen: Vec<bool>,
    /// Bits 0, 1, 2: vertices; bit 3: the centroid, within some leaf that holds the triangle.
    corners_held: Vec<u8>,
}

impl Walk<'_> {
    /// `within`: what all boxes above have in common.
    fn node(&mut self, node: u32, within: &Bounds, depth: usize) -> Result<(), AccelError> {
        match self.nodes_seen.get_mut(node as usize) {
            None => return invalid(format!("node {node} does not exist")),
            Some(true) => return invalid(format!("node {node} is reached twice")),
            Some(seen) => *seen = true,
        }
        if depth > self.bvh.max_depth {
            return invalid(format!("node {node} lies below max_depth {}", self.bvh.max_depth));
        }
        for (bounds, child) in self.bvh.nodes[node as usize].children().into_iter().flatten() {
            let common = Bounds { min: bounds.min.max(within.min), max: bounds.max.min(within.max) };
            match child {
                Child::Inner(inner) => self.node(inner, &common, depth + 1)?,
                Child::Leaf { first, count } => self.leaf(first, count, &common)?,
            }
        }
        Ok(())
    }

    fn leaf(&mut self, first: u32, count: u32, bounds: &Bounds) -> Result<(), AccelError> {
        let slots = first as usize..first as usize + count as usize;
        if slots.end > self.slots_seen.len() {
            return invalid(format!("leaf slots {slots:?} do not exist"));
        }
        for slot in slots {
            if std::mem::replace(&mut self.slots_seen[slot], true) {
                return invalid(format!("slot {slot} is reached twice"));
            }
            let triangle = self.bvh.primitives[slot] as usize;
            if triangle >= self.triangles.len() {
                self.instance(triangle - self.triangles.len(), bounds)?;
                continue;
            }
            let [a, b, c] = self.triangles[triangle];
            for (bit, point) in [a, b, c, a / 3.0 + b / 3.0 + c / 3.0].into_iter().enumerate() {
                self.corners_held[triangle] |= u8::from(bounds.contains_point(point)) << bit;
            }
        }
        Ok(())
    }

    fn instance(&mut self, instance: usize, bounds: &Bounds) -> Result<(), AccelError> {
        match self.instances_seen.get_mut(instance) {
            None => return invalid(format!("instance {instance} does not exist")),
            Some(true) => return invalid(format!("instance {instance} is reached twice")),
            Some(seen) => *seen = true,
        }
        if !bounds.contains(&self.instances[instance]) {
            return invalid(format!("instance {instance} is not within its boxes"));
        }
        Ok(())
    }
}
