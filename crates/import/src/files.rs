//! Reading files, from inside one folder only: the scene's own, or one that holds it.

use std::{
    borrow::Cow,
    collections::HashMap,
    fs, io,
    io::Read,
    path::{self, Component, Path, PathBuf},
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

/// The folder that a scene's references start from, and the one that they may not leave.
pub(crate) struct SceneFolder {
    /// Where the scene is; canonical.
    folder: PathBuf,
    /// What has to hold every file; canonical.
    root: PathBuf,
    /// The same as it was named, absolute: it may lead through links.
    root_as_named: PathBuf,
    /// By canonical path: a file that is referred to often is held once.
    buffers: HashMap<PathBuf, Arc<[u8]>>,
}

impl SceneFolder {
    /// Of a scene whose files lie in `root`, by default in its own folder.
    ///
    /// # Errors
    ///
    /// [`ImportError::OutsideRoot`] where the scene does not lie there itself.
    pub fn of(scene: &Path, root: Option<&Path>) -> Result<Self, ImportError> {
        let parent = match scene.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let folder = canonical(parent, scene)?;
        let named = root.unwrap_or(parent);
        let root = canonical(named, named)?;
        if !folder.starts_with(&root) {
            return Err(ImportError::OutsideRoot { path: scene.to_owned(), root: named.to_owned() });
        }
        let root_as_named = path::absolute(named).unwrap_or_else(|_| root.clone());
        Ok(Self { folder, root, root_as_named, buffers: HashMap::new() })
    }

    /// Whether an absolute path, of whatever system, is one of a file that may be read.
    pub fn holds(&self, absolute: &str) -> bool {
        self.find(absolute, &Place::default()).is_ok()
    }

    /// Where a file in the folder is, by a path that is not percent-encoded.
    pub fn find(&self, name: &str, place: &Place) -> Result<PathBuf, ImportError> {
        refuse_scheme(name, place)?;
        self.resolve(name, place)
    }

    /// A file in the folder, by a path that is not percent-encoded.
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

    /// A text file in the folder, by a path that is not percent-encoded.
    pub fn read_text(&self, name: &str, place: &Place) -> Result<Vec<u8>, ImportError> {
        let path = self.find(name, place)?;
        read_open(&path, open(&path)?, MAX_TEXT_BYTES)
    }

    /// The canonical path of a file in the folder: neither `..` nor links lead out of it. What lies
    /// outside by its name alone is not looked at.
    fn resolve(&self, reference: &str, place: &Place) -> Result<PathBuf, ImportError> {
        let refused = || ImportError::UnsafePath { place: place.clone(), uri: shortened(reference) };
        let missing = || ImportError::MissingBuffer { place: place.clone(), uri: shortened(reference) };
        let path = self.absolute(Path::new(reference));
        if !path.starts_with(&self.root) && !path.starts_with(&self.root_as_named) {
            return Err(refused());
        }
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

    /// A reference from the scene's folder, without `.` and `..`.
    fn absolute(&self, reference: &Path) -> PathBuf {
        let mut path = self.folder.clone();
        for component in reference.components() {
            match component {
                Component::CurDir => {}
                Component::ParentDir => {
                    path.pop();
                }
                // One that is absolute takes the place of all before it.
                Component::Normal(_) | Component::RootDir | Component::Prefix(_) => path.push(component),
            }
        }
        path
    }
}

fn canonical(folder: &Path, named: &Path) -> Result<PathBuf, ImportError> {
    folder.canonicalize().map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => ImportError::NotFound { path: named.to_owned() },
        _ => ImportError::Unreadable { path: folder.to_owned(), source },
    })
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

/// Only references to files of this machine are followed.
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
    // One letter is a drive.
    if cfg!(windows) && scheme.len() == 1 {
        return Ok(());
    }
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
