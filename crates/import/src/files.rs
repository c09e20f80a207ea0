//! Reading files, from inside the scene's folder only.

use std::{
    borrow::Cow,
    collections::HashMap,
    fs, io,
    io::Read,
    path::{Component, Path, PathBuf},
    sync::Arc,
};

use base64::{Engine, engine::general_purpose};
use percent_encoding::percent_decode_str;

use crate::{ImportError, Place};

/// Text (JSON, OBJ, MTL) takes several times its size once parsed.
const MAX_TEXT_BYTES: u64 = 1 << 30;
/// Buffers are held as they are.
const MAX_BUFFER_BYTES: u64 = 1 << 34;

/// Whether a scene file begins with these bytes; a shorter one does not.
pub(crate) fn starts_with(path: &Path, magic: &[u8]) -> Result<bool, ImportError> {
    let mut start = Vec::new();
    open(path)?
        .take(magic.len() as u64)
        .read_to_end(&mut start)
        .map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
    Ok(start == magic)
}

/// The scene file itself.
pub(crate) fn read_scene(path: &Path, limit_is_text: bool) -> Result<Vec<u8>, ImportError> {
    let file = open(path)?;
    read_open(path, file, if limit_is_text { MAX_TEXT_BYTES } else { MAX_BUFFER_BYTES })
}

fn open(path: &Path) -> Result<fs::File, ImportError> {
    let unreadable = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => ImportError::NotFound { path: path.to_owned() },
        _ => ImportError::Unreadable { path: path.to_owned(), source },
    };
    // A pipe or a device may never end: asked before it is opened.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        let source = io::Error::new(io::ErrorKind::InvalidInput, "not a regular file");
        return Err(ImportError::Unreadable { path: path.to_owned(), source });
    }
    fs::File::open(path).map_err(unreadable)
}

fn read_open(path: &Path, file: fs::File, limit: u64) -> Result<Vec<u8>, ImportError> {
    let mut bytes = Vec::new();
    file.take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
    if bytes.len() as u64 > limit {
        let place = Place::new(path, "");
        return Err(ImportError::TooBig { place, what: "the file is too large".into(), limit });
    }
    Ok(bytes)
}

/// The folder that holds a scene: what the scene refers to has to be in it.
pub(crate) struct SceneFolder {
    root: PathBuf,
    /// By canonical path: a file that is referred to often is held once.
    buffers: HashMap<PathBuf, Arc<[u8]>>,
}

impl SceneFolder {
    pub fn of(scene: &Path) -> Result<Self, ImportError> {
        let parent = match scene.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let root = parent
            .canonicalize()
            .map_err(|source| ImportError::Unreadable { path: parent.to_owned(), source })?;
        Ok(Self { root, buffers: HashMap::new() })
    }

    /// Where a file in the folder is, by a relative path that is not percent-encoded.
    pub fn find(&self, name: &str, place: &Place) -> Result<PathBuf, ImportError> {
        refuse_scheme(name, place)?;
        self.resolve(name, place)
    }

    /// A file in the folder, by a relative path that is not percent-encoded.
    pub fn read_bytes(&mut self, name: &str, place: &Place) -> Result<Arc<[u8]>, ImportError> {
        let path = self.find(name, place)?;
        self.read_once(path)
    }

    /// What a `data:` URI holds, or a file in the folder by a relative URI.
    pub fn read_uri(&mut self, uri: &str, place: &Place) -> Result<Arc<[u8]>, ImportError> {
        if let Some(data) = strip_data_scheme(uri) {
            return decode_data(data, place).map(Into::into);
        }
        let path = self.resolve(&decode_uri(uri, place)?, place)?;
        self.read_once(path)
    }

    fn read_once(&mut self, path: PathBuf) -> Result<Arc<[u8]>, ImportError> {
        if let Some(known) = self.buffers.get(&path) {
            return Ok(known.clone());
        }
        let bytes: Arc<[u8]> = read_open(&path, open(&path)?, MAX_BUFFER_BYTES)?.into();
        self.buffers.insert(path, bytes.clone());
        Ok(bytes)
    }

    /// The same, read anew and not held: for what is parsed once.
    pub fn read_unheld(&self, name: &str, place: &Place) -> Result<Vec<u8>, ImportError> {
        let path = self.find(name, place)?;
        read_open(&path, open(&path)?, MAX_BUFFER_BYTES)
    }

    /// A text file in the folder, by a relative path that is not percent-encoded.
    pub fn read_text(&self, name: &str, place: &Place) -> Result<Vec<u8>, ImportError> {
        let path = self.find(name, place)?;
        read_open(&path, open(&path)?, MAX_TEXT_BYTES)
    }

    /// The canonical path of a file in the folder: neither `..` nor links lead out of it.
    fn resolve(&self, relative: &str, place: &Place) -> Result<PathBuf, ImportError> {
        let refused = || ImportError::UnsafePath { place: place.clone(), uri: shortened(relative) };
        let mut path = self.root.clone();
        let mut depth = 0usize;
        for component in Path::new(relative).components() {
            match component {
                Component::Normal(name) => {
                    path.push(name);
                    depth += 1;
                }
                Component::CurDir => {}
                Component::ParentDir => {
                    depth = depth.checked_sub(1).ok_or_else(refused)?;
                    path.pop();
                }
                Component::RootDir | Component::Prefix(_) => return Err(refused()),
            }
        }
        let missing = || ImportError::MissingBuffer { place: place.clone(), uri: shortened(relative) };
        let path = match path.canonicalize() {
            Ok(path) => path,
            Err(source) if source.kind() == io::ErrorKind::PermissionDenied => {
                return Err(ImportError::Unreadable { path, source });
            }
            Err(_) => return Err(missing()),
        };
        if !path.starts_with(&self.root) {
            return Err(refused());
        }
        if path.is_file() { Ok(path) } else { Err(missing()) }
    }
}

/// The path that a relative URI stands for.
///
/// # Errors
///
/// [`ImportError`] where it has a scheme, or is not UTF-8.
pub(crate) fn decode_uri<'u>(uri: &'u str, place: &Place) -> Result<Cow<'u, str>, ImportError> {
    refuse_scheme(uri, place)?;
    percent_decode_str(uri).decode_utf8().map_err(|_| ImportError::Malformed {
        place: place.clone(),
        problem: format!("the URI \"{}\" is not UTF-8 once decoded", shortened(uri)),
    })
}

/// What follows `data:`; none for other URIs.
pub(crate) fn strip_data_scheme(uri: &str) -> Option<&str> {
    let scheme = uri.get(..5)?;
    scheme.eq_ignore_ascii_case("data:").then(|| &uri[5..])
}

/// The bytes of a data URI, its scheme removed.
pub(crate) fn decode_data(data: &str, place: &Place) -> Result<Vec<u8>, ImportError> {
    let malformed = |problem: &str| ImportError::Malformed { place: place.clone(), problem: problem.into() };
    let (header, body) =
        data.split_once(',').ok_or_else(|| malformed("a data URI has no comma before its data"))?;
    if !header.to_ascii_lowercase().ends_with(";base64") {
        return Ok(percent_decode_str(body).collect());
    }
    let unescaped: Vec<u8> = percent_decode_str(body).collect();
    let engine = if unescaped.ends_with(b"=") || unescaped.len().is_multiple_of(4) {
        &general_purpose::STANDARD
    } else {
        &general_purpose::STANDARD_NO_PAD
    };
    engine.decode(&unescaped).map_err(|e| malformed(&format!("a data URI's base64 does not decode ({e})")))
}

/// Only relative references are followed.
fn refuse_scheme(uri: &str, place: &Place) -> Result<(), ImportError> {
    let refuse = |network: bool| {
        let (place, uri) = (place.clone(), shortened(uri));
        Err(if network {
            ImportError::NetworkUri { place, uri }
        } else {
            ImportError::UnsafePath { place, uri }
        })
    };
    if uri.starts_with("//") || uri.starts_with("\\\\") {
        return refuse(true);
    }
    let Some((scheme, _)) = uri.split_once(':') else {
        return Ok(());
    };
    let is_scheme = scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+.-".contains(c));
    if !is_scheme {
        return Ok(());
    }
    // One letter is a Windows drive.
    refuse(scheme.len() > 1 && !scheme.eq_ignore_ascii_case("file"))
}

/// Enough of a URI to recognise it, and without control characters, for messages of one line.
pub(crate) fn shortened(uri: &str) -> String {
    const LONGEST: usize = 100;
    let mut short: String = uri.chars().take(LONGEST).map(|c| if c.is_control() { '?' } else { c }).collect();
    if uri.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    short
}
