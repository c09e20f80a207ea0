//! What `midway info` says of lights.

use midway_scene::{Light, LightKind, Scene};
use serde_json::{Value, json};

/// For programs: what emissive triangles emit together, every other light, and the environment, by
/// what crosses disks that cover the scene. Powers are RGB, W.
pub fn to_json(scene: &Scene) -> Value {
    let radius = radius(scene);
    let one = |light: &Light| {
        json!({
            "name": light.name,
            "kind": kind_name(&light.kind),
            "power": light.kind.power(radius).to_array(),
        })
    };
    let environment = scene.environment.as_ref().map(|environment| {
        let image = scene.environment_image();
        json!({
            "radiance": environment.radiance.to_array(),
            "image": image.map(|image| json!({
                "name": image.name, "width": image.width, "height": image.height,
            })),
            "power": environment.power(image, radius).to_array(),
        })
    });
    json!({
        "emissive_triangles_power": scene.emitted_power().to_array(),
        "lights": Value::from_iter(scene.lights.iter().map(one)),
        "light_groups": Value::from_iter(scene.light_groups().names.iter().map(|name| &**name)),
        "environment": environment,
    })
}

/// For people.
pub fn to_lines(scene: &Scene) -> Vec<String> {
    let radius = radius(scene);
    let watts = |power: glam::DVec3| format!("{:.4} {:.4} {:.4} W", power.x, power.y, power.z);
    let mut lines = vec![format!("lights     {}", scene.lights.len())];
    if scene.counts().emissive_triangles > 0 {
        lines.push(format!("  emissive triangles: {}", watts(scene.emitted_power())));
    }
    lines.extend(scene.lights.iter().enumerate().map(|(index, light)| {
        let name = if light.name.is_empty() { "(no name)" } else { &light.name };
        format!("  {index} {name}: {}, {}", kind_name(&light.kind), watts(light.kind.power(radius)))
    }));
    if scene.has_light() {
        lines.push(format!("  groups: {}", scene.light_groups().names.join(", ")));
    }
    if let Some(environment) = &scene.environment {
        let image = scene.environment_image();
        let what = image.map_or_else(
            || format!("constant {}", environment.radiance),
            |image| format!("image {:?}, {} x {}", image.name, image.width, image.height),
        );
        lines
            .push(format!("  environment: {what}, {} on the scene", watts(environment.power(image, radius))));
    }
    lines
}

fn radius(scene: &Scene) -> f64 {
    scene.bounds().sphere().radius.into()
}

fn kind_name(kind: &LightKind) -> &'static str {
    match kind {
        LightKind::Point { .. } => "point",
        LightKind::Spot { .. } => "spot",
        LightKind::Directional { .. } => "directional",
    }
}
