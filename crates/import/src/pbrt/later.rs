//! Materials that are named before they are defined, which v4 allows: what shapes got of them is put right
//! at the end.

use std::{collections::BTreeMap, rc::Rc};

use midway_scene::{Material, ScalarInput, Surface};

use super::{colours::ColourSpace, directives::Interpreter, params::Params};
use crate::ImportError;

/// Mixtures of mixtures that are resolved, at most: what mixes itself never ends.
const MAX_DEPTH: usize = 32;

/// What waits for definitions.
#[derive(Default)]
pub(super) struct Later {
    /// Mixtures of materials that are not there yet, by their index.
    pub mixtures: Vec<(usize, Params, ColourSpace)>,
    /// By the scene's material.
    undressed: BTreeMap<u32, Undressed>,
}

/// A material of the scene's that is made of one still to come.
struct Undressed {
    material: usize,
    alpha: Option<ScalarInput>,
    inside: Rc<str>,
}

impl Interpreter<'_> {
    pub(super) fn is_mixture_of_awaited(&self, kind: &str, params: &Params) -> Result<bool, ImportError> {
        let names = if kind == "mix" { params.strings("materials")? } else { None };
        Ok(names.is_some_and(|names| names.iter().any(|name| !self.materials.is_defined(name))))
    }

    /// Notes a material of the scene's where it is made of one that is still to come.
    pub(super) fn note_undressed(&mut self, of_scene: u32, alpha: &Option<ScalarInput>) {
        let material = self.state.material;
        if self.materials.is_awaited(material) {
            let inside = self.state.inside.clone();
            self.later.undressed.insert(of_scene, Undressed { material, alpha: alpha.clone(), inside });
        }
    }

    /// Reads the mixtures that were put off, those first whose parts are there.
    pub(super) fn define_mixtures(&mut self) -> Result<(), ImportError> {
        for depth in 0..MAX_DEPTH {
            let mixtures = std::mem::take(&mut self.later.mixtures);
            let is_last = depth + 1 == MAX_DEPTH;
            for (index, params, colour_space) in mixtures {
                if !is_last && self.is_mixture_of_awaited("mix", &params)? {
                    self.later.mixtures.push((index, params, colour_space));
                    continue;
                }
                let material = self.definition("mix", &params, colour_space)?;
                self.materials.fill(index, material);
            }
        }
        Ok(())
    }

    /// Gives the scene's materials what they were to be made of.
    pub(super) fn dress_later(&mut self) {
        for (of_scene, Undressed { material, alpha, inside }) in std::mem::take(&mut self.later.undressed) {
            let dressed = self.dressed_as(material, &alpha, &inside);
            let known = &mut self.world.materials[of_scene as usize];
            // What is not there does not shine in v4.
            let emission = if dressed.surface == Surface::Null {
                dressed.emission.clone()
            } else {
                known.emission.clone()
            };
            *known = Material { emission, emits: known.emits, ..dressed };
        }
    }
}
