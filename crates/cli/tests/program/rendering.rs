//! `midway render`, from the command line to the files.

use std::{
    fs,
    io::{BufRead, BufReader},
    path::Path,
    process::Stdio,
    thread,
    time::{Duration, Instant},
};

use midway_film::{ExrFile, Framing, Image};

use crate::support::{Run, Sandbox};

const SMALL: [&str; 8] = ["render", "scene.obj", "--device", "cpu", "--width", "24", "--height", "16"];

fn scene() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    sandbox
}

fn render(sandbox: &Sandbox, extra: &[&str]) -> Run {
    sandbox.expect(0, &[&SMALL[..], extra].concat())
}

fn read(sandbox: &Sandbox, name: &str) -> ExrFile {
    ExrFile::read(&sandbox.path(name)).unwrap()
}

/// A grey of a fifth, thrice, is one of three fifths; what is above 1 is 1: on each value that colours may
/// multiply.
#[test]
fn images_are_multiplied_before_they_are_cut_to_1() {
    let sandbox = Sandbox::new();
    // BMP, 1 x 1, 24 bits, its row padded to 4 bytes.
    let mut image = b"BM".to_vec();
    for word in [58u32, 0, 54, 40, 1, 1, 0x0018_0001, 0, 4, 2835, 2835, 0, 0, 0x0033_3333] {
        image.extend(word.to_le_bytes());
    }
    sandbox.write("a.bmp", image);
    let picture = |bsdf: &str, inside: &str| {
        let film = "<integer name='width' value='8'/><integer name='height' value='8'/>";
        sandbox.write(
            "scene.xml",
            format!(
                "<scene version='3.0.0'><sensor type='perspective'><transform name='to_world'>\
                 <lookat origin='0,0,2' target='0,0,0' up='0,1,0'/></transform>\
                 <film type='hdrfilm'>{film}</film></sensor><emitter type='constant'/>\
                 <shape type='rectangle'><transform name='to_world'><scale value='5'/></transform>\
                 <bsdf type='{bsdf}'>{inside}</bsdf></shape></scene>"
            ),
        );
        sandbox.expect(0, &["render", "scene.xml", "--device", "cpu", "--spp", "16", "-i", "path"]);
        read(&sandbox, "scene.exr").image().unwrap()
    };
    for (bsdf, name) in [
        ("diffuse", "reflectance"),
        ("plastic", "specular_reflectance"),
        ("conductor", "specular_reflectance"),
        ("thindielectric", "specular_transmittance"),
    ] {
        for (by, value) in [(3.0, 0.6), (7.0, 1.0)] {
            let textured = format!(
                "<texture name='{name}' type='scale'><float name='scale' value='{by}'/><texture type='bitmap'>\
                 <string name='filename' value='a.bmp'/><boolean name='raw' value='true'/></texture></texture>"
            );
            let found = picture(bsdf, &textured);
            let expected = picture(bsdf, &format!("<rgb name='{name}' value='{value}'/>"));
            let mut pairs = found.pixels.as_flattened().iter().zip(expected.pixels.as_flattened());
            // Rounding: numbers are multiplied in another order.
            assert!(pairs.all(|(a, b)| (a - b).abs() <= 1e-5), "{bsdf} by {by}: {found:?} {expected:?}");
        }
    }
}

#[test]
fn both_files_are_written_and_the_header_tells_all() {
    let sandbox = scene();
    let run = render(&sandbox, &["-i", "path", "--spp", "4", "--seed", "9"]);
    assert!(
        run.stderr.contains("device: cpu") && run.stderr.contains("stopped: all samples"),
        "{}",
        run.stderr
    );
    assert!(sandbox.exists("scene.png"));
    let file = read(&sandbox, "scene.exr");
    assert_eq!((file.width, file.height, file.framing), (24, 16, None));
    assert!(!file.image().unwrap().is_black());
    let header = &file.metadata;
    assert_eq!((header.int("samples"), header.int("seed")), (Some(4), Some(9)));
    assert!(header.float("seconds").unwrap() > 0.0);
    assert_eq!((header.text("bias"), header.text("stopped_by")), (Some("none"), Some("samples")));
    assert!(header.text("device").unwrap().starts_with("cpu"));
    assert!(header.text("integrator").unwrap().starts_with("path"));
    assert_eq!(header.text("light_sampling"), Some("power"));
    assert_eq!(header.text("scene_hash").unwrap().len(), 64);
    assert!(header.get("world_from_camera").is_some());
    let left: Vec<_> = fs::read_dir(sandbox.path(".")).unwrap().collect();
    assert_eq!(left.len(), 4, "{left:?}");
}

/// A wall that nothing lights, and the flags that do.
#[test]
fn flags_put_light_around_a_dark_scene() {
    let sandbox = Sandbox::new();
    sandbox.write("scene.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    // One texel of radiance 2 in the upper half, 0 in the lower.
    sandbox.write("sky.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 1\n\x80\x80\x80\x82\0\0\0\0");
    let dark = "nothing emits light";
    let run = render(&sandbox, &["--spp", "2", "-o", "dark.exr"]);
    assert!(run.stderr.contains(dark), "{}", run.stderr);
    assert!(read(&sandbox, "dark.exr").image().unwrap().is_black());
    let run = render(&sandbox, &["--spp", "2", "-o", "black.exr", "--background", "0,0,0"]);
    assert!(run.stderr.contains(dark), "{}", run.stderr);
    for (name, flags) in [
        ("white.exr", &["--background", "1,1,1"][..]),
        ("sky.exr", &["--env", "sky.hdr", "--env-rotation", "-30"]),
    ] {
        let run = render(&sandbox, &[&["--spp", "64", "-o", name], flags].concat());
        assert!(!run.stderr.contains(dark), "{}", run.stderr);
        let file = read(&sandbox, name);
        let mean = file.image().unwrap().mean()[0];
        // Of the wall 0.8 times as much as of what is behind it.
        assert!((0.75..=1.02).contains(&mean), "{name}: {mean}");
        let said = if flags[0] == "--env" { "environment" } else { "background" };
        assert!(file.metadata.text(said).is_some());
    }
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let sandbox = scene();
    for (name, seed) in [("a.exr", "1"), ("b.exr", "1"), ("c.exr", "2")] {
        render(&sandbox, &["--spp", "3", "--seed", seed, "-o", name, "--quiet"]);
    }
    let image = |name| read(&sandbox, name).image().unwrap();
    assert!(image("a.exr") == image("b.exr"), "the same seed gave two images");
    assert!(image("a.exr") != image("c.exr"), "two seeds gave the same image");
}

#[test]
fn quiet_says_nothing() {
    let run = render(&scene(), &["--spp", "1", "--quiet"]);
    assert!(run.stderr.is_empty() && run.stdout.is_empty(), "{}{}", run.stderr, run.stdout);
}

#[test]
fn json_progress_is_one_object_a_line() {
    let events = render(&scene(), &["--spp", "4", "--progress", "json"]).json_lines();
    let names: Vec<&str> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!((names[0], names[names.len() - 1]), ("start", "end"));
    assert!(names.contains(&"progress"));
    assert_eq!(events[0]["outputs"], serde_json::json!(["scene.exr", "scene.png"]));
    assert_eq!(events[events.len() - 1]["stopped_by"], "samples");
}

/// The default says what it chose, and chooses the same for a part of the image.
#[test]
fn auto_is_the_default_and_tells_its_choice() {
    let sandbox = scene();
    let run = render(&sandbox, &["--spp", "4"]);
    assert!(run.stderr.contains("auto, error for the same work: "), "{}", run.stderr);
    let whole = read(&sandbox, "scene.exr").metadata;
    assert!(whole.text("auto").unwrap().contains(" 1.00, "));
    render(&sandbox, &["--spp", "4", "--seed", "3", "--crop", "5,3,10,7"]);
    let part = read(&sandbox, "scene.exr").metadata;
    for key in ["auto", "integrator"] {
        assert_eq!(whole.text(key), part.text(key));
    }
}

#[test]
fn time_stops_too_and_is_named() {
    let sandbox = scene();
    let run = render(&sandbox, &["--time", "300ms", "--spp", "100000000"]);
    assert!(run.stderr.contains("stopped: the time is over"), "{}", run.stderr);
    let header = read(&sandbox, "scene.exr").metadata;
    assert_eq!(header.text("stopped_by"), Some("time"));
    assert!(header.float("seconds").unwrap() <= 5.0 && header.int("samples").unwrap() >= 1);
}

#[test]
fn a_crop_is_that_part_of_the_image() {
    let sandbox = scene();
    render(&sandbox, &["-i", "path", "--spp", "8", "-o", "whole.exr"]);
    render(&sandbox, &["-i", "path", "--spp", "8", "-o", "part.exr", "--crop", "5,3,10,7"]);
    let part = read(&sandbox, "part.exr");
    assert_eq!(part.framing, Some(Framing { frame: [24, 16], offset: [5, 3] }));
    let whole = read(&sandbox, "whole.exr").image().unwrap();
    let cut = Image::from_fn(10, 7, |x, y| whole.pixels[(y + 3) * 24 + x + 5]);
    assert!(part.image().unwrap() == cut, "the crop's samples are not the whole's");
}

#[test]
fn layers_are_beside_the_picture_and_compare_reads_the_picture() {
    let sandbox = scene();
    render(&sandbox, &["--spp", "4", "-o", "plain.exr"]);
    render(&sandbox, &["--spp", "4", "-o", "layers.exr", "--aov", "all"]);
    render(&sandbox, &["--spp", "4", "-o", "two.exr", "--aov", "depth,samples"]);
    let names = |file: &str| -> Vec<String> {
        read(&sandbox, file).channels.into_iter().map(|channel| channel.name).collect()
    };
    assert_eq!(names("plain.exr"), ["B", "G", "R"]);
    assert_eq!(names("two.exr"), ["B", "G", "R", "depth.Z", "samples.Y"]);
    assert_eq!(names("layers.exr").len(), 3 + 14);
    let layers = read(&sandbox, "layers.exr");
    assert_eq!(layers.channel("samples.Y"), Some(&[4.0; 24 * 16][..]));
    assert!(layers.layer("albedo").is_some() && layers.layer("variance").is_some());
    let same = sandbox.expect(0, &["compare", "layers.exr", "plain.exr", "--json"]).json_lines().remove(0);
    assert_eq!(same["rmse"], 0.0);
    let refused = [&SMALL[..], &["--aov", "depth", "-o", "a.png", "-o", "b.png"]].concat();
    assert!(sandbox.expect(2, &refused).error().contains("--aov"));
    sandbox.expect(2, &[&SMALL[..], &["--aov", "deep"]].concat());
}

#[test]
fn groups_of_lights_are_layers_that_add_up() {
    let sandbox = scene();
    let flags = |groups| ["-i", "path", "--spp", "4", "--background", "1,1,1", groups];
    render(&sandbox, &flags("--light-groups=sky=environment,room=*"));
    let read = read(&sandbox, "scene.exr");
    let names: Vec<&str> = read.channels.iter().map(|channel| channel.name.as_str()).collect();
    let layers = ["B", "G", "R"].map(|c| ["room", "sky"].map(|group| format!("Combined_{group}.{c}")));
    assert_eq!(names.len(), 9);
    assert!(layers.as_flattened().iter().all(|layer| names.contains(&layer.as_str())), "{names:?}");
    for (pixel, rgb) in read.image().unwrap().pixels.iter().enumerate() {
        let value = |group: &str| read.channel(&format!("Combined_{group}.G")).unwrap()[pixel];
        assert!(value("room") > 0.0 || value("sky") > 0.0);
        assert!((value("room") + value("sky") - rgb[1]).abs() <= 1e-6 * rgb[1]);
    }
    let refused = |groups| sandbox.expect(2, &[&SMALL[..], &[groups]].concat()).error().to_owned();
    assert!(refused("--light-groups=key=moon").contains("no light is called 'moon'"));
    sandbox.expect(2, &[&SMALL[..], &["--light-groups=moon"]].concat());
    let png = [&SMALL[..], &["--light-groups", "-o", "a.png", "-o", "b.png"]].concat();
    assert!(sandbox.expect(2, &png).error().contains("--light-groups"));
}

#[test]
fn camera_and_filter_are_in_the_header() {
    let sandbox = scene();
    let camera = ["--eye", "0,0,4", "--target", "0,0,0", "--lens-radius", "0.1", "--ortho", "3"];
    render(&sandbox, &[&["--spp", "1", "--filter", "blackman-harris"], &camera[..]].concat());
    let header = read(&sandbox, "scene.exr").metadata;
    assert_eq!(header.text("filter"), Some("blackman-harris width=3"));
    assert_eq!(header.float("orthographic_height"), Some(3.0));
    assert_eq!((header.float("yfov_degrees"), header.float("focus_distance")), (None, Some(4.0)));
    assert_eq!(header.float("lens_radius"), Some(f64::from(0.1_f32)));
    let wide = [&SMALL[..], &["--filter-width", "17"]].concat();
    assert!(sandbox.expect(2, &wide).error().contains("filter"));
}

#[test]
fn bias_is_printed_and_in_the_header() {
    let sandbox = scene();
    let run =
        render(&sandbox, &["--spp", "1", "--max-path-length", "3", "--clamp", "10", "--rng", "table:64"]);
    assert_eq!(run.stderr.lines().filter(|line| line.starts_with("bias: ")).count(), 3, "{}", run.stderr);
    let bias = read(&sandbox, "scene.exr").metadata.text("bias").unwrap().to_owned();
    assert!(bias.contains("max-path-length") && bias.contains("clamp") && bias.contains("table"), "{bias}");
}

#[test]
fn errors_against_a_reference_are_logged() {
    let sandbox = scene();
    render(&sandbox, &["--spp", "64", "-o", "reference.exr", "--seed", "5"]);
    render(&sandbox, &["--spp", "8", "--reference", "reference.exr", "--errors", "errors.csv"]);
    let text = fs::read_to_string(sandbox.path("errors.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("seconds,samples,rmse,relmse"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect();
    assert!(!rows.is_empty());
    assert_eq!(rows[rows.len() - 1][1], 8.0);
    assert!(rows.iter().all(|row| row[2] > 0.0 && row[3] > 0.0));
    assert!(rows.windows(2).all(|pair| pair[0][1] < pair[1][1] && pair[0][0] <= pair[1][0]));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_5_and_the_other_file_is_kept() {
    let sandbox = scene();
    std::os::unix::fs::symlink("/dev/full", sandbox.path("full.exr")).unwrap();
    let run = sandbox.expect(5, &[&SMALL[..], &["--spp", "1", "-o", "full.exr"]].concat());
    assert!(run.error().contains("full.exr: cannot write"), "{}", run.stderr);
    assert!(sandbox.exists("full.png") && Path::new("/dev/full").exists());
}

#[cfg(unix)]
#[test]
fn snapshots_are_written_and_ctrl_c_writes_what_there_is() {
    let sandbox = scene();
    let arguments =
        [&SMALL[..], &["--time", "60s", "--progress", "json", "--snapshot-every", "100ms"]].concat();
    let mut child = sandbox.command(&arguments).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let progress = lines.find(|line| line.as_ref().unwrap().contains("\"progress\""));
    assert!(progress.is_some(), "it ended before its first pass");
    let start = Instant::now();
    while !sandbox.exists("scene.png") {
        assert!(start.elapsed() < Duration::from_secs(30), "no snapshot");
        thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(read(&sandbox, "scene.exr").metadata.text("stopped_by"), None);
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let last = lines.map(|line| line.unwrap()).last().unwrap();
    assert!(last.contains("\"stopped_by\":\"interrupt\""), "{last}");
    assert_eq!(child.wait().unwrap().code(), Some(10));
    assert!(sandbox.exists("scene.png"));
    assert_eq!(read(&sandbox, "scene.exr").metadata.text("stopped_by"), Some("interrupt"));
}

/// A render whose terminal goes writes what there is; under `nohup` it goes on.
#[cfg(target_os = "linux")]
#[test]
fn a_hangup_ends_a_render_unless_it_is_ignored() {
    for (signal, time, code, stopped_by) in
        [("--default-signal=HUP", "60s", 10, "interrupt"), ("--ignore-signal=HUP", "4s", 0, "time")]
    {
        let sandbox = scene();
        let mut command = std::process::Command::new("env");
        command.arg(signal).arg(env!("CARGO_BIN_EXE_midway")).args(SMALL);
        command.args(["--time", time, "--progress", "json"]).current_dir(sandbox.path("."));
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().contains("\"progress\"")), "it ended before its first pass");
        // Twice, as systems and shells do.
        for _ in 0..2 {
            let id = child.id().to_string();
            assert!(std::process::Command::new("kill").args(["-HUP", &id]).status().unwrap().success());
        }
        let last = lines.map(|line| line.unwrap()).last().unwrap();
        assert!(last.contains(&format!("\"stopped_by\":\"{stopped_by}\"")), "{last}");
        assert_eq!(child.wait().unwrap().code(), Some(code));
        assert!(sandbox.exists("scene.exr"));
    }
}

#[test]
fn a_scene_with_no_light_is_black_and_says_why() {
    let sandbox = Sandbox::new();
    sandbox.write("scene.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let run = render(&sandbox, &["--spp", "1"]);
    assert!(run.stderr.contains("warning: the image is black"), "{}", run.stderr);
    assert!(read(&sandbox, "scene.exr").image().unwrap().is_black());
}
