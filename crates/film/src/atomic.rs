//! Files that are either whole or absent.

use std::{
    ffi::OsString,
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicU64, Ordering},
};

use crate::FilmError;

/// Writes `bytes` to `path` so that a crash or a full disk leaves either the old file or the new
/// one: to a temporary file in the same folder, flushed to the disk, then renamed. A symbolic link
/// keeps pointing where it did; a device or a pipe is written to directly.
///
/// # Errors
/// [`FilmError::Write`], with the temporary file removed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FilmError> {
    let fail = |source| FilmError::Write { path: path.to_owned(), source };
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(found) if found.is_dir() => return Err(fail(io::Error::from(io::ErrorKind::IsADirectory))),
        Ok(found) if !found.is_file() => return fs::write(&target, bytes).map_err(fail),
        _ => {}
    }
    let temporary = temporary_beside(&target).map_err(fail)?;
    let result = write_and_sync(&temporary, bytes).and_then(|()| fs::rename(&temporary, &target));
    result.map_err(|source| {
        // The first error is the one to report; a file that was never made cannot be removed.
        let _ = fs::remove_file(&temporary);
        fail(source)
    })
}

/// Fails now if [`write_atomically`] to `path` would fail for want of a folder or of permission.
///
/// # Errors
/// [`FilmError::Write`].
pub fn check_writable(path: &Path) -> Result<(), FilmError> {
    let fail = |source| FilmError::Write { path: path.to_owned(), source };
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(found) if found.is_dir() => return Err(fail(io::Error::from(io::ErrorKind::IsADirectory))),
        Ok(found) if !found.is_file() => {
            return OpenOptions::new().write(true).open(&target).map(drop).map_err(fail);
        }
        _ => {}
    }
    let temporary = temporary_beside(&target).map_err(fail)?;
    OpenOptions::new().write(true).create_new(true).open(&temporary).map_err(fail)?;
    fs::remove_file(&temporary).map_err(fail)
}

/// A name in the folder of `target` that no other write of this or another process uses.
fn temporary_beside(target: &Path) -> io::Result<PathBuf> {
    static WRITES: AtomicU64 = AtomicU64::new(0);
    let name = target.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}-{}.tmp", process::id(), WRITES.fetch_add(1, Ordering::Relaxed)));
    Ok(target.with_file_name(hidden))
}

fn write_and_sync(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file: File = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(bytes)?;
    match file.sync_all() {
        // Some file systems cannot sync; the write itself has succeeded.
        Err(error) if matches!(error.kind(), io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput) => {
            Ok(())
        }
        result => result,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<OsString> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect()
    }

    #[test]
    fn replaces_a_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        check_writable(&path).unwrap();
        assert!(names(folder.path()).is_empty());
        write_atomically(&path, b"one").unwrap();
        write_atomically(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn a_missing_folder_or_a_folder_as_target_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().join("none/a.bin"), folder.path().to_owned(), PathBuf::from("..")] {
            let error = write_atomically(&path, b"x").unwrap_err().to_string();
            assert!(error.contains(&path.display().to_string()), "{error}");
            assert!(check_writable(&path).is_err());
        }
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error() {
        let full = Path::new("/dev/full");
        check_writable(full).unwrap();
        assert!(matches!(write_atomically(full, b"x"), Err(FilmError::Write { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn a_symbolic_link_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, b"old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
