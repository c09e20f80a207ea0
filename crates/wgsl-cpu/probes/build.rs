//! Translates every `wgsl/*.wgsl` to `$OUT_DIR/*.rs`.

use std::{env, error::Error, fs, path::Path};

fn main() -> Result<(), Box<dyn Error>> {
    let out = env::var("OUT_DIR")?;
    println!("cargo::rerun-if-changed=wgsl");
    for file in fs::read_dir("wgsl")? {
        let path = file?.path();
        let translation = wgsl_cpu::translate::translate(&fs::read_to_string(&path)?)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let name = path.file_stem().ok_or("a probe has a name")?;
        fs::write(Path::new(&out).join(name).with_extension("rs"), translation.rust)?;
    }
    Ok(())
}
