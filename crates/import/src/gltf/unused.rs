//! What a document holds beside meshes, materials, cameras and lights.

use super::{SUPPORTED_EXTENSIONS, json::Json, unused_extension, warn_of_extensions};
use crate::{
    ImportError,
    warning::{WarningKind, Warnings},
};

pub(super) fn warn(root: &Json, warnings: &mut Warnings) -> Result<(), ImportError> {
    let animations = root.items("animations")?;
    if let Some(first) = animations.first() {
        let message = format!("{} animations are not used: the scene is rendered at rest", animations.len());
        warnings.add(WarningKind::Animation, first.pointer(), message);
    }
    let scenes = root.items("scenes")?;
    if scenes.len() > 1 {
        let message = format!("of {} scenes only the default one is rendered", scenes.len());
        warnings.add(WarningKind::Unused, "/scenes", message);
    }
    warn_of_extensions(root, warnings)?;
    for used in root.items("extensionsUsed")? {
        let name = used.string()?;
        if !SUPPORTED_EXTENSIONS.contains(&name) {
            warnings.add_once(WarningKind::Extension, used.pointer(), unused_extension(name));
        }
    }
    Ok(())
}
