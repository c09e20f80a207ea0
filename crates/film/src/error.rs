//! What can go wrong with an image.

use std::{io, path::PathBuf};

/// Everything this crate reports. Each message is one line and names the file where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The file could not be opened or read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The bytes are not an EXR that this crate accepts.
    #[error("{}: not a usable EXR file: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The file lacks the channels asked for.
    #[error("{}: no {wanted} among its channels ({})", path.display(), found.join(", "))]
    MissingChannels {
        /// The file.
        path: PathBuf,
        /// What was looked for.
        wanted: String,
        /// The channels it has.
        found: Vec<String>,
    },
    /// The file could not be written; what was there before is untouched.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Two images that must have the same size do not.
    #[error("the images differ in size: {}x{} and {}x{}", .0[0], .0[1], .1[0], .1[1])]
    SizeMismatch([usize; 2], [usize; 2]),
    /// An image holds NaN or infinity, so that no number would mean anything.
    #[error("the {which} image has {count} pixel(s) that are NaN or infinite, the first at ({x}, {y})")]
    NotFinite {
        /// `"test"` or `"reference"`.
        which: &'static str,
        /// How many pixels.
        count: usize,
        /// Column of the first.
        x: usize,
        /// Row of the first.
        y: usize,
    },
    /// Width, height and the number of pixels do not belong together, or there are none.
    #[error("an image of {width}x{height} cannot have {pixels} pixels")]
    BadShape {
        /// Pixels along x.
        width: usize,
        /// Pixels along y.
        height: usize,
        /// Length of the pixel array.
        pixels: usize,
    },
}
