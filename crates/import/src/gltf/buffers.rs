//! Buffers and views of them, every bound checked.

use std::{ops::Range, sync::Arc};

use super::{json::Json, meshopt};
use crate::{ImportError, files::SceneFolder, images::Bytes};

/// The document's buffers, loaded, and its views.
pub(super) struct Buffers<'a> {
    /// None for one that holds nothing: an extension's, an error where it is used.
    buffers: Vec<Option<Arc<[u8]>>>,
    views: Vec<Json<'a>>,
    /// What views that are compressed come to.
    decompressed: Vec<Option<Arc<[u8]>>>,
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
            let stands_in = match meshopt::extension(&buffer) {
                Some(extension) => extension.bool_or("fallback", false)?,
                None => false,
            };
            let uri = buffer.get("uri").filter(|_| !stands_in);
            let bytes = match (uri, binary) {
                (Some(uri), _) => folder.read_uri(uri.string()?, &uri.place())?,
                (None, Some(binary)) if i == 0 && !stands_in => binary.into(),
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
        let views = root.items("bufferViews")?;
        let decompress = |view: &Json| match meshopt::extension(view) {
            Some(extension) => meshopt::decode(&extension, &buffers).map(Some),
            None => Ok(None),
        };
        let decompressed = views.iter().map(decompress).collect::<Result<_, _>>()?;
        Ok(Self { buffers, views, decompressed })
    }

    /// Bytes held in all buffers.
    pub fn total_bytes(&self) -> u64 {
        self.buffers.iter().chain(&self.decompressed).flatten().map(|b| b.len() as u64).sum()
    }

    /// The view that an index refers to.
    pub fn view(&self, index: &Json) -> Result<View<'_>, ImportError> {
        let (buffer, range) = self.range(index)?;
        let stride = self.views[index.index("buffer view", self.views.len())?].get("byteStride");
        let stride = stride.map(|stride| stride.unsigned()).transpose()?;
        Ok(View { bytes: &buffer[range], stride: stride.map(|stride| stride as usize) })
    }

    /// The bytes of the view that an index refers to, shared.
    pub fn shared(&self, index: &Json) -> Result<Bytes, ImportError> {
        let (buffer, range) = self.range(index)?;
        Ok(Bytes { buffer: buffer.clone(), start: range.start, end: range.end })
    }

    fn range(&self, index: &Json) -> Result<(&Arc<[u8]>, Range<usize>), ImportError> {
        let i = index.index("buffer view", self.views.len())?;
        let view = &self.views[i];
        if let Some(decompressed) = &self.decompressed[i] {
            return Ok((decompressed, 0..decompressed.len()));
        }
        let buffer = view.required("buffer")?;
        let buffer = self.buffers[buffer.index("buffer", self.buffers.len())?]
            .as_ref()
            .ok_or_else(|| buffer.malformed("the buffer has neither a URI nor a GLB chunk"))?;
        let offset = view.unsigned_or("byteOffset", 0)?;
        let length = view.required("byteLength")?.unsigned()?;
        let truncated = || ImportError::Truncated {
            place: view.place(),
            what: "the buffer view",
            needed: offset.saturating_add(length),
            available: buffer.len() as u64,
        };
        Ok((buffer, range(buffer.len(), offset, length).ok_or_else(truncated)?))
    }
}

/// A part of a slice; none where any of it is beyond the end.
pub(super) fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    range(bytes.len(), offset, length).map(|range| &bytes[range])
}

fn range(available: usize, offset: u64, length: u64) -> Option<Range<usize>> {
    let start = usize::try_from(offset).ok()?;
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    (end <= available).then_some(start..end)
}
