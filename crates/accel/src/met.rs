//! What a walk through a hierarchy, of either width, has met: everything once, and in boxes that hold it.

use std::ops::Range;

use glam::Vec3;
use midway_scene::Bounds;

use crate::AccelError;

/// The hierarchy is not valid, by what it says.
pub fn invalid<T>(what: String) -> Result<T, AccelError> {
    Err(AccelError::Invalid(what))
}

/// Met so far.
pub struct Met<'a> {
    triangles: &'a [[Vec3; 3]],
    instances: &'a [Bounds],
    instances_met: Vec<bool>,
    nodes_met: Vec<bool>,
    slots_met: Vec<bool>,
    /// Bits 0, 1, 2: vertices; bit 3: the centroid, within some leaf that holds the triangle.
    corners_held: Vec<u8>,
}

impl<'a> Met<'a> {
    /// Nothing yet, of so many nodes and slots over these triangles and instances.
    pub fn new(n_nodes: usize, n_slots: usize, triangles: &'a [[Vec3; 3]], instances: &'a [Bounds]) -> Self {
        Self {
            triangles,
            instances,
            instances_met: vec![false; instances.len()],
            nodes_met: vec![false; n_nodes],
            slots_met: vec![false; n_slots],
            corners_held: vec![0; triangles.len()],
        }
    }

    /// A node.
    pub fn node(&mut self, node: u32) -> Result<(), AccelError> {
        meet(&mut self.nodes_met, node as usize, "node")
    }

    /// The slots of a leaf.
    pub fn slots(&mut self, first: u32, count: u32) -> Result<Range<usize>, AccelError> {
        let slots = first as usize..first as usize + count as usize;
        for slot in slots.clone() {
            meet(&mut self.slots_met, slot, "slot")?;
        }
        Ok(slots)
    }

    /// A leaf's primitive, a triangle or behind them an instance; `bounds`: what holds it.
    pub fn primitive(&mut self, primitive: usize, bounds: &Bounds) -> Result<(), AccelError> {
        let Some(&[a, b, c]) = self.triangles.get(primitive) else {
            let instance = primitive - self.triangles.len();
            meet(&mut self.instances_met, instance, "instance")?;
            if !bounds.contains(&self.instances[instance]) {
                return invalid(format!("instance {instance} is not within its boxes"));
            }
            return Ok(());
        };
        for (bit, point) in [a, b, c, a / 3.0 + b / 3.0 + c / 3.0].into_iter().enumerate() {
            self.corners_held[primitive] |= u8::from(bounds.contains_point(point)) << bit;
        }
        Ok(())
    }

    /// Whether that was all.
    pub fn finish(&self) -> Result<(), AccelError> {
        let all = [(&self.nodes_met, "node"), (&self.slots_met, "slot"), (&self.instances_met, "instance")];
        for (met, what) in all {
            if let Some(missed) = met.iter().position(|met| !met) {
                return invalid(format!("{what} {missed} cannot be reached"));
            }
        }
        match self.corners_held.iter().position(|&held| held != 0b1111) {
            Some(triangle) => invalid(format!("triangle {triangle} is not within the leaves that hold it")),
            None => Ok(()),
        }
    }
}

fn meet(met: &mut [bool], index: usize, what: &str) -> Result<(), AccelError> {
    match met.get_mut(index) {
        None => invalid(format!("{what} {index} does not exist")),
        Some(true) => invalid(format!("{what} {index} is reached twice")),
        Some(met) => {
            *met = true;
            Ok(())
        }
    }
}
