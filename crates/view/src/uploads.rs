//! Files from browsers: into a temporary folder that ends with the server, and nowhere else.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use tempfile::TempDir;

use crate::ViewError;

/// Bytes of one file at most.
pub const MAX_FILE: usize = 512 << 20;
/// Bytes and files of one upload at most.
const MAX_BATCH: u64 = 1 << 30;
const MAX_FILES: usize = 4096;
/// Folders in folders at most, and the longest name.
const MAX_DEPTH: usize = 12;
const MAX_NAME: usize = 200;
/// Uploads that are kept: what is being rendered, and what is under way.
const KEPT: usize = 3;

/// All uploads of a server.
pub struct Uploads {
    batches: Mutex<Vec<Batch>>,
}

/// A file that was uploaded.
#[derive(Debug)]
pub struct Uploaded {
    /// Where it lies.
    pub file: PathBuf,
    /// The folder of all that was uploaded with it, which it may refer to. It stays until nobody has it any more.
    pub folder: Arc<TempDir>,
}

struct Batch {
    number: u64,
    folder: Arc<TempDir>,
    bytes: u64,
    files: usize,
}

impl Uploads {
    /// None yet.
    pub fn new() -> Self {
        Self { batches: Mutex::default() }
    }

    /// Writes a file of an upload. The oldest upload goes when a new one begins.
    ///
    /// # Errors
    /// [`ViewError::Refused`] for a path that is not confined or too much; if it cannot be written.
    pub fn write(&self, number: u64, path: &str, bytes: &[u8]) -> Result<(), ViewError> {
        let relative =
            confined(path).ok_or_else(|| ViewError::Refused("no such path may be uploaded".into()))?;
        let folder = self.room(number, bytes)?;
        let target = folder.path().join(relative);
        if let Some(folder) = target.parent() {
            fs::create_dir_all(folder)?;
        }
        Ok(fs::write(target, bytes)?)
    }

    /// The folder of an upload that has room for a file more of these bytes.
    fn room(&self, number: u64, bytes: &[u8]) -> Result<Arc<TempDir>, ViewError> {
        let mut batches = self.batches.lock().unwrap_or_else(PoisonError::into_inner);
        let place = match batches.iter().position(|batch| batch.number == number) {
            Some(place) => place,
            None => {
                let folder = tempfile::Builder::new().prefix("midway-view-").tempdir()?.into();
                batches.push(Batch { number, folder, bytes: 0, files: 0 });
                if batches.len() > KEPT {
                    batches.remove(0);
                }
                batches.len() - 1
            }
        };
        let batch = &mut batches[place];
        batch.bytes += bytes.len() as u64;
        batch.files += 1;
        if batch.bytes > MAX_BATCH || batch.files > MAX_FILES {
            return Err(ViewError::Refused("the upload is larger than 1 GiB or 4096 files".into()));
        }
        Ok(Arc::clone(&batch.folder))
    }

    /// A file that was uploaded.
    ///
    /// # Errors
    /// [`ViewError::Refused`] where there is none.
    pub fn find(&self, number: u64, path: &str) -> Result<Uploaded, ViewError> {
        let none = || ViewError::Refused("no such file was uploaded".into());
        let relative = confined(path).ok_or_else(none)?;
        let batches = self.batches.lock().unwrap_or_else(PoisonError::into_inner);
        let batch = batches.iter().find(|batch| batch.number == number).ok_or_else(none)?;
        let folder = Arc::clone(&batch.folder);
        let file = folder.path().join(relative);
        if file.is_file() { Ok(Uploaded { file, folder }) } else { Err(none()) }
    }
}

/// A path below a folder, by plain names only.
fn confined(path: &str) -> Option<PathBuf> {
    let names: Vec<&str> = path.split('/').collect();
    let plain = |name: &&str| {
        !name.is_empty()
            && name.len() <= MAX_NAME
            && !name.starts_with('.')
            && !name
                .chars()
                .any(|c| c.is_control() || matches!(c, '\\' | ':' | '*' | '?' | '"' | '<' | '>' | '|'))
    };
    let fits = names.len() <= MAX_DEPTH && names.iter().all(plain);
    fits.then(|| names.iter().collect::<PathBuf>()).filter(|path| Path::new(path).is_relative())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_confined() {
        for path in ["a.glb", "scene/textures/wood 1.png", "ü.gltf"] {
            assert!(confined(path).is_some(), "{path}");
        }
        let deep = "a/".repeat(20) + "b";
        for path in [
            "",
            "/",
            "/etc/passwd",
            "..",
            "../a",
            "a/../../b",
            "a//b",
            "a/",
            ".bashrc",
            "a\\b",
            "C:a",
            "a\0b",
            "a\nb",
            &deep,
            &"x".repeat(300),
        ] {
            assert!(confined(path).is_none(), "{path:?}");
        }
    }

    #[test]
    fn files_are_found_in_their_own_upload_and_old_uploads_go() {
        let uploads = Uploads::new();
        uploads.write(1, "s/a.bin", b"one").unwrap();
        uploads.write(2, "a.bin", b"two").unwrap();
        let first = uploads.find(1, "s/a.bin").unwrap().file;
        assert_eq!(fs::read(&first).unwrap(), b"one");
        assert!(uploads.find(1, "a.bin").is_err() && uploads.find(3, "a.bin").is_err());
        assert!(uploads.find(1, "s").is_err(), "a folder is no file");
        uploads.write(3, "a.bin", b"").unwrap();
        uploads.write(4, "a.bin", b"").unwrap();
        assert!(uploads.find(1, "s/a.bin").is_err() && !first.exists());
        assert!(uploads.write(4, "../x", b"").is_err());
    }
}
