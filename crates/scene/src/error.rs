//! What can be wrong with a scene.

/// A scene that cannot be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// Nothing to intersect.
    #[error("the scene has no triangles")]
    NoTriangles,
    /// An index points past the end of a list.
    #[error("{what} refers to {list} {index}, of which there are {len}")]
    IndexOutOfRange {
        /// Who refers.
        what: String,
        /// To a member of what.
        list: &'static str,
        /// The index.
        index: usize,
        /// Length of the list.
        len: usize,
    },
    /// A value is NaN, infinite, or outside what it may be.
    #[error("{what}: {problem}")]
    BadValue {
        /// Which value.
        what: String,
        /// What is wrong with it.
        problem: String,
    },
}

impl SceneError {
    pub(crate) fn bad(what: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::BadValue { what: what.into(), problem: problem.into() }
    }
}
