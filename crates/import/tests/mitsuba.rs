//! Mitsuba's XML: what each plugin becomes, and that bad files give one clear line.

mod common;

use std::{f32::consts::FRAC_1_SQRT_2, io::Write, time::Instant};

use common::Folder;
use flate2::{Compression, write::ZlibEncoder};
use glam::{Mat3, Mat4, Vec2, Vec3, vec3};
use midway_import::{Import, ImportError, WarningKind, load};
use midway_scene::{
    Camera, Channel, ConductorFresnel, Filter, LightKind, Material, Opacity, Projection, Sides, SpotFalloff,
    Surface, Texels, Wrap,
};

const LAMP: &str = "<shape type='rectangle'><emitter type='area'/></shape>";

/// A scene of release 3 with a lamp and what `body` says.
fn scene(body: &str) -> Result<Import, ImportError> {
    document(&format!("<scene version='3.0.0'>{LAMP}{body}</scene>"))
}

fn document(text: &str) -> Result<Import, ImportError> {
    let folder = Folder::new();
    load(&folder.write("scene.xml", text))
}

/// The material of a rectangle with this BSDF, which comes after the lamp's.
fn material(bsdf: &str) -> Material {
    let import = scene(&format!("<shape type='rectangle'>{bsdf}</shape>")).unwrap();
    import.scene.materials[1].clone()
}

fn says(import: &Import, words: &str) -> bool {
    import.warnings.iter().any(|warning| warning.to_string().contains(words))
}

fn bmp(pixels: [[u8; 3]; 4]) -> Vec<u8> {
    // BMP, 2 x 2, bottom row first, rows padded to 8 bytes.
    let mut bytes = b"BM".to_vec();
    for word in [70u32, 0, 54, 40, 2, 2, 0x0018_0001, 0, 16, 2835, 2835, 0, 0] {
        bytes.extend(word.to_le_bytes());
    }
    for row in [&pixels[2..], &pixels[..2]] {
        row.iter().for_each(|[r, g, b]| bytes.extend([*b, *g, *r]));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn bsdfs_become_surfaces() {
    let plain = material("");
    assert_eq!((&plain.surface, plain.scatters), (&Surface::diffuse(Vec3::splat(0.5)), Sides::Front));
    let red = "<bsdf type='diffuse'><rgb name='reflectance' value='1 0 0'/></bsdf>";
    assert_eq!(material(red).surface, Surface::diffuse(Vec3::X));
    let both = material(&format!("<bsdf type='twosided'>{red}</bsdf>"));
    assert_eq!((both.surface, both.scatters), (Surface::diffuse(Vec3::X), Sides::Both));
    let Surface::Dielectric { ior, thin: false, roughness, .. } =
        material("<bsdf type='dielectric'/>").surface
    else {
        panic!()
    };
    assert!((ior - 1.504_183).abs() <= 1e-5 && roughness.is_smooth());
    let water = "<bsdf type='thindielectric'><string name='int_ior' value='Water'/><float name='ext_ior' value='1'/></bsdf>";
    assert!(matches!(material(water).surface, Surface::Dielectric { ior: 1.333, thin: true, .. }));
    let rough = "<bsdf type='roughdielectric'><float name='alpha' value='0.3'/></bsdf>";
    let Surface::Dielectric { roughness, .. } = material(rough).surface else { panic!() };
    assert_eq!((roughness.along.value, roughness.across.value, roughness.squared), (0.3, 0.3, false));
    let Surface::Plastic { ior, nonlinear: true, specular, .. } =
        material("<bsdf type='plastic'><boolean name='nonlinear' value='true'/></bsdf>").surface
    else {
        panic!()
    };
    assert!((ior - 1.489_587).abs() <= 1e-5 && specular.value == Vec3::ONE);
}

#[test]
fn metals_have_measured_indices() {
    let gold = "<bsdf type='roughconductor'><string name='material' value='Au'/>\
        <float name='alpha_u' value='0.1'/><float name='alpha_v' value='0.4'/></bsdf>";
    let Surface::Conductor { fresnel: ConductorFresnel::Complex { eta, k, .. }, roughness } =
        material(gold).surface
    else {
        panic!()
    };
    assert!((eta - vec3(0.143, 0.3753, 1.442)).abs().max_element() <= 1e-3, "{eta}");
    assert!((k - vec3(3.983, 2.3856, 1.6034)).abs().max_element() <= 1e-3, "{k}");
    assert_eq!((roughness.along.value, roughness.across.value), (0.1, 0.4));
    let complex = |m: Material| match m.surface {
        Surface::Conductor { fresnel: ConductorFresnel::Complex { eta, k, .. }, .. } => (eta, k),
        other => panic!("{other:?}"),
    };
    assert_eq!(complex(material("<bsdf type='conductor'/>")), (Vec3::ZERO, Vec3::ONE));
    let old = document(&format!(
        "<scene version='0.6.0'>{LAMP}<shape type='rectangle'><bsdf type='conductor'/></shape></scene>"
    ));
    let copper = complex(old.unwrap().scene.materials[1].clone());
    assert!((copper.0.x - 0.201).abs() <= 1e-3);
}

#[test]
fn nested_bsdfs_keep_what_is_around_them() {
    let mask = "<bsdf type='mask'><float name='opacity' value='0.25'/><bsdf type='twosided'><bsdf type='plastic'/>\
        </bsdf></bsdf>";
    let mask = material(mask);
    assert_eq!((mask.opacity, mask.scatters), (Opacity::Blend(0.25.into()), Sides::Both));
    assert!(matches!(mask.surface, Surface::Plastic { .. }));
    let blend = "<bsdf type='blendbsdf'><float name='weight' value='0.7'/><bsdf type='null'/>\
        <bsdf type='diffuse'/></bsdf>";
    assert_eq!(material(blend).opacity, Opacity::Blend(0.7.into()));
    let coat = material("<bsdf type='coating'><bsdf type='diffuse'/></bsdf>");
    assert!(matches!(coat.surface, Surface::Plastic { nonlinear: true, .. }));
    assert!(matches!(material("<bsdf type='bumpmap'><bsdf type='null'/></bsdf>").surface, Surface::Null));
    let Surface::MetallicRoughness(model) =
        material("<bsdf type='principled'><float name='metallic' value='0.75'/></bsdf>").surface
    else {
        panic!()
    };
    assert_eq!((model.metallic.value, model.roughness.value), (0.75, 0.5));
    assert!((model.ior - 1.5).abs() <= 1e-3);
}

#[test]
fn what_has_no_counterpart_is_said() {
    for (body, words) in [
        ("<shape type='rectangle'><bsdf type='hk'/></shape>", "\"hk\" are rendered as diffuse grey"),
        ("<shape type='rectangle'><bsdf type='phong'/></shape>", "Phong"),
        ("<shape type='rectangle'><bsdf type='difftrans'/></shape>", "diffuse transmission"),
        ("<shape type='rectangle'><bsdf type='roughconductor'/></shape>", "beckmann distributions"),
        (
            "<shape type='rectangle'><bsdf type='diffuse'><float name='shine' value='1'/></bsdf></shape>",
            "\"shine\"",
        ),
        (
            "<shape type='rectangle'><bsdf type='principled'><texture name='specular' type='checkerboard'/></bsdf></shape>",
            "the texture \"specular\" of \"principled\" is not used",
        ),
        ("<shape type='hair'/>", "\"hair\" are not rendered"),
        ("<emitter type='sunsky'/>", "\"sunsky\" are not rendered"),
        ("<sensor type='radiancemeter'/>", "\"radiancemeter\" are not rendered"),
        (
            "<integrator type='path'><integer name='max_depth' value='5'/></integrator>",
            "give --max-path-length 5",
        ),
        (
            "<sensor type='perspective'><film type='hdrfilm'><rfilter type='gaussian'/></film></sensor>",
            "\"gaussian\"",
        ),
        (
            "<sensor type='perspective'><film type='hdrfilm'><integer name='crop_width' value='4'/></film></sensor>",
            "crop",
        ),
        ("<shape type='sphere'/>", "fine meshes"),
    ] {
        let import = scene(body).unwrap();
        assert!(says(&import, words), "{body}: {:?}", import.warnings);
    }
    let quiet = scene("<sensor type='perspective'/>").unwrap();
    assert!(quiet.warnings.is_empty(), "{:?}", quiet.warnings);
}

#[test]
fn textures_keep_their_place() {
    let folder = Folder::new();
    folder.write("a.bmp", bmp([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]]));
    let texture = "<texture name='reflectance' type='bitmap'><string name='filename' value='a.bmp'/>\
        <string name='wrap_mode' value='clamp'/><string name='filter_type' value='nearest'/>\
        <transform name='to_uv'><scale x='2' y='3'/><translate x='0.5' y='0.25'/></transform></texture>";
    let text = format!(
        "<scene version='3.0.0'>{LAMP}<shape type='rectangle'><bsdf type='diffuse'>{texture}</bsdf></shape>\
        <shape type='rectangle'><bsdf type='mask'><texture name='opacity' type='bitmap'>\
        <string name='filename' value='a.bmp'/><boolean name='raw' value='true'/></texture>\
        <bsdf type='diffuse'/></bsdf></shape></scene>"
    );
    let import = load(&folder.write("scene.xml", text)).unwrap();
    let Surface::Diffuse { reflectance } = &import.scene.materials[1].surface else { panic!() };
    let texture = reflectance.texture.as_ref().unwrap();
    assert_eq!(reflectance.value, Vec3::ONE);
    assert_eq!((texture.wrap, texture.filter), ([Wrap::Clamp; 2], Filter::Nearest));
    assert!((texture.place(Vec2::ONE) - Vec2::new(2.5, 3.25)).length() <= 1e-6);
    let image = &import.scene.images[texture.image as usize];
    // The first row of a file is at v = 0, as here.
    assert_eq!(image.texels.linear(0)[..3], [1.0, 0.0, 0.0]);
    assert!(matches!(image.texels, Texels::Srgb8(_)));
    let Opacity::Blend(input) = &import.scene.materials[2].opacity else { panic!() };
    let (texture, channel) = input.texture.as_ref().unwrap();
    assert_eq!(*channel, Channel::R);
    assert!(matches!(import.scene.images[texture.image as usize].texels, Texels::Linear8(_)));
}

/// A factor above 1 is for dark images: it counts where the product is below 1, and what is cut is said.
#[test]
fn textures_keep_factors_above_1() {
    let folder = Folder::new();
    folder.write("dark.bmp", bmp([[20; 3], [60; 3], [30; 3], [40; 3]]));
    folder.write("light.bmp", bmp([[20; 3], [250; 3], [30; 3], [40; 3]]));
    let read = |file: &str| {
        let scaled = |name: &str| {
            format!(
                "<texture name='{name}' type='scale'><float name='scale' value='4'/>\
                 <texture type='bitmap'><string name='filename' value='{file}'/></texture></texture>"
            )
        };
        let (reflectance, opacity) = (scaled("reflectance"), scaled("opacity"));
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'/>{LAMP}<shape type='rectangle'>\
             <bsdf type='mask'>{opacity}<bsdf type='diffuse'>{reflectance}</bsdf></bsdf></shape></scene>"
        );
        let import = load(&folder.write("scene.xml", text)).unwrap();
        let material = &import.scene.materials[1];
        let Surface::Diffuse { reflectance } = &material.surface else { panic!() };
        let opacity = match &material.opacity {
            Opacity::Blend(input) => input.value,
            _ => 1.0,
        };
        (reflectance.value, opacity, import.warnings)
    };
    let (reflectance, opacity, warnings) = read("dark.bmp");
    assert_eq!((reflectance, opacity), (Vec3::splat(4.0), 4.0));
    assert!(warnings.is_empty(), "{warnings:?}");
    let (reflectance, _, warnings) = read("light.bmp");
    assert_eq!(reflectance, Vec3::splat(4.0));
    assert!(warnings.iter().all(|w| w.message.contains("cut to 1")) && !warnings.is_empty(), "{warnings:?}");
    // Without an image there is nothing that the factor could be for.
    let (reflectance, opacity, _) = read("none.bmp");
    assert_eq!((reflectance, opacity), (Vec3::ONE, 1.0));
}

/// A weight may be an image: then what is there of the other is what it leaves.
#[test]
fn a_blend_with_nothing_is_a_share() {
    let of = |parts: [&str; 2]| {
        let folder = Folder::new();
        folder.write("a.bmp", bmp([[0; 3], [51; 3], [102; 3], [255; 3]]));
        let text = format!(
            "<scene version='3.0.0'>{LAMP}<shape type='rectangle'>{}</shape></scene>",
            blend("a.bmp", parts)
        );
        let import = load(&folder.write("scene.xml", text)).unwrap();
        let Opacity::Blend(input) = &import.scene.materials[1].opacity else { panic!() };
        let (texture, channel) = input.texture.as_ref().unwrap();
        let texels = &import.scene.images[texture.image as usize].texels;
        (0..4).map(|i| texels.linear(i)[*channel as usize]).collect::<Vec<f32>>()
    };
    let nothing = "<bsdf type='null'/>";
    assert_eq!(of([nothing, &diffuse("0.5")]), [0.0, 0.2, 0.4, 1.0]);
    assert_eq!(of([&diffuse("0.5"), nothing]), [1.0, 0.8, 0.6, 0.0]);
}

/// A diffuse BSDF of a grey, or of an image.
fn diffuse(reflectance: &str) -> String {
    match reflectance.parse::<f32>() {
        Ok(grey) => format!("<bsdf type='diffuse'><rgb name='reflectance' value='{grey}'/></bsdf>"),
        Err(_) => format!("<bsdf type='diffuse'>{}</bsdf>", image("reflectance", reflectance)),
    }
}

fn image(name: &str, file: &str) -> String {
    format!(
        "<texture name='{name}' type='bitmap'><string name='filename' value='{file}'/>\
         <boolean name='raw' value='true'/></texture>"
    )
}

/// The material with this BSDF, its texels' red where it has an image, and what is said.
fn mixed(bsdf: &str) -> (Surface, Vec<f32>, Vec<String>) {
    let folder = Folder::new();
    folder.write("a.bmp", bmp([[0; 3], [51; 3], [102; 3], [255; 3]]));
    folder.write("b.bmp", bmp([[255; 3]; 4]));
    let camera = "<sensor type='perspective'/>";
    let text = format!("<scene version='3.0.0'>{camera}{LAMP}<shape type='rectangle'>{bsdf}</shape></scene>");
    let import = load(&folder.write("scene.xml", text)).unwrap_or_else(|e| panic!("{e}"));
    let surface = import.scene.materials[1].surface.clone();
    let texels = import
        .scene
        .images
        .last()
        .map_or(Vec::new(), |image| (0..image.texels.len()).map(|i| image.texels.linear(i)[0]).collect());
    (surface, texels, import.warnings.into_iter().map(|w| w.message).collect())
}

fn blend(weight: &str, parts: [&str; 2]) -> String {
    let weight = match weight.parse::<f32>() {
        Ok(weight) => format!("<float name='weight' value='{weight}'/>"),
        Err(_) => image("weight", weight),
    };
    format!("<bsdf type='blendbsdf'>{weight}{}{}</bsdf>", parts[0], parts[1])
}

/// The sum of two Lambertian surfaces is one of their albedos' sum.
#[test]
fn mixed_diffuse_bsdfs_are_their_sum() {
    let close = |found: &[f32], expected: &[f32]| {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-4);
        assert!(near && found.len() == expected.len(), "{found:?} {expected:?}");
    };
    let both = |weight: &str, a: &str, b: &str| mixed(&blend(weight, [&diffuse(a), &diffuse(b)]));
    let (surface, _, warnings) = both("0.25", "0.25", "0.75");
    assert_eq!((surface, warnings), (Surface::diffuse(Vec3::splat(0.375)), vec![]));
    for (weight, a, b, expected) in [
        ("0.5", "a.bmp", "1", [0.5, 0.6, 0.7, 1.0]),
        ("0.25", "0", "a.bmp", [0.0, 0.05, 0.1, 0.25]),
        ("a.bmp", "0.5", "1", [0.5, 0.6, 0.7, 1.0]),
        ("a.bmp", "b.bmp", "0.5", [1.0, 0.9, 0.8, 0.5]),
    ] {
        let (surface, texels, warnings) = both(weight, a, b);
        assert_eq!(warnings, Vec::<String>::new());
        let Surface::Diffuse { reflectance } = surface else { panic!("{surface:?}") };
        assert!(reflectance.value == Vec3::ONE && reflectance.texture.is_some());
        close(&texels, &expected);
    }
    // Shares above 1 are cut before they mix.
    let by_four = image("weight", "a.bmp").replacen(
        "<texture name='weight' ",
        "<texture name='weight' type='scale'><float name='scale' value='4'/><texture ",
        1,
    );
    let blend =
        format!("<bsdf type='blendbsdf'>{by_four}</texture>{}{}</bsdf>", diffuse("0.2"), diffuse("0.6"));
    let (_, texels, _) = mixed(&blend);
    close(&texels, &[0.2, 0.52, 0.6, 0.6]);
    let three = format!(
        "<bsdf type='mixturebsdf'><string name='weights' value='0.5, 0.25, 0.25'/>{}{}{}</bsdf>",
        diffuse("0.4"),
        diffuse("0.8"),
        diffuse("0"),
    );
    let (surface, _, warnings) = mixed(&three);
    let Surface::Diffuse { reflectance } = surface else { panic!("{surface:?}") };
    close(&[reflectance.value.x], &[0.4]);
    assert_eq!(warnings, Vec::<String>::new());
    // What weights lack is dark.
    let (surface, _, _) = mixed(&three.replace("0.5, 0.25, 0.25", "0.25, 0.25, 0"));
    let Surface::Diffuse { reflectance } = surface else { panic!("{surface:?}") };
    close(&[reflectance.value.x], &[0.3]);
}

/// Each level refers to the one below twice.
#[test]
fn mixtures_of_mixtures_do_not_multiply() {
    let start = Instant::now();
    let levels: String = (0..30)
        .map(|i| {
            let below =
                if i == 0 { diffuse("0.5").repeat(2) } else { format!("<ref id='m{}'/>", i - 1).repeat(2) };
            format!("<bsdf type='blendbsdf' id='m{i}'><float name='weight' value='0.5'/>{below}</bsdf>")
        })
        .collect();
    let import = scene(&format!("{levels}<shape type='rectangle'><ref id='m29'/></shape>")).unwrap();
    assert_eq!(import.scene.materials[1].surface, Surface::diffuse(Vec3::splat(0.5)));
    assert!(start.elapsed().as_secs() < 5);
    let itself = "<bsdf type='blendbsdf' id='m'><ref id='m'/><ref id='m'/></bsdf><shape type='rectangle'><ref id='m'/></shape>";
    refused(scene(itself), "without end");
}

#[test]
fn mixed_bsdfs_of_one_type_have_mixed_parameters() {
    let metal = |alpha: f32, tint: f32| {
        format!(
            "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>\
             <float name='alpha' value='{alpha}'/><rgb name='specular_reflectance' value='{tint}'/></bsdf>"
        )
    };
    let of = |weight: &str, a: &str, b: &str| {
        let (surface, _, warnings) = mixed(&blend(weight, [a, b]));
        match surface {
            Surface::Conductor { fresnel: ConductorFresnel::Complex { tint, .. }, roughness } => {
                (roughness.along.value, tint.value.x, warnings)
            }
            other => panic!("{other:?}"),
        }
    };
    let (alpha, tint, warnings) = of("0.25", &metal(0.2, 0.4), &metal(0.6, 0.8));
    assert!((alpha - 0.3).abs() <= 1e-6 && (tint - 0.5).abs() <= 1e-6, "{alpha} {tint}");
    assert!(warnings.iter().any(|w| w.contains("whose parameters are mixed")), "{warnings:?}");
    // What light is multiplied by adds up.
    assert_eq!(of("0.5", &metal(0.2, 0.5), &metal(0.2, 1.0)), (0.2, 0.75, vec![]));
    // Of different types there is one.
    let (surface, _, warnings) = mixed(&blend("0.75", [&diffuse("0.5"), "<bsdf type='dielectric'/>"]));
    assert!(matches!(surface, Surface::Dielectric { .. }));
    assert!(warnings.iter().any(|w| w.contains("the one with the greatest weight")), "{warnings:?}");
}

/// `c` is the base's hue, of luminance 1: sheen times the way from white to it.
#[test]
fn textures_of_a_principled_sheen_and_coat_count() {
    let principled = |inside: &str| {
        let (surface, texels, warnings) = mixed(&format!("<bsdf type='principled'>{inside}</bsdf>"));
        let Surface::MetallicRoughness(model) = surface else { panic!("{surface:?}") };
        assert!(warnings.iter().all(|w| w.contains("principled BSDFs are")), "{warnings:?}");
        (model, texels)
    };
    let near = |found: &[f32], expected: [f32; 4]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-4), "{found:?} {expected:?}");
    };
    let (model, texels) = principled(&image("sheen", "a.bmp"));
    assert!(model.sheen_color.texture.is_some());
    near(&texels, [0.0, 0.2, 0.4, 1.0]);
    let base = "<rgb name='base_color' value='0 0.5 0'/><float name='sheen' value='0.5'/>";
    let (_, texels) = principled(&format!("{base}{}", image("sheen_tint", "a.bmp")));
    near(&texels, [0.5, 0.4, 0.3, 0.0]);
    let coat = "<float name='clearcoat' value='1'/>";
    let (model, texels) = principled(&format!("{coat}{}", image("clearcoat_gloss", "a.bmp")));
    assert!(model.clearcoat_roughness.texture.is_some());
    near(&texels, [0.0, 0.2, 0.4, 1.0].map(|gloss: f32| (0.1 - 0.099 * gloss).sqrt()));
    let scaled = image("clearcoat_gloss", "a.bmp").replacen(
        "<texture name='clearcoat_gloss' ",
        "<texture name='clearcoat_gloss' type='scale'><float name='scale' value='4'/><texture ",
        1,
    );
    let (_, texels, _) = mixed(&format!("<bsdf type='principled'>{coat}{scaled}</texture></bsdf>"));
    near(&texels, [0.0, 0.8, 1.0, 1.0].map(|gloss: f32| (0.1 - 0.099 * gloss).sqrt()));
    let (plain, _) = principled("<float name='sheen' value='0.5'/><float name='clearcoat_gloss' value='1'/>");
    assert_eq!(plain.sheen_color, Vec3::splat(0.5).into());
    assert!((plain.clearcoat_roughness.value - 0.001f32.sqrt()).abs() <= 1e-6);
}

#[test]
fn checkerboards_are_four_texels() {
    let board = "<bsdf type='diffuse'><texture name='reflectance' type='checkerboard'>\
        <rgb name='color0' value='0.25'/><rgb name='color1' value='0.5'/></texture></bsdf>";
    let import = scene(&format!("<shape type='rectangle'>{board}</shape>")).unwrap();
    let texels: Vec<f32> = (0..4).map(|i| import.scene.images[0].texels.linear(i)[0]).collect();
    assert_eq!(texels, [0.25, 0.5, 0.5, 0.25]);
}

#[test]
fn emitters_become_lights() {
    let import = scene(
        "<emitter type='point'><point name='position' x='1' y='2' z='3'/><rgb name='intensity' value='4'/></emitter>\
        <emitter type='spot'><transform name='to_world'><lookat origin='0,5,0' target='0,0,0' up='1,0,0'/></transform>\
        <float name='cutoff_angle' value='40'/></emitter>\
        <emitter type='directional'><vector name='direction' x='0' y='-3' z='0'/><rgb name='irradiance' value='2'/>\
        </emitter><emitter type='constant'><spectrum name='radiance' value='0.5'/></emitter>",
    )
    .unwrap();
    let kinds: Vec<LightKind> = import.scene.lights.iter().map(|light| light.kind).collect();
    assert_eq!(kinds[0], LightKind::Point { position: vec3(1.0, 2.0, 3.0), intensity: Vec3::splat(4.0) });
    let LightKind::Spot { position, direction, inner_angle, outer_angle, falloff, .. } = kinds[1] else {
        panic!()
    };
    assert_eq!((position, direction, falloff), (vec3(0.0, 5.0, 0.0), Vec3::NEG_Y, SpotFalloff::Angle));
    assert!(
        (inner_angle.to_degrees() - 30.0).abs() <= 1e-4 && (outer_angle.to_degrees() - 40.0).abs() <= 1e-4
    );
    assert_eq!(kinds[2], LightKind::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(2.0) });
    let environment = import.scene.environment.unwrap();
    assert_eq!((environment.radiance, environment.image), (Vec3::splat(0.5), None));
}

#[test]
fn an_environment_without_its_image_is_named() {
    let sky = "<emitter type='envmap'><string name='filename' value='sky.exr'/></emitter>";
    let import = scene(sky).unwrap();
    assert!(import.scene.environment.is_none());
    assert!(says(&import, "the environment's image \"sky.exr\" does not exist"), "{:?}", import.warnings);
}

/// Mitsuba 3.9.1 finds the left edge of the image in the direction -z and a quarter of it at +x; here
/// that is half of the image.
#[test]
fn environments_are_turned_as_in_mitsuba() {
    let folder = Folder::new();
    folder.write("a.bmp", bmp([[255, 0, 0], [0, 255, 0], [255, 0, 0], [0, 255, 0]]));
    let load = |transform: &str| {
        let emitter = format!(
            "<emitter type='envmap'><string name='filename' value='a.bmp'/><float name='scale' value='2'/>\
            <transform name='to_world'>{transform}</transform></emitter>"
        );
        let text = format!("<scene version='3.0.0'>{LAMP}{emitter}</scene>");
        load(&folder.write("scene.xml", text)).unwrap().scene
    };
    // Where a direction of the world is on the image, along u.
    let u = |m: Mat3, d: Vec3| {
        let d = m.transpose() * d;
        (0.5 + d.x.atan2(-d.z) / std::f32::consts::TAU).rem_euclid(1.0)
    };
    let scene = load("");
    let environment = scene.environment.as_ref().unwrap();
    let m = environment.world_from_environment;
    assert_eq!(environment.radiance, Vec3::splat(2.0));
    assert!((u(m, Vec3::X) - 0.25).abs() <= 1e-6 && (u(m, Vec3::Z) - 0.5).abs() <= 1e-6);
    let turned = load("<rotate y='1' angle='90'/>").environment.unwrap().world_from_environment;
    // By Mitsuba: what was at -z is at -x.
    assert!((u(turned, Vec3::NEG_Z) - 0.25).abs() <= 1e-6, "{}", u(turned, Vec3::NEG_Z));
    let mirrored = load("<scale x='-1'/>");
    let environment = mirrored.environment.unwrap();
    // Mirrored, +x is at three quarters of the file, which is a quarter of the copy.
    assert!((u(environment.world_from_environment, Vec3::X) - 0.25).abs() <= 1e-6);
    let image = &mirrored.images[environment.image.unwrap() as usize];
    assert_eq!(image.texels.linear(0)[..3], [0.0, 1.0, 0.0]);
}

fn camera(sensor: &str) -> Camera {
    let size =
        "<film type='hdrfilm'><integer name='width' value='200'/><integer name='height' value='100'/></film>";
    scene(&sensor.replace("FILM", size)).unwrap().scene.cameras[0].clone()
}

/// Directions through the film's top left corner as Mitsuba 3.9.1 has them.
#[test]
fn cameras_see_what_mitsubas_see() {
    for (inner, expected) in [
        ("<float name='fov' value='60'/>", [0.4851, 0.2425, 0.8402]),
        (
            "<float name='fov' value='60'/><string name='fov_axis' value='y'/>",
            [FRAC_1_SQRT_2, 0.3536, 0.6124],
        ),
        (
            "<float name='fov' value='60'/><string name='fov_axis' value='smaller'/>",
            [FRAC_1_SQRT_2, 0.3536, 0.6124],
        ),
        ("<float name='fov' value='60'/><string name='fov_axis' value='larger'/>", [0.4851, 0.2425, 0.8402]),
        ("<float name='fov' value='60'/><string name='fov_axis' value='diagonal'/>", [0.4472, 0.2236, 0.866]),
        ("<string name='focal_length' value='50mm'/>", [0.3552, 0.1776, 0.9178]),
    ] {
        let camera = camera(&format!("<sensor type='perspective'>{inner}FILM</sensor>"));
        assert_eq!(camera.resolution, Some([200, 100]));
        let half = (0.5 * camera.yfov().unwrap()).tan();
        let corner = vec3(-2.0 * half, half, -1.0).normalize();
        let direction = camera.world_from_camera.transform_vector3(corner);
        assert!((direction - Vec3::from_array(expected)).length() <= 1e-4, "{inner}: {direction}");
    }
}

#[test]
fn lenses_and_parallel_rays() {
    let lens = camera(
        "<sensor type='thinlens'><float name='aperture_radius' value='0.2'/><float name='focus_distance' value='3'/>\
        <float name='fov' value='30'/>FILM</sensor>",
    );
    assert_eq!((lens.lens_radius, lens.focus_distance), (0.2, 3.0));
    let parallel = camera(
        "<sensor type='orthographic'><transform name='to_world'><scale x='2' y='2'/></transform>FILM</sensor>",
    );
    assert_eq!(parallel.projection, Projection::Orthographic { height: 2.0 });
}

/// The point that a mirrored camera sees at its left is at its right in the file.
#[test]
fn mirrored_cameras_mirror_the_world() {
    let import = scene(
        "<sensor type='perspective'><transform name='to_world'><scale x='-1'/></transform></sensor>\
        <emitter type='point'><point name='position' x='1' y='2' z='3'/></emitter>",
    )
    .unwrap();
    assert!(says(&import, "mirrored"));
    let camera_from_world = import.scene.cameras[0].world_from_camera.inverse();
    let LightKind::Point { position, .. } = import.scene.lights[0].kind else { panic!() };
    let seen = camera_from_world.transform_point3(position);
    // Mitsuba's camera has x to the left: mirrored, the file's +x is at the right.
    assert!((seen - vec3(1.0, 2.0, -3.0)).length() <= 1e-6, "{seen}");
    assert!(import.scene.instances[0].world_from_mesh.determinant() < 0.0);
}

#[test]
fn instances_share_their_meshes() {
    let import = scene(
        "<shape type='shapegroup' id='g'><shape type='cube'/><shape type='cube'><transform name='to_world'>\
        <translate x='3'/></transform></shape></shape>\
        <shape type='instance'><ref id='g'/></shape>\
        <shape type='instance'><ref id='g'/><transform name='to_world'><translate y='5'/></transform></shape>",
    )
    .unwrap();
    // The lamp's and the cube's, which all four placements share.
    assert_eq!((import.scene.meshes.len(), import.scene.instances.len()), (2, 5));
    let last = import.scene.instances[4].world_from_mesh;
    assert_eq!(last, Mat4::from_translation(vec3(3.0, 5.0, 0.0)));
}

#[test]
fn media_that_absorb_are_glass() {
    let medium = "<medium name='interior' type='homogeneous'><rgb name='sigma_t' value='1 2 3'/>\
        <rgb name='albedo' value='0'/><float name='scale' value='2'/></medium>";
    let of =
        |bsdf: &str| scene(&format!("<shape type='cube'><bsdf type='{bsdf}'/>{medium}</shape>")).unwrap();
    for (bsdf, index) in [("null", 1.0), ("dielectric", 1.504_183)] {
        let import = of(bsdf);
        let Surface::Dielectric { sigma_a, ior, .. } = import.scene.materials[1].surface else { panic!() };
        assert!(sigma_a == vec3(2.0, 4.0, 6.0) && (ior - index).abs() <= 1e-5);
    }
    let cloudy = scene(
        "<shape type='cube'><bsdf type='dielectric'/><medium name='interior' type='homogeneous'/></shape>",
    );
    assert!(says(&cloudy.unwrap(), "scattering media"));
}

#[test]
fn files_of_release_0_6_are_read() {
    let folder = Folder::new();
    folder
        .write("sub/box.xml", "<scene version='0.6.0'><shape type='cube'><ref id='paint'/></shape></scene>");
    let text = format!(
        "<scene version='0.6.0'>{LAMP}<default name='w' value='12'/><default name='w' value='13'/>\
        <bsdf type='diffuse' id='red'><srgb name='reflectance' value='#ff0000'/></bsdf><alias id='red' as='paint'/>\
        <sensor type='perspective'><transform name='toWorld'><lookAt origin='0 0 9' target='0 0 0' up='0 1 0'/>\
        </transform><film type='hdrfilm'><integer name='width' value='$w'/></film></sensor>\
        <include filename='sub\\box.xml'/></scene>"
    );
    let import = load(&folder.write("scene.xml", text)).unwrap();
    assert_eq!(import.scene.cameras[0].resolution, Some([12, 576]));
    assert_eq!(import.scene.cameras[0].position(), vec3(0.0, 0.0, 9.0));
    let cube = &import.scene.meshes[1];
    assert_eq!(import.scene.materials[cube.material as usize].surface, Surface::diffuse(Vec3::X));
}

/// A `.serialized` file of version 4 of one mesh with these numbers of vertices and triangles announced.
fn serialized(n_vertices: u64, n_triangles: u64, last: f32, indices: [u32; 3]) -> Vec<u8> {
    serialized_as(0x1000, n_vertices, n_triangles, last, indices)
}

/// The same with these flags.
fn serialized_as(flags: u32, n_vertices: u64, n_triangles: u64, last: f32, indices: [u32; 3]) -> Vec<u8> {
    let mut body = flags.to_le_bytes().to_vec();
    body.extend(b"name\0");
    body.extend(n_vertices.to_le_bytes());
    body.extend(n_triangles.to_le_bytes());
    for x in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, last] {
        body.extend(x.to_le_bytes());
    }
    indices.iter().for_each(|i| body.extend(i.to_le_bytes()));
    let mut bytes = [0x041cu16, 4].iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&body).unwrap();
    bytes.extend(encoder.finish().unwrap());
    bytes.extend(0u64.to_le_bytes());
    bytes.extend(1u32.to_le_bytes());
    bytes
}

const SERIALIZED: &str = "<shape type='serialized'><string name='filename' value='m.serialized'/></shape>";

fn load_serialized(bytes: &[u8]) -> Result<Import, ImportError> {
    load_serialized_by("3.0.0", bytes)
}

fn load_serialized_by(release: &str, bytes: &[u8]) -> Result<Import, ImportError> {
    let folder = Folder::new();
    folder.write("m.serialized", bytes);
    load(&folder.write("scene.xml", format!("<scene version='{release}'>{LAMP}{SERIALIZED}</scene>")))
}

#[test]
fn serialized_meshes_are_read_and_bounded() {
    let good = serialized(3, 1, 0.0, [0, 1, 2]);
    let import = load_serialized(&good).unwrap();
    assert_eq!(import.scene.meshes[1].positions[1..], [Vec3::X, Vec3::Y]);
    assert_eq!(import.scene.meshes[1].normals.len(), 3);
    // Face normals are asked for by the file in release 0.6, and by the scene alone since.
    let flat = serialized_as(0x1010, 3, 1, 0.0, [0, 1, 2]);
    for (release, n_normals) in [("0.6.0", 0), ("3.0.0", 3)] {
        let import = load_serialized_by(release, &flat).unwrap();
        assert_eq!(import.scene.meshes[1].normals.len(), n_normals, "{release}");
    }
    let start = Instant::now();
    for (n_vertices, n_triangles) in
        [(u64::MAX, 1), (u64::from(u32::MAX), 1), (3, u64::MAX), (3, 1 << 26), (4, 1)]
    {
        let result = load_serialized(&serialized(n_vertices, n_triangles, 0.0, [0, 1, 2]));
        assert!(
            matches!(result, Err(ImportError::TooBig { .. } | ImportError::Truncated { .. })),
            "{n_vertices} {n_triangles}: {result:?}"
        );
    }
    assert!(start.elapsed().as_secs() < 5);
    let nan = load_serialized(&serialized(3, 1, f32::NAN, [0, 1, 2]));
    assert!(matches!(nan, Err(ImportError::NotFinite { index: 2, .. })), "{nan:?}");
    let far = load_serialized(&serialized(3, 1, 0.0, [0, 1, 3]));
    assert!(matches!(far, Err(ImportError::OutOfRange { .. })), "{far:?}");
    for length in 0..good.len() {
        assert!(load_serialized(&good[..length]).is_err(), "cut at {length}");
    }
    for at in 0..good.len() {
        for value in [0, 0xff, good[at] ^ 1] {
            let mut damaged = good.clone();
            damaged[at] = value;
            let _ = load_serialized(&damaged);
        }
    }
}

/// Asserts that a scene is refused with one line that says these words.
fn refused(result: Result<Import, ImportError>, words: &str) {
    let line = result.expect_err(words).to_string();
    assert!(!line.contains(char::is_control) && line.contains("scene.xml") && line.contains(words), "{line}");
}

#[test]
fn bad_documents_are_refused() {
    let mut deep = String::new();
    (0..100_000).for_each(|_| deep.push_str("<bsdf type='twosided'>"));
    (0..100_000).for_each(|_| deep.push_str("</bsdf>"));
    let cases = [
        ("", "not XML"),
        ("<scene", "not XML"),
        // What the parser says of it quotes the line break.
        ("<scene version='3.0.0'/\n>", "not XML"),
        ("<mesh/>", "begins with <mesh>"),
        ("<scene version='3.0.0'></scene>", "no triangles"),
        ("<scene version='3.0.0'><nonsense name='a' value='1'/></scene>", "<nonsense>"),
        ("<scene version='3.0.0'><shape type='cube'><ref id='x'/></shape></scene>", "nothing has this id"),
        (
            "<scene version='3.0.0'><shape type='cube'><transform name='to_world'><scale value='$s'/></transform></shape></scene>",
            "\"$s\"",
        ),
        (
            "<scene version='3.0.0'><shape type='cube' id='a'/><shape type='cube' id='a'/></scene>",
            "given twice",
        ),
        (
            "<scene version='3.0.0'><shape type='sphere'><float name='radius' value='nan'/></shape></scene>",
            "<float>",
        ),
        (
            "<scene version='3.0.0'><shape type='sphere'><float name='radius' value='-1'/></shape></scene>",
            "radius",
        ),
        (
            "<scene version='3.0.0'><shape type='sphere'><string name='radius' value='1'/></shape></scene>",
            "has to be a number",
        ),
        (
            "<scene version='3.0.0'><shape type='cube'><bsdf type='twosided' id='a'><ref id='a'/></bsdf></shape></scene>",
            "without end",
        ),
        ("<scene version='3.0.0'><shape type='obj'/></scene>", "names no file"),
        (
            "<scene version='3.0.0'><shape type='shapegroup' id='g'><shape type='instance'><ref id='g'/></shape></shape></scene>",
            "instance",
        ),
        (
            "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='180'/></sensor></scene>",
            "field of view",
        ),
        (
            "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'><integer name='width' value='0'/></film></sensor></scene>",
            "pixels",
        ),
        (
            "<scene version='3.0.0'><shape type='cube'><bsdf type='dielectric'><float name='int_ior' value='0'/></bsdf></shape></scene>",
            "above 0",
        ),
        (
            "<scene version='3.0.0'><shape type='cube'><bsdf type='diffuse'><rgb name='reflectance' value='-1'/></bsdf></shape></scene>",
            "below 0",
        ),
    ];
    for (text, words) in cases {
        refused(document(text), words);
    }
    refused(document(&format!("<scene version='3.0.0'>{deep}</scene>")), "nested too deep");
}

#[test]
fn entities_do_not_multiply() {
    let mut laughs = String::from("<!DOCTYPE scene [<!ENTITY a 'ha'>");
    for (name, before) in
        ["b", "c", "d", "e", "f", "g", "h", "i"].iter().zip(["a", "b", "c", "d", "e", "f", "g", "h"])
    {
        laughs.push_str(&format!("<!ENTITY {name} '{}'>", format!("&{before};").repeat(10)));
    }
    laughs.push_str("]><scene version='3.0.0'><shape type='&i;'/></scene>");
    let start = Instant::now();
    refused(document(&laughs), "DTD");
    assert!(start.elapsed().as_secs() < 2);
}

#[test]
fn files_stay_in_the_scenes_folder() {
    let file = |kind: &str, name: &str| {
        format!("<shape type='{kind}'><string name='filename' value='{name}'/></shape>")
    };
    for name in ["../a.obj", "/etc/passwd", "a/../../b.ply"] {
        let result = scene(&file("obj", name));
        assert!(matches!(result, Err(ImportError::UnsafePath { .. })), "{name}: {result:?}");
    }
    assert!(matches!(scene(&file("ply", "http://example.org/a.ply")), Err(ImportError::NetworkUri { .. })));
    refused(scene(&file("serialized", "none.serialized")), "does not exist");
    refused(scene("<include filename='none.xml'/>"), "does not exist");
    let image = "<shape type='cube'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'>\
        <string name='filename' value='none.png'/></texture></bsdf></shape>";
    assert!(scene(image).unwrap().warnings.iter().any(|w| w.kind == WarningKind::MissingFile));
}

#[test]
fn includes_end() {
    let folder = Folder::new();
    let twice =
        "<scene version='3.0.0'><include filename='scene.xml'/><include filename='scene.xml'/></scene>";
    let start = Instant::now();
    refused(load(&folder.write("scene.xml", twice)), "include each other");
    assert!(start.elapsed().as_secs() < 5);
}

/// Every byte of a scene changed: whatever comes of it, it is no panic.
#[test]
fn damage_anywhere_is_survived() {
    let text = format!(
        "<scene version='3.0.0'>{LAMP}<shape type='cube'><bsdf type='roughconductor'><float name='alpha' value='0.1'/>\
        <spectrum name='eta' value='400:1,700:2'/></bsdf><transform name='to_world'><rotate x='1' angle='3'/></transform>\
        </shape><sensor type='thinlens'><float name='aperture_radius' value='1'/></sensor></scene>"
    );
    let folder = Folder::new();
    for at in 0..text.len() {
        for value in [b'0', b'-', b'<', b'\'', 0xff] {
            let mut damaged = text.clone().into_bytes();
            damaged[at] = value;
            let _ = load(&folder.write("scene.xml", &damaged));
        }
    }
}

#[test]
fn spectra_may_stand_where_textures_do() {
    let radiance = |texture: &str| {
        let texture = texture.replacen("<texture ", "<texture name='radiance' ", 1);
        let text = format!("<shape type='rectangle'><emitter type='area'>{texture}</emitter></shape>");
        let import = scene(&format!("<sensor type='perspective'/>{text}")).unwrap();
        let rgb = import.scene.materials[1].emission.value;
        (rgb, import.warnings.iter().map(|w| w.kind).collect::<Vec<_>>())
    };
    let scale = "<float name='scale' value='2'/>";
    let rgb = "<rgb name='color' value='1 2 3'/>";
    for (texture, expected) in [
        (format!("<texture type='d65'>{scale}</texture>"), Vec3::splat(2.0)),
        (format!("<texture type='d65'>{rgb}</texture>"), vec3(1.0, 2.0, 3.0)),
        (format!("<texture type='d65'>{scale}{rgb}</texture>"), vec3(2.0, 4.0, 6.0)),
        (
            format!("<texture type='d65'>{scale}<texture type='srgb'>{rgb}</texture></texture>"),
            vec3(2.0, 4.0, 6.0),
        ),
        ("<texture type='uniform'><float name='value' value='3'/></texture>".into(), Vec3::splat(3.0)),
        ("<texture type='uniform'/>".into(), Vec3::ONE),
    ] {
        assert_eq!(radiance(&texture), (expected, vec![]), "{texture}");
    }
    let warm = radiance("<texture type='blackbody'><float name='temperature' value='3000'/></texture>");
    assert!(warm.0.x > warm.0.y && warm.0.y > warm.0.z && warm.1 == [WarningKind::Approximation], "{warm:?}");
}

#[test]
fn spectra_may_be_plugins() {
    let reflectance = |spectrum: &str| {
        let (head, body) = spectrum.split_once('|').unwrap();
        let element = format!("<spectrum type='{head}' name='reflectance'>{body}</spectrum>");
        match material(&format!("<bsdf type='diffuse'>{element}</bsdf>")).surface {
            Surface::Diffuse { reflectance } => reflectance.value,
            other => panic!("{other:?}"),
        }
    };
    let uniform = "uniform|<float name='value' value='0.25'/>";
    assert_eq!(reflectance(uniform), Vec3::splat(0.25));
    assert_eq!(reflectance("d65|<float name='scale' value='0.5'/>"), Vec3::splat(0.5));
    let values = "<string name='values' value='0.2, 0.2'/>";
    let irregular = format!("irregular|<string name='wavelengths' value='400, 700'/>{values}");
    assert!(reflectance(&irregular).abs_diff_eq(Vec3::splat(0.2), 1e-5));
    for bound in ["wavelength", "lambda"] {
        let [min, max] = [("min", 400), ("max", 700)]
            .map(|(end, at)| format!("<float name='{bound}_{end}' value='{at}'/>"));
        assert!(reflectance(&format!("regular|{min}{max}{values}")).abs_diff_eq(Vec3::splat(0.2), 1e-5));
    }
    let coloured = "uniform|<rgb name='value' value='0.25 0.5 0.75'/>";
    assert_eq!(reflectance(coloured), vec3(0.25, 0.5, 0.75));
    let warm =
        reflectance("blackbody|<float name='temperature' value='3000'/><float name='scale' value='.1'/>");
    assert!(warm.x > warm.y && warm.y > warm.z, "{warm}");
    assert!(scene("<emitter type='constant'><spectrum type='odd' name='radiance'/></emitter>").is_err());
}
