//! Mitsuba's XML: what each plugin becomes.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod textures;

use std::f32::consts::FRAC_1_SQRT_2;

use common::Folder;
use glam::{Mat3, Mat4, Vec3, vec3};
use midway_import::{Import, ImportError, load};
use midway_scene::{
    Camera, ConductorFresnel, LightKind, Material, Opacity, Projection, Sides, SpotFalloff, Surface,
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

/// Asserts that a scene is refused with one line that says these words.
fn refused(result: Result<Import, ImportError>, words: &str) {
    let line = result.expect_err(words).to_string();
    assert!(!line.contains(char::is_control) && line.contains("scene.xml") && line.contains(words), "{line}");
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
