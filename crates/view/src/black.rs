//! Why a picture is black, where it is.

use midway_film::{Display, Image};
use midway_render::{Integrator, Join};

use crate::{ViewError, engine::Engine, nothing::is_nothing, pick};

/// A pixel this dark in 8 bits is black to the eye.
const BLACK: u8 = 2;
/// Places of the film, along each side, that are asked whether anything is there.
const PLACES: u32 = 7;
/// More triangles are not asked one by one: a frame waits for the answer.
const MANY: usize = 200_000;

/// Whether all of a picture is, its pixels as RGBA.
pub fn is_black(picture: &[u8]) -> bool {
    picture.chunks_exact(4).all(|pixel| pixel[..3].iter().all(|byte| *byte <= BLACK))
}

/// The reason, if all of the picture is black as it is shown; `image` without the mix of its lights.
///
/// # Errors
/// If the device fails.
pub fn reason(engine: &Engine, image: &Image) -> Result<Option<String>, ViewError> {
    let shown = engine.mixed_image()?;
    Ok(reason_of(engine, image, &shown))
}

fn reason_of(engine: &Engine, image: &Image, shown: &Image) -> Option<String> {
    let display = Display { exposure: engine.shown.exposure, tone_map: engine.shown.tone_map.into() };
    if shown.pixels.iter().any(|pixel| display.encode_u8(*pixel).iter().any(|byte| *byte > BLACK)) {
        return None;
    }
    let scene = &engine.scene;
    let integrator = engine.left.renderer.settings().integrator;
    let surfaces_emit = scene.counts().emissive_triangles > 0 || scene.environment.is_some();
    let hits_alone = integrator.integrator == Integrator::PathNaive
        || integrator.joins() == Some(Join::SingleStep) && !integrator.uses_nee();
    let text = if !image.is_black() && shown.is_black() {
        "All lights are turned down. Press Reset lights."
    } else if !image.is_black() {
        let brightest = image.pixels.iter().flatten().copied().fold(0.0, f32::max);
        return Some(format!(
            "The exposure is too low: the brightest pixel is {brightest:.2e} W/(m² sr). Press ] to raise it."
        ));
    } else if is_nothing(scene) {
        "There is no scene. Drop a .glb, or a folder with a .gltf, on the page."
    } else if !scene.has_light() {
        "Nothing emits light. Raise the environment's strength, or drop an .hdr on the page."
    } else if engine.left.stats.rejected > 0 {
        "Every contribution was NaN or infinite and is left out: the scene's numbers are at fault."
    } else if sees_nothing(engine) {
        "The camera sees nothing. Press F to bring the whole scene into view."
    } else if hits_alone && !surfaces_emit {
        "All lights are points or directions, which this integrator's paths cannot hit. Try path or bdpt (2, 4)."
    } else if integrator.integrator == Integrator::Light {
        "Light paths see no mirror and no glass, and little reaches the film. Try path or bdpt (2, 4)."
    } else if engine.settings.max_path_length.is_some_and(|n| n < 2) {
        "Paths of length 1 show lights alone. Raise the path length."
    } else {
        "No light reaches what is seen yet: is the camera inside an object, or the light behind a wall? bdpt (4) finds more."
    };
    Some(text.to_owned())
}

fn sees_nothing(engine: &Engine) -> bool {
    let (scene, camera) = (&engine.scene, &engine.camera);
    let aspect = engine.settings.width as f32 / engine.settings.height as f32;
    let middle = |i: u32| (i as f32 + 0.5) / PLACES as f32;
    let places = || (0..PLACES * PLACES).map(|i| [middle(i % PLACES), middle(i / PLACES)]);
    let near = |place: &[f32; 2]| pick::passes(engine.outline.bounds(), camera, aspect, *place);
    if places().any(|place| near(&place)) && scene.counts().triangles > MANY {
        return false; // they may be seen: too many to ask each
    }
    places().filter(near).all(|place| pick::pick(scene, camera, aspect, place).is_none())
}
