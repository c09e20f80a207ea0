//! The folder of scenes and references beside the repository, where there is one.

use std::path::PathBuf;

/// `../shared/NAME`, or a message and none where it is absent.
pub fn file(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
    if path.exists() {
        return Some(path);
    }
    println!("not run: ../shared/{name} is not there");
    None
}
