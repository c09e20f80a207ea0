//! Buffers and views of them, every bound checked.

use std::sync::Arc;

use super::json::Json;
use crate::{ImportError, files::SceneFolder};

/// The document's buffers, loaded, and its views.
pub(super) struct Buffers<'a> {
    /// None for one that holds nothing: an extension's, an error where it is used.
    buffers: Vec<Option<Arc<[u8]>>>,
    views: Vec<Json<'a>>,
}

/// A range of a buffer.
pub(super) struct View<'b> {
    pub bytes: &'b [u8],
    /// Bytes from one element to the next, where the view says.
    pub stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    pub fn load(
        root: &Json<'a>,
        folder: &mut SceneFolder,
        binary: Option<&[u8]>,
    ) -> Result<Self, ImportError> {
        let mut buffers = Vec::new();
        for (i, buffer) in root.items("buffers")?.into_iter().enumerate() {
            let bytes = match (buffer.get("uri"), binary) {
                (Some(uri), _) => folder.read_uri(uri.string()?, &uri.place())?,
                (None, Some(binary)) if i == 0 => binary.into(),
                (None, _) => {
                    buffers.push(None);
                    continue;
                }
            };
            let announced = buffer.required("byteLength")?;
            let needed = announced.unsigned()?;
            if needed > bytes.len() as u64 {
                let (place, available) = (announced.place(), bytes.len() as u64);
                return Err(ImportError::Truncated { place, what: "the buffer", needed, available });
            }
            buffers.push(Some(bytes));
        }
        Ok(Self { buffers, views: root.items("bufferViews")? })
    }

    /// Bytes held in all buffers.
    pub fn total_bytes(&self) -> u64 {
        self.buffers.iter().flatten().map(|b| b.len() as u64).sum()
    }

    /// The view that an index refers to.
    pub fn view(&self, index: &Json) -> Result<View<'_>, ImportError> {
        let view = &self.views[index.index("buffer view", self.views.len())?];
        let buffer = view.required("buffer")?;
        let buffer = self.buffers[buffer.index("buffer", self.buffers.len())?]
            .as_ref()
            .ok_or_else(|| buffer.malformed("the buffer has neither a URI nor a GLB chunk"))?;
        let offset = view.unsigned_or("byteOffset", 0)?;
        let length = view.required("byteLength")?.unsigned()?;
        let bytes = slice(buffer, offset, length).ok_or_else(|| ImportError::Truncated {
            place: view.place(),
            what: "the buffer view",
            needed: offset.saturating_add(length),
            available: buffer.len() as u64,
        })?;
        let stride = match view.get("byteStride") {
            Some(stride) => Some(stride.unsigned()? as usize),
            None => None,
        };
        Ok(View { bytes, stride })
    }
}

/// A part of a slice; none where any of it is beyond the end.
pub(super) fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(start..end)
}
