//! Materials of both versions.

use glam::{Vec3, vec3};
use midway_import::{WarningKind, load};
use midway_scene::{ConductorFresnel, Opacity, Surface};

use crate::{HANDED, TRIANGLE, common::Folder, import, kinds, material, png, used, world};

#[test]
fn materials_of_version_4() {
    let surface = |text: &str| material(text).surface;
    assert_eq!(surface(""), Surface::diffuse(Vec3::splat(0.5)));
    assert_eq!(
        surface("Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]"),
        Surface::diffuse(vec3(0.1, 0.2, 0.3))
    );
    let Surface::Plastic { reflectance, ior, roughness, nonlinear, .. } = surface(
        "Material \"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] \"float roughness\" .25 \"float eta\" 1.4",
    ) else {
        panic!("not plastic");
    };
    assert_eq!(
        (reflectance.value, ior, roughness.along.value, nonlinear),
        (vec3(0.1, 0.2, 0.3), 1.4, 0.5, true)
    );
    let Surface::Conductor { fresnel: ConductorFresnel::Complex { eta, k, .. }, roughness } = surface(
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \
         \"float uroughness\" .1 \"float vroughness\" .2 \"bool remaproughness\" false",
    ) else {
        panic!("not a conductor");
    };
    assert!(eta.z > eta.x && k.x > k.z, "{eta} {k}");
    assert_eq!((roughness.along.value, roughness.across.value, roughness.squared), (0.1, 0.2, false));
    let Surface::Dielectric { ior, thin, .. } =
        surface("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"")
    else {
        panic!("not a dielectric");
    };
    assert!((ior - 1.5168).abs() <= 1e-4 && !thin);
    assert!(matches!(surface("Material \"thindielectric\""), Surface::Dielectric { thin: true, .. }));
    assert_eq!(surface("Material \"interface\""), Surface::Null);
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 0 0] \
                 MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 0 1]";
    assert_eq!(surface(&format!("{named} NamedMaterial \"b\"")), Surface::diffuse(Vec3::Z));
    assert_eq!(
        surface(&format!("{named} Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25")),
        Surface::diffuse(vec3(0.75, 0.0, 0.25))
    );
    // The state's defaults.
    assert_eq!(
        surface("Attribute \"material\" \"rgb reflectance\" [0 1 0] Material \"diffuse\""),
        Surface::diffuse(Vec3::Y)
    );
    for kind in ["diffusetransmission", "coatedconductor", "hair", "subsurface", "measured", "nonsense"] {
        let import = world(&format!("Material \"{kind}\""));
        assert_eq!(kinds(&import), [WarningKind::Approximation], "{kind}");
    }
    // Absorption, where it has a place.
    let medium = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 2 3] \"float scale\" 2 \
                  MediumInterface \"m\" \"\"";
    let Surface::Dielectric { sigma_a, .. } = surface(&format!("{medium} Material \"dielectric\"")) else {
        panic!("not a dielectric");
    };
    assert_eq!(sigma_a, vec3(2.0, 4.0, 6.0));
}

/// Version 4 looks names up when all of the file is read.
#[test]
fn materials_may_be_named_before_they_are_defined() {
    let folder = Folder::new();
    folder.write("a.png", png(1, 1, &[[255; 3]]));
    let image = "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\"";
    let read = |shapes: &str, definitions: &str| {
        let text = format!("{HANDED}WorldBegin\n{shapes}\n{TRIANGLE}\n{image}\n{definitions}");
        let import = load(&folder.write("scene.pbrt", text)).unwrap_or_else(|e| panic!("{e}"));
        let found = kinds(&import);
        (import, found)
    };
    let red = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 0 0]";
    let black = "MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 0 0]";
    let (import, warnings) = read("NamedMaterial \"a\"", red);
    assert_eq!((used(&import.scene).surface, warnings), (Surface::diffuse(Vec3::X), vec![]));
    assert_eq!(used(&import.scene).name, "a");

    let textured = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"texture reflectance\" \"i\"";
    let (import, warnings) = read("NamedMaterial \"a\"", textured);
    assert_eq!((import.scene.meshes[0].uvs[0].len(), warnings), (3, vec![]));

    // A lamp keeps its light, and one on what is not there has none.
    let lamp = "NamedMaterial \"a\" AreaLightSource \"diffuse\" \"rgb L\" [1 2 3]";
    let (import, _) = read(lamp, red);
    assert_eq!(used(&import.scene).emission, vec3(1.0, 2.0, 3.0).into());
    let (import, _) = read(lamp, "MakeNamedMaterial \"a\" \"string type\" \"interface\"");
    assert!(!used(&import.scene).is_emissive());

    let mix = |name: &str, a: &str, b: &str| {
        format!("MakeNamedMaterial \"{name}\" \"string type\" \"mix\" \"string materials\" [\"{a}\" \"{b}\"]")
    };
    let definitions = format!("{}\n{}\n{black}\n{red}", mix("n", "m", "b"), mix("m", "a", "b"));
    let (import, warnings) = read("NamedMaterial \"n\"", &definitions);
    assert_eq!((used(&import.scene).surface, warnings), (Surface::diffuse(Vec3::X / 4.0), vec![]));

    // What never comes, and what comes of itself.
    let (import, warnings) = read("NamedMaterial \"a\"", "");
    assert_eq!((used(&import.scene).surface, warnings.len()), (Surface::diffuse(Vec3::splat(0.8)), 1));
    let (_, warnings) = read("NamedMaterial \"a\"", &format!("{black}\n{}", mix("a", "a", "b")));
    assert_eq!(warnings, [WarningKind::Approximation]);

    // However long the way, and to what never comes.
    let chain = |end: &str| {
        let links: String =
            (0..100).map(|i| mix(&format!("m{i}"), &format!("m{}", i + 1), "b") + "\n").collect();
        let (import, warnings) =
            read("NamedMaterial \"m60\"", &format!("{links}{black}\n{}", end.replace("\"a\"", "\"m100\"")));
        (used(&import.scene).surface, warnings)
    };
    let (surface, warnings) = chain(red);
    let Surface::Diffuse { reflectance } = surface else { panic!("{surface:?}") };
    assert_eq!((reflectance.value.x > 0.0, reflectance.value.y, warnings), (true, 0.0, vec![]));
    assert_eq!(chain("").1, [WarningKind::Approximation]);
}

#[test]
fn materials_of_version_3() {
    let read = |text: &str| {
        let import = import(&format!(
            "{HANDED}WorldBegin\nMaterial {text}\n{TRIANGLE}\nWorldEnd\nnothing more is read"
        ));
        (used(&import.scene), kinds(&import))
    };
    let surface = |text: &str| {
        let (material, kinds) = read(text);
        assert_eq!(kinds, [], "{text}");
        material.surface
    };
    assert_eq!(surface("\"matte\" \"color Kd\" [.1 .2 .3]"), Surface::diffuse(vec3(0.1, 0.2, 0.3)));
    let Surface::Conductor { fresnel: ConductorFresnel::Complex { eta, tint, .. }, .. } =
        surface("\"mirror\" \"rgb Kr\" [.5 .5 .5]")
    else {
        panic!("not a mirror");
    };
    assert_eq!((eta, tint.value), (Vec3::ZERO, Vec3::splat(0.5)));
    assert!(matches!(surface("\"glass\" \"float index\" 1.3"), Surface::Dielectric { ior: 1.3, .. }));
    assert!(matches!(surface("\"metal\""), Surface::Conductor { .. }));
    assert_eq!(surface("\"none\""), Surface::Null);
    let approximated = vec![WarningKind::Approximation];
    for kind in ["plastic", "substrate", "translucent", "disney", "fourier", "kdsubsurface"] {
        assert_eq!(read(&format!("\"{kind}\"")).1, approximated, "{kind}");
    }
    let (uber, _) = read("\"uber\" \"rgb opacity\" [.25 .25 .25]");
    assert_eq!(uber.opacity, Opacity::Blend(0.25.into()));
    assert!(matches!(read("\"uber\" \"rgb Kt\" [1 1 1]").0.surface, Surface::Dielectric { .. }));
    let disney = read("\"disney\" \"float clearcoat\" 1").0.surface;
    let Surface::MetallicRoughness(disney) = disney else { panic!("{disney:?}") };
    assert_eq!(disney.clearcoat.value, 0.25);
    assert_eq!(read("\"matte\" \"float sigma\" 20").1, approximated);
    // v3's lights take spectra as they are.
    let lit = import(&format!(
        "WorldBegin AreaLightSource \"diffuse\" \"blackbody L\" [3000 5]\n{TRIANGLE}\nWorldEnd"
    ));
    let emission = used(&lit.scene).emission.value;
    assert!(emission.y > 1.5 && emission.y < 5.0, "{emission}");
}
