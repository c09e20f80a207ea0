//! Every material, and every light, side by side.

use glam::{DVec3, dvec3};
use image::{Rgba, RgbaImage};
use serde_json::{Value, json};

use crate::{
    document::Document,
    materials::{diffuse, emitter, glass, model},
    shape::{Front, Quad, globe, horizontal, pictured, quads},
};

const OURS: &str = "CC0 1.0";
const GREY: [f64; 3] = [0.5, 0.5, 0.5];
const PALE: [f64; 3] = [0.8, 0.78, 0.75];

/// Balls in four rows: metals, opaque dielectrics, what light passes through, textures.
pub fn materials() -> Document {
    const SPACING: f64 = 1.15;
    let mut document = Document::new(OURS);
    let checks = document.texture("checks", &checks([255, 255, 255, 255], [90, 90, 90, 255]));
    let floor = horizontal(0.0, 0.0, 8.0, 8.0, 0.0);
    let mut tiles = diffuse(GREY, true);
    tiles["pbrMetallicRoughness"]["baseColorTexture"] = checks.clone();
    document.add("floor", pictured([floor[3], floor[2], floor[1], floor[0]], 8.0), tiles);
    let wall = [(-8.0, 0.0), (8.0, 0.0), (8.0, 6.0), (-8.0, 6.0)].map(|(x, y)| dvec3(x, y, -5.0));
    document.add("wall", quads(&[wall], Front::Along(DVec3::Z)), diffuse(GREY, true));
    let lamp = horizontal(-1.0, 1.0, 2.0, 1.5, 5.5);
    document.add("lamp", quads(&[lamp], Front::Along(DVec3::NEG_Y)), emitter([9.0, 8.6, 8.0]));
    let strip = [(-1.0, 1.0), (-1.0, 3.0), (2.0, 3.0), (2.0, 1.0)].map(|(z, y)| dvec3(5.0, y, z));
    document.add("strip", quads(&[strip], Front::Along(DVec3::NEG_X)), emitter([3.0, 3.6, 4.5]));
    let ball = document.geometry(&globe(0.5));
    let rows = [metals(), dielectrics(), clear(), textured(&mut document, &checks)];
    for (row, balls) in rows.into_iter().enumerate() {
        for (column, (name, material)) in balls.into_iter().enumerate() {
            let at = dvec3((column as f64 - 2.0) * SPACING, 0.5, (row as f64 - 2.0) * SPACING);
            document.place(name, ball.clone(), material, at);
        }
    }
    document.look(dvec3(0.0, 4.6, 6.6), dvec3(0.0, 0.1, -0.55), 36f64.to_radians(), 4.0 / 3.0);
    document
}

type Named = (&'static str, Value);

fn metals() -> [Named; 5] {
    let metal = |colour, roughness| model(colour, 1.0, roughness, json!({}));
    let mut brushed = metal([0.9, 0.88, 0.85], 0.45);
    brushed["extensions"]["KHR_materials_anisotropy"] = json!({"anisotropyStrength": 0.9});
    [
        ("smooth silver", metal([0.97, 0.96, 0.91], 0.0)),
        ("gold, roughness 0.3", metal([1.0, 0.78, 0.34], 0.3)),
        ("copper, roughness 0.6", metal([0.95, 0.64, 0.54], 0.6)),
        ("brushed steel", brushed),
        ("half metal", model([0.2, 0.5, 0.8], 0.5, 0.4, json!({}))),
    ]
}

fn dielectrics() -> [Named; 5] {
    let lacquer =
        json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.03}});
    let velvet = json!({"KHR_materials_sheen":
        {"sheenColorFactor": [0.9, 0.6, 0.9], "sheenRoughnessFactor": 0.4}});
    [
        ("matte", diffuse([0.75, 0.35, 0.25], true)),
        ("smooth plastic", model([0.1, 0.25, 0.7], 0.0, 0.0, json!({}))),
        ("plastic, roughness 0.4", model([0.1, 0.55, 0.25], 0.0, 0.4, json!({}))),
        ("car paint", model([0.7, 0.03, 0.03], 0.6, 0.5, lacquer)),
        ("velvet", model([0.25, 0.02, 0.2], 0.0, 1.0, velvet)),
    ]
}

fn clear() -> [Named; 5] {
    let mut frosted = glass();
    frosted["pbrMetallicRoughness"]["roughnessFactor"] = json!(0.4);
    let mut amber = glass();
    amber["extensions"]["KHR_materials_volume"] = json!({
        "thicknessFactor": 1.0, "attenuationDistance": 0.5, "attenuationColor": [0.9, 0.5, 0.1],
    });
    let mut diamond = glass();
    diamond["extensions"]["KHR_materials_ior"]["ior"] = json!(2.42);
    let thin = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
    let mut bubble = model([0.8, 0.95, 1.0], 0.0, 0.0, thin);
    bubble["doubleSided"] = json!(true);
    [
        ("glass", glass()),
        ("frosted glass", frosted),
        ("amber", amber),
        ("diamond", diamond),
        ("thin bubble", bubble),
    ]
}

fn textured(document: &mut Document, checks: &Value) -> [Named; 5] {
    let plain = |colour| model(colour, 0.0, 0.4, json!({}));
    let on = |colour, texture: &Value| {
        let mut material = plain(colour);
        material["pbrMetallicRoughness"]["baseColorTexture"] = texture.clone();
        material
    };
    let mut waves = plain([0.3, 0.5, 0.6]);
    waves["normalTexture"] = document.texture("waves", &waves_image());
    let holes = document.texture("holes", &self::checks([255; 4], [255, 255, 255, 0]));
    let mut mask = on([0.8, 0.6, 0.2], &holes);
    (mask["alphaMode"], mask["doubleSided"]) = (json!("MASK"), json!(true));
    let mut ghost = plain([0.6, 0.7, 0.9]);
    (ghost["alphaMode"], ghost["doubleSided"]) = (json!("BLEND"), json!(true));
    ghost["pbrMetallicRoughness"]["baseColorFactor"][3] = json!(0.5);
    let mut glowing = plain([0.05; 3]);
    glowing["emissiveFactor"] = json!([1.0, 0.5, 0.15]);
    glowing["emissiveTexture"] = checks.clone();
    glowing["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 2.0}});
    [
        ("checks", on([0.9, 0.4, 0.3], checks)),
        ("waves", waves),
        ("mask", mask),
        ("ghost", ghost),
        ("glowing checks", glowing),
    ]
}

/// Rooms in two rows: a rectangle, a textured rectangle, a glowing ball; a point, a spot, and
/// parallel light through an open roof.
pub fn lights() -> Document {
    const OUTSIDE: f64 = 0.05;
    let mut document = Document::new(OURS);
    let ball = document.geometry(&globe(0.4));
    let wall = diffuse(PALE, true);
    for room in 0..6 {
        let [x, y] = [f64::from(room % 3) * 2.0 - 3.0, if room < 3 { 2.0 } else { 0.0 }];
        let open = room == 2;
        document.add("room", quads(&room_walls(x, y, open), Front::Along(DVec3::Z)), wall.clone());
        document.place("ball", ball.clone(), diffuse([0.5, 0.55, 0.6], true), dvec3(x + 1.0, y + 0.4, -1.1));
    }
    let top = |x: f64, y: f64| dvec3(x, y + 2.0 - OUTSIDE, -1.0);
    let punctual = |kind, name, intensity: f64, colour: [f64; 3]| json!({"type": kind, "name": name, "intensity": intensity, "color": colour});
    let at = top(-2.0, 2.0) - 0.4 * DVec3::Y;
    document.light(punctual("point", "point", 2.0, [1.0, 0.9, 0.7]), at, DVec3::NEG_Y);
    let mut spot = punctual("spot", "spot", 10.0, [0.7, 0.85, 1.0]);
    spot["spot"] = json!({"innerConeAngle": 0.35, "outerConeAngle": 0.55});
    document.light(spot, top(0.0, 2.0), dvec3(0.15, -1.0, -0.1));
    let sun = punctual("directional", "sun", 5.0, [1.0, 0.95, 0.85]);
    document.light(sun, dvec3(2.0, 9.0, -1.0), dvec3(-0.35, -1.0, 0.15));
    let panel = |x: f64, half: f64| horizontal(x, -1.0, half, half, 2.0 - OUTSIDE);
    let front = Front::Along(DVec3::NEG_Y);
    document.add("panel", quads(&[panel(-2.0, 0.3)], front), emitter([16.0, 15.0, 13.0]));
    let colours = document.texture("colours", &checks([255, 90, 40, 255], [40, 110, 255, 255]));
    let mut screen = emitter([16.0; 3]);
    screen["emissiveTexture"] = colours;
    document.add("screen", pictured(panel(0.0, 0.4), 1.0), screen);
    let bulb = document.geometry(&globe(0.12));
    document.place("bulb", bulb, emitter([50.0, 41.0, 28.0]), dvec3(2.0, 1.55, -1.0));
    document.look(dvec3(0.0, 2.0, 9.0), dvec3(0.0, 2.0, 0.0), 26f64.to_radians(), 1.5);
    document
}

/// Floor, back, sides and, unless it is open, ceiling of a room whose left lower front corner is (x, y).
fn room_walls(x: f64, y: f64, open: bool) -> Vec<Quad> {
    let [x1, y1, z] = [x + 2.0, y + 2.0, -2.0];
    let level = |y: f64| [dvec3(x, y, 0.0), dvec3(x1, y, 0.0), dvec3(x1, y, z), dvec3(x, y, z)];
    let side = |x: f64| [dvec3(x, y, 0.0), dvec3(x, y1, 0.0), dvec3(x, y1, z), dvec3(x, y, z)];
    let back = [dvec3(x, y, z), dvec3(x1, y, z), dvec3(x1, y1, z), dvec3(x, y1, z)];
    let mut walls = vec![level(y), back, side(x), side(x1)];
    if !open {
        walls.push(level(y1));
    }
    walls
}

/// 8 x 4 squares of two colours.
fn checks(one: [u8; 4], other: [u8; 4]) -> RgbaImage {
    RgbaImage::from_fn(64, 32, |x, y| Rgba(if (x / 8 + y / 8) % 2 == 0 { one } else { other }))
}

/// Normals of waves around and along.
fn waves_image() -> RgbaImage {
    const TURN: f64 = std::f64::consts::TAU;
    RgbaImage::from_fn(256, 128, |x, y| {
        let [u, v] = [f64::from(x) / 256.0, f64::from(y) / 128.0];
        let normal = dvec3(-0.5 * (TURN * 12.0 * u).cos(), 0.5 * (TURN * 6.0 * v).cos(), 1.0).normalize();
        let [r, g, b] = normal.to_array().map(|n| ((n * 0.5 + 0.5) * 255.0).round() as u8);
        Rgba([r, g, b, 255])
    })
}
