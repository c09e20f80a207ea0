//! What is wrong is named in one line, with the exit code of its kind, and nothing is written.

use std::fs;

use crate::support::Sandbox;

fn render(sandbox: &Sandbox, code: i32, extra: &[&str]) -> String {
    let arguments: Vec<&str> =
        ["render", "scene.obj", "--device", "cpu"].iter().chain(extra).copied().collect();
    let run = sandbox.expect(code, &arguments);
    assert!(run.stdout.is_empty(), "{}", run.stdout);
    assert!(!sandbox.exists("scene.exr") && !sandbox.exists("scene.png"));
    run.stderr
}

#[test]
fn warnings_come_before_the_error() {
    let sandbox = Sandbox::new();
    sandbox
        .write("empty.gltf", r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"skin":0}]}"#);
    let run = sandbox.expect(3, &["info", "empty.gltf"]);
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert!(lines[0].starts_with("warning: /nodes/0"), "{}", run.stderr);
    assert!(lines[lines.len() - 1].contains("no triangles"), "{}", run.stderr);
}

#[test]
fn a_wrong_command_line_is_2() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    for arguments in [
        &["--spp", "0"][..],
        &["--spp", "many"],
        &["--time", "0s"],
        &["--width", "0"],
        &["--integrator", "magic"],
        &["--light-paths", "pool:0"],
        &["--rng", "table"],
        &["--clamp", "-1"],
        &["--background", "1,2"],
        &["--background", "1,-1,1"],
        &["--env-rotation", "30"],
        &["--env", "sky.hdr", "--background", "1,1,1"],
        &["--errors", "e.csv"],
        &["--quiet", "--verbose"],
        &["--unknown"],
        &["second.obj"],
    ] {
        render(&sandbox, 2, arguments);
    }
    sandbox.expect(2, &[]);
    sandbox.expect(2, &["paint"]);
}

#[test]
fn flags_that_mean_nothing_together_are_2() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    for (arguments, named) in [
        (&["--join", "full"][..], "--join"),
        (&["--integrator", "bdpt", "--k", "2"], "--k"),
        (&["--integrator", "light", "--light-sampling", "tree"], "--light-sampling"),
        (&["-o", "a.jpg"], "a.jpg"),
        (&["--camera", "7"], "--camera"),
        (&["--width", "8", "--height", "8", "--crop", "4,4,5,4"], "--crop"),
        (&["--eye", "0,0,0", "--target", "0,0,0"], "--eye"),
        (&["--fov", "180"], "--fov"),
    ] {
        let stderr = render(&sandbox, 2, arguments);
        assert!(stderr.contains(named), "{stderr}");
    }
}

#[test]
fn files_outside_the_scenes_folder_are_read_only_within_a_root() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    for folder in ["scenes", "other"] {
        fs::create_dir(sandbox.path(folder)).unwrap();
    }
    let scene = fs::read_to_string(sandbox.path("scene.obj")).unwrap();
    sandbox.write("scenes/room.obj", scene.replace("mtllib scene.mtl", "mtllib ../scene.mtl"));
    let run = sandbox.expect(3, &["info", "scenes/room.obj"]);
    assert!(run.error().contains("--root FOLDER"), "{}", run.stderr);
    let command = |line: &'static str| -> Vec<&str> { line.split_whitespace().collect() };
    for line in [
        "info scenes/room.obj --root .",
        "render scenes/room.obj --root . --device cpu --spp 1 --width 8 --height 8",
        "bench rays scenes/room.obj --root . --device cpu --rays 64 --only wide,plain,random,any",
    ] {
        sandbox.expect(0, &command(line));
    }
    for line in ["info scenes/room.obj --root other", "view --root . --no-open"] {
        let run = sandbox.expect(2, &command(line));
        assert!(run.error().contains("--root"), "{}", run.stderr);
    }
}

#[test]
fn a_missing_or_damaged_scene_is_3() {
    let sandbox = Sandbox::new();
    sandbox.write("garbage.gltf", b"\x00\xffnot json");
    sandbox.write("cut.glb", b"glTF\x02\0\0\0");
    sandbox.write("empty.obj", "");
    sandbox.write("picture.jpg", "x");
    for scene in ["none.gltf", "garbage.gltf", "cut.glb", "empty.obj", "picture.jpg", "."] {
        for command in ["render", "info"] {
            let run = sandbox.expect(3, &[command, scene]);
            assert!(run.error().contains(scene), "{}", run.stderr);
        }
    }
}

#[test]
fn a_missing_or_damaged_environment_is_3() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    sandbox.write("damaged.hdr", "#?RADIANCE\n\n-Y 2 +X");
    for environment in ["none.hdr", "damaged.hdr"] {
        let stderr = render(&sandbox, 3, &["--env", environment]);
        assert!(stderr.contains(environment), "{stderr}");
    }
}

#[test]
fn an_unknown_device_is_4_and_lists_what_there_is() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    let run = sandbox.expect(4, &["render", "scene.obj", "--device", "voodoo"]);
    assert!(run.error().contains("voodoo") && run.error().contains("cpu"), "{}", run.stderr);
    let run = sandbox.expect(4, &["render", "scene.obj", "--device", "cpu, CPU"]);
    assert!(run.error().contains("'cpu' was given twice"), "{}", run.stderr);
}

#[test]
fn an_unwritable_output_is_5_before_anything_is_rendered() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    fs::create_dir(sandbox.path("folder.exr")).unwrap();
    // The scene does not even exist: the output is looked at first.
    for arguments in [
        &["render", "none.obj", "-o", "missing/a.exr"][..],
        &["render", "none.obj", "-o", "folder.exr"],
        &["render", "none.obj", "--reference", "r.exr", "--errors", "missing/e.csv"],
    ] {
        let run = sandbox.expect(5, arguments);
        assert!(run.error().contains("cannot write"), "{}", run.stderr);
    }
}

#[test]
fn a_bad_reference_is_told_apart() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    let small = midway_film::Image::filled(3, 3, [1.0; 3]);
    sandbox.write_image("small.exr", &small);
    let size = ["--width", "8", "--height", "8"];
    let with = |reference| [&size[..], &["--reference", reference]].concat();
    render(&sandbox, 3, &with("none.exr"));
    render(&sandbox, 6, &with("small.exr"));
}

#[test]
fn help_and_version_are_0() {
    let sandbox = Sandbox::new();
    for arguments in [&["--help"][..], &["-h"], &["--version"], &["render", "--help"], &["compare", "-h"]] {
        let run = sandbox.expect(0, arguments);
        assert!(!run.stdout.is_empty() && run.stderr.is_empty());
    }
    let help = sandbox.expect(0, &["render", "--help"]).stdout;
    for flag in [
        "output",
        "snapshot-every",
        "exposure",
        "tone-map",
        "spp",
        "time",
        "seed",
        "width",
        "height",
        "crop",
        "camera",
        "eye",
        "target",
        "up",
        "fov",
        "env",
        "env-rotation",
        "background",
        "integrator",
        "join",
        "k",
        "join-choice",
        "light-paths",
        "light-sampling",
        "mis",
        "nee",
        "splat",
        "max-path-length",
        "rng",
        "clamp",
        "device",
        "threads",
        "quiet",
        "verbose",
        "progress",
        "reference",
        "errors",
    ] {
        assert!(help.contains(&format!("--{flag}")), "--{flag}");
    }
}
