//! `EXT_mesh_gpu_instancing`: a node's mesh, placed many times.

use glam::{DMat4, DQuat, DVec3};

use super::{
    accessors::{Accessors, Integers},
    json::Json,
};
use crate::ImportError;

pub(super) const EXTENSION: &str = "EXT_mesh_gpu_instancing";

/// Where each instance lies in its node; none where the node has no such list.
pub(super) fn node_from_instances(
    node: &Json,
    accessors: &Accessors,
) -> Result<Option<Vec<DMat4>>, ImportError> {
    let Some(extension) = node.extension(EXTENSION) else {
        return Ok(None);
    };
    let attributes = extension.required("attributes")?;
    let mut count: Option<u64> = None;
    for (_, index) in attributes.members()? {
        let own = accessors.count(&index)?;
        if count.is_some_and(|count| count != own) {
            return Err(index.malformed("the attributes of instances differ in number"));
        }
        count = Some(own);
    }
    let vectors = |key: &str| match attributes.get(key) {
        Some(index) => accessors.vectors::<3>(&index, None, Integers::Any).map(Some),
        None => Ok(None),
    };
    let translations = vectors("TRANSLATION")?;
    let scales = vectors("SCALE")?;
    let rotations = match attributes.get("ROTATION") {
        Some(index) => Some(accessors.vectors::<4>(&index, None, Integers::Normalized)?),
        None => None,
    };
    accessors.charge(&extension, count.unwrap_or(0))?;
    let place = |i: usize| {
        let vector = |list: &Option<Vec<[f32; 3]>>, default| {
            list.as_ref().map_or(DVec3::splat(default), |list| DVec3::from_array(list[i].map(f64::from)))
        };
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |list| unit(list[i]));
        DMat4::from_scale_rotation_translation(vector(&scales, 1.0), rotation, vector(&translations, 0.0))
    };
    Ok(Some((0..count.unwrap_or(0) as usize).map(place).collect()))
}

/// A rotation; none at all where its length is 0.
fn unit(components: [f32; 4]) -> DQuat {
    let q = DQuat::from_array(components.map(f64::from));
    let length = q.length();
    if length > 0.0 { q / length } else { DQuat::IDENTITY }
}
