//! What pbrt files of both versions come to.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod materials;
mod textures;

use common::{Folder, load_bytes};
use glam::{Mat3, Mat4, Vec2, Vec3, vec3};
use midway_import::{Import, WarningKind, load};
use midway_scene::{LightKind, Material, Projection, Scene, Sides, SpotFalloff};

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
