//! Compiled pipelines kept on disk, so that the next start does not compile them again.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicBool, Ordering},
};

/// A driver only ever adds to its cache; a file this large holds mostly kernels of old versions.
const MAX_BYTES: u64 = 64 << 20;

/// The backend's pipeline cache and its file. Whatever goes wrong with the file only costs time.
pub(super) struct PipelineCache {
    cache: wgpu::PipelineCache,
    path: PathBuf,
    /// Whether pipelines were made since the file was written.
    dirty: AtomicBool,
}

impl PipelineCache {
    /// Opens the cache of this adapter, where the device has the feature, in `folder` or the
    /// platform's own.
    pub(super) fn open(
        device: &wgpu::Device,
        info: &wgpu::AdapterInfo,
        folder: Option<&Path>,
    ) -> Option<Self> {
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
            return None;
        }
        let key = wgpu::util::pipeline_cache_key(info)?;
        let folder = folder.map(Path::to_owned).or_else(platform_folder)?;
        let path = folder.join(format!("{key}-{}.bin", env!("CARGO_PKG_VERSION")));
        let data = read_small(&path);
        let descriptor =
            wgpu::PipelineCacheDescriptor { label: Some("midway"), data: data.as_deref(), fallback: true };
        // SAFETY: the file is in the user's own folder and written only by `save`, whole or not at
        // all; wgpu and the driver check that its header is theirs.
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        Some(Self { cache, path, dirty: AtomicBool::new(false) })
    }

    /// The cache, for a pipeline about to be made.
    pub(super) fn for_new_pipeline(&self) -> &wgpu::PipelineCache {
        self.dirty.store(true, Ordering::Release);
        &self.cache
    }

    /// Writes what was added since the last call.
    pub(super) fn save(&self) {
        if !self.dirty.swap(false, Ordering::AcqRel) {
            return;
        }
        if let Some(data) = self.cache.get_data() {
            // Harmless: the next start compiles the kernels again.
            let _ = replace(&self.path, &data);
        }
    }
}

fn read_small(path: &Path) -> Option<Vec<u8>> {
    let small = fs::metadata(path).is_ok_and(|file| file.len() <= MAX_BYTES);
    small.then(|| fs::read(path).ok()).flatten()
}

/// Writes a file whole or not at all, unless it holds these bytes already.
fn replace(path: &Path, data: &[u8]) -> io::Result<()> {
    if fs::read(path).is_ok_and(|old| old == data) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let unfinished = path.with_extension(format!("{}.tmp", process::id()));
    let written = fs::write(&unfinished, data).and_then(|()| fs::rename(&unfinished, path));
    if written.is_err() {
        let _ = fs::remove_file(&unfinished);
    }
    written
}

/// Where this platform's programs keep what can be made again.
fn platform_folder() -> Option<PathBuf> {
    let folder = |variable| env::var_os(variable).map(PathBuf::from).filter(|path| path.is_absolute());
    let caches = if cfg!(windows) {
        folder("LOCALAPPDATA")
    } else if cfg!(target_vendor = "apple") {
        folder("HOME").map(|home| home.join("Library/Caches"))
    } else {
        folder("XDG_CACHE_HOME").or_else(|| folder("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("midway"))
}

#[cfg(test)]
mod tests {
    use super::{read_small, replace};

    #[test]
    fn a_file_is_replaced_whole() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a/b/cache.bin");
        assert_eq!(read_small(&path), None);
        for data in [&b"first"[..], b"second", b"second"] {
            replace(&path, data).expect("writable");
            assert_eq!(read_small(&path).as_deref(), Some(data));
        }
        let files = path.parent().and_then(|folder| folder.read_dir().ok()).map(Iterator::count);
        assert_eq!(files, Some(1), "nothing unfinished is left behind");
        assert!(replace(folder.path(), b"a folder is in the way").is_err());
    }
}
