//! The rooms depend on each other as design.md says, and on graphics APIs in one place only.

use std::{collections::BTreeSet, fs, path::PathBuf};

/// Each crate with the project's own crates that it may use at run time. The device runs kernels by
/// the records and cells of the translator's runtime half.
const ROOMS: &[(&str, &[&str])] = &[
    ("accel", &["midway-scene"]),
    (
        "cli",
        &[
            "midway-accel",
            "midway-device",
            "midway-film",
            "midway-import",
            "midway-kernels",
            "midway-render",
            "midway-scene",
            "midway-view",
        ],
    ),
    ("device", &["wgsl-cpu"]),
    ("film", &[]),
    ("import", &["midway-scene"]),
    ("kernels", &["wgsl-cpu"]),
    ("render", &["midway-accel", "midway-device", "midway-film", "midway-kernels", "midway-scene"]),
    ("scene", &[]),
    ("view", &["midway-device", "midway-film", "midway-import", "midway-render", "midway-scene"]),
    ("wgsl-cpu", &[]),
];

/// Libraries that only some rooms may name.
const RESERVED: &[(&str, &[&str])] = &[
    ("wgpu", &["device"]),
    ("naga", &["wgsl-cpu"]),
    ("rayon", &["accel", "device", "import", "render", "view"]),
    ("obvhs", &["accel"]),
    ("exr", &["film"]),
    ("png", &["film"]),
    ("image", &["import"]),
    ("basisu", &["import"]),
    ("draco-core", &["import"]),
    ("clap", &["cli"]),
    ("anyhow", &["cli"]),
    ("axum", &["view"]),
    ("tokio", &["view"]),
];

/// What one manifest names: what it is built of, and what its tests add.
#[derive(Debug, Default, PartialEq)]
struct Dependencies {
    run: BTreeSet<String>,
    build: BTreeSet<String>,
    dev: BTreeSet<String>,
}

impl Dependencies {
    /// Of a manifest's text: its tables of dependencies, one name a line or a table a name.
    fn parse(manifest: &str) -> Self {
        let mut all = Self::default();
        let mut table: Option<(Kind, bool)> = None;
        for line in manifest.lines().map(str::trim).filter(|line| !line.starts_with('#')) {
            if let Some(header) = line.strip_prefix('[') {
                let header = header.trim_matches(['[', ']']);
                table = Kind::of(header).map(|(kind, name)| {
                    if let Some(name) = &name {
                        all.set(kind).insert(name.clone());
                    }
                    (kind, name.is_none())
                });
            } else if let (Some((kind, true)), Some((key, value))) = (table, line.split_once('=')) {
                all.set(kind).insert(package(key, value));
            }
        }
        all
    }

    fn set(&mut self, kind: Kind) -> &mut BTreeSet<String> {
        match kind {
            Kind::Run => &mut self.run,
            Kind::Build => &mut self.build,
            Kind::Dev => &mut self.dev,
        }
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Run,
    Build,
    Dev,
}

impl Kind {
    /// `[dependencies]`, `[target.'…'.dependencies]` or `[dependencies.NAME]`.
    fn of(header: &str) -> Option<(Self, Option<String>)> {
        let kinds = [
            ("dev-dependencies", Self::Dev),
            ("build-dependencies", Self::Build),
            ("dependencies", Self::Run),
        ];
        kinds.into_iter().find_map(|(table, kind)| {
            let end = header.rfind(table)? + table.len();
            let starts = header.rfind(table).is_some_and(|at| at == 0 || header[..at].ends_with('.'));
            let name = header[end..].strip_prefix('.').map(|name| name.trim_matches('"').to_owned());
            (starts && (name.is_some() || end == header.len())).then_some((kind, name))
        })
    }
}

/// The package that a line names: its key, unless `package = "…"` renames it.
fn package(key: &str, value: &str) -> String {
    let renamed = value
        .split_once("package")
        .and_then(|(_, rest)| rest.trim_start().strip_prefix('='))
        .and_then(|rest| rest.split('"').nth(1));
    let key = key.trim().trim_matches('"').split('.').next().unwrap_or_default();
    renamed.unwrap_or(key).to_owned()
}

fn crates_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../crates")
}

/// Every crate's folder name and dependencies.
fn crates() -> Vec<(String, Dependencies)> {
    let entries = fs::read_dir(crates_folder()).expect("crates/ is there");
    let manifests = entries.filter_map(|entry| {
        let folder = entry.expect("readable").path();
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).ok()?;
        let name = folder.file_name()?.to_str()?.to_owned();
        Some((name, Dependencies::parse(&manifest)))
    });
    manifests.collect()
}

/// Why a crate of that name may not have these dependencies.
fn violations(room: &str, dependencies: &Dependencies) -> Vec<String> {
    let Some((_, allowed)) = ROOMS.iter().find(|(name, _)| *name == room) else {
        return vec![format!("crates/{room} has no place in the layering: say what it may use")];
    };
    let built_of = || dependencies.run.union(&dependencies.build);
    let own = built_of()
        .filter(|name| is_own(name) && !allowed.contains(&name.as_str()))
        .map(|name| format!("{room} may not use {name}"));
    let reserved = built_of().filter_map(|name| {
        let (_, rooms) = RESERVED.iter().find(|(library, _)| library == name)?;
        (!rooms.contains(&room)).then(|| format!("{room} may not name {name}"))
    });
    own.chain(reserved).collect()
}

fn is_own(name: &str) -> bool {
    name.starts_with("midway") || name.starts_with("wgsl-cpu")
}

#[test]
fn rooms_use_only_what_lies_below_them() {
    let crates = crates();
    assert!(crates.len() >= 9, "{} crates are too few to be all", crates.len());
    let found: Vec<String> = crates.iter().flat_map(|(room, all)| violations(room, all)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Graphics APIs are one room's business, in tests too.
#[test]
fn only_the_device_names_wgpu() {
    for (room, all) in crates() {
        let names = all.run.iter().chain(&all.build).chain(&all.dev);
        let graphics: Vec<_> = names.filter(|name| name.starts_with("wgpu") || *name == "ash").collect();
        assert!(room == "device" || graphics.is_empty(), "{room} names {graphics:?}");
    }
    let device = crates().into_iter().find(|(room, _)| room == "device").expect("crates/device is there");
    assert!(device.1.run.contains("wgpu"));
}

#[test]
fn violations_are_found() {
    let manifest = |text: &str| Dependencies::parse(text);
    let found = |room: &str, text: &str| violations(room, &manifest(text)).len();
    assert_eq!(found("film", "[dependencies]\nexr.workspace = true\n"), 0);
    assert_eq!(found("film", "[dependencies]\nmidway-scene.workspace = true\n"), 1);
    assert_eq!(found("film", "[dependencies.midway-scene]\nworkspace = true\n"), 1);
    assert_eq!(found("film", "[dependencies]\ns = { path = \"../scene\", package = \"midway-scene\" }\n"), 1);
    assert_eq!(found("kernels", "[build-dependencies]\nmidway-device = { path = \"../device\" }\n"), 1);
    assert_eq!(found("kernels", "[target.'cfg(unix)'.dependencies]\nwgpu = \"30\"\n"), 1);
    assert_eq!(found("film", "[dev-dependencies]\nrayon.workspace = true\n"), 0);
    assert_eq!(found("unheard-of", ""), 1);
    assert_eq!(manifest("[features]\nwgpu = []\n[dependencies]\n# wgpu\n"), Dependencies::default());
}
