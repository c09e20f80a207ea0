//! Changes between passes give what a renderer made that way from the start gives, bit for bit.

use std::{
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use glam::{Mat3, Vec3};
use midway_device::{CpuDevice, Device, DeviceKind};
use midway_film::{Display, Image, ToneMap};
use midway_render::{
    Aov, Crop, Integrator, IntegratorSettings, Join, LightPaths, LightSampling, PackedScene, RenderError,
    RenderSettings, Renderer, Rng,
};
use midway_scene::{
    Camera, Environment, Image as Texture, Material, Opacity, Scene, Surface, Surround, Texels,
};

const SIZE: u32 = 24;

fn device() -> Arc<dyn Device> {
    Arc::new(CpuDevice::new(Some(2)).expect("starts"))
}

fn load(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
    midway_import::load(&path).expect("the repository's scenes load").scene
}

fn by(integrator: IntegratorSettings) -> RenderSettings {
    RenderSettings { width: SIZE, height: SIZE, seed: 7, integrator, ..RenderSettings::default() }
}

fn path() -> IntegratorSettings {
    IntegratorSettings::default()
}

fn full() -> IntegratorSettings {
    IntegratorSettings { integrator: Integrator::Bdpt, ..path() }
}

fn k_step(k: u32) -> IntegratorSettings {
    IntegratorSettings { join: Join::KStep, k, ..full() }
}

fn pool(k: u32) -> IntegratorSettings {
    IntegratorSettings { light_paths: LightPaths::Pool(None), ..k_step(k) }
}

fn renderer(scene: &Scene, camera: &Camera, settings: RenderSettings) -> Renderer {
    Renderer::new(device(), scene, camera, settings).expect("fits")
}

fn run(renderer: &mut Renderer, samples: u64) -> Image {
    while renderer.samples() < samples {
        renderer.step(samples - renderer.samples()).expect("renders");
    }
    renderer.image().expect("reads")
}

fn fresh(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Image {
    run(&mut renderer(scene, camera, settings.clone()), 2)
}

#[test]
fn every_ray_of_a_sample_is_recorded() {
    let scene = load("glass-caustic.gltf");
    // More pixels than a lane's batch has paths.
    let (width, height) = (48, 40);
    let light = IntegratorSettings { integrator: Integrator::Light, ..path() };
    for integrator in [path(), light, full(), k_step(2)] {
        let settings = RenderSettings { width, height, ..by(integrator) };
        let mut renderer = renderer(&scene, &scene.cameras[0], settings);
        let before = renderer.stats().expect("reads").rays;
        run(&mut renderer, 1);
        let traced = renderer.stats().expect("reads").rays - before;
        renderer.restart().expect("restarts");
        let recorded = renderer.record_rays().expect("reads");
        let rays = |rays: &[[f32; 4]]| rays.len() as u64 / 2;
        let bounces = recorded.iter().flatten();
        let n: u64 = bounces.map(|bounce| rays(&bounce.closest) + rays(&bounce.shadow)).sum();
        assert!(recorded.len() > 1, "several batches");
        // A path that waits a turn with joins left is counted again.
        let again = if integrator.joins().is_some() { traced / 200 } else { 0 };
        assert!(n <= traced && n + again >= traced, "{:?}: {n} of {traced}", integrator.integrator);
    }
}

#[test]
fn settings_changed_between_passes_are_those_of_a_new_renderer() {
    let scene = load("cornell-box.gltf");
    let camera = &scene.cameras[0];
    let crop = Some(Crop { x: 3, y: 5, width: 11, height: 7 });
    let steps = [
        by(full()),
        RenderSettings { width: 12, height: 16, ..by(full()) },
        RenderSettings { crop, ..by(full()) },
        by(k_step(2)),
        RenderSettings { max_path_length: Some(3), ..by(k_step(2)) },
        by(k_step(9)),
        by(pool(3)),
        RenderSettings { width: 12, height: 16, ..by(pool(5)) },
        RenderSettings { width: 40, height: 30, ..by(path()) },
        by(IntegratorSettings { join: Join::SingleStep, ..full() }),
        RenderSettings { aovs: vec![Aov::Depth, Aov::Variance], ..by(path()) },
    ];
    let mut live = renderer(&scene, camera, by(path()));
    for settings in steps {
        run(&mut live, 3);
        live.set_settings(settings.clone()).expect("changes");
        // Another K alone keeps samples; every step here changes more.
        assert_eq!(live.samples(), 0, "{settings:?}");
        assert_eq!(run(&mut live, 2), fresh(&scene, camera, &settings), "{settings:?}");
    }
}

#[test]
fn another_camera_sees_what_a_new_renderer_sees_from_inside_glass_too() {
    let scene = load("glass-caustic.gltf");
    let mut live = renderer(&scene, &scene.cameras[0], by(full()));
    let glass = scene.materials.iter().position(|m| m.surface.has_inside()).expect("has glass") as u32;
    let mesh = scene.meshes.iter().position(|m| m.material == glass).expect("is used");
    let instance = (0..).zip(&scene.instances).find(|(_, i)| i.mesh as usize == mesh).expect("placed").0;
    let placed = scene.placed(instance);
    let n = placed.n_triangles();
    let vertices = (0..n).flat_map(|t| placed.positions(t));
    let centre = vertices.fold(Vec3::ZERO, |sum, v| sum + v) / (3 * n) as f32;
    let outside = scene.cameras[0].position();
    for eye in [outside + Vec3::new(0.1, 0.05, -0.02), centre, outside] {
        run(&mut live, 3);
        let target = if eye == centre { centre + Vec3::new(0.3, -1.0, 0.2) } else { centre };
        let camera = Camera::look_at(eye, target, Vec3::Y, 0.7).expect("looks");
        live.set_camera(&scene, &camera).expect("changes");
        assert_eq!(run(&mut live, 2), fresh(&scene, &camera, &by(full())), "{eye}");
    }
}

/// A scene under a sky of few texels that is turned, a constant one, none, and the sky again.
fn environments(scene: &Scene) -> Vec<Scene> {
    let texels = (0..32).map(|i| [0.1 * i as f32, 0.5, 3.0 / (1 + i) as f32, 1.0]).collect::<Vec<_>>();
    let sky = Texture { name: String::new(), width: 8, height: 4, texels: Texels::Float(texels.into()) };
    let constant = Environment {
        radiance: Vec3::new(0.2, 0.4, 0.8),
        image: None,
        world_from_environment: Mat3::from_rotation_y(0.7),
    };
    let pictured = Environment { image: Some(scene.images.len() as u32), ..constant };
    let images = [scene.images.clone(), vec![sky]].concat();
    let under = |environment| Scene { environment, images: images.clone(), ..scene.clone() };
    [Some(pictured), Some(constant), None, Some(pictured)].map(under).into()
}

/// With glass, so that media are found anew; with a tree over lights; with instances and textures.
#[test]
fn another_environment_is_that_of_a_new_renderer() {
    for name in ["glass-caustic.gltf", "light-sheet.gltf", "material-sheet.gltf"] {
        let scene = load(name);
        let camera = &scene.cameras[0];
        for method in [path(), full(), pool(2)] {
            let mut live = renderer(&scene, camera, by(method));
            let scenes = environments(&scene);
            for scene in &scenes {
                run(&mut live, 1);
                // What is around it by now is not asked: the geometry alone is.
                let made_with = &scenes[0];
                let mut next =
                    live.basis().surrounded(made_with, &Surround::of(scene), by(method)).expect("fits");
                run(&mut live, 3); // goes on, on a film of its own
                std::mem::swap(&mut live, &mut next);
                assert_eq!(live.samples(), 0);
                let mut new = renderer(scene, camera, by(method));
                assert_eq!(run(&mut live, 2), run(&mut new, 2), "{name}, {method:?}");
                let plans = [&live, &new].map(|renderer| renderer.plan().total());
                assert_eq!(plans[0], plans[1], "{name}, {method:?}");
                let beside = live.beside(by(full())).map(|mut beside| run(&mut beside, 1)).expect("fits");
                assert_eq!(beside, run(&mut renderer(scene, camera, by(full())), 1));
            }
        }
    }
}

#[test]
fn under_another_environment_all_but_what_shines_stays() {
    let scene = load("glass-caustic.gltf");
    let pack = |scene: &Scene| PackedScene::new(scene, &scene.cameras[0], &by(full()), DeviceKind::Cpu);
    let packed = pack(&scene).expect("packs");
    for scene in environments(&scene) {
        let changed = packed.clone().surrounded(&scene, &Surround::of(&scene), &by(full())).expect("packs");
        assert!(changed.nodes.is_empty() && changed.triangles.is_empty());
        let PackedScene { nodes, triangles, images, scene: mut words, lights_at, .. } = packed.clone();
        words.truncate(lights_at as usize);
        words.extend(&changed.scene);
        let changed = PackedScene { nodes, triangles, images, scene: words, ..changed };
        let new = pack(&scene).expect("packs");
        // Media hold how long the build took.
        assert!(changed.media.is_some() && new.media.is_some());
        let same = PackedScene { media: None, ..changed } == PackedScene { media: None, ..new };
        assert!(same, "{:?}", scene.environment);
    }
}

/// Other materials on the meshes of `scene`: each the next of the list, as far as `wanted` has them.
fn redressed(scene: &Scene, wanted: impl Fn(&Material) -> bool) -> Scene {
    let mut dressed = scene.clone();
    let n = scene.materials.len() as u32;
    for mesh in &mut dressed.meshes {
        let next = (1..=n).map(|step| (mesh.material + step) % n);
        mesh.material =
            next.into_iter().find(|&m| wanted(&scene.materials[m as usize])).expect("there is one");
    }
    dressed
}

/// With glass, whose media change places; with lights that go and come; with instances and textures.
#[test]
fn other_materials_are_those_of_a_new_renderer() {
    for name in ["glass-caustic.gltf", "light-sheet.gltf", "material-sheet.gltf", "cornell-box.gltf"] {
        let scene = load(name);
        let camera = &scene.cameras[0];
        let (dark, any) = (redressed(&scene, |m| !m.is_emissive()), redressed(&scene, |_| true));
        for method in [path(), full(), pool(2)] {
            let (mut live, mut before) = (renderer(&scene, camera, by(method)), &scene);
            for scene in [&any, &dark, &scene] {
                let mut next = live.basis().dressed(before, scene, by(method)).expect("fits");
                run(&mut live, 3); // goes on, on a film of its own
                std::mem::swap(&mut live, &mut next);
                before = scene;
                let mut new = renderer(scene, camera, by(method));
                assert_eq!(run(&mut live, 2), run(&mut new, 2), "{name}, {method:?}");
                assert_eq!(live.plan().total(), new.plan().total(), "{name}, {method:?}");
            }
        }
    }
}

#[test]
fn hierarchies_stay_while_the_same_triangles_are_opaque_and_baked() {
    let pack = |scene: &Scene| PackedScene::new(scene, &scene.cameras[0], &by(full()), DeviceKind::Cpu);
    let scene = load("glass-caustic.gltf");
    let packed = pack(&scene).expect("packs");
    let mut dressed = redressed(&scene, |_| true);
    let changed = packed.dressed(&scene, &dressed, &scene.cameras[0], &by(full())).expect("packs");
    let changed = changed.expect("hierarchies stay");
    assert!(changed.nodes.is_empty() && changed.triangles.is_empty());
    let PackedScene { nodes, triangles, .. } = packed.clone();
    let (changed, new) = (PackedScene { nodes, triangles, ..changed }, pack(&dressed).expect("packs"));
    assert!(PackedScene { media: None, ..changed } == PackedScene { media: None, ..new });
    // A material that is not there, or has holes, marks its triangles.
    let diffuse = Surface::Diffuse { reflectance: Vec3::ONE.into() };
    let holes = Opacity::Mask(0.0.into(), 0.5);
    for (surface, opacity) in [(Surface::Null, Opacity::Opaque), (diffuse, holes)] {
        let mut with_holes = scene.clone();
        with_holes.materials.push(Material { surface, opacity, ..scene.materials[0].clone() });
        dressed = with_holes.clone();
        dressed.meshes[0].material = scene.materials.len() as u32;
        let packed = pack(&with_holes).expect("packs");
        let changed = packed.dressed(&with_holes, &dressed, &scene.cameras[0], &by(full()));
        assert!(changed.expect("packs").is_none());
    }
}

#[test]
fn an_environment_that_is_refused_leaves_the_renderer_as_it_was() {
    let scene = load("cornell-box.gltf");
    let mut live = renderer(&scene, &scene.cameras[0], by(path()));
    run(&mut live, 2);
    let [pictured, constant] = [0, 1].map(|i| Surround::of(&environments(&scene)[i]));
    let mut broken = [constant, pictured.clone(), pictured];
    broken[0].environment.as_mut().expect("is there").radiance = Vec3::NAN;
    broken[1].image.as_mut().expect("is there").width = 7;
    broken[2].image.as_mut().expect("is there").texels = Texels::Float([[f32::INFINITY; 4]; 32].into());
    for surround in broken {
        assert!(live.basis().surrounded(&scene, &surround, by(path())).is_err());
    }
    let table = RenderSettings { rng: Rng::Table(64), ..by(path()) };
    assert!(live.basis().surrounded(&scene, &Surround::default(), table).is_err());
    assert_eq!(run(&mut live, 4), run(&mut renderer(&scene, &scene.cameras[0], by(path())), 4));
}

#[test]
fn k_changes_keep_the_samples_and_the_mean() {
    let scene = load("cornell-box.gltf");
    for join in [k_step, pool] {
        let mut live = renderer(&scene, &scene.cameras[0], by(join(1)));
        // Up beyond the room that there is, down, and up within it.
        for (pass, k) in (1..).zip([1, 6, 2, 5]) {
            live.set_k(k).expect("changes");
            live.step(1).expect("renders");
            assert_eq!(live.samples(), pass, "K {k}");
        }
        let mixed = run(&mut live, 400).mean()[1];
        let constant = run(&mut renderer(&scene, &scene.cameras[0], by(join(5))), 400).mean()[1];
        // 230,400 samples each, of spread about their mean: 0.3 %.
        assert!((mixed / constant - 1.0).abs() <= 0.02, "{mixed} {constant}");
    }
}

#[test]
fn refused_changes_leave_the_renderer_as_it_was() {
    let scene = load("cornell-box.gltf");
    let mut live = renderer(&scene, &scene.cameras[0], by(path()));
    run(&mut live, 2);
    for settings in [
        RenderSettings { width: 0, ..by(path()) },
        RenderSettings { rng: Rng::Table(64), ..by(path()) },
        RenderSettings { light_sampling: LightSampling::Tree, ..by(path()) },
        by(k_step(0)),
    ] {
        assert!(matches!(live.set_settings(settings), Err(RenderError::Settings(_))));
    }
    assert!(live.set_k(2).is_err(), "path has no K");
    assert_eq!(run(&mut live, 4), run(&mut renderer(&scene, &scene.cameras[0], by(path())), 4));
}

#[test]
fn a_pass_that_is_stopped_leaves_nothing_behind() {
    let scene = load("cornell-box.gltf");
    for method in [path(), full(), pool(2)] {
        let mut live = renderer(&scene, &scene.cameras[0], by(method));
        let stop = Arc::new(AtomicBool::new(false));
        live.stop_when(Arc::clone(&stop));
        run(&mut live, 2);
        stop.store(true, Ordering::Relaxed);
        assert_eq!(live.step(1).expect("stops"), 0);
        assert_eq!((live.samples(), stop.load(Ordering::Relaxed)), (0, false));
        assert_eq!(run(&mut live, 2), fresh(&scene, &scene.cameras[0], &by(method)));
    }
}

/// Cut into parts a pass has the same bits; meanwhile the image is the one before it; and what cannot
/// change within a pass waits for its end, or ends it.
#[test]
fn a_pass_in_parts_is_the_pass() {
    let scene = load("cornell-box.gltf");
    for method in [path(), full(), pool(2)] {
        let settings = RenderSettings { width: 96, height: 64, ..by(method) };
        let in_part = |live: &mut Renderer| {
            assert_eq!(live.step_within(1, Duration::ZERO).expect("renders"), None);
            assert!(live.pass_done().is_some_and(|done| (0.01..0.99).contains(&done)));
        };
        let mut live = renderer(&scene, &scene.cameras[0], settings.clone());
        let first = run(&mut live, 1);
        in_part(&mut live);
        assert_eq!((live.samples(), live.image().expect("reads")), (1, first));
        let mut parts = 1;
        while live.step_within(1, Duration::ZERO).expect("renders").is_none() {
            parts += 1;
        }
        assert!(parts > 1 && live.pass_done().is_none());
        let mut whole = renderer(&scene, &scene.cameras[0], settings.clone());
        assert_eq!(live.image().expect("reads"), run(&mut whole, 2));
        in_part(&mut live);
        live.set_camera(&scene, &scene.cameras[0]).expect("changes");
        assert_eq!(run(&mut live, 2), run(&mut whole, 2));
        if method.join == Join::KStep {
            in_part(&mut live);
            live.set_k(1).expect("changes");
            assert_eq!((live.samples(), live.pass_done()), (3, None));
            assert_eq!(live.image().expect("reads"), run(&mut whole, 3));
        }
    }
}

#[test]
fn groups_of_lights_are_kept_apart_and_mixed_live() {
    let scene = load("light-sheet.gltf");
    let camera = &scene.cameras[0];
    let apart = RenderSettings { light_groups: true, ..by(full()) };
    let expected = fresh(&scene, camera, &by(full()));
    let mut live = renderer(&scene, camera, by(full()));
    run(&mut live, 1);
    let alone = live.plan().total();
    live.set_settings(apart).expect("changes");
    assert_eq!((live.samples(), live.light_groups().len()), (0, 6));
    assert_eq!(live.plan().total() - alone, 5 * 24 * u64::from(SIZE * SIZE));
    assert_eq!(run(&mut live, 2), expected);
    let display = Display { exposure: 0.0, tone_map: ToneMap::Linear };
    let shown = live.display(display).expect("shows");
    live.set_mix(&[[0.0; 3]; 6]);
    assert!(live.display(display).expect("shows").chunks_exact(4).all(|pixel| pixel[..3] == [0; 3]));
    live.set_mix(&[[2.0, 0.0, 1.0]; 6]);
    let mixed = live.mixed_image(&[[2.0, 0.0, 1.0]; 6]).expect("mixes");
    for (mixed, plain) in mixed.pixels.iter().zip(&expected.pixels) {
        assert!((mixed[0] - 2.0 * plain[0]).abs() <= 1e-5 * plain[0] && mixed[1] == 0.0);
    }
    live.set_mix(&[]);
    assert_eq!((live.samples(), live.display(display).expect("shows")), (2, shown));
    live.set_settings(by(full())).expect("changes");
    assert_eq!((live.plan().total(), live.light_groups().len()), (alone, 0));
    assert_eq!(run(&mut live, 2), expected);
}

#[test]
fn a_renderer_beside_another_is_independent_of_it() {
    let scene = load("cornell-box.gltf");
    let mut one = renderer(&scene, &scene.cameras[0], by(path()));
    let small = RenderSettings { width: 9, height: 5, ..by(k_step(2)) };
    let mut other = one.beside(small.clone()).expect("fits");
    one.step(1).expect("renders");
    assert_eq!(run(&mut other, 2), fresh(&scene, &scene.cameras[0], &small));
    assert_eq!(run(&mut one, 3), run(&mut renderer(&scene, &scene.cameras[0], by(path())), 3));
}

#[test]
fn what_the_device_shows_is_what_films_tone_maps_give() {
    let scene = load("cornell-box.gltf");
    let mut live = renderer(&scene, &scene.cameras[0], by(path()));
    let image = run(&mut live, 4);
    for tone_map in [ToneMap::Linear, ToneMap::Agx, ToneMap::Aces, ToneMap::PbrNeutral] {
        for exposure in [-3.0, 0.0, 2.5] {
            let display = Display { exposure, tone_map };
            let shown = live.display(display).expect("shows");
            assert_eq!(shown.len(), image.pixels.len() * 4);
            for (bytes, pixel) in shown.chunks(4).zip(&image.pixels) {
                let expected = display.encode_u8(*pixel);
                // One step: the two round the same formulas in another order.
                let close = bytes.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1);
                assert!(close && bytes[3] == 255, "{display:?} {pixel:?}: {bytes:?} {expected:?}");
            }
        }
    }
}
