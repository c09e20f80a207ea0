//! Links each kernel, translates it to Rust, and writes the tables that hosts use: kernels, buffer
//! layouts, constants. All are derived from the WGSL, so that nothing has to be kept in step.

#[path = "build/layout.rs"]
mod layout;
#[path = "build/link.rs"]
mod link;

use std::{
    collections::BTreeMap,
    env,
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use link::Linked;
use wgsl_cpu::translate::{Native, ScalarValue, StructInfo, Translation, translate_with};

/// Functions that the CPU device has by hand (src/traversal).
const NATIVES: [Native; 2] = [
    Native { function: "closest_hit", path: "crate::traversal::closest_hit" },
    Native { function: "any_hit", path: "crate::traversal::any_hit" },
];

/// What is gathered over all kernels.
#[derive(Default)]
struct Tables {
    kernels: String,
    modules: String,
    structs: BTreeMap<String, StructInfo>,
    constants: BTreeMap<String, ScalarValue>,
}

fn main() {
    println!("cargo::rerun-if-changed=wgsl");
    println!("cargo::rerun-if-env-changed=MIDWAY_MUTANT");
    if let Err(message) = generate() {
        eprintln!("{message}");
        std::process::exit(1);
    }
}

fn generate() -> Result<(), String> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("set by cargo")).join("wgsl");
    let out = PathBuf::from(env::var("OUT_DIR").expect("set by cargo"));
    let mutant = env::var("MIDWAY_MUTANT").ok().filter(|text| !text.is_empty());
    let mutated = std::cell::Cell::new(false);
    let patch = |file: &Path, text: String| match &mutant {
        Some(mutant) => mutate(mutant, file, text, &mutated),
        None => text,
    };

    let library = link::link(&root, Path::new("lib/all.wgsl"), &patch)?;
    let translation = translate_linked("lib", &library)?;
    write(&out.join("lib.rs"), &translation.rust)?;

    let mut tables = Tables::default();
    for file in kernel_files(&root)? {
        let linked = link::link(&root, &file, &patch)?;
        add_kernel(&out, &file, &linked, &mut tables)?;
    }
    if mutant.is_some() && !mutated.get() {
        return Err("MIDWAY_MUTANT matched no kernel source".into());
    }
    let kernels = format!(
        "{}\n/// Every kernel, by name.\npub static KERNELS: &[Kernel] = &[\n{}];\n",
        tables.modules, tables.kernels
    );
    write(&out.join("kernels.rs"), &kernels)?;
    write(&out.join("layout.rs"), &layout::structs(&tables.structs))?;
    write(&out.join("constants.rs"), &layout::constants(&tables.constants))
}

/// The kernels, the probes that tests run on both devices, and what measures alone run.
fn kernel_files(root: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for folder in ["", "probes", "bench"] {
        let entries = fs::read_dir(root.join(folder)).map_err(|e| format!("wgsl/{folder}: {e}"))?;
        for entry in entries {
            let path = entry.map_err(|e| e.to_string())?.path();
            if path.extension().is_some_and(|e| e == "wgsl") {
                files.push(Path::new(folder).join(path.file_name().expect("a file has a name")));
            }
        }
    }
    files.sort();
    Ok(files)
}

fn add_kernel(out: &Path, file: &Path, linked: &Linked, tables: &mut Tables) -> Result<(), String> {
    let name = file.file_stem().and_then(|s| s.to_str()).ok_or("a kernel's file name is not UTF-8")?;
    let translation = translate_linked(name, linked)?;
    let entry = translation.entry.as_ref().ok_or_else(|| format!("{name}: no entry point"))?;
    if entry.name != name {
        return Err(format!("{name}: the entry point is called {}", entry.name));
    }
    write(&out.join(format!("{name}.rs")), &translation.rust)?;
    write(&out.join(format!("{name}.wgsl")), &linked.wgsl)?;
    let _ = write!(
        tables.modules,
        "#[allow(unused, nonstandard_style, missing_docs, clippy::all, clippy::undocumented_unsafe_blocks)]\n\
         mod {name} {{ include!(concat!(env!(\"OUT_DIR\"), \"/{name}.rs\")); }}\n"
    );
    let _ = writeln!(
        tables.kernels,
        "    Kernel {{ name: \"{name}\", wgsl: include_str!(concat!(env!(\"OUT_DIR\"), \"/{name}.wgsl\")), \
         bindings: {name}::BINDINGS, workgroup_size: {name}::WORKGROUP_SIZE, \
         workgroup_override: {name}::WORKGROUP_OVERRIDE, native: {name}::entry }},"
    );
    collect(translation, tables)
}

fn collect(translation: Translation, tables: &mut Tables) -> Result<(), String> {
    for info in translation.structs {
        if let Some(other) = tables.structs.insert(info.name.clone(), info.clone())
            && other != info
        {
            return Err(format!("struct {} differs between kernels", info.name));
        }
    }
    for constant in translation.constants {
        let Some(value) = constant.value else { continue };
        if let Some(other) = tables.constants.insert(constant.name.clone(), value)
            && other != value
        {
            return Err(format!("constant {} differs between kernels", constant.name));
        }
    }
    Ok(())
}

fn translate_linked(name: &str, linked: &Linked) -> Result<Translation, String> {
    translate_with(&linked.wgsl, &NATIVES).map_err(|error| {
        let place = linked
            .origin(error.location().line as usize)
            .map_or_else(|| name.to_owned(), |(file, line)| format!("wgsl/{}:{line}", file.display()));
        format!("{place}: {error}")
    })
}

/// A mutant is `FILE::FIND=>REPLACE`, for the command that shows what the tests catch.
fn mutate(mutant: &str, file: &Path, text: String, mutated: &std::cell::Cell<bool>) -> String {
    let Some((target, (find, replace))) =
        mutant.split_once("::").and_then(|(file, edit)| Some((file, edit.split_once("=>")?)))
    else {
        return text;
    };
    if Path::new(target) != file || !text.contains(find) {
        return text;
    }
    mutated.set(true);
    text.replacen(find, replace, 1)
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}
