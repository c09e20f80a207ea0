//! Every scene file of a large collection loads or is refused, with one clear line and in time.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use midway_import::{ImportError, Options, load, load_with};

/// What takes longer hangs, or as good as: the largest takes a second on two idle cores, and tests
/// run beside each other.
const SLOWEST: Duration = Duration::from_secs(20);

/// What a small file may take: textures of flat colour, instances, tables.
const FREE_BYTES: usize = 1 << 30;
/// What a byte of a file may take beyond that: an index of 8 bits becomes one of 32, thrice.
const BYTES_PER_BYTE: usize = 64;

/// The system's, with how much is taken and was taken at most.
struct Counting {
    now: AtomicUsize,
    peak: AtomicUsize,
}

#[global_allocator]
static ALLOCATOR: Counting = Counting { now: AtomicUsize::new(0), peak: AtomicUsize::new(0) };

/// Tests that measure run one after the other.
static MEASURING: Mutex<()> = Mutex::new(());

// SAFETY: everything is passed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = self.now.fetch_add(layout.size(), Relaxed) + layout.size();
        self.peak.fetch_max(now, Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let now = self.now.fetch_add(layout.size(), Relaxed) + layout.size();
        self.peak.fetch_max(now, Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        self.now.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// What a call takes at most beyond what was taken before, and how long.
fn measured<T>(call: impl FnOnce() -> T) -> (T, usize, Duration) {
    let (start, before) = (Instant::now(), ALLOCATOR.now.load(Relaxed));
    ALLOCATOR.peak.store(before, Relaxed);
    let result = call();
    (result, ALLOCATOR.peak.load(Relaxed) - before, start.elapsed())
}

fn collection(folder: &str) -> Vec<PathBuf> {
    collection_of(folder, &["gltf", "glb", "obj", "ply"])
}

fn collection_of(folder: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(folder);
    let mut found = Vec::new();
    let mut folders = vec![root];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e == *x)) {
                found.push(path);
            }
        }
    }
    found.sort();
    if found.is_empty() {
        println!("did not run: there is no {folder} in ../shared/scenes");
    }
    found
}

/// Variant's name, for counting.
fn kind(error: &ImportError) -> String {
    let debug = format!("{error:?}");
    debug.split([' ', '{', '(']).next().unwrap_or_default().to_owned()
}

#[test]
fn every_gltf_loads_or_is_refused() {
    let files = collection("gltf");
    let _alone = MEASURING.lock();
    let mut outcomes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut greediest = (0, PathBuf::new());
    let mut slowest = (Duration::ZERO, PathBuf::new());
    for path in &files {
        let (outcome, bytes, time) = measured(|| load(path));
        assert!(time <= SLOWEST, "{} took {time:?}", path.display());
        // Files beside it are small in this collection.
        let limit = FREE_BYTES + BYTES_PER_BYTE * fs::metadata(path).unwrap().len() as usize;
        assert!(bytes <= limit, "{} took {bytes} bytes", path.display());
        greediest = greediest.max((bytes, path.clone()));
        slowest = slowest.max((time, path.clone()));
        let key = match outcome {
            Ok(import) => {
                import.scene.validate().unwrap();
                assert!(!import.scene.cameras.is_empty());
                assert_eq!(import.scene.hash(), load(path).unwrap().scene.hash());
                "loaded".to_owned()
            }
            Err(error) => {
                let line = error.to_string();
                assert!(!line.contains('\n'), "{line}");
                println!("{line}");
                kind(&error)
            }
        };
        outcomes.entry(key).or_default().push(path.display().to_string());
    }
    for (kind, files) in &outcomes {
        println!("{kind}: {}", files.len());
    }
    println!("the most memory: {greediest:?}; the slowest: {slowest:?}");
    // The validator's own tests are mostly fragments without a triangle; the others are scenes.
    let is_scene = |p: &&String| !p.contains("validator-tests");
    let n_scenes = outcomes.values().flatten().filter(is_scene).count();
    let n_loaded = outcomes.get("loaded").into_iter().flatten().filter(is_scene).count();
    assert!(n_loaded * 10 >= n_scenes * 8, "only {n_loaded} of {n_scenes} scenes load");
}

#[test]
fn scenes_for_measuring_load_whole() {
    for folder in ["yardstick", "transport", "sponza"] {
        for path in collection(folder) {
            let _alone = MEASURING.lock();
            let (import, bytes, time) = measured(|| load(&path));
            let import = import.unwrap_or_else(|e| panic!("{e}"));
            let counts = import.scene.counts();
            println!("{}: {counts:?}, {time:.2?}, {} MiB at most", path.display(), bytes >> 20);
            for warning in &import.warnings {
                println!("    {warning}");
            }
            if folder == "yardstick" {
                assert!(import.warnings.is_empty(), "{:?}", import.warnings);
            }
        }
    }
}

#[test]
fn cornell_boxes_of_mcguire_load() {
    for path in collection("cornell-mcguire") {
        let _alone = MEASURING.lock();
        let import = load(&path).unwrap_or_else(|e| panic!("{e}"));
        println!("{}: {:?}", path.display(), import.scene.counts());
        for warning in &import.warnings {
            println!("    {warning}");
        }
        let materials = &import.scene.materials;
        for t in import.scene.world_triangles() {
            // Light is emitted from the front: into the room.
            if materials[t.material as usize].is_emissive() {
                assert!(t.geometric_normal().is_some_and(|n| n.y < -0.99), "{t:?}");
            }
        }
    }
}

/// Their meshes and images lie in folders beside theirs: within a root that holds all of them those load
/// whose files are there.
#[test]
fn evaluation_scenes_of_ignis_load_within_a_root() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/scenes/references/ignis-evaluation/evaluation");
    let options = Options { root: Some(root), ..Options::default() };
    let (mut n_outside, mut n_loaded) = (0, 0);
    for path in collection_of("references/ignis-evaluation/evaluation/mitsuba", &["xml"]) {
        let is_outside = matches!(load(&path), Err(ImportError::UnsafePath { .. }));
        n_outside += usize::from(is_outside);
        match load_with(&path, &options) {
            (Ok((scene, _)), warnings) => {
                n_loaded += usize::from(is_outside);
                println!("{}: {:?}", path.display(), scene.counts());
                warnings.iter().for_each(|warning| println!("    {warning}"));
            }
            (Err(ImportError::MissingBuffer { uri, .. }), _) => {
                assert!(uri.starts_with("meshes/") || uri.starts_with("../textures/"), "{uri}");
            }
            (Err(other), _) => panic!("{other}"),
        }
    }
    println!("{n_outside} name files outside of their folder, {n_loaded} of them load");
    assert!(n_outside == 0 || n_loaded >= 5, "{n_loaded} of {n_outside}");
}
