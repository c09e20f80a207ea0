//! What a file says and the scene does not.

use std::{collections::HashMap, fmt};

/// What sort of thing was left out or changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum WarningKind {
    /// An image on a surface.
    Texture,
    /// Movement.
    Animation,
    /// A skin: the mesh is shown as modelled.
    Skin,
    /// Morph targets: the mesh is shown without.
    MorphTarget,
    /// An extension of the format.
    Extension,
    /// A material rendered as the nearest that there is.
    Approximation,
    /// Transparency by alpha.
    Alpha,
    /// Points, lines, curves.
    Primitive,
    /// A light that is not a surface.
    Light,
    /// Colours at vertices.
    VertexColour,
    /// A camera of a kind that is not rendered.
    Camera,
    /// A file that is not there and can be done without.
    MissingFile,
    /// A bad value that was replaced.
    Repaired,
    /// What breaks the format's rules, where nothing that is rendered depends on it.
    Invalid,
    /// Something in the file that the scene has no place for.
    Unused,
    /// The file has no camera.
    NoCamera,
    /// Nothing emits.
    NoLight,
}

/// One thing left out or changed, however often it occurs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What sort of thing.
    pub kind: WarningKind,
    /// Where it occurs first: a JSON pointer, `file.mtl:12`, or empty for the whole file.
    pub place: String,
    /// How often it occurs.
    pub count: usize,
    /// What, and what is rendered instead.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.place.is_empty() {
            write!(f, "{}", self.place)?;
            if self.count > 1 {
                write!(f, " and {} more", self.count - 1)?;
            }
            write!(f, ": ")?;
        }
        write!(f, "{}", self.message)
    }
}

/// Collects warnings, those of the same kind and words as one.
#[derive(Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    known: HashMap<(WarningKind, String), usize>,
}

/// Words of a file as they may be shown in a terminal.
fn shown(words: impl Into<String>) -> String {
    let words = words.into();
    if words.contains(char::is_control) { words.replace(char::is_control, "?") } else { words }
}

impl Warnings {
    pub fn add(&mut self, kind: WarningKind, place: impl Into<String>, message: impl Into<String>) {
        let message = shown(message);
        let next = self.list.len();
        let index = *self.known.entry((kind, message.clone())).or_insert(next);
        if index == next {
            self.list.push(Warning { kind, place: shown(place), count: 0, message });
        }
        self.list[index].count += 1;
    }

    /// Adds those of another, after its own.
    pub fn append(&mut self, others: Self) {
        for warning in others.list {
            let key = (warning.kind, warning.message.clone());
            let next = self.list.len();
            let index = *self.known.entry(key).or_insert(next);
            if index == next {
                self.list.push(warning);
            } else {
                self.list[index].count += warning.count;
            }
        }
    }

    /// Like [`Warnings::add`], but never one with others: each place counts.
    pub fn add_apart(&mut self, kind: WarningKind, place: impl Into<String>, message: impl Into<String>) {
        self.list.push(Warning { kind, place: shown(place), count: 1, message: shown(message) });
    }

    /// Like [`Warnings::add`], but not counted again where it is known already.
    pub fn add_once(&mut self, kind: WarningKind, place: impl Into<String>, message: impl Into<String>) {
        let message = shown(message);
        if !self.known.contains_key(&(kind, message.clone())) {
            self.add(kind, place, message);
        }
    }

    pub fn into_list(self) -> Vec<Warning> {
        self.list
    }
}
