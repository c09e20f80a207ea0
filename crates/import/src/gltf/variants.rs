//! `KHR_materials_variants`: named choices of materials, of which one may be taken.

use super::json::Json;
use crate::ImportError;

pub(super) const EXTENSION: &str = "KHR_materials_variants";

/// The document's variants, and which of them is taken.
pub(super) struct Variants {
    names: Vec<String>,
    chosen: Option<usize>,
}

impl Variants {
    /// `wanted`: a variant's name, the first of that name where several have it; none for the
    /// materials that primitives have by themselves.
    pub fn read(root: &Json, wanted: Option<&str>) -> Result<Self, ImportError> {
        let extension = root.extension(EXTENSION);
        let items = extension.map_or(Ok(Vec::new()), |extension| extension.items("variants"))?;
        let names: Vec<String> = items.iter().map(Json::name).collect();
        let chosen = match wanted {
            Some(wanted) => match names.iter().position(|name| name == wanted) {
                Some(index) => Some(index),
                None => return Err(ImportError::unknown_variant(&root.place().file, wanted, names)),
            },
            None => None,
        };
        Ok(Self { names, chosen })
    }

    /// In the file's order.
    pub fn into_names(self) -> Vec<String> {
        self.names
    }

    /// The material that the variant taken gives a primitive: of several the first. None where no
    /// variant is taken, or where it leaves the primitive its own.
    pub fn material<'a>(&self, primitive: &Json<'a>) -> Result<Option<Json<'a>>, ImportError> {
        let (Some(chosen), Some(extension)) = (self.chosen, primitive.extension(EXTENSION)) else {
            return Ok(None);
        };
        for mapping in extension.items("mappings")? {
            for variant in mapping.items("variants")? {
                if variant.index("variant", self.names.len())? == chosen {
                    return mapping.required("material").map(Some);
                }
            }
        }
        Ok(None)
    }
}
