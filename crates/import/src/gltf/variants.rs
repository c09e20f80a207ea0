//! `KHR_materials_variants`: named choices of materials, of which one may be taken.

use super::json::Json;
use crate::{ImportError, variants::Choices};

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
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// What each variant gives a primitive, whose material is else `own`; without what is damaged.
    pub fn choices(&self, primitive: &Json, own: u32, n_materials: usize) -> Choices {
        let mut changed = Vec::new();
        let extension = primitive.extension(EXTENSION);
        for mapping in extension.and_then(|extension| extension.items("mappings").ok()).unwrap_or_default() {
            let index = mapping.get("material").and_then(|index| index.index("material", n_materials).ok());
            let Some(material) = index else { continue };
            let variants = mapping.items("variants").unwrap_or_default();
            let known = variants.iter().filter_map(|variant| variant.index("variant", self.names.len()).ok());
            changed.extend(known.map(|variant| (variant as u32, material as u32)));
        }
        // Of several for one variant the first counts: the sort is stable.
        changed.sort_by_key(|&(variant, _)| variant);
        changed.dedup_by_key(|&mut (variant, _)| variant);
        Choices { own, changed }
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
