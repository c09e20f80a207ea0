//! OpenEXR files: write 32-bit RGB with any layers beside it, read anything flat.

mod read;
#[cfg(test)]
mod tests;
mod write;

pub use read::{Channel, ExrFile};
pub use write::{write_exr, write_exr_with};

/// Before the name of every header attribute that is a [`crate::Metadata`] entry.
const ATTRIBUTE_PREFIX: &str = "midway:";

/// Where an image lies in the full frame, when it is a crop of one. Becomes EXR's display window
/// (the frame) and data window (the image).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing {
    /// Width and height of the frame.
    pub frame: [usize; 2],
    /// Column and row of the image's top left pixel in the frame.
    pub offset: [usize; 2],
}
