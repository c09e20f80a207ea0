//! The Khronos validator's own tests: what it finds wrong is refused, or listed, where it is.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use midway_import::{ImportError, Options, WarningKind, load_with};
use serde_json::Value;

/// What the validator calls an error and is let pass, and why.
const LET_PASS: &[(&str, &[&str])] = &[
    (
        "no pixel depends on it",
        &[
            "EMPTY_ENTITY",
            "ACCESSOR_MIN_MISMATCH",
            "ACCESSOR_MAX_MISMATCH",
            "ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND",
            "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND",
            "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS",
            "UNSATISFIED_DEPENDENCY",
            "UNEXPECTED_EXTENSION_OBJECT",
            "UNDECLARED_EXTENSION",
            "UNUSED_EXTENSION_REQUIRED",
            "NON_REQUIRED_EXTENSION",
            "DUPLICATE_ELEMENTS",
            "CAMERA_ZFAR_LEQUAL_ZNEAR",
            "BUFFER_VIEW_TARGET_OVERRIDE",
            "IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE",
            "BUFFER_DATA_URI_MIME_TYPE_INVALID",
        ],
    ),
    ("of a variant's materials the first is taken", &["KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT"]),
    (
        "images are known by their content",
        &["IMAGE_MIME_TYPE_INVALID", "IMAGE_NON_ENABLED_MIME_TYPE", "TEXTURE_INVALID_IMAGE_MIME_TYPE"],
    ),
    (
        "read all the same: alignment is for graphics cards",
        &[
            "ACCESSOR_TOTAL_OFFSET_ALIGNMENT",
            "ACCESSOR_OFFSET_ALIGNMENT",
            "ACCESSOR_MATRIX_ALIGNMENT",
            "MESH_PRIMITIVE_ACCESSOR_UNALIGNED",
            "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE",
            "MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE",
            "GLB_CHUNK_LENGTH_UNALIGNED",
            "VALUE_MULTIPLE_OF",
        ],
    ),
    (
        "repaired where it is rendered",
        &["ACCESSOR_VECTOR3_NON_UNIT", "ACCESSOR_INVALID_SIGN", "ACCESSOR_NON_CLAMPED", "ROTATION_NON_UNIT"],
    ),
    (
        "of GLB containers, what cannot be mistaken is read",
        &[
            "GLB_DUPLICATE_CHUNK",
            "GLB_EMPTY_CHUNK",
            "GLB_LENGTH_MISMATCH",
            "GLB_UNEXPECTED_BIN_CHUNK",
            "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
        ],
    ),
    (
        "animations are not used",
        &[
            "ACCESSOR_ANIMATION_INPUT_NEGATIVE",
            "ACCESSOR_ANIMATION_INPUT_NON_INCREASING",
            "ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION",
            "ANIMATION_SAMPLER_ACCESSOR_WITH_BYTESTRIDE",
            "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT",
            "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
            "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT",
            "ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS",
            "ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS",
            "ANIMATION_DUPLICATE_TARGETS",
            "ANIMATION_CHANNEL_TARGET_NODE_MATRIX",
            "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS",
            "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_PATH",
            "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_NODE",
        ],
    ),
    (
        "skins are not used",
        &[
            "ACCESSOR_INVALID_IBM",
            "ACCESSOR_JOINTS_INDEX_OOB",
            "ACCESSOR_JOINTS_INDEX_DUPLICATE",
            "ACCESSOR_WEIGHTS_NEGATIVE",
            "ACCESSOR_WEIGHTS_NON_NORMALIZED",
            "INVALID_IBM_ACCESSOR_COUNT",
            "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH",
            "NODE_SKIN_NO_SCENE",
            "NODE_SKIN_WITH_NON_SKINNED_MESH",
            "SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE",
            "SKIN_IBM_INVALID_FORMAT",
            "SKIN_NO_COMMON_ROOT",
            "SKIN_SKELETON_INVALID",
        ],
    ),
    (
        "nothing in the file's scene uses it: it is looked at where a node does",
        &[
            "ACCESSOR_TOO_LONG",
            "ACCESSOR_SMALL_BYTESTRIDE",
            "ACCESSOR_NORMALIZED_INVALID",
            "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
            "ACCESSOR_INDEX_OOB",
            "ACCESSOR_INDEX_PRIMITIVE_RESTART",
            "ACCESSOR_INVALID_FLOAT",
            "BUFFER_VIEW_TOO_LONG",
            "BUFFER_VIEW_TOO_BIG_BYTE_STRIDE",
            "BUFFER_VIEW_INVALID_BYTE_STRIDE",
            "BUFFER_MISSING_GLB_DATA",
            "CAMERA_XMAG_YMAG_ZERO",
            "IMAGE_DATA_INVALID",
            "IMAGE_UNEXPECTED_EOS",
            "IO_ERROR",
            "INVALID_URI",
            "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES",
            "MESH_INVALID_WEIGHTS_COUNT",
            "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT",
            "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
            "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT",
            "MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY",
            "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
            "MESH_PRIMITIVE_INVALID_ATTRIBUTE",
            "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT",
            "MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR",
            "MESH_PRIMITIVE_NO_TANGENT_SPACE",
            "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
            "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
            "NODE_LOOP",
            "NODE_MATRIX_NON_TRS",
            "NODE_MATRIX_TRS",
            "NODE_PARENT_OVERRIDE",
            "NODE_WEIGHTS_INVALID",
            "SCENE_NON_ROOT_NODE",
            "BUFFER_BYTE_LENGTH_MISMATCH",
            "ASSET_MIN_VERSION_GREATER_THAN_VERSION",
        ],
    ),
];

/// Of the errors that are not let pass, how many may go unnamed: values within extensions, of
/// types and ranges that readers meet where they read them.
const MOST_UNNAMED: usize = 30;

fn assets(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            assets(&path, found);
        } else if let Some(asset) = path.to_str().and_then(|p| p.strip_suffix(".report.json")) {
            found.push(asset.into());
        }
    }
}

/// The validator's errors: code and pointer.
fn errors_of(asset: &Path) -> Vec<(String, String)> {
    let text = fs::read(format!("{}.report.json", asset.display())).unwrap();
    let report: Value = serde_json::from_slice(&text).unwrap();
    let messages = report["issues"]["messages"].as_array().cloned().unwrap_or_default();
    let text = |m: &Value, key: &str| m[key].as_str().unwrap_or_default().to_owned();
    messages.iter().filter(|m| m["severity"] == 0).map(|m| (text(m, "code"), text(m, "pointer"))).collect()
}

/// Whether one place is the other, or lies in it.
fn related(a: &str, b: &str) -> bool {
    let within = |a: &str, b: &str| a == b || (!b.is_empty() && a.starts_with(&format!("{b}/")));
    within(a, b) || within(b, a)
}

#[test]
fn invalid_assets_are_refused_or_listed_where_they_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes/gltf/validator-tests");
    let mut found = Vec::new();
    assets(&root, &mut found);
    if found.is_empty() {
        println!("did not run: there is no validator-tests in ../shared/scenes/gltf");
        return;
    }
    let let_pass = |code: &str| LET_PASS.iter().any(|(_, codes)| codes.contains(&code));
    let (mut n_errors, mut n_named, mut n_passed) = (0, 0, 0);
    let mut unnamed: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for asset in found {
        let errors = errors_of(&asset);
        let (scene, warnings) = load_with(&asset, &Options::default());
        let mut places: Vec<String> =
            warnings.iter().filter(|w| w.kind != WarningKind::NoCamera).map(|w| w.place.clone()).collect();
        let mut whole = false;
        if let Err(error) = &scene {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line}");
            // Refused as a whole: for what cannot be parsed there is no pointer.
            whole = !line.contains("#/") && !matches!(error, ImportError::EmptyScene { .. });
            let pointer = line.split_once('#').and_then(|(_, rest)| rest.split(": ").next());
            places.extend(pointer.map(str::to_owned));
        }
        for (code, pointer) in errors {
            n_errors += 1;
            if whole || places.iter().any(|place| related(place, &pointer)) {
                n_named += 1;
            } else if let_pass(&code) {
                n_passed += 1;
            } else {
                let name = asset.strip_prefix(&root).unwrap_or(&asset).display().to_string();
                unnamed.entry(code).or_default().push(format!("{name}#{pointer}"));
            }
        }
    }
    let n_unnamed: usize = unnamed.values().map(Vec::len).sum();
    println!(
        "{n_errors} errors: {n_named} refused or listed in their place, {n_passed} let pass for a reason, {n_unnamed} others"
    );
    for (code, places) in &unnamed {
        println!("{code}: {places:#?}");
    }
    assert!(n_unnamed <= MOST_UNNAMED, "{n_unnamed} of {n_errors}");
    assert!(n_named > 0);
}
