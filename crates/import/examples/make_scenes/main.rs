//! Writes the project's own scenes: `cargo run --release -p midway-import --example make_scenes -- scenes`.
//!
//! The Cornell box is from the measurements that Cornell University's Program of Computer Graphics
//! publishes; lengths are theirs, about a millimetre. Radiance is linear Rec. 709.

mod document;
mod materials;
mod shape;
mod sheets;

use std::{fs, io, path::Path};

use glam::{DVec3, dvec3};

use document::Document;
use materials::{diffuse, emitter, glass, mirror};
use shape::{Front, Quad, Shape, horizontal, quads, sphere};

const CORNELL_RIGHTS: &str = "CC0 1.0; measurements by Cornell University Program of Computer Graphics";
const WHITE: [f64; 3] = [0.73, 0.73, 0.73];
const RED: [f64; 3] = [0.63, 0.065, 0.05];
const GREEN: [f64; 3] = [0.14, 0.45, 0.091];

fn main() -> io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "scenes".to_owned());
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;

    let mut cornell = cornell_box();
    add_blocks(&mut cornell);
    let ceiling_light = horizontal(278.0, 279.5, 65.0, 52.5, 548.3);
    cornell.add("light", quads(&[ceiling_light], Front::Along(DVec3::NEG_Y)), emitter([17.0, 12.0, 4.0]));
    cornell.save(folder, "cornell-box")?;

    let mut caustic = cornell_box();
    caustic.add("glass sphere", sphere(dvec3(278.0, 150.0, 280.0), 100.0), glass());
    let small_light = horizontal(278.0, 279.5, 10.0, 10.0, 548.3);
    caustic.add("light", quads(&[small_light], Front::Along(DVec3::NEG_Y)), emitter([600.0, 420.0, 140.0]));
    caustic.save(folder, "glass-caustic")?;

    let mut lamp = cornell_box();
    add_blocks(&mut lamp);
    lamp.add("shade", quads(&shade(), Front::From(dvec3(186.0, 240.0, 168.0))), diffuse(WHITE, true));
    let bulb = horizontal(186.0, 168.0, 30.0, 30.0, 170.0);
    lamp.add("light", quads(&[bulb], Front::Along(DVec3::Y)), emitter([255.0, 180.0, 60.0]));
    lamp.save(folder, "lamp")?;

    let mut glass_and_mirror = cornell_box();
    let [_, tall] = blocks();
    glass_and_mirror.add("mirror block", tall, mirror());
    glass_and_mirror.add("glass sphere", sphere(dvec3(170.0, 90.0, 180.0), 90.0), glass());
    glass_and_mirror.add(
        "light",
        quads(&[ceiling_light], Front::Along(DVec3::NEG_Y)),
        emitter([17.0, 12.0, 4.0]),
    );
    glass_and_mirror.save(folder, "cornell-glass-mirror")?;

    exterior().save(folder, "exterior")?;

    sheets::materials().save(folder, "material-sheet")?;
    sheets::lights().save(folder, "light-sheet")
}

/// The blocks on open ground under a light as wide as the sky: nearly all light comes straight from it.
fn exterior() -> Document {
    let mut document = Document::new(CORNELL_RIGHTS);
    let ground = horizontal(278.0, 279.5, 3000.0, 3000.0, 0.0);
    document.add("ground", quads(&[ground], Front::Along(DVec3::Y)), diffuse([0.4, 0.36, 0.3], true));
    add_blocks(&mut document);
    let sky = horizontal(278.0, 279.5, 4000.0, 4000.0, 3000.0);
    document.add("light", quads(&[sky], Front::Along(DVec3::NEG_Y)), emitter([1.1, 1.2, 1.4]));
    let (eye, target) = (dvec3(278.0, 400.0, -800.0), dvec3(278.0, 120.0, 250.0));
    document.look(eye, target, 39.3077_f64.to_radians(), 1.0);
    document
}

/// The empty box with its camera.
fn cornell_box() -> Document {
    let walls = [
        (
            "floor",
            [(552.8, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 559.2), (549.6, 0.0, 559.2)],
            DVec3::Y,
            WHITE,
        ),
        (
            "ceiling",
            [(556.0, 548.8, 0.0), (556.0, 548.8, 559.2), (0.0, 548.8, 559.2), (0.0, 548.8, 0.0)],
            DVec3::NEG_Y,
            WHITE,
        ),
        (
            "back",
            [(549.6, 0.0, 559.2), (0.0, 0.0, 559.2), (0.0, 548.8, 559.2), (556.0, 548.8, 559.2)],
            DVec3::NEG_Z,
            WHITE,
        ),
        (
            "right",
            [(0.0, 0.0, 559.2), (0.0, 0.0, 0.0), (0.0, 548.8, 0.0), (0.0, 548.8, 559.2)],
            DVec3::X,
            GREEN,
        ),
        (
            "left",
            [(552.8, 0.0, 0.0), (549.6, 0.0, 559.2), (556.0, 548.8, 559.2), (556.0, 548.8, 0.0)],
            DVec3::NEG_X,
            RED,
        ),
    ];
    let mut document = Document::new(CORNELL_RIGHTS);
    for (name, corners, front, colour) in walls {
        let quad = corners.map(|(x, y, z)| dvec3(x, y, z));
        document.add(name, quads(&[quad], Front::Along(front)), diffuse(colour, true));
    }
    document.look(dvec3(278.0, 273.0, -800.0), dvec3(278.0, 273.0, 0.0), 39.3077_f64.to_radians(), 1.0);
    document
}

fn add_blocks(document: &mut Document) {
    let [short, tall] = blocks();
    document.add("short block", short, diffuse(WHITE, true));
    document.add("tall block", tall, diffuse(WHITE, true));
}

/// The short block and the tall one.
fn blocks() -> [Shape; 2] {
    let short = block([(130.0, 65.0), (82.0, 225.0), (240.0, 272.0), (290.0, 114.0)], 165.0);
    let tall = block([(423.0, 247.0), (265.0, 296.0), (314.0, 456.0), (472.0, 406.0)], 330.0);
    let outward = |x, y, z| Front::From(dvec3(x, y, z));
    [quads(&short, outward(185.0, 82.0, 169.0)), quads(&tall, outward(368.0, 165.0, 351.0))]
}

/// A block's top and sides, from its measured top corners (x, z).
fn block(top: [(f64, f64); 4], height: f64) -> Vec<Quad> {
    let mut faces = vec![top.map(|(x, z)| dvec3(x, height, z))];
    for i in 0..4 {
        let ((x0, z0), (x1, z1)) = (top[i], top[(i + 1) % 4]);
        faces.push([dvec3(x0, 0.0, z0), dvec3(x0, height, z0), dvec3(x1, height, z1), dvec3(x1, 0.0, z1)]);
    }
    faces
}

/// Four walls around a lamp on the short block, open above.
fn shade() -> Vec<Quad> {
    let (x0, x1, z0, z1, y0, y1) = (141.0, 231.0, 123.0, 213.0, 165.0, 315.0);
    let wall = |xa, za, xb, zb| [dvec3(xa, y0, za), dvec3(xb, y0, zb), dvec3(xb, y1, zb), dvec3(xa, y1, za)];
    vec![wall(x0, z0, x1, z0), wall(x0, z1, x1, z1), wall(x0, z0, x0, z1), wall(x1, z0, x1, z1)]
}
