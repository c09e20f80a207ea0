//! Materials that are named before they are defined, which v4 allows: what shapes got of them is put right
//! at the end.

use std::{
    collections::{BTreeMap, HashMap, VecDeque},
    rc::Rc,
};

use midway_scene::{Material, ScalarInput, Surface};

use super::{colours::ColourSpace, directives::Interpreter, params::Params};
use crate::{ImportError, warning::WarningKind};

/// A mixture that waits for its parts, and its index.
type Awaited = (usize, Params, ColourSpace);

/// What waits for definitions.
#[derive(Default)]
pub(super) struct Later {
    /// Mixtures of materials that are not there yet, by their index.
    pub mixtures: Vec<Awaited>,
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

    /// Reads the mixtures that were put off, each after those it is made of. What mixes itself is grey there,
    /// and a warning says so.
    pub(super) fn define_mixtures(&mut self) -> Result<(), ImportError> {
        let mixtures = std::mem::take(&mut self.later.mixtures);
        let mut of_material: HashMap<usize, Vec<usize>> = HashMap::new();
        for (i, (index, ..)) in mixtures.iter().enumerate() {
            of_material.entry(*index).or_default().push(i);
        }
        // By material, the mixtures that have it as a part, and of each mixture how many it waits for.
        let mut users: HashMap<usize, Vec<usize>> = HashMap::new();
        let mut n_awaited = vec![0; mixtures.len()];
        for (i, (_, params, _)) in mixtures.iter().enumerate() {
            for name in params.strings("materials")?.unwrap_or_default() {
                let Some(part) = self.materials.index_of(name) else { continue };
                if let Some(definitions) = of_material.get(&part) {
                    n_awaited[i] += definitions.len();
                    users.entry(part).or_default().push(i);
                }
            }
        }
        let mut ready: VecDeque<usize> = (0..mixtures.len()).filter(|i| n_awaited[*i] == 0).collect();
        while let Some(i) = ready.pop_front() {
            let index = self.define_mixture(&mixtures[i])?;
            for &user in users.get(&index).into_iter().flatten() {
                n_awaited[user] -= 1;
                if n_awaited[user] == 0 {
                    ready.push_back(user);
                }
            }
        }
        for (mixture, _) in mixtures.iter().zip(n_awaited).filter(|(_, n)| *n > 0) {
            let message = "mixtures of materials that mix themselves are of grey in their place";
            self.warnings.add(WarningKind::Approximation, mixture.1.place.short(), message);
            self.define_mixture(mixture)?;
        }
        Ok(())
    }

    fn define_mixture(&mut self, (index, params, space): &Awaited) -> Result<usize, ImportError> {
        let material = self.definition("mix", params, *space)?;
        self.materials.fill(*index, material);
        Ok(*index)
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
