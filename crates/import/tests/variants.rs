//! Variants of materials: which there are, and which material each gives a primitive.

mod common;

use std::path::Path;

use common::{Folder, triangle};
use midway_import::{Import, ImportError, Options, WarningKind, load, load_with};
use serde_json::{Value, json};

/// Three primitives of three materials, of which the first has two variants besides and the second
/// one.
fn document() -> Value {
    let mut document = triangle();
    let mut primitive = document["meshes"][0]["primitives"][0].clone();
    let material = document["materials"][0].clone();
    document["materials"] = json!([material, material, material]);
    document["meshes"][0]["primitives"] = json!(["day and night", "night", "always"].map(|what| {
        let night = json!({"material": 2, "variants": [1]});
        let mappings = match what {
            "day and night" => json!([{"material": 1, "variants": [0]}, night]),
            "night" => json!([night]),
            _ => json!([]),
        };
        primitive["extensions"] = json!({"KHR_materials_variants": {"mappings": mappings}});
        primitive.clone()
    }));
    document["extensionsUsed"] = json!(["KHR_materials_variants"]);
    document["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "Day"}, {"name": "Night"}]}});
    document
}

fn by_name(path: &Path, variant: Option<&str>) -> Result<Import, ImportError> {
    let (loaded, warnings) =
        load_with(path, &Options { variant: variant.map(str::to_owned), ..Options::default() });
    loaded.map(|(scene, variants)| Import { scene, variants, warnings })
}

fn import(document: &Value, variant: Option<&str>) -> Result<Import, ImportError> {
    let folder = Folder::new();
    by_name(&folder.write("scene.gltf", document.to_string()), variant)
}

fn materials(document: &Value, variant: Option<&str>) -> Vec<u32> {
    import(document, variant).unwrap().scene.meshes.iter().map(|mesh| mesh.material).collect()
}

#[test]
fn each_variant_has_its_materials_and_leaves_the_others_their_own() {
    let document = document();
    assert_eq!(materials(&document, None), [0, 0, 0]);
    assert_eq!(materials(&document, Some("Day")), [1, 0, 0]);
    assert_eq!(materials(&document, Some("Night")), [2, 2, 0]);
}

/// By whatever variant the scene was read, each is as if it had been read by that one.
#[test]
fn each_can_be_taken_later_on() {
    let mut document = document();
    // A primitive without a material of its own, another that maps a variant twice, and copies of all.
    document["meshes"][0]["primitives"][1].as_object_mut().unwrap().remove("material");
    let twice = json!([{"material": 2, "variants": [0, 0]}, {"material": 1, "variants": [0]}]);
    document["meshes"][0]["primitives"][2]["extensions"]["KHR_materials_variants"]["mappings"] = twice;
    document["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": []}]);
    document["scenes"] = json!([{"nodes": [0, 1]}]);
    let all = [(None, None), (Some(0), Some("Day")), (Some(1), Some("Night"))];
    for (_, read) in all {
        let variants = import(&document, read).unwrap().variants;
        for (index, name) in all {
            assert_eq!(variants.materials(index).unwrap(), materials(&document, name), "{read:?}, {name:?}");
        }
        assert!(variants.materials(Some(2)).is_none());
    }
}

#[test]
fn a_damaged_mapping_leaves_a_primitive_its_own() {
    let mapping = "/meshes/0/primitives/1/extensions/KHR_materials_variants/mappings/0";
    for (key, bad) in
        [("material", json!(3)), ("material", json!("x")), ("variants", json!([2])), ("variants", json!(1))]
    {
        let mut document = document();
        document.pointer_mut(mapping).unwrap()[key] = bad;
        let variants = import(&document, None).unwrap().variants;
        assert_eq!(variants.materials(Some(1)).unwrap(), [2, 0, 0]);
    }
}

#[test]
fn variants_are_listed_without_a_warning_even_where_the_file_requires_them() {
    let mut document = document();
    document["extensionsRequired"] = json!(["KHR_materials_variants"]);
    for variant in [None, Some("Night")] {
        let import = import(&document, variant).unwrap();
        assert_eq!(import.variants.names(), ["Day", "Night"]);
        assert_eq!(import.warnings, []);
    }
}

#[test]
fn an_unknown_variant_is_refused_with_those_that_there_are() {
    let error = import(&document(), Some("Dusk")).unwrap_err();
    assert!(matches!(error, ImportError::UnknownVariant { .. }));
    let line = error.to_string();
    assert!(line.ends_with(r#"there is no variant "Dusk"; there are: "Day", "Night""#), "{line}");
    let mut hostile = document();
    hostile["extensions"]["KHR_materials_variants"]["variants"][0]["name"] = json!("a\n\u{1b}[31m");
    let line = import(&hostile, Some("Dusk")).unwrap_err().to_string();
    assert!(!line.contains(char::is_control), "{line:?}");
}

#[test]
fn other_files_and_formats_have_none() {
    let line = import(&triangle(), Some("Day")).unwrap_err().to_string();
    assert!(line.ends_with(r#"there is no variant "Day": the file has none"#), "{line}");
    let folder = Folder::new();
    let path = folder.write("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(matches!(by_name(&path, Some("Day")), Err(ImportError::UnknownVariant { .. })));
    let variants = load(&path).unwrap().variants;
    assert!(variants.names().is_empty() && variants.materials(None).is_none());
}

/// By default nothing depends on it; a variant that is taken does.
#[test]
fn bad_indices_are_refused_where_a_variant_is_taken_and_listed_elsewhere() {
    let mapping = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0";
    for (key, bad) in [("material", json!(3)), ("variants", json!([2])), ("variants", json!(["Day"]))] {
        let mut document = document();
        document.pointer_mut(mapping).unwrap()[key] = bad;
        let line = import(&document, Some("Day")).unwrap_err().to_string();
        assert!(line.contains(&format!("#{mapping}/{key}")), "{line}");
        let warnings = import(&document, None).unwrap().warnings;
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        assert!(warning.kind == WarningKind::Invalid && warning.place.starts_with(mapping), "{warning}");
    }
    let mut missing = document();
    missing.pointer_mut(mapping).unwrap().as_object_mut().unwrap().remove("material");
    let line = import(&missing, Some("Day")).unwrap_err().to_string();
    assert!(line.contains(mapping) && line.contains("\"material\" is missing"), "{line}");
}
