//! The include linker: `#include "path"` lines, each file once, in the order of need.

use std::{
    collections::HashSet,
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

/// A linked module, and where each of its lines came from.
pub struct Linked {
    /// The WGSL text.
    pub wgsl: String,
    /// `(file, line)` of each line of `wgsl`, from 1.
    origins: Vec<(PathBuf, usize)>,
}

impl Linked {
    /// The file and line behind a line of the linked text (from 1).
    pub fn origin(&self, line: usize) -> Option<(&Path, usize)> {
        self.origins.get(line.checked_sub(1)?).map(|(file, line)| (file.as_path(), *line))
    }
}

/// Links `file`, whose includes are relative to `root`. `patch` sees each file's text once.
pub fn link(root: &Path, file: &Path, patch: &dyn Fn(&Path, String) -> String) -> Result<Linked, String> {
    let mut linked = Linked { wgsl: String::new(), origins: Vec::new() };
    append(root, file, patch, &mut HashSet::new(), &mut linked)?;
    Ok(linked)
}

fn append(
    root: &Path,
    file: &Path,
    patch: &dyn Fn(&Path, String) -> String,
    seen: &mut HashSet<PathBuf>,
    linked: &mut Linked,
) -> Result<(), String> {
    if !seen.insert(file.to_owned()) {
        return Ok(());
    }
    let text = fs::read_to_string(root.join(file)).map_err(|e| format!("{}: {e}", file.display()))?;
    let text = patch(file, text);
    for (index, line) in text.lines().enumerate() {
        if let Some(rest) = line.strip_prefix("#include ") {
            let name = rest.trim().trim_matches('"');
            append(root, Path::new(name), patch, seen, linked)
                .map_err(|e| format!("{}:{}: {e}", file.display(), index + 1))?;
        } else {
            writeln!(linked.wgsl, "{line}").expect("writing to a string cannot fail");
            linked.origins.push((file.to_owned(), index + 1));
        }
    }
    Ok(())
}
