//! Materials as glTF says them.

use serde_json::{Value, json};

/// Lambertian.
pub fn diffuse(colour: [f64; 3], double_sided: bool) -> Value {
    let [r, g, b] = colour;
    json!({
        "doubleSided": double_sided,
        "pbrMetallicRoughness":
            {"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
        "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
    })
}

/// Black, and emits from its front.
pub fn emitter(radiance: [f64; 3]) -> Value {
    let strength = radiance.into_iter().fold(0.0, f64::max);
    let mut material = diffuse([0.0; 3], false);
    material["emissiveFactor"] = json!(radiance.map(|c| c / strength));
    material["extensions"]["KHR_materials_emissive_strength"] = json!({"emissiveStrength": strength});
    material
}

pub fn glass() -> Value {
    json!({
        "pbrMetallicRoughness":
            {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.0},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_ior": {"ior": 1.5},
            "KHR_materials_volume": {"thicknessFactor": 1.0},
        },
    })
}

/// glTF's own model with extensions.
pub fn model([r, g, b]: [f64; 3], metallic: f64, roughness: f64, extensions: Value) -> Value {
    json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness,
        },
        "extensions": extensions,
    })
}

/// A metal that reflects 95 %, smooth.
pub fn mirror() -> Value {
    json!({
        "pbrMetallicRoughness":
            {"baseColorFactor": [0.95, 0.95, 0.95, 1.0], "metallicFactor": 1.0, "roughnessFactor": 0.0},
        "extensions": {},
    })
}
