//! What glTF files come to.

mod common;

use std::{f32::consts::FRAC_1_SQRT_2, sync::Arc};

use common::{data_uri, load_json, triangle, triangle_bytes, triangle_with};
use glam::{Vec3, vec3};
use midway_import::{Import, WarningKind};
use midway_scene::{
    ConductorFresnel, LightKind, Material, MetallicRoughness, Projection, Roughness, Sides, SpotFalloff,
    Surface,
};
use serde_json::{Value, json};

fn import(document: &Value) -> Import {
    load_json(document).unwrap_or_else(|e| panic!("{e}"))
}

fn kinds(import: &Import) -> Vec<WarningKind> {
    import.warnings.iter().map(|w| w.kind).collect()
}

/// A material by its JSON, and the kinds of warning it gives. It emits, so that light is there.
fn material(mut definition: Value) -> (Material, Vec<WarningKind>) {
    if definition.get("emissiveFactor").is_none() {
        definition["emissiveFactor"] = json!([1, 1, 1]);
    }
    let import = import(&triangle_with("/materials/0", definition));
    (import.scene.materials[0].clone(), kinds(&import))
}

#[test]
fn a_plain_file_has_no_warnings() {
    let import = import(&triangle());
    assert_eq!(import.warnings, []);
    let mesh = &import.scene.meshes[0];
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    let camera = &import.scene.cameras[0];
    assert_eq!((camera.yfov().unwrap(), camera.position()), (0.7, vec3(0.0, 0.0, 3.0)));
}

#[test]
fn diffuse_materials() {
    let none = json!({"KHR_materials_specular": {"specularFactor": 0}});
    let pbr = json!({"metallicFactor": 0, "baseColorFactor": [0.1, 0.2, 0.3, 0.4]});
    let reflectance = vec3(0.1, 0.2, 0.3);
    let (plain, warnings) = material(json!({"pbrMetallicRoughness": pbr, "extensions": none}));
    assert_eq!((plain.surface, warnings), (Surface::diffuse(reflectance), vec![]));
    let (layered, warnings) = material(json!({"pbrMetallicRoughness": pbr}));
    let expected = MetallicRoughness { base_color: reflectance.into(), ..MetallicRoughness::default() };
    assert_eq!((layered.surface, warnings), (Surface::MetallicRoughness(Box::new(expected)), vec![]));
}

#[test]
fn metals_by_roughness() {
    for roughness in [0.0f32, 0.3, 1.0] {
        let pbr =
            json!({"metallicFactor": 1, "roughnessFactor": roughness, "baseColorFactor": [0.5, 0.5, 0.5, 1]});
        let (found, warnings) = material(json!({"pbrMetallicRoughness": pbr}));
        let fresnel = ConductorFresnel::Schlick { f0: Vec3::splat(0.5).into() };
        let roughness = Roughness {
            along: roughness.into(),
            across: roughness.into(),
            squared: true,
            single_bounce: false,
        };
        assert_eq!((found.surface, warnings), (Surface::Conductor { fresnel, roughness }, vec![]));
    }
}

#[test]
fn glass_thick_and_thin() {
    let glass = |volume: Value, ior: Value| {
        let mut extensions = json!({"KHR_materials_transmission": {"transmissionFactor": 1}});
        if !volume.is_null() {
            extensions["KHR_materials_volume"] = volume;
        }
        if !ior.is_null() {
            extensions["KHR_materials_ior"] = json!({"ior": ior});
        }
        let pbr = json!({"metallicFactor": 0, "roughnessFactor": 0, "baseColorFactor": [1, 0.5, 1, 1]});
        let (found, warnings) = material(json!({"pbrMetallicRoughness": pbr, "extensions": extensions}));
        assert_eq!(warnings, []);
        found.surface
    };
    let tint = vec3(1.0, 0.5, 1.0);
    let smooth = |ior, thin| Surface::Dielectric {
        ior,
        dispersion: 0.0,
        reflection: Vec3::ONE.into(),
        transmission: tint.into(),
        sigma_a: Vec3::ZERO,
        thin,
        roughness: Roughness { squared: true, ..Roughness::smooth() },
    };
    let sheet = smooth(1.5, true);
    assert_eq!(glass(Value::Null, Value::Null), sheet);
    let clear = smooth(1.33, false);
    assert_eq!(glass(json!({"thicknessFactor": 1}), json!(1.33)), clear);
    let volume =
        json!({"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.36787944, 0]});
    let Surface::Dielectric { sigma_a, .. } = glass(volume, Value::Null) else {
        panic!("not glass");
    };
    assert_eq!(sigma_a.x, 0.0);
    assert!((sigma_a.y - 0.5).abs() <= 1e-6);
    assert!(sigma_a.z > 5.0 && sigma_a.z.is_finite());
}

/// glTF 2.0: base colour, metallic and roughness factors of 1.
#[test]
fn primitives_without_a_material_have_gltfs_own() {
    let mut document = triangle();
    document["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    let import = import(&document);
    let found = &import.scene.materials[import.scene.meshes[0].material as usize];
    let empty = material(json!({})).0;
    assert_eq!((&found.surface, found.emits, found.scatters), (&empty.surface, empty.emits, empty.scatters));
    let white = ConductorFresnel::Schlick { f0: Vec3::ONE.into() };
    assert!(matches!(&found.surface, Surface::Conductor { fresnel, .. } if *fresnel == white));
    let of_scene = |w: &&midway_import::Warning| w.kind != WarningKind::NoLight;
    assert_eq!(import.warnings.iter().find(of_scene), None);
}

/// `KHR_materials_ior`: with 0 the dielectric's F0 is 1, times what `KHR_materials_specular` says.
#[test]
fn an_index_of_0_reflects_by_the_specular_colour_alone() {
    let read = |transmission: f32| {
        let extensions = json!({
            "KHR_materials_ior": {"ior": 0},
            "KHR_materials_transmission": {"transmissionFactor": transmission},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [0.8, 0.4, 0.2]}});
        material(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}))
    };
    let (found, warnings) = read(0.0);
    let Surface::MetallicRoughness(model) = found.surface else { panic!() };
    let f0 = ((model.ior - 1.0) / (model.ior + 1.0)).powi(2) * model.specular_color.value;
    assert!((f0 - vec3(0.8, 0.4, 0.2)).abs().max_element() <= 1e-6, "{f0}");
    assert_eq!((model.specular.value, warnings), (0.5, vec![]));
    assert_eq!(read(1.0).1, [WarningKind::Approximation]);
}

#[test]
fn glass_that_disperses() {
    let glass = |dispersion: f32, volume: Value, transmission: Value| {
        let extensions = json!({"KHR_materials_dispersion": {"dispersion": dispersion},
            "KHR_materials_volume": volume, "KHR_materials_transmission": transmission});
        let pbr = json!({"metallicFactor": 0, "roughnessFactor": 0.3});
        let (found, warnings) = material(json!({"pbrMetallicRoughness": pbr, "extensions": extensions}));
        (found.surface.ior_spread(), warnings)
    };
    let (solid, thin) = (json!({"thicknessFactor": 1}), json!({}));
    let (clear, half) = (json!({"transmissionFactor": 1}), json!({"transmissionFactor": 0.5}));
    // The extension's formula: (n - 1) / V between the F and the C line, V = 20 / dispersion, half of it.
    let spread = 0.5 * (1.5 - 1.0) / (20.0 / 4.0);
    for transmission in [&clear, &half] {
        let (found, warnings) = glass(4.0, solid.clone(), transmission.clone());
        assert!((found - spread).abs() <= 1e-6, "{found}");
        assert_eq!(warnings, []);
    }
    assert_eq!(glass(0.0, solid.clone(), clear.clone()), (0.0, vec![]));
    assert_eq!(glass(4.0, thin, clear.clone()), (0.0, vec![]));
    assert_eq!(glass(4.0, solid.clone(), json!({})), (0.0, vec![]));
    // Red's index is not below 1, and no Abbe number below 0.
    assert_eq!(glass(100.0, solid.clone(), clear.clone()), (0.5, vec![WarningKind::Repaired]));
    assert_eq!(glass(-1.0, solid, clear), (0.0, vec![WarningKind::Repaired]));
}

#[test]
fn emission_and_sides() {
    let strength = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 20}});
    let emissive = json!({"emissiveFactor": [1, 0.5, 0], "doubleSided": true, "extensions": strength});
    let (found, _) = material(emissive);
    assert_eq!((found.emission, found.emits), (vec3(20.0, 10.0, 0.0).into(), Sides::Both));
    assert_eq!(material(json!({})).0.emits, Sides::Front);
}

#[test]
fn each_unused_thing_is_listed_once() {
    let mut document = triangle();
    document["textures"] = json!([{}]);
    document["skins"] = json!([{"joints": [0]}]);
    document["materials"][0]["occlusionTexture"] = json!({"index": 0});
    document["materials"][0]["extensions"]["KHR_materials_iridescence"] = json!({});
    let twin = document["materials"][0].clone();
    document["materials"].as_array_mut().unwrap().push(twin);
    document["extensionsUsed"] = json!(["KHR_materials_iridescence", "KHR_materials_specular", "EXT_other"]);
    document["nodes"][0]["skin"] = json!(0);
    document["animations"] = json!([{"channels": [], "samplers": []}, {"channels": [], "samplers": []}]);
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_1"] = json!(0);
    document["meshes"][0]["primitives"][0]["targets"] = json!([{"TEXCOORD_0": 0}]);
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(json!({"attributes": {}, "mode": 0}));
    document["scenes"].as_array_mut().unwrap().push(json!({}));
    let import = import(&document);
    use WarningKind::*;
    let mut expected =
        vec![Unused, Extension, Skin, VertexColour, MorphTarget, Primitive, Animation, Unused, Extension];
    let mut found = kinds(&import);
    let order = |k: &WarningKind| format!("{k:?}");
    expected.sort_by_key(order);
    found.sort_by_key(order);
    assert_eq!(found, expected, "{:#?}", import.warnings);
    let unused = import.warnings.iter().find(|w| w.message.contains("iridescence")).unwrap();
    let place = "/materials/0/extensions/KHR_materials_iridescence";
    assert_eq!((unused.place.as_str(), unused.count), (place, 2));
    assert!(unused.to_string().contains("and 1 more"));
}

/// A node's name, or the `lightgroup` among its extras.
#[test]
fn groups_of_lights_have_names() {
    let mut document = triangle();
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    document["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    document["nodes"][0]["name"] = json!("Desk lamp");
    let names = |document: &Value| {
        let scene = import(document).scene;
        (scene.instances[0].light_group.clone(), scene.lights[0].name.clone(), scene.light_groups().names)
    };
    let (instance, light, groups) = names(&document);
    assert_eq!((instance.as_deref(), light.as_str()), (Some("Desk lamp"), "Desk lamp"));
    assert_eq!(groups, [Arc::from("Desk lamp")]);
    document["nodes"][0]["extras"] = json!({"lightgroup": "key"});
    assert_eq!(names(&document).2, [Arc::from("key")]);
    for other in [json!({"lightgroup": 3}), json!({"lightgroup": " "}), json!("key"), json!(null)] {
        document["nodes"][0]["extras"] = other;
        assert_eq!(names(&document).2, [Arc::from("Desk lamp")]);
    }
}

#[test]
fn lights_by_kind() {
    let light = |definition: Value| {
        let mut document = triangle();
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [definition]}});
        document["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        document["nodes"][0]["translation"] = json!([1, 2, 3]);
        document["nodes"][0]["rotation"] = json!([-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2]);
        document
    };
    let position = vec3(1.0, 2.0, 3.0);
    let read = |definition| import(&light(definition)).scene.lights[0].kind;
    let point = read(json!({"type": "point", "intensity": 5, "color": [1, 0.5, 0]}));
    assert_eq!(point, LightKind::Point { position, intensity: vec3(5.0, 2.5, 0.0) });
    let LightKind::Directional { direction, irradiance } = read(json!({"type": "directional"})) else {
        panic!("not directional");
    };
    // A quarter turn about x takes -z to -y.
    assert!(direction.distance(Vec3::NEG_Y) <= 1e-6 && irradiance == Vec3::ONE);
    let spot = read(json!({"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}}));
    let LightKind::Spot { inner_angle, outer_angle, falloff, .. } = spot else { panic!("no spot") };
    assert_eq!((inner_angle, outer_angle, falloff), (0.2, 0.5, SpotFalloff::CosineSquared));

    let mut blender = light(json!({"type": "point", "intensity": 683}));
    blender["asset"]["generator"] = json!("Khronos glTF Blender I/O v4.0.44");
    let blender = import(&blender);
    assert_eq!(kinds(&blender), [WarningKind::Light]);
    let LightKind::Point { intensity, .. } = blender.scene.lights[0].kind else { panic!("no point") };
    assert!(intensity.distance(Vec3::ONE) <= 1e-6);
    for bad in [json!({"type": "area"}), json!({"type": "point", "intensity": -1}), json!({})] {
        assert!(load_json(&light(bad)).is_err());
    }
}

#[test]
fn orthographic_cameras() {
    let camera =
        json!({"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 1.5, "zfar": 9, "znear": 1}});
    let camera = &import(&triangle_with("/cameras/0", camera)).scene.cameras[0];
    assert_eq!((camera.projection, camera.aspect), (Projection::Orthographic { height: 3.0 }, Some(2.0)));
}

#[test]
fn instances_of_a_node() {
    let mut bytes = triangle_bytes();
    bytes.resize(80, 0);
    bytes.extend([[1.0f32, 0.0, 0.0], [0.0, 5.0, 0.0]].as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    let mut document = triangle_with("/buffers/0", json!({"byteLength": 104, "uri": data_uri(&bytes)}));
    document["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 0, "byteOffset": 80, "byteLength": 24}));
    let accessor = json!({"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"});
    document["accessors"].as_array_mut().unwrap().push(accessor);
    document["nodes"][0]["scale"] = json!([2, 2, 2]);
    document["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 3}}});
    let found = import(&document);
    let places: Vec<Vec3> =
        found.scene.instances.iter().map(|i| i.world_from_mesh.w_axis.truncate()).collect();
    assert_eq!(places, [vec3(2.0, 0.0, 0.0), vec3(0.0, 10.0, 0.0)]);
    assert_eq!(found.scene.meshes.len(), 1);
    document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(0);
    assert!(load_json(&document).is_err(), "two translations and three scales");
}

/// A target of the positions themselves, at a weight of the mesh's and then of the node's.
#[test]
fn morph_targets_at_their_weights() {
    let mut document = triangle();
    document["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": 0}, {"POSITION": 0, "NORMAL": 1}]);
    document["meshes"][0]["weights"] = json!([0.5, 0]);
    let twice = json!({"mesh": 0, "weights": [0, 1]});
    document["nodes"].as_array_mut().unwrap().push(twice);
    document["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let import = import(&document);
    assert_eq!(import.warnings, []);
    let meshes = &import.scene.meshes;
    assert_eq!(meshes[0].positions, [Vec3::ZERO, Vec3::X * 1.5, Vec3::Y * 1.5]);
    assert_eq!(meshes[1].positions, [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0]);
    assert_eq!(meshes[1].normals, [Vec3::Z; 3]);
}

/// Faults in what is not used: listed with their place, and the rest is rendered.
#[test]
fn faults_elsewhere_are_listed() {
    let mut document = triangle();
    document["animations"] = json!([{"channels": [{"sampler": 1, "target": {"path": "scale", "node": 9}}],
        "samplers": [{"input": 0, "output": "x"}]}]);
    document["skins"] = json!([{"joints": [0, 7]}, {}]);
    document["materials"]
        .as_array_mut()
        .unwrap()
        .push(json!({"extensions": {"OTHER": {"aTexture": {"index": 0}}}}));
    document["samplers"] = json!([{"wrapS": 1}]);
    document["cameras"][0]["perspective"]["zfar"] = json!(-1);
    let found = import(&document);
    let invalid = found.warnings.iter().filter(|w| w.kind == WarningKind::Invalid);
    let mut places: Vec<&str> = invalid.map(|w| w.place.as_str()).collect();
    places.sort_unstable();
    assert_eq!(
        places,
        [
            "/animations/0/channels/0/sampler",
            "/animations/0/channels/0/target/node",
            "/animations/0/samplers/0/output",
            "/cameras/0/perspective/zfar",
            "/materials/1/extensions/OTHER/aTexture/index",
            "/samplers/0/wrapS",
            "/skins/0/joints/1",
            "/skins/1",
        ]
    );
}

#[test]
fn no_camera_and_no_light() {
    let mut document = triangle_with("/materials/0/emissiveFactor", json!([0, 0, 0]));
    document["scenes"][0]["nodes"] = json!([0]);
    let import = import(&document);
    assert_eq!(kinds(&import), [WarningKind::NoCamera, WarningKind::NoLight]);
    assert_eq!(import.scene.cameras.len(), 1);
}

#[test]
fn strips_and_fans_keep_their_front() {
    let positions = [[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let fan_order = [0usize, 1, 3, 2];
    for (mode, order) in [(5, [0usize, 1, 2, 3]), (6, fan_order)] {
        let bytes: Vec<u8> = order
            .iter()
            .flat_map(|&i| [positions[i][0], positions[i][1], 0.0])
            .flat_map(f32::to_le_bytes)
            .collect();
        let mut document = triangle();
        document["buffers"] = json!([{"byteLength": 48, "uri": data_uri(&bytes)}]);
        document["bufferViews"] = json!([{"buffer": 0, "byteLength": 48}]);
        document["accessors"] = json!([{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}]);
        document["meshes"][0]["primitives"] =
            json!([{"attributes": {"POSITION": 0}, "mode": mode, "material": 0}]);
        let import = import(&document);
        let triangles: Vec<_> = import.scene.world_triangles().collect();
        assert_eq!(triangles.len(), 2);
        for t in triangles {
            assert_eq!(t.geometric_normal(), Some(Vec3::Z), "mode {mode}");
            assert_eq!(t.normals, None);
        }
    }
}

/// Positions of 16 bits, normals of 8, normalized, with padding between: KHR_mesh_quantization.
#[test]
fn quantized_and_strided_attributes() {
    let mut bytes = Vec::new();
    for p in [[0i16, 0, 0], [32767, 0, 0], [0, -32767, -32768]] {
        p.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes.extend([0, 0, 127, 0].repeat(3));
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": 36, "uri": data_uri(&bytes)}]);
    document["bufferViews"] = json!([
        {"buffer": 0, "byteLength": 24, "byteStride": 8},
        {"buffer": 0, "byteOffset": 24, "byteLength": 12, "byteStride": 4}]);
    document["accessors"] = json!([
        {"bufferView": 0, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3"}]);
    document["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
    let import = import(&document);
    let mesh = &import.scene.meshes[0];
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, vec3(0.0, -1.0, -1.0)]);
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut bytes = triangle_bytes();
    bytes.extend([2u8, 0, 0, 0]);
    bytes.extend([5.0f32, 6.0, 7.0].iter().flat_map(|x| x.to_le_bytes()));
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": bytes.len(), "uri": data_uri(&bytes)}]);
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 78, "byteLength": 4}));
    views.push(json!({"buffer": 0, "byteOffset": 82, "byteLength": 12}));
    document["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": 3, "componentType": 5121}, "values": {"bufferView": 4}});
    let replaced = vec3(5.0, 6.0, 7.0);
    assert_eq!(import(&document).scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, replaced]);
    document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(import(&document).scene.meshes[0].positions, [Vec3::ZERO, Vec3::ZERO, replaced]);
    document["accessors"][0]["sparse"]["count"] = json!(2);
    assert!(load_json(&document).is_err());
}

#[test]
fn normals_of_no_length_are_repaired() {
    let mut bytes = triangle_bytes();
    bytes[36..48].fill(0);
    let import = import(&triangle_with("/buffers/0/uri", json!(data_uri(&bytes))));
    assert_eq!(import.scene.meshes[0].normals[0], Vec3::Z);
    assert_eq!(kinds(&import), [WarningKind::Repaired]);
}

#[test]
fn few_vertices_of_a_long_accessor_are_picked() {
    let mut bytes: Vec<u8> =
        (0..300).flat_map(|i| [i as f32, (i * i) as f32, 0.0]).flat_map(f32::to_le_bytes).collect();
    bytes.extend([10u16, 200, 299].iter().flat_map(|i| i.to_le_bytes()));
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": 3606, "uri": data_uri(&bytes)}]);
    document["bufferViews"] =
        json!([{"buffer": 0, "byteLength": 3600}, {"buffer": 0, "byteOffset": 3600, "byteLength": 6}]);
    document["accessors"] = json!([
        {"bufferView": 0, "componentType": 5126, "count": 300, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}]);
    document["meshes"][0]["primitives"] =
        json!([{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]);
    let mesh = &import(&document).scene.meshes[0];
    assert_eq!(mesh.positions.iter().map(|p| p.x).collect::<Vec<_>>(), [10.0, 200.0, 299.0]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn transforms_compose_and_cameras_lose_their_scale() {
    let mut document = triangle();
    document["scenes"][0]["nodes"] = json!([2]);
    document["nodes"].as_array_mut().unwrap().push(json!({
        "children": [0, 1], "scale": [2, 2, 2],
        "rotation": [0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2], "translation": [0, 10, 0]}));
    let import = import(&document);
    let t = import.scene.world_triangles().next().unwrap();
    assert!(t.positions[1].distance(vec3(0.0, 10.0, -2.0)) <= 1e-5);
    let camera = &import.scene.cameras[0];
    assert!(camera.position().distance(vec3(6.0, 10.0, 0.0)) <= 1e-5);
    let forward = camera.world_from_camera.transform_vector3(Vec3::NEG_Z);
    assert!(forward.distance(Vec3::NEG_X) <= 1e-5);
}

#[test]
fn instances_share_their_mesh() {
    let mut document = triangle();
    document["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0, "scale": [-1, 1, 1]}));
    document["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0, "scale": [0, 1, 1]}));
    document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let import = import(&document);
    let counts = import.scene.counts();
    assert_eq!((counts.meshes, counts.instances, counts.triangles), (1, 2, 2));
    assert_eq!(kinds(&import), [WarningKind::Unused]);
    assert!(import.scene.world_triangles().all(|t| t.geometric_normal() == Some(Vec3::Z)));
}

/// Found by fuzzing: an extension's name went into a warning as it was.
#[test]
fn no_name_of_an_extension_steers_the_terminal() {
    let import = import(&triangle_with(
        "/materials/0",
        json!({"emissiveFactor": [1, 1, 1], "extensions": {"KHR\u{7f}materials\u{1b}[31m": {}}}),
    ));
    let lines: Vec<String> = import.warnings.iter().map(ToString::to_string).collect();
    assert!(lines.iter().any(|line| line.contains("KHR?materials?[31m is not used")), "{lines:?}");
    assert!(!lines.iter().any(|line| line.contains(char::is_control)), "{lines:?}");
}
