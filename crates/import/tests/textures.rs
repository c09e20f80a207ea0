//! Images, and how they lie: formats, samplers, transforms, and what is wrong with them.

mod common;

use std::f32::consts::FRAC_PI_2;

use common::{Folder, data_uri, image_bytes, load_json, textured};
use glam::{Vec3, vec2};
use image::ImageFormat;
use midway_import::{Import, ImportError, WarningKind, load};
use midway_scene::{
    Channel, CoatNormal, Filter, Image, MetallicRoughness, Opacity, Surface, Texels, Texture, Wrap,
};
use serde_json::{Value, json};

const GREEN: [u8; 4] = [0, 255, 0, 128];

fn import(document: &Value) -> Import {
    load_json(document).unwrap_or_else(|e| panic!("{e}"))
}

fn kinds(import: &Import) -> Vec<WarningKind> {
    import.warnings.iter().map(|w| w.kind).collect()
}

fn png() -> Vec<u8> {
    image_bytes(&[GREEN, [255; 4]], 2, ImageFormat::Png)
}

fn embedded(bytes: &[u8]) -> Value {
    textured(json!({"uri": data_uri(bytes)}))
}

/// The base colour's texture of a diffuse material.
fn base(import: &Import) -> Texture {
    match &import.scene.materials[0].surface {
        Surface::Diffuse { reflectance } => reflectance.texture.clone().expect("no texture"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_format_comes_to_its_texels() {
    for format in [
        ImageFormat::Png,
        ImageFormat::WebP,
        ImageFormat::Bmp,
        ImageFormat::Jpeg,
        ImageFormat::Hdr,
        ImageFormat::OpenExr,
    ] {
        let found = import(&embedded(&image_bytes(&[[0, 255, 0, 255]; 64], 8, format)));
        assert_eq!(found.warnings, [], "{format:?}");
        let image = &found.scene.images[0];
        assert_eq!((image.width, image.height), (8, 8));
        let is_float = matches!(format, ImageFormat::Hdr | ImageFormat::OpenExr);
        assert_eq!(matches!(image.texels, Texels::Float(_)), is_float, "{format:?}");
        let [r, g, b, a] = image.texels.linear(9);
        // JPEG is a few steps of 255 off.
        assert!(r <= 0.01 && (g - 1.0).abs() <= 0.02 && b <= 0.01 && a == 1.0, "{format:?}: {r} {g} {b} {a}");
    }
}

#[test]
fn sixteen_bits_keep_their_precision() {
    let buffer =
        image::ImageBuffer::<image::Rgba<u16>, _>::from_raw(1, 1, vec![0u16, 32768, 65535, 1]).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::DynamicImage::from(buffer).write_to(&mut bytes, ImageFormat::Png).unwrap();
    let mut document = embedded(&bytes.into_inner());
    document["materials"][0]["normalTexture"] = json!({"index": 0, "scale": 0.5});
    let found = import(&document);
    let of = |image: &Image| image.texels.linear(0);
    assert_eq!(of(&found.scene.images[1])[1], 32768.0 / 65535.0, "a normal map is linear");
    // The sRGB curve at a half is 0.21404.
    assert!((of(&found.scene.images[0])[1] - 0.214_05).abs() <= 2e-5);
    assert_eq!(found.scene.materials[0].normal_map.as_ref().unwrap().scale, 0.5);
}

#[test]
fn images_lie_in_files_views_and_uris() {
    let folder = Folder::new();
    folder.write("textures/a b.png", png());
    let file = load(&folder.write("scene.gltf", textured(json!({"uri": "textures/a%20b.png"})).to_string()));
    let uri = import(&embedded(&png()));
    let mut in_view = textured(json!({"bufferView": 4, "mimeType": "image/png"}));
    in_view["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({"byteLength": png().len(), "uri": data_uri(&png())}));
    in_view["bufferViews"].as_array_mut().unwrap().push(json!({"buffer": 1, "byteLength": png().len()}));
    let view = import(&in_view);
    for import in [file.unwrap(), uri, view] {
        assert_eq!(import.warnings, []);
        let Texels::Srgb8(texels) = &import.scene.images[0].texels else { panic!("not sRGB") };
        assert_eq!(texels[..], [GREEN, [255; 4]]);
    }
}

#[test]
fn samplers_sets_and_transforms() {
    let mut document = embedded(&png());
    let found = import(&document);
    let expected = Texture::new(0);
    assert_eq!(base(&found), expected);
    assert_eq!(found.scene.meshes[0].uvs[0], [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(0.0, 1.0)]);

    document["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    document["textures"][0]["sampler"] = json!(0);
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(3);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0, "extensions":
        {"KHR_texture_transform": {"offset": [0.5, 0.25], "rotation": FRAC_PI_2, "scale": [2, 3], "texCoord": 1}}});
    let texture = base(&import(&document));
    assert_eq!(
        (texture.wrap, texture.filter, texture.uv_set),
        ([Wrap::Clamp, Wrap::Mirror], Filter::Nearest, 1)
    );
    // A quarter turn counter-clockwise on the image takes u to -v: upwards.
    assert!(texture.place(vec2(1.0, 0.0)).distance(vec2(0.5, 0.25 - 2.0)) <= 1e-6);
    assert!(texture.place(vec2(0.0, 1.0)).distance(vec2(0.5 + 3.0, 0.25)) <= 1e-6);
}

#[test]
fn alpha_is_of_the_base_colour() {
    let mut document = embedded(&png());
    document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.5]);
    document["materials"][0]["alphaMode"] = json!("MASK");
    let Opacity::Mask(alpha, cutoff) = import(&document).scene.materials[0].opacity.clone() else {
        panic!("no mask");
    };
    assert_eq!((alpha.value, cutoff, alpha.texture.unwrap().1), (0.5, 0.5, Channel::A));
    document["materials"][0]["alphaMode"] = json!("BLEND");
    let found = import(&document);
    assert!(matches!(&found.scene.materials[0].opacity, Opacity::Blend(a) if a.value == 0.5));
    assert_eq!(found.scene.images.len(), 1, "colour and alpha share an image");
    document["materials"][0]["alphaMode"] = json!("OPAQUE");
    assert_eq!(import(&document).scene.materials[0].opacity, Opacity::Opaque);
}

#[test]
fn channels_of_the_extensions_textures() {
    let mut document = embedded(&png());
    let texture = json!({"index": 0});
    document["materials"][0] = json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": texture,
        "pbrMetallicRoughness": {"metallicRoughnessTexture": texture},
        "extensions": {
            "KHR_materials_specular": {"specularTexture": texture, "specularColorTexture": texture},
            "KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": texture},
            "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": texture,
                "clearcoatRoughnessFactor": 1, "clearcoatRoughnessTexture": texture,
                "clearcoatNormalTexture": {"index": 0, "scale": 0.5}},
            "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenColorTexture": texture,
                "sheenRoughnessFactor": 1, "sheenRoughnessTexture": texture},
            "KHR_materials_anisotropy": {"anisotropyStrength": 1, "anisotropyRotation": 0.5}}});
    let found = import(&document);
    assert_eq!(found.warnings, []);
    let Surface::MetallicRoughness(model) = &found.scene.materials[0].surface else { panic!("simplified") };
    let MetallicRoughness { metallic, roughness, specular, transmission, clearcoat, .. } = &**model;
    let channel = |input: &midway_scene::ScalarInput| input.texture.as_ref().unwrap().1;
    assert_eq!([metallic, roughness].map(channel), [Channel::B, Channel::G]);
    assert_eq!([specular, transmission, clearcoat].map(channel), [Channel::A, Channel::R, Channel::R]);
    assert_eq!(channel(&model.clearcoat_roughness), Channel::G);
    assert_eq!(channel(&model.sheen_roughness), Channel::A);
    assert!(model.specular_color.texture.is_some() && model.sheen_color.texture.is_some());
    assert_eq!((model.anisotropy.value, model.anisotropy_rotation), (1.0, 0.5));
    assert!(found.scene.materials[0].emission.texture.is_some());
    let CoatNormal::Map(map) = &model.clearcoat_normal else { panic!("{:?}", model.clearcoat_normal) };
    assert_eq!(map.scale, 0.5);
    assert_eq!(found.scene.images.len(), 3, "one file, read as colour, numbers and normals");
}

#[test]
fn older_and_unlit_materials() {
    let mut document = embedded(&png());
    let texture = json!({"index": 0});
    document["materials"][0]["extensions"] = json!({"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.5, 0.5, 1], "diffuseTexture": texture, "specularFactor": [0.2, 0.04, 0],
        "glossinessFactor": 0.75}});
    let found = import(&document);
    assert_eq!(kinds(&found), [WarningKind::Approximation]);
    let Surface::MetallicRoughness(model) = &found.scene.materials[0].surface else { panic!("simplified") };
    assert_eq!((model.metallic.value, model.roughness.value, model.ior), (0.0, 0.25, 1.5));
    assert!(model.specular_color.value.distance(Vec3::new(5.0, 1.0, 0.0)) <= 1e-6);
    assert_eq!(model.base_color.value, Vec3::splat(0.5));

    document["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}});
    let found = import(&document);
    assert_eq!(kinds(&found), [WarningKind::Approximation]);
    let material = &found.scene.materials[0];
    assert_eq!(material.surface, Surface::diffuse(Vec3::ZERO));
    assert!(material.emission.value == Vec3::ONE && material.emission.texture.is_some());
}

#[test]
fn missing_and_damaged_images_are_done_without() {
    let missing = load_json(&textured(json!({"uri": "none.png"}))).unwrap();
    assert_eq!(kinds(&missing), [WarningKind::MissingFile]);
    assert_eq!(missing.warnings[0].place, "/images/0/uri");
    assert_eq!(missing.scene.materials[0].surface, Surface::diffuse(Vec3::ONE));

    let jpeg = image_bytes(&[GREEN; 4096], 64, ImageFormat::Jpeg);
    let noise: Vec<[u8; 4]> = (0..4096u32).map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
    let noisy = image_bytes(&noise, 64, ImageFormat::Png);
    for bytes in [&noisy[..noisy.len() / 2], &jpeg[..jpeg.len() - 2], &png()[..20], b"no image", b""] {
        let found = load_json(&embedded(bytes)).unwrap();
        assert_eq!(kinds(&found), [WarningKind::Texture], "{} bytes: {:?}", bytes.len(), found.warnings);
        let image = &found.scene.images[0];
        assert_eq!((image.width, image.texels.linear(0)), (1, [1.0; 4]));
    }
}

#[test]
fn references_that_lead_elsewhere_are_refused() {
    let refused = |uri: &str| load_json(&textured(json!({"uri": uri}))).unwrap_err();
    assert!(matches!(refused("../a.png"), ImportError::UnsafePath { .. }));
    assert!(matches!(refused("/etc/passwd"), ImportError::UnsafePath { .. }));
    assert!(matches!(refused("https://example.com/a.png"), ImportError::NetworkUri { .. }));
    let line = refused("http://example.com/a.png").to_string();
    assert!(line.contains("#/images/0/uri") && !line.contains('\n'), "{line}");
}

#[test]
fn wrong_references_and_types() {
    let broken = |pointer: &str, value: Value| {
        let mut document = embedded(&png());
        *document.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value;
        load_json(&document)
    };
    let info = "/materials/0/pbrMetallicRoughness/baseColorTexture";
    for (pointer, value) in [
        (format!("{info}/index"), json!(7)),
        ("/textures/0/source".to_owned(), json!(7)),
        ("/images/0/uri".to_owned(), json!("data:;base64,????")),
        ("/images/0".to_owned(), json!({})),
        ("/accessors/3/type".to_owned(), json!("VEC3")),
        ("/accessors/3/componentType".to_owned(), json!(5125)),
        ("/accessors/3/count".to_owned(), json!(2)),
        (info.to_owned(), json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [1]}}})),
    ] {
        let error = broken(&pointer, value).expect_err(&pointer).to_string();
        assert!(error.contains("scene.gltf#/") && !error.contains('\n'), "{error}");
    }
    let far = broken(info, json!({"index": 0, "texCoord": 2})).unwrap();
    assert_eq!(kinds(&far), [WarningKind::Texture]);
    assert_eq!(far.warnings[0].place, info);
}

/// Small files that claim to be large images, alone and in numbers.
#[test]
fn images_are_bounded_by_their_files() {
    let header = |side: u32| {
        let mut bytes = image_bytes(&[GREEN], 1, ImageFormat::Png);
        bytes[16..20].copy_from_slice(&side.to_be_bytes());
        bytes[20..24].copy_from_slice(&side.to_be_bytes());
        let checksum = crc32(&bytes[12..29]).to_be_bytes();
        bytes[29..33].copy_from_slice(&checksum);
        bytes
    };
    for side in [1 << 14, 1 << 15, 1 << 20, u32::MAX] {
        let found = load_json(&embedded(&header(side))).unwrap();
        assert_eq!(kinds(&found), [WarningKind::Texture], "{side}");
        assert_eq!(found.scene.images[0].width, 1);
    }
    // Each could be, all together could not.
    let mut many = embedded(&header(4096));
    many["images"] = (0..40u8)
        .map(|i| {
            let mut bytes = header(4096);
            bytes.extend([i; 4]);
            json!({"uri": data_uri(&bytes)})
        })
        .collect();
    many["textures"] = (0..40).map(|i| json!({"source": i})).collect();
    let material = many["materials"][0].clone();
    many["materials"] = (0..40)
        .map(|i| {
            let mut own = material.clone();
            own["pbrMetallicRoughness"]["baseColorTexture"]["index"] = json!(i);
            own
        })
        .collect();
    let found = load_json(&many).unwrap();
    assert!(found.warnings.iter().any(|w| w.message.contains("more than files of this size hold")));
}

/// As PNG's chunks have it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}
