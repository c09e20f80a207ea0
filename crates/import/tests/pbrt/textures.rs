//! Textures, what is made of them, and spectra.

use glam::{Vec2, Vec3, vec2, vec3};
use midway_import::{Import, WarningKind, load};
use midway_scene::{Filter, Opacity, Surface, Texels, Wrap};

use crate::{HANDED, TRIANGLE, common::Folder, kinds, material, near, png, used, world};

#[test]
fn textures() {
    let folder = Folder::new();
    folder.write("a.png", png(2, 1, &[[255, 0, 0], [0, 0, 255]]));
    let load_with = |text: &str| {
        let text = format!(
            "{HANDED}WorldBegin\n{text}\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n{TRIANGLE}"
        );
        load(&folder.write("scene.pbrt", text)).unwrap_or_else(|e| panic!("{e}"))
    };
    let reflectance = |import: &Import| match used(&import.scene).surface {
        Surface::Diffuse { reflectance } => reflectance,
        other => panic!("{other:?}"),
    };
    let image = load_with(
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"float scale\" .5 \"string wrap\" \"clamp\" \
         \"string filter\" \"point\" \"float uscale\" 2 \"float vdelta\" .25",
    );
    assert_eq!(kinds(&image), []);
    let found = reflectance(&image);
    assert_eq!(found.value, Vec3::splat(0.5));
    let texture = found.texture.unwrap();
    assert_eq!((texture.wrap, texture.filter), ([Wrap::Clamp; 2], Filter::Nearest));
    // pbrt's v goes upwards.
    assert!((texture.place(vec2(0.25, 0.5)) - vec2(0.5, 0.25)).length() <= 1e-6);
    assert!(matches!(image.scene.images[texture.image as usize].texels, Texels::Srgb8(_)));
    // A mesh without texture coordinates has pbrt's.
    assert_eq!(image.scene.meshes[0].uvs[0], [Vec2::ZERO, Vec2::X, Vec2::ONE]);

    let inverted = load_with(
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"bool invert\" true \"string encoding\" \"linear\"",
    );
    let texture = reflectance(&inverted).texture.unwrap();
    let texel = inverted.scene.images[texture.image as usize].texels.linear(0);
    assert_eq!(texel, [0.0, 1.0, 1.0, 1.0]);

    let checks = load_with(
        "Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4 \
         \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 1 0]",
    );
    let texture = reflectance(&checks).texture.unwrap();
    let at = |u: f32, v: f32| {
        let place = texture.place(vec2(u, v)).rem_euclid(Vec2::ONE) * 2.0;
        let image = &checks.scene.images[texture.image as usize];
        image.texels.linear(place.y as usize * 2 + place.x as usize)[0]
    };
    assert_eq!([at(0.1, 0.1), at(0.3, 0.1), at(0.3, 0.3), at(0.1, 0.6)], [1.0, 0.0, 1.0, 1.0]);

    let constant = "Texture \"c\" \"spectrum\" \"constant\" \"rgb value\" [.5 .5 .5]";
    let scaled = load_with(&format!(
        "{constant} Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"float scale\" .5"
    ));
    assert_eq!(reflectance(&scaled), Vec3::splat(0.25).into());
    let mixed = load_with(&format!(
        "{constant} Texture \"t\" \"color\" \"mix\" \"texture tex1\" \"c\" \"rgb tex2\" [1 1 1] \"float amount\" .5"
    ));
    assert_eq!(reflectance(&mixed), Vec3::splat(0.75).into());
    for class in ["fbm", "wrinkled", "marble", "dots", "bilerp", "ptex", "directionmix", "nonsense"] {
        let import = load_with(&format!("Texture \"t\" \"spectrum\" \"{class}\""));
        assert_eq!(import.warnings.iter().filter(|w| w.kind != WarningKind::NoLight).count(), 1, "{class}");
    }
    let missing = load_with("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"");
    assert_eq!(kinds(&missing), [WarningKind::MissingFile]);
    assert_eq!(kinds(&load_with("")), [WarningKind::Texture]);
}

#[test]
fn images_that_lie_alike_mix_and_multiply() {
    let folder = Folder::new();
    folder.write("a.png", png(2, 1, &[[51; 3], [255; 3]]));
    folder.write("b.png", png(1, 1, &[[102; 3]]));
    let read = |texture: &str, scale: f32| {
        let image = |kind: &str, name: &str, scale: f32| {
            format!(
                "Texture \"{kind}-{name}\" \"{kind}\" \"imagemap\" \"string filename\" \"{name}.png\" \
                 \"string encoding\" \"linear\" \"float uscale\" {scale}\n"
            )
        };
        let images = image("spectrum", "a", 1.0) + &image("spectrum", "b", scale) + &image("float", "a", 1.0);
        let material = "Material \"diffuse\" \"texture reflectance\" \"t\"";
        let text = format!(
            "{HANDED}WorldBegin\n{images}Texture \"t\" \"spectrum\" {texture}\n{material}\n{TRIANGLE}"
        );
        let import = load(&folder.write("scene.pbrt", text)).unwrap_or_else(|e| panic!("{e}"));
        let Surface::Diffuse { reflectance } = used(&import.scene).surface else { panic!() };
        let texels = &import.scene.images[reflectance.texture.as_ref().unwrap().image as usize].texels;
        let values: Vec<f32> = (0..texels.len()).map(|i| reflectance.value.x * texels.linear(i)[0]).collect();
        (values, kinds(&import))
    };
    let product = "\"scale\" \"texture tex1\" \"spectrum-a\" \"texture tex2\" \"spectrum-b\"";
    let by_number = "\"scale\" \"texture tex\" \"spectrum-b\" \"texture scale\" \"float-a\"";
    let mix = "\"mix\" \"texture tex1\" \"spectrum-a\" \"texture tex2\" \"spectrum-b\" \"float amount\" .5";
    let by_image =
        "\"mix\" \"texture tex1\" \"spectrum-a\" \"rgb tex2\" [2 2 2] \"texture amount\" \"float-a\"";
    for (texture, expected) in
        [(product, [0.08, 0.4]), (by_number, [0.08, 0.4]), (mix, [0.3, 0.7]), (by_image, [0.56, 2.0])]
    {
        let (values, warnings) = read(texture, 1.0);
        let near = values.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-4) && values.len() == 2;
        assert!(near, "{texture}: {values:?}");
        // Twice the light is cut.
        let cut = if texture == by_image { vec![WarningKind::Repaired] } else { vec![] };
        assert_eq!(warnings, cut, "{texture}");
    }
    for texture in [product, mix] {
        assert_eq!(read(texture, 2.0).1, [WarningKind::Approximation], "{texture}");
    }
}

/// A factor above 1 is for dark images: it counts where the product is below 1, and what is cut is said.
#[test]
fn textures_keep_factors_above_1() {
    let folder = Folder::new();
    folder.write("dark.png", png(2, 1, &[[20; 3], [60; 3]]));
    folder.write("light.png", png(2, 1, &[[20; 3], [250; 3]]));
    let read = |texture: &str| {
        let material = "Material \"diffuse\" \"texture reflectance\" \"t\"";
        let image =
            "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"dark.png\" \"float scale\" .5";
        let text = format!("{HANDED}WorldBegin\n{image}\n{texture}\n{material}\n{TRIANGLE}");
        let import = load(&folder.write("scene.pbrt", text)).unwrap();
        let Surface::Diffuse { reflectance } = used(&import.scene).surface else { panic!() };
        (reflectance.value.x, reflectance.texture.is_some(), kinds(&import))
    };
    let image = |file: &str, scale: f32| {
        format!(
            "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\" \"float scale\" {scale}"
        )
    };
    let constant = |value: f32| {
        format!("Texture \"c\" \"spectrum\" \"constant\" \"rgb value\" [{value} {value} {value}]")
    };
    let product = |tex: &str, scale: f32| {
        format!("Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"{tex}\" \"float scale\" {scale}")
    };
    for (texture, value, is_image, warnings) in [
        (image("dark.png", 4.0), 4.0, true, vec![]),
        (image("light.png", 4.0), 4.0, true, vec![WarningKind::Repaired]),
        (product("i", 6.0), 3.0, true, vec![]),
        (format!("{}\n{}", constant(4.0), product("c", 0.125)), 0.5, false, vec![]),
        (format!("{}\n{}", constant(0.25), product("c", 2.0)), 0.5, false, vec![]),
        (format!("{}\n{}", constant(0.75), product("c", 2.0)), 1.0, false, vec![WarningKind::Repaired]),
    ] {
        assert_eq!(read(&texture), (value, is_image, warnings), "{texture}");
    }
    let import = world("Material \"diffuse\" \"rgb reflectance\" [1.5 .5 .5]");
    assert_eq!(used(&import.scene).surface, Surface::diffuse(vec3(1.0, 0.5, 0.5)));
    assert_eq!(kinds(&import), [WarningKind::Repaired]);
    let alpha = "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"dark.png\" \"float scale\" 4";
    let text = format!("{HANDED}WorldBegin\n{alpha}\n{TRIANGLE} \"texture alpha\" \"a\"");
    let import = load(&folder.write("scene.pbrt", text)).unwrap();
    assert!(matches!(used(&import.scene).opacity, Opacity::Blend(input) if input.value == 4.0));
}

/// Texels above 1 are multiplied before they are cut.
#[test]
fn factors_below_1_darken_floats() {
    let folder = Folder::new();
    // One texel of 4: mantissas 128, exponent 131.
    let texel = [128u8, 128, 128, 131];
    let hdr = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".as_slice(), &texel].concat();
    folder.write("bright.hdr", hdr);
    let alpha =
        "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"bright.hdr\" \"float scale\" .125";
    let text = format!("{HANDED}WorldBegin\n{alpha}\n{TRIANGLE} \"texture alpha\" \"a\"");
    let import = load(&folder.write("scene.pbrt", text)).unwrap();
    let Opacity::Blend(input) = used(&import.scene).opacity else { panic!() };
    let image = &import.scene.images[input.texture.unwrap().0.image as usize];
    assert!((input.value * image.texels.linear(0)[0] - 0.5).abs() <= 1e-4);
}

/// A small file of many texels that many textures are made of, alike and each in its own way.
#[test]
fn images_made_of_images_are_bounded_by_their_files() {
    let folder = Folder::new();
    let side = 4096;
    let file = png(side, side, &vec![[0; 3]; (side * side) as usize]);
    folder.write("black.png", &file);
    let read = |scale: &dyn Fn(usize) -> f32| {
        let textures: String = (1..=12)
            .map(|i| {
                let scale = scale(i);
                format!(
                    "Texture \"t{i}\" \"float\" \"imagemap\" \"string filename\" \"black.png\" \"float scale\" {scale}\n"
                )
            })
            .collect();
        let text = format!("{HANDED}WorldBegin\n{textures}{TRIANGLE}");
        load(&folder.write("scene.pbrt", text)).unwrap()
    };
    let alike = read(&|_| 0.5);
    assert_eq!((alike.scene.images.len(), kinds(&alike)), (1, vec![]));
    let apart = read(&|i| 0.05 * i as f32);
    let made: usize = apart.scene.images.iter().map(|image| image.texels.len()).sum();
    // The file's own texels count too.
    let limit = (1 << 26) + 512 * file.len() - (side * side) as usize;
    assert!(made <= limit && made > (side * side) as usize, "{made} {limit}");
    assert_eq!(kinds(&apart), [WarningKind::Texture]);
}

#[test]
fn images_mix_materials_and_shine_on_cloth() {
    let folder = Folder::new();
    folder.write("a.png", png(2, 1, &[[0; 3], [51; 3]]));
    let read = |text: &str| {
        let image = "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\" \"string encoding\" \"linear\"";
        let text = format!("{HANDED}WorldBegin\n{image}\n{text}\n{TRIANGLE}");
        let import = load(&folder.write("scene.pbrt", text)).unwrap_or_else(|e| panic!("{e}"));
        let texels = &import.scene.images.last().unwrap().texels;
        let texels: Vec<f32> = (0..texels.len()).map(|i| texels.linear(i)[0]).collect();
        (used(&import.scene).surface, texels, kinds(&import))
    };
    let diffuse = |name: &str, grey: f32| {
        format!(
            "MakeNamedMaterial \"{name}\" \"string type\" \"diffuse\" \"rgb reflectance\" [{grey} {grey} {grey}]\n"
        )
    };
    let parts = diffuse("x", 1.0) + &diffuse("y", 0.0);
    let mix = "Material \"mix\" \"string materials\" [\"x\" \"y\"] \"texture amount\" \"a\"";
    let (surface, texels, warnings) = read(&format!("{parts}{mix}"));
    assert!(matches!(surface, Surface::Diffuse { reflectance } if reflectance.texture.is_some()));
    assert!((texels[0] - 1.0).abs() + (texels[1] - 0.8).abs() <= 1e-4, "{texels:?}");
    assert_eq!(warnings, []);

    let cloth = "Material \"disney\" \"rgb color\" [0 .5 0] \"texture sheen\" \"a\" \"float sheentint\" 1";
    let (surface, texels, warnings) = read(cloth);
    assert!(matches!(surface, Surface::MetallicRoughness(model) if model.sheen_color.texture.is_some()));
    // Green alone, of luminance 1.
    assert_eq!(texels, [0.0, 0.0]);
    assert_eq!(warnings, [WarningKind::Approximation]);
}

#[test]
fn alpha_by_number_and_texture() {
    let folder = Folder::new();
    folder.write("a.png", png(2, 1, &[[255; 3], [0; 3]]));
    let read = |alpha: &str, end: &str| {
        let text = format!(
            "{HANDED}WorldBegin\nTexture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\"\n{TRIANGLE} {alpha}\n{end}"
        );
        let import = load(&folder.write("scene.pbrt", text)).unwrap();
        assert_eq!(kinds(&import), []);
        used(&import.scene).opacity
    };
    assert_eq!(read("\"float alpha\" 1", ""), Opacity::Opaque);
    assert_eq!(read("\"float alpha\" .25", ""), Opacity::Blend(0.25.into()));
    assert!(matches!(read("\"texture alpha\" \"a\"", ""), Opacity::Blend(input) if input.texture.is_some()));
    assert!(
        matches!(read("\"texture alpha\" \"a\"", "WorldEnd"), Opacity::Mask(input, _) if input.texture.is_some())
    );
}

#[test]
fn colours_by_space_and_spectrum() {
    let reflectance = |text: &str| match material(&format!("{text} ")).surface {
        Surface::Diffuse { reflectance } => reflectance.value,
        other => panic!("{other:?}"),
    };
    let wide = reflectance("ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [.5 .5 .2]");
    assert!((wide.x - 0.5).abs() <= 0.05 && wide.z < 0.2, "{wide}");
    let flat = reflectance("Material \"diffuse\" \"spectrum reflectance\" [400 .3 700 .3]");
    near(flat, Vec3::splat(0.3));
    let folder = Folder::new();
    folder.write("red.spd", "# nm\n400 0\n600 0\n610 1\n800 1\n");
    let path = folder.write(
        "scene.pbrt",
        format!("{HANDED}WorldBegin Material \"diffuse\" \"spectrum reflectance\" \"red.spd\" {TRIANGLE}"),
    );
    let Surface::Diffuse { reflectance } = used(&load(&path).unwrap().scene).surface else {
        panic!("not diffuse")
    };
    assert!(reflectance.value.x > 0.3 && reflectance.value.y < 0.1, "{}", reflectance.value);
}
