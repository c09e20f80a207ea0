//! What can be wrong with a file.

use std::{
    fmt, io,
    path::{Path, PathBuf},
};

use midway_scene::SceneError;

/// Where in which file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// A JSON pointer (`/materials/3`), a line number, or empty for the whole file.
    pub within: String,
}

impl Place {
    pub(crate) fn new(file: &Path, within: impl Into<String>) -> Self {
        Self { file: file.to_owned(), within: within.into() }
    }

    /// For a warning: a JSON pointer alone, a line with its file's name, or the file's name.
    pub(crate) fn short(&self) -> String {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        match self.within.as_str() {
            "" => name.into_owned(),
            pointer if pointer.starts_with('/') => pointer.to_owned(),
            line => format!("{name}:{line}"),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.display();
        match self.within.as_str() {
            "" => write!(f, "{file}"),
            pointer if pointer.starts_with('/') => write!(f, "{file}#{pointer}"),
            line => write!(f, "{file}:{line}"),
        }
    }
}

/// A file that cannot be read as a scene: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// There is no such scene file.
    #[error("{}: no such file; check the path", path.display())]
    NotFound {
        /// As given.
        path: PathBuf,
    },
    /// The file is there but the system does not let it be read.
    #[error("{}: cannot be read ({source}); check that it is a file and its permissions", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Not a format that is read.
    #[error("{}: not a format that is read; convert it to {}", path.display(), crate::FORMATS)]
    UnsupportedFormat {
        /// As given.
        path: PathBuf,
    },
    /// The file breaks its format's rules.
    #[error("{place}: {problem}; export the file again")]
    Malformed {
        /// Where.
        place: Place,
        /// Which rule.
        problem: String,
    },
    /// A reference to a file that does not lie in the folder that may be read: the scene's own, or
    /// [`crate::Options::root`].
    #[error(
        "{place}: \"{uri}\" lies outside the folder that the scene's files may come from; \
         move the file there, or allow a folder that holds both"
    )]
    UnsafePath {
        /// Where it is referred to.
        place: Place,
        /// The reference.
        uri: String,
    },
    /// The scene itself does not lie in [`crate::Options::root`].
    #[error(
        "{}: does not lie in {}, the folder that its files may come from; name one that holds the scene",
        path.display(), root.display()
    )]
    OutsideRoot {
        /// The scene, as given.
        path: PathBuf,
        /// The folder, as given.
        root: PathBuf,
    },
    /// A reference to another machine.
    #[error("{place}: \"{uri}\" is on a network, from which nothing is read; save it in the scene's folder")]
    NetworkUri {
        /// Where it is referred to.
        place: Place,
        /// The reference.
        uri: String,
    },
    /// A file that the scene needs is not there.
    #[error("{place}: the file \"{uri}\" that it needs does not exist; put it beside the scene")]
    MissingBuffer {
        /// Where it is referred to.
        place: Place,
        /// The reference.
        uri: String,
    },
    /// Less data than announced.
    #[error("{place}: {what} needs {needed} bytes and {available} are there; the file is cut short")]
    Truncated {
        /// Where it is announced.
        place: Place,
        /// What is too short.
        what: &'static str,
        /// Bytes announced.
        needed: u64,
        /// Bytes there.
        available: u64,
    },
    /// An index of something that does not exist.
    #[error("{place}: {what} {index} does not exist, there are {len}; export the file again")]
    OutOfRange {
        /// Where.
        place: Place,
        /// Of what.
        what: &'static str,
        /// The index, as the file counts.
        index: i64,
        /// How many there are.
        len: u64,
    },
    /// A NaN or an infinity where a number has to be.
    #[error("{place}: {what} {index} is not finite (NaN or infinity); repair the mesh and export it again")]
    NotFinite {
        /// Where.
        place: Place,
        /// Of what.
        what: &'static str,
        /// Which one.
        index: u64,
    },
    /// The file says that it cannot be understood without this.
    #[error("{place}: it requires {extension}, which is not supported; export it without")]
    UnsupportedExtension {
        /// Where it is required.
        place: Place,
        /// Its name.
        extension: String,
    },
    /// A variant of materials that the file does not have.
    #[error("{}: there is no variant {name:?}{}", path.display(), known_variants(known))]
    UnknownVariant {
        /// As given.
        path: PathBuf,
        /// As given.
        name: String,
        /// The names of those that there are.
        known: Vec<String>,
    },
    /// More than can be held, or than a file of this size has any reason to ask for.
    #[error("{place}: {what} (the limit is {limit}); split or simplify the scene")]
    TooBig {
        /// Where.
        place: Place,
        /// What there is too much of.
        what: String,
        /// How much there may be.
        limit: u64,
    },
    /// Nothing that can be rendered.
    #[error("{}: the scene has no triangles; check what was exported", path.display())]
    EmptyScene {
        /// As given.
        path: PathBuf,
    },
    /// Read without fault, but not a scene that can be rendered.
    #[error("{}: {source}; correct it and export it again", path.display())]
    InvalidScene {
        /// As given.
        path: PathBuf,
        /// What is wrong.
        source: SceneError,
    },
}

impl ImportError {
    pub(crate) fn unknown_variant(path: &Path, name: &str, known: Vec<String>) -> Self {
        Self::UnknownVariant { path: path.to_owned(), name: name.to_owned(), known }
    }
}

/// What is said of the variants that there are, on one line.
fn known_variants(known: &[String]) -> String {
    if known.is_empty() {
        return ": the file has none".to_owned();
    }
    let quoted: Vec<String> = known.iter().map(|name| format!("{name:?}")).collect();
    format!("; there are: {}", quoted.join(", "))
}
