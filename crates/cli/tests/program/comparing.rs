//! `midway compare`, `midway info` and `midway devices`.

use std::fs;

use midway_film::Image;

use crate::support::Sandbox;

fn picture() -> Image {
    Image::from_fn(32, 24, |x, y| [0.02 * x as f32 + 0.1, 0.03 * y as f32 + 0.05, 0.2])
}

#[test]
fn json_has_the_five_keys() {
    let sandbox = Sandbox::new();
    let mut brighter = picture();
    brighter.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|value| value * 1.01));
    sandbox.write_image("a.exr", &brighter);
    sandbox.write_image("b.exr", &picture());
    let run = sandbox.expect(0, &["compare", "a.exr", "b.exr", "--json", "--heatmap", "h.png"]);
    let [object] = &run.json_lines()[..] else { panic!("{}", run.stdout) };
    let keys: Vec<&String> = object.as_object().unwrap().keys().collect();
    assert_eq!(keys, ["mae", "rmse", "relmse", "flip", "mean_ratio", "block_ratio"]);
    for channel in object["mean_ratio"].as_array().unwrap() {
        assert!((channel.as_f64().unwrap() - 1.01).abs() <= 1e-5);
    }
    assert!(object["rmse"].as_f64().unwrap() > 1e-3 && object["flip"].as_f64().unwrap() > 0.0);
    assert!(fs::read(sandbox.path("h.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn equal_images_have_no_error() {
    let sandbox = Sandbox::new();
    sandbox.write_image("a.exr", &picture());
    let run = sandbox.expect(0, &["compare", "a.exr", "a.exr", "--json"]);
    let object = &run.json_lines()[0];
    assert!(["mae", "rmse", "relmse", "flip"].iter().all(|key| object[*key] == 0.0), "{object}");
    let text = sandbox.expect(0, &["compare", "a.exr", "a.exr"]).stdout;
    assert!(text.contains("relMSE") && text.contains("mean ratio  1.000000"), "{text}");
}

#[test]
fn must_fail_what_cannot_be_compared_is_6() {
    let sandbox = Sandbox::new();
    sandbox.write_image("a.exr", &picture());
    let mut bad = picture();
    bad.pixels[77][1] = f32::NAN;
    sandbox.write_image("nan.exr", &bad);
    sandbox.write_image("small.exr", &Image::filled(32, 23, [0.5; 3]));
    for other in ["nan.exr", "small.exr"] {
        for pair in [["a.exr", other], [other, "a.exr"]] {
            let run = sandbox.expect(6, &["compare", pair[0], pair[1], "--json"]);
            assert!(run.stdout.is_empty() && !run.error().is_empty());
        }
    }
}

#[test]
fn must_fail_what_cannot_be_read_is_3() {
    let sandbox = Sandbox::new();
    sandbox.write_image("a.exr", &picture());
    let whole = fs::read(sandbox.path("a.exr")).unwrap();
    sandbox.write("cut.exr", &whole[..whole.len() - 100]);
    sandbox.write("text.exr", "not an image");
    for other in ["cut.exr", "text.exr", "none.exr", "."] {
        let run = sandbox.expect(3, &["compare", other, "a.exr"]);
        assert!(run.error().contains(other), "{}", run.stderr);
    }
}

#[test]
fn an_unwritable_heat_map_is_5() {
    let sandbox = Sandbox::new();
    sandbox.write_image("a.exr", &picture());
    sandbox.expect(5, &["compare", "a.exr", "a.exr", "--heatmap", "missing/h.png"]);
}

#[test]
fn info_counts() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    let object = &sandbox.expect(0, &["info", "scene.obj", "--json"]).json_lines()[0];
    assert_eq!((&object["triangles"], &object["emissive_triangles"]), (&6.into(), &4.into()));
    assert_eq!(object["cameras"].as_array().unwrap().len(), 1);
    assert_eq!(object["bounds"]["max"], serde_json::json!([1.0, 1.5, 0.5]));
    assert_eq!(object["hash"].as_str().unwrap().len(), 64);
    // Two lamps of 2 by √½ that shine 4: π times that.
    let power = object["lighting"]["emissive_triangles_power"][0].as_f64().unwrap();
    assert!((power - 35.543).abs() <= 1e-3, "{power}");
    assert!(object["lighting"]["environment"].is_null());
    let memory = |part: &str| object["memory"][part].as_u64().unwrap();
    let parts = ["hierarchies_bytes", "geometry_bytes", "images_bytes"].map(memory);
    // 112 bytes a triangle: 64 to shade, 48 to hit.
    assert!(parts[0] >= 64 && parts[1] >= 6 * 112 && memory("total_bytes") == parts.iter().sum::<u64>());
    assert_eq!(object["cameras"][0]["lens_radius"], 0.0);
    let text = sandbox.expect(0, &["info", "scene.obj"]).stdout;
    assert!(text.contains("memory     "), "{text}");
    assert!(text.contains("triangles  6 (4 emit)") && text.contains("emissive triangles: 35.543"), "{text}");
}

#[test]
fn devices_include_this_machines_cores() {
    let sandbox = Sandbox::new();
    let list = sandbox.expect(0, &["devices", "--json"]).json_lines().remove(0);
    let cpu = list.as_array().unwrap().iter().find(|device| device["name"] == "cpu").unwrap();
    assert_eq!(cpu["kind"], "cpu");
    assert!(cpu["max_buffer_bytes"].as_u64().unwrap() > 0);
    let table = sandbox.expect(0, &["devices"]).stdout;
    assert!(table.starts_with("NAME") && table.contains("cpu"), "{table}");
}
