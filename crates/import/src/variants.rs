//! A file's variants of materials, as whoever has loaded the scene may take them.

/// The named choices of materials that a file has (`KHR_materials_variants`), and the material that each
/// means for the meshes of the scene that was read from it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variants {
    names: Vec<String>,
    /// Of each primitive that was read.
    choices: Vec<Choices>,
    /// Of each of the scene's meshes, its place among `choices`: a primitive may be read more than once.
    of_mesh: Vec<u32>,
}

/// A primitive's materials.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Choices {
    /// Where no variant is taken.
    pub own: u32,
    /// Variants that change it, ascending and each once, with their materials.
    pub changed: Vec<(u32, u32)>,
}

impl Variants {
    pub(crate) fn new(names: Vec<String>) -> Self {
        Self { names, ..Self::default() }
    }

    /// Notes a primitive; its place.
    pub(crate) fn add(&mut self, choices: Choices) -> u32 {
        self.choices.push(choices);
        self.choices.len() as u32 - 1
    }

    /// Notes that the scene's next mesh is of a primitive.
    pub(crate) fn add_mesh(&mut self, choices: u32) {
        self.of_mesh.push(choices);
    }

    /// In the file's order; none where it has no variants.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The material of each of the scene's meshes, as [`crate::Options::variant`] gives it, by a variant's place
    /// among the names, or those that the file has by default. A mapping that is damaged leaves a primitive
    /// its own; it is among the warnings. None where there is no such variant, or none at all.
    pub fn materials(&self, variant: Option<u32>) -> Option<Vec<u32>> {
        let n = self.names.len();
        if n == 0 || variant.is_some_and(|variant| variant as usize >= n) {
            return None;
        }
        Some(self.of_mesh.iter().map(|&place| self.choices[place as usize].material(variant)).collect())
    }
}

impl Choices {
    fn material(&self, variant: Option<u32>) -> u32 {
        let changed = |variant| self.changed.binary_search_by_key(&variant, |&(changed, _)| changed).ok();
        variant.and_then(changed).map_or(self.own, |place| self.changed[place].1)
    }
}
