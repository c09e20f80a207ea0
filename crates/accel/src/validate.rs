//! Checks a hierarchy against its triangles.

use glam::Vec3;
use midway_scene::Bounds;

use crate::{AccelError, Bvh, Child, MAX_LEAF_SIZE, STACK_SIZE};

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
            triangles,
            instances,
            instances_seen: vec![false; instances.len()],
            nodes_seen: vec![false; self.nodes.len() / 4],
            slots_seen: vec![false; self.primitives.len()],
            leaf_boxes: vec![Bounds::EMPTY; triangles.len()],
            corners_held: vec![0; triangles.len()],
        };
        walk.node(0, &self.bounds, 1)?;
        walk.finish()
    }
}

fn invalid<T>(what: String) -> Result<T, AccelError> {
    Err(AccelError::Invalid(what))
}

struct Walk<'a> {
    bvh: &'a Bvh,
    triangles: &'a [[Vec3; 3]],
    instances: &'a [Bounds],
    instances_seen: Vec<bool>,
    nodes_seen: Vec<bool>,
    slots_seen: Vec<bool>,
    /// Around all leaves that hold a triangle.
    leaf_boxes: Vec<Bounds>,
    /// Bits 0, 1, 2: vertices; bit 3: the centroid, within some leaf that holds the triangle.
    corners_held: Vec<u8>,
}

impl Walk<'_> {
    fn node(&mut self, node: u32, bounds: &Bounds, depth: usize) -> Result<(), AccelError> {
        match self.nodes_seen.get_mut(node as usize) {
            None => return invalid(format!("node {node} does not exist")),
            Some(true) => return invalid(format!("node {node} is reached twice")),
            Some(seen) => *seen = true,
        }
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
        let slots = first as usize..first as usize + count as usize;
        if slots.end > self.slots_seen.len() {
            return invalid(format!("leaf slots {slots:?} do not exist"));
        }
        if slots.len() > MAX_LEAF_SIZE || (slots.is_empty() && !bounds.is_empty()) {
            return invalid(format!("leaf at slot {first} has {count} and an unfit box"));
        }
        for slot in slots {
            if std::mem::replace(&mut self.slots_seen[slot], true) {
                return invalid(format!("slot {slot} is reached twice"));
            }
            let triangle = self.bvh.primitives[slot] as usize;
            let Some(&[a, b, c]) = self.triangles.get(triangle) else {
                self.instance(triangle - self.triangles.len(), bounds)?;
                continue;
            };
            self.leaf_boxes[triangle] = self.leaf_boxes[triangle].union(*bounds);
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

    fn finish(&self) -> Result<(), AccelError> {
        if let Some(node) = self.nodes_seen.iter().position(|seen| !seen) {
            return invalid(format!("node {node} cannot be reached"));
        }
        if let Some(slot) = self.slots_seen.iter().position(|seen| !seen) {
            return invalid(format!("slot {slot} cannot be reached"));
        }
        if let Some(instance) = self.instances_seen.iter().position(|seen| !seen) {
            return invalid(format!("instance {instance} cannot be reached"));
        }
        for (i, vertices) in self.triangles.iter().enumerate() {
            let whole = Bounds::of_points(vertices);
            if !self.leaf_boxes[i].contains(&whole) || self.corners_held[i] != 0b1111 {
                return invalid(format!("triangle {i} is not within the leaves that hold it"));
            }
        }
        Ok(())
    }
}
