//! What pbrt files of both versions come to.

mod common;

use common::{Folder, load_bytes};
use glam::{Mat3, Mat4, Vec2, Vec3, vec2, vec3};
use midway_import::{Import, WarningKind, load};
use midway_scene::{
    ConductorFresnel, Filter, LightKind, Material, Opacity, Projection, Scene, Sides, SpotFalloff, Surface,
    Texels, Wrap,
};

/// A triangle in the plane z = 0 whose front is towards +z.
const TRIANGLE: &str = r#"Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]"#;
/// The custom of exporters: pbrt's world is right-handed then.
const HANDED: &str = "Scale -1 1 1\nCamera \"perspective\" \"float fov\" 90\n";

fn import(text: &str) -> Import {
    load_bytes("scene.pbrt", text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A world of these directives and a triangle.
fn world(text: &str) -> Import {
    import(&format!("{HANDED}WorldBegin\n{text}\n{TRIANGLE}"))
}

fn kinds(import: &Import) -> Vec<WarningKind> {
    import.warnings.iter().map(|w| w.kind).filter(|k| *k != WarningKind::NoLight).collect()
}

/// The material of the triangle, read without a warning.
fn material(text: &str) -> Material {
    let import = world(text);
    assert_eq!(kinds(&import), [], "{text}: {:?}", import.warnings);
    used(&import.scene)
}

fn used(scene: &Scene) -> Material {
    scene.materials[scene.meshes.last().unwrap().material as usize].clone()
}

fn near(a: Vec3, b: Vec3) {
    assert!((a - b).abs().max_element() <= 1e-5 * b.abs().max_element().max(1.0), "{a} is not {b}");
}

fn normals(scene: &Scene) -> Vec<Vec3> {
    scene.world_triangles().filter_map(|t| t.geometric_normal()).collect()
}

#[test]
fn transforms_compose_as_in_pbrt() {
    let corner = |text: &str| {
        let import = world(text);
        import.scene.world_triangles().next().unwrap().positions[1]
    };
    near(corner("Translate 1 2 3"), vec3(2.0, 2.0, 3.0));
    near(corner("Scale 2 1 1 Translate 1 0 0"), vec3(4.0, 0.0, 0.0));
    near(corner("Rotate 90 0 0 1"), vec3(0.0, 1.0, 0.0));
    near(corner("Translate 9 9 9 Identity"), vec3(1.0, 0.0, 0.0));
    near(corner("Transform [1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1]"), vec3(6.0, 6.0, 7.0));
    near(corner("Translate 1 0 0 ConcatTransform [2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1]"), vec3(3.0, 0.0, 0.0));
    near(corner("TransformBegin Translate 1 0 0 CoordinateSystem \"a\" TransformEnd"), vec3(1.0, 0.0, 0.0));
    near(
        corner("TransformBegin Translate 4 0 0 CoordinateSystem \"a\" TransformEnd CoordSysTransform \"a\""),
        vec3(5.0, 0.0, 0.0),
    );
    near(corner("Translate 1 0 0 CoordSysTransform \"world\""), vec3(1.0, 0.0, 0.0));
    near(corner("AttributeBegin Translate 1 0 0 AttributeEnd"), vec3(1.0, 0.0, 0.0));
    // The matrix takes the origin of the view to the eye.
    near(corner("LookAt 0 0 5  0 0 0  0 1 0"), vec3(-1.0, 0.0, 5.0));
}

#[test]
fn cameras_see_what_pbrts_see() {
    // Looking along +z from the origin, pbrt's own frame: left-handed.
    let own = import(&format!(
        "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100\n\
         Camera \"perspective\" \"float fov\" 60\nWorldBegin\nTranslate 1 0 5\n{TRIANGLE}"
    ));
    let camera = &own.scene.cameras[0];
    assert_eq!(camera.resolution, Some([200, 100]));
    assert!((camera.aspect.unwrap() - 2.0).abs() <= 1e-6);
    // The shorter axis has the field of view.
    assert!((camera.yfov().unwrap() - 60f32.to_radians()).abs() <= 1e-6);
    let seen = |import: &Import| {
        let camera_from_world = import.scene.cameras[0].world_from_camera.inverse();
        camera_from_world.transform_point3(import.scene.world_triangles().next().unwrap().positions[0])
    };
    // To the right and in front, in a camera that looks along -z.
    near(seen(&own), vec3(1.0, 0.0, -5.0));
    let flipped = import(&format!(
        "Scale -1 1 1\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\nTranslate 1 0 5\n{TRIANGLE}"
    ));
    near(seen(&flipped), vec3(-1.0, 0.0, -5.0));
    // The world is the file's own then.
    near(flipped.scene.world_triangles().next().unwrap().positions[0], vec3(1.0, 0.0, 5.0));

    let looked =
        import(&format!("LookAt 3 4 5  3 4 0  0 1 0\nCamera \"perspective\"\nWorldBegin\n{TRIANGLE}"));
    near(seen(&looked), vec3(3.0, -4.0, -5.0));
    for import in [own, flipped, looked] {
        assert!(import.scene.cameras[0].world_from_camera.determinant() > 0.0);
    }
}

#[test]
fn cameras_of_other_kinds_and_forms() {
    let camera = |text: &str| {
        let import = import(&format!("{text}\nWorldBegin\n{TRIANGLE}"));
        let kinds = kinds(&import);
        (import.scene.cameras[0].clone(), kinds)
    };
    let (tall, _) = camera(
        "Film \"rgb\" \"integer xresolution\" 100 \"integer yresolution\" 200\nCamera \"perspective\" \"float fov\" 90",
    );
    assert!((tall.yfov().unwrap() - 2.0 * 2f32.atan()).abs() <= 1e-6);
    let (lens, none) = camera(
        "Scale -0.5 0.5 0.5 Camera \"perspective\" \"float lensradius\" .1 \"float focaldistance\" 3 \
         \"float screenwindow\" [-1 1 -.5 .5]",
    );
    assert_eq!(none, []);
    assert!((lens.lens_radius - 0.2).abs() <= 1e-6 && (lens.focus_distance - 6.0).abs() <= 1e-5);
    assert!((lens.aspect.unwrap() - 2.0).abs() <= 1e-6);
    assert!((lens.yfov().unwrap() - 2.0 * 0.5f32.atan()).abs() <= 1e-6);
    let (parallel, none) = camera("Camera \"orthographic\" \"float screenwindow\" [-3 3 -2 2]");
    assert_eq!((parallel.projection, none), (Projection::Orthographic { height: 4.0 }, vec![]));
    let (off, warned) = camera("Camera \"orthographic\" \"float screenwindow\" [0 3 -2 2]");
    assert_eq!((off.aspect, warned), (Some(0.75), vec![WarningKind::Camera]));
    let (odd, warned) = camera("Translate 0 0 7 Camera \"spherical\"");
    assert_eq!(warned, [WarningKind::Camera]);
    near(odd.position(), vec3(0.0, 0.0, 7.0));
    let none = import(&format!("WorldBegin\n{TRIANGLE}"));
    assert_eq!(kinds(&none), [WarningKind::NoCamera]);
}

#[test]
fn fronts_are_where_pbrts_normals_point() {
    let of = |text: &str| normals(&world(text).scene)[0];
    near(of(""), Vec3::Z);
    near(of("ReverseOrientation"), Vec3::NEG_Z);
    near(of("ReverseOrientation ReverseOrientation"), Vec3::Z);
    // A mirror leaves the front where it is on the object.
    near(of("Scale -1 1 1"), Vec3::Z);
    near(of("Scale 1 1 -1"), Vec3::NEG_Z);
    // Shading normals decide.
    let given = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 -1 0 0 -1 0 0 -2]";
    let import = import(&format!("{HANDED}WorldBegin {given}"));
    near(normals(&import.scene)[0], Vec3::NEG_Z);
    assert_eq!(import.scene.meshes[0].normals, [Vec3::NEG_Z; 3]);
    let reversed = load_bytes("a.pbrt", format!("{HANDED}WorldBegin ReverseOrientation {given}")).unwrap();
    near(normals(&reversed.scene)[0], Vec3::Z);
    // The world turned round takes the front along.
    let turned = load_bytes("a.pbrt", format!("Camera \"perspective\" WorldBegin {TRIANGLE}")).unwrap();
    near(normals(&turned.scene)[0], Vec3::NEG_Z);
}

#[test]
fn shapes() {
    let area = |import: &Import| import.scene.world_triangles().map(|t| f64::from(t.area())).sum::<f64>();
    let shape = |text: &str| import(&format!("{HANDED}WorldBegin\n{text}"));
    let sphere =
        shape("Translate 1 0 0 Shape \"sphere\" \"float radius\" 2 Shape \"sphere\" Shape \"sphere\"");
    // One unit sphere, three times.
    assert_eq!((sphere.scene.meshes.len(), sphere.scene.instances.len()), (1, 3));
    assert!((area(&sphere) / (24.0 * std::f64::consts::PI) - 1.0).abs() <= 2e-3);
    assert!(normals(&sphere.scene).len() > 1000);
    let outward = sphere.scene.world_triangles().all(|t| {
        let from_centre = t.positions.iter().sum::<Vec3>() / 3.0 - Vec3::X;
        t.geometric_normal().is_none_or(|n| n.dot(from_centre) > 0.0)
    });
    assert!(outward);
    let quad = shape("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0] \"rgb unknown\" [1 1 1]");
    assert_eq!(quad.scene.counts().triangles, 2);
    assert!((area(&quad) - 2.0).abs() <= 1e-6);
    assert!(quad.warnings.iter().any(|w| w.kind == WarningKind::Unused && w.message.contains("unknown")));
    near(normals(&quad.scene)[0], Vec3::Z);
    let saddle = shape("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 1 0 1 1 1 1 0]");
    assert_eq!(saddle.scene.counts().triangles, 128);
    let control = shape(
        "Shape \"loopsubdiv\" \"integer levels\" 3 \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]",
    );
    assert_eq!(kinds(&control), [WarningKind::Approximation]);
    assert_eq!(control.scene.meshes[0].normals, [Vec3::Z; 3]);
    let curve = shape(&format!("Shape \"curve\" \"point3 P\" [0 0 0] Shape \"curve\" {TRIANGLE}"));
    assert_eq!(curve.warnings.iter().filter(|w| w.kind == WarningKind::Primitive).count(), 1);
    for kind in ["disk", "cylinder", "cone", "paraboloid"] {
        assert!(area(&shape(&format!("Shape \"{kind}\" \"float phimax\" 270"))) > 1.0, "{kind}");
    }
}

#[test]
fn ply_meshes_packed_or_not() {
    use std::io::Write;
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n";
    let folder = Folder::new();
    folder.write("a.ply", ply);
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packer.write_all(ply.as_bytes()).unwrap();
    folder.write("b.ply.gz", packer.finish().unwrap());
    let scene = folder.write(
        "scene.pbrt",
        format!("{HANDED}WorldBegin Shape \"plymesh\" \"string filename\" \"a.ply\" Shape \"plymesh\" \"string filename\" [\"b.ply.gz\"]"),
    );
    let scene = load(&scene).unwrap().scene;
    assert_eq!(scene.counts().triangles, 4);
    assert_eq!(scene.meshes[0], scene.meshes[1]);
    assert_eq!(scene.meshes[0].uvs[0][2], Vec2::ONE);
}

#[test]
fn instances_share_their_meshes() {
    let text = format!(
        "{HANDED}WorldBegin\nTranslate 0 0 1\nObjectBegin \"o\"\nTranslate 1 0 0\n{TRIANGLE}\n{TRIANGLE}\nObjectEnd\n\
         ObjectInstance \"o\"\nAttributeBegin Identity Scale 2 2 2 ObjectInstance \"o\" AttributeEnd\n"
    );
    let scene = import(&text).scene;
    assert_eq!((scene.meshes.len(), scene.instances.len(), scene.counts().triangles), (2, 4, 4));
    // The transform at the instance is over that at the definition.
    near(scene.instances[0].world_from_mesh.w_axis.truncate(), vec3(1.0, 0.0, 2.0));
    near(scene.instances[2].world_from_mesh.w_axis.truncate(), vec3(2.0, 0.0, 2.0));
}

#[test]
fn area_lights_shine_from_pbrts_side_with_pbrts_radiance() {
    let light = |text: &str| material(&format!("AreaLightSource \"diffuse\" {text}"));
    let of = |text: &str| light(text).emission.value;
    near(of("\"rgb L\" [1 2 3]"), vec3(1.0, 2.0, 3.0));
    near(of("\"rgb L\" [1 2 3] \"float scale\" 2"), vec3(2.0, 4.0, 6.0));
    assert_eq!(light("\"rgb L\" [1 1 1]").emits, Sides::Front);
    assert_eq!(light("\"rgb L\" [1 1 1] \"bool twosided\" true").emits, Sides::Both);
    // 1 nit of a black body, and of D65.
    let luminance = |rgb: Vec3| rgb.dot(vec3(0.2126, 0.7152, 0.0722));
    let warm = of("\"blackbody L\" 3000");
    assert!((luminance(warm) - 1.0).abs() <= 1e-3 && warm.x > 1.5 * warm.y && warm.y > warm.z, "{warm}");
    assert!((of("\"spectrum L\" \"stdillum-D65\"") - Vec3::ONE).abs().max_element() <= 2e-3);
    assert!((luminance(of("\"spectrum L\" [300 7 800 7]")) - 1.0).abs() <= 0.01);
    // The triangle has half a unit of area.
    near(of("\"float power\" 3"), Vec3::splat(6.0 / std::f32::consts::PI));
    near(of("\"float power\" 3 \"bool twosided\" [true]"), Vec3::splat(3.0 / std::f32::consts::PI));
    // An area light ends with its block, and those in objects do not shine.
    let after = world("AttributeBegin AreaLightSource \"diffuse\" AttributeEnd");
    assert!(!used(&after.scene).is_emissive());
    let object = world(&format!(
        "ObjectBegin \"o\" AreaLightSource \"diffuse\" {TRIANGLE} ObjectEnd ObjectInstance \"o\""
    ));
    assert_eq!(kinds(&object), [WarningKind::Light]);
    assert_eq!(object.scene.counts().emissive_triangles, 0);
    let absent = world(&format!("Material \"interface\" AreaLightSource \"diffuse\" {TRIANGLE}"));
    assert_eq!(kinds(&absent), [WarningKind::Light]);
    assert_eq!(absent.scene.counts().emissive_triangles, 0);
}

#[test]
fn the_film_and_the_shutter_expose() {
    let emission = |film: &str| {
        let import = import(&format!(
            "Film \"rgb\" {film}\nScale -1 1 1 Camera \"perspective\" \"float shutterclose\" 0.5\nWorldBegin\n\
             LightSource \"point\" \"rgb I\" [4 4 4]\nLightSource \"infinite\" \"rgb L\" [4 4 4]\n\
             AreaLightSource \"diffuse\" \"rgb L\" [4 4 4]\n{TRIANGLE}"
        ));
        let LightKind::Point { intensity, .. } = import.scene.lights[0].kind else { panic!("no point") };
        let sky = import.scene.environment.as_ref().unwrap().radiance;
        [used(&import.scene).emission.value.x, intensity.x, sky.x]
    };
    assert_eq!(emission(""), [2.0; 3]);
    assert_eq!(emission("\"float iso\" 200"), [4.0; 3]);
}

#[test]
fn lights_without_extent() {
    let light = |text: &str| {
        let import = world(text);
        assert_eq!(kinds(&import), [], "{text}: {:?}", import.warnings);
        import.scene.lights[0].kind
    };
    let LightKind::Point { position, intensity } = light(
        "Translate 1 0 0 LightSource \"point\" \"rgb I\" [1 2 3] \"float scale\" 2 \"point3 from\" [0 1 0]",
    ) else {
        panic!("not a point");
    };
    near(position, vec3(1.0, 1.0, 0.0));
    near(intensity, vec3(2.0, 4.0, 6.0));
    let LightKind::Point { intensity, .. } = light("LightSource \"point\" \"float power\" 12.566371") else {
        panic!("not a point");
    };
    near(intensity, Vec3::ONE);
    let LightKind::Spot { position, direction, intensity, inner_angle, outer_angle, falloff } = light(
        "LightSource \"spot\" \"rgb I\" [1 1 1] \"point3 from\" [0 5 0] \"point3 to\" [0 0 0] \
         \"float coneangle\" 40 \"float conedeltaangle\" 10",
    ) else {
        panic!("not a spot");
    };
    near(position, vec3(0.0, 5.0, 0.0));
    near(direction, Vec3::NEG_Y);
    near(intensity, Vec3::ONE);
    near(vec3(inner_angle, outer_angle, 0.0), vec3(30f32.to_radians(), 40f32.to_radians(), 0.0));
    assert_eq!(falloff, SpotFalloff::Smoothstep);
    light("LightSource \"spot\" \"float conedeltaangle\" 0");
    let LightKind::Directional { direction, irradiance } =
        light("LightSource \"distant\" \"rgb L\" [3 3 3] \"point3 from\" [0 2 0] \"point3 to\" [0 1 0]")
    else {
        panic!("not directional");
    };
    near(direction, Vec3::NEG_Y);
    near(irradiance, Vec3::splat(3.0));
    for kind in ["goniometric", "projection"] {
        let import = world(&format!("LightSource \"{kind}\" \"string filename\" \"none.png\""));
        assert_eq!((kinds(&import), import.scene.lights.len()), (vec![WarningKind::Light], 1));
    }
}

#[test]
fn infinite_lights() {
    let constant =
        world("LightSource \"infinite\" \"rgb L\" [1 2 3] LightSource \"infinite\" \"rgb L\" [1 1 1]");
    assert_eq!(kinds(&constant), []);
    let sky = constant.scene.environment.unwrap();
    assert_eq!((sky.radiance, sky.image), (vec3(2.0, 3.0, 4.0), None));
    let lux = world("LightSource \"infinite\" \"float illuminance\" 3.1415927 \"point3 portal\" [0 0 0]");
    near(lux.scene.environment.unwrap().radiance, Vec3::ONE);

    // Latitude and longitude: the top row is +z of the light, the first column +x.
    let folder = Folder::new();
    let mut texels = vec![[0u8; 3]; 8 * 4];
    texels[..8].fill([255, 0, 0]);
    folder.write("sky.png", png(8, 4, &texels));
    let light = "LightSource \"infinite\" \"string mapname\" \"sky.png\" \"rgb L\" [2 2 2]";
    let path = folder.write(
        "scene.pbrt",
        format!(
            "{HANDED}WorldBegin AttributeBegin Rotate -90 1 0 0 {light} AttributeEnd {TRIANGLE} WorldEnd"
        ),
    );
    let scene = load(&path).unwrap().scene;
    let sky = scene.environment.unwrap();
    assert_eq!(sky.radiance, Vec3::splat(2.0));
    let image = &scene.images[sky.image.unwrap() as usize];
    assert_eq!((image.width, image.height), (8, 4));
    assert_eq!(image.texels.linear(3)[0], 1.0);
    assert_eq!(image.texels.linear(20)[0], 0.0);
    // z of the light is y of this world, as it is of the environment.
    let up = sky.world_from_environment * Vec3::Y;
    near(up, Vec3::Y);
    let m = sky.world_from_environment.as_dmat3();
    assert!((m.determinant() - 1.0).abs() <= 1e-6);
}

fn png(width: u32, height: u32, rgb: &[[u8; 3]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let buffer = image::RgbImage::from_raw(width, height, rgb.as_flattened().to_vec()).unwrap();
    buffer.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

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

#[test]
fn files_within_files() {
    let folder = Folder::new();
    folder.write("geometry/a.pbrt", format!("Translate 1 0 0\nInclude \"geometry/b.pbrt\"\n{TRIANGLE}"));
    folder.write("geometry/b.pbrt", "Translate 0 1 0");
    let place = |directive: &str| {
        let path = folder
            .write("scene.pbrt", format!("{HANDED}WorldBegin {directive} \"geometry/a.pbrt\"\n{TRIANGLE}"));
        let scene = load(&path).unwrap().scene;
        assert_eq!(scene.instances.len(), 2);
        scene.instances[1].world_from_mesh.w_axis.truncate()
    };
    assert_eq!(place("Include"), vec3(1.0, 1.0, 0.0));
    // What is imported leaves the state alone.
    assert_eq!(place("Import"), Vec3::ZERO);
}

#[test]
fn directives_without_a_picture_are_read_over() {
    let import = import(&format!(
        "Option \"disablepixeljitter\" true\nSampler \"halton\" \"integer pixelsamples\" 16\nPixelFilter \"gaussian\" \"float xradius\" 2\n\
         Integrator \"volpath\" \"integer maxdepth\" [ 7 ]\nAccelerator \"bvh\"\nColorSpace \"srgb\"\n{HANDED}\
         WorldBegin # the rest is the world\n{TRIANGLE}"
    ));
    assert_eq!(kinds(&import), []);
    let moving = world("ActiveTransform EndTime Translate 9 0 0 ActiveTransform All TransformTimes 0 1");
    assert_eq!(moving.warnings.iter().filter(|w| w.kind == WarningKind::Animation).count(), 1);
    assert_eq!(moving.scene.instances[0].world_from_mesh, Mat4::IDENTITY);
    assert_eq!(Mat3::from_mat4(moving.scene.instances[0].world_from_mesh), Mat3::IDENTITY);
}
