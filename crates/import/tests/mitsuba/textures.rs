//! Textures, spectra and mixtures of BSDFs.

use std::time::Instant;

use glam::{Vec2, Vec3, vec3};
use midway_import::{WarningKind, load};
use midway_scene::{Channel, ConductorFresnel, Filter, Opacity, Surface, Texels, Wrap};

use crate::{LAMP, bmp, common::Folder, material, refused, scene};

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
