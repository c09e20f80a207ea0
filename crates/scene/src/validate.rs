//! Checks everything that the rest of the program relies on.

use glam::{DMat3, Mat3, Vec3, Vec4};

use crate::{
    Camera, CoatNormal, ColorInput, ConductorFresnel, Environment, Image, Instance, Light, LightKind,
    MAX_DISPERSION, Material, Mesh, MetallicRoughness, NormalMap, Opacity, Projection, Roughness,
    ScalarInput, Scene, SceneError, Surface, Surround, Texels, Texture,
};

/// How far a normal's length and a camera's axes may be from 1: rounding in files that store
/// them with three or four decimals.
const UNIT_TOLERANCE: f32 = 1e-3;

/// Squares of distances are numbers of 32 bits, with room for the sides of a box and a sphere around it.
const FARTHEST: f32 = 1e18;

type Checked = Result<(), SceneError>;

impl Scene {
    /// Checks that indices are in range and values finite and within their domains, and that
    /// there is something to render. A scene without cameras or lights is valid.
    ///
    /// # Errors
    ///
    /// [`SceneError`] names the first thing that is wrong.
    pub fn validate(&self) -> Checked {
        for (i, camera) in self.cameras.iter().enumerate() {
            validate_camera(&label("camera", i, &camera.name), camera)?;
        }
        for (i, material) in self.materials.iter().enumerate() {
            validate_material(&label("material", i, &material.name), material, self.images.len())?;
        }
        for (i, mesh) in self.meshes.iter().enumerate() {
            let what = label("mesh", i, &mesh.name);
            in_range(&what, "material", mesh.material, self.materials.len())?;
            validate_mesh(&what, mesh)?;
        }
        for (i, instance) in self.instances.iter().enumerate() {
            let what = format!("instance {i}");
            in_range(&what, "mesh", instance.mesh, self.meshes.len())?;
            validate_instance(&what, instance)?;
        }
        for (i, image) in self.images.iter().enumerate() {
            validate_image(&label("image", i, &image.name), image)?;
        }
        for (i, light) in self.lights.iter().enumerate() {
            validate_light(&label("light", i, &light.name), light)?;
        }
        if let Some(environment) = &self.environment {
            validate_environment(environment)?;
            let in_list = |image| in_range("the environment", "image", image, self.images.len());
            environment.image.map_or(Ok(()), in_list)?;
        }
        let bounds = self.bounds();
        if bounds.is_empty() {
            return Err(SceneError::NoTriangles);
        }
        // Meshes and transforms are finite, and are multiplied in f64: no vertex is NaN.
        let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
        check(farthest <= FARTHEST, "the scene", || {
            format!(
                "it reaches {farthest:.1e} from its origin, and no more than {FARTHEST:.0e} can be rendered"
            )
        })
    }
}

impl Surround {
    /// Checks it as [`Scene::validate`] does where it is a part of one.
    ///
    /// # Errors
    ///
    /// [`SceneError`] names the first thing that is wrong.
    pub fn validate(&self) -> Checked {
        self.environment.as_ref().map_or(Ok(()), validate_environment)?;
        self.image.as_ref().map_or(Ok(()), |image| validate_image("the environment's image", image))
    }
}

fn label(kind: &str, index: usize, name: &str) -> String {
    if name.is_empty() { format!("{kind} {index}") } else { format!("{kind} {index} (\"{name}\")") }
}

fn check(holds: bool, what: &str, problem: impl FnOnce() -> String) -> Checked {
    if holds {
        return Ok(());
    }
    Err(SceneError::bad(what, problem()))
}

fn in_range(what: &str, list: &'static str, index: u32, len: usize) -> Checked {
    if (index as usize) < len {
        return Ok(());
    }
    Err(SceneError::IndexOutOfRange { what: what.to_owned(), list, index: index as usize, len })
}

fn validate_camera(what: &str, camera: &Camera) -> Checked {
    match camera.projection {
        Projection::Perspective { yfov } => {
            check(yfov > 0.0 && yfov < std::f32::consts::PI, what, || {
                format!("its field of view, {yfov} radians, is not in (0, π)")
            })?;
        }
        Projection::Orthographic { height } => positive(what, "height", height)?,
    }
    non_negative(what, "lens radius", Vec3::splat(camera.lens_radius))?;
    positive(what, "focus distance", camera.focus_distance)?;
    let pixels = camera.resolution.unwrap_or([1; 2]);
    check(pixels[0] > 0 && pixels[1] > 0, what, || "its film has no pixels".to_owned())?;
    let aspect = camera.aspect.unwrap_or(1.0);
    check(aspect > 0.0 && aspect.is_finite(), what, || {
        format!("its aspect ratio, {aspect}, is not positive")
    })?;
    let m = camera.world_from_camera;
    let linear = Mat3::from_mat4(m);
    let off = linear.transpose() * linear - Mat3::IDENTITY;
    let orthonormal = off.to_cols_array().iter().all(|x| x.abs() <= UNIT_TOLERANCE);
    check(m.is_finite() && orthonormal && linear.determinant() > 0.0 && m.row(3) == Vec4::W, what, || {
        "its matrix is not a rotation and a translation".to_owned()
    })
}

fn positive(what: &str, name: &str, value: f32) -> Checked {
    check(value > 0.0 && value.is_finite(), what, || format!("its {name}, {value}, is not positive"))
}

fn non_negative(what: &str, name: &str, value: Vec3) -> Checked {
    check(value.is_finite() && value.cmpge(Vec3::ZERO).all(), what, || {
        format!("its {name}, {value}, is not finite and at least 0")
    })
}

fn fraction(what: &str, name: &str, value: Vec3) -> Checked {
    let holds = value.cmpge(Vec3::ZERO).all() && value.cmple(Vec3::ONE).all();
    check(holds, what, || format!("its {name}, {value}, is not within 0 and 1"))
}

/// A value in [0, 1]; that of a texture may be greater: their product is cut off where it is used.
fn factor(what: &str, name: &str, value: Vec3, is_textured: bool) -> Checked {
    if is_textured { non_negative(what, name, value) } else { fraction(what, name, value) }
}

fn validate_material(what: &str, material: &Material, n_images: usize) -> Checked {
    non_negative(what, "emission", material.emission.value)?;
    texture(what, material.emission.texture.as_ref(), n_images)?;
    match &material.opacity {
        Opacity::Opaque => {}
        Opacity::Mask(input, _) | Opacity::Blend(input) => scalar(what, "opacity", input, n_images)?,
    }
    if let Some(map) = &material.normal_map {
        normal_map(what, map, n_images)?;
    }
    let color = |name: &str, input: &ColorInput| {
        factor(what, name, input.value, input.texture.is_some())?;
        texture(what, input.texture.as_ref(), n_images)
    };
    let rough = |input: &Roughness| {
        scalar(what, "roughness", &input.along, n_images)?;
        scalar(what, "roughness", &input.across, n_images)
    };
    match &material.surface {
        Surface::Null => Ok(()),
        Surface::Diffuse { reflectance } => color("reflectance", reflectance),
        Surface::Conductor { fresnel, roughness } => {
            rough(roughness)?;
            match fresnel {
                ConductorFresnel::Schlick { f0 } => color("reflectance", f0),
                ConductorFresnel::Complex { eta, k, tint } => {
                    non_negative(what, "index of refraction", *eta)?;
                    non_negative(what, "extinction", *k)?;
                    color("tint", tint)
                }
            }
        }
        Surface::Dielectric { ior, dispersion, reflection, transmission, sigma_a, roughness, .. } => {
            positive(what, "index of refraction", *ior)?;
            bounded_dispersion(what, *dispersion)?;
            color("reflection tint", reflection)?;
            color("transmission tint", transmission)?;
            non_negative(what, "absorption", *sigma_a)?;
            rough(roughness)
        }
        Surface::Plastic { reflectance, specular, ior, roughness, .. } => {
            positive(what, "index of refraction", *ior)?;
            color("reflectance", reflectance)?;
            color("specular reflectance", specular)?;
            rough(roughness)
        }
        Surface::MetallicRoughness(model) => validate_metallic_roughness(what, model, n_images),
    }
}

fn validate_metallic_roughness(what: &str, model: &MetallicRoughness, n_images: usize) -> Checked {
    let colors = [("base colour", &model.base_color), ("sheen colour", &model.sheen_color)];
    for (name, input) in colors {
        factor(what, name, input.value, input.texture.is_some())?;
        texture(what, input.texture.as_ref(), n_images)?;
    }
    // May exceed 1 by the extension: the reflectance is clamped where it is used.
    non_negative(what, "specular colour", model.specular_color.value)?;
    texture(what, model.specular_color.texture.as_ref(), n_images)?;
    let scalars = [
        ("metallic factor", &model.metallic),
        ("roughness", &model.roughness),
        ("specular factor", &model.specular),
        ("transmission factor", &model.transmission),
        ("clearcoat factor", &model.clearcoat),
        ("clearcoat roughness", &model.clearcoat_roughness),
        ("sheen roughness", &model.sheen_roughness),
        ("anisotropy", &model.anisotropy),
    ];
    for (name, input) in scalars {
        scalar(what, name, input, n_images)?;
    }
    texture(what, model.anisotropy_direction.as_ref(), n_images)?;
    if let CoatNormal::Map(map) = &model.clearcoat_normal {
        normal_map(what, map, n_images)?;
    }
    positive(what, "index of refraction", model.ior)?;
    bounded_dispersion(what, model.dispersion)?;
    non_negative(what, "absorption", model.sigma_a)?;
    check(model.anisotropy_rotation.is_finite(), what, || {
        "its anisotropy's rotation is not finite".to_owned()
    })
}

fn normal_map(what: &str, map: &NormalMap, n_images: usize) -> Checked {
    texture(what, Some(&map.texture), n_images)?;
    check(map.scale.is_finite(), what, || "the scale of its normal map is not finite".to_owned())
}

fn bounded_dispersion(what: &str, dispersion: f32) -> Checked {
    check((0.0..=MAX_DISPERSION).contains(&dispersion), what, || {
        format!("its dispersion is {dispersion}, outside [0, {MAX_DISPERSION}]")
    })
}

fn scalar(what: &str, name: &str, input: &ScalarInput, n_images: usize) -> Checked {
    factor(what, name, Vec3::splat(input.value), input.texture.is_some())?;
    texture(what, input.texture.as_ref().map(|(texture, _)| texture), n_images)
}

fn texture(what: &str, texture: Option<&Texture>, n_images: usize) -> Checked {
    let Some(texture) = texture else { return Ok(()) };
    in_range(what, "image", texture.image, n_images)?;
    let sets = 2;
    in_range(what, "UV set", texture.uv_set, sets)?;
    check(texture.image_from_uv.is_finite(), what, || "a texture's transform is not finite".to_owned())
}

fn validate_image(what: &str, image: &Image) -> Checked {
    let texels = image.width as usize * image.height as usize;
    check(texels > 0 && texels == image.texels.len(), what, || {
        format!("it is {} x {} and holds {} texels", image.width, image.height, image.texels.len())
    })?;
    let Texels::Float(values) = &image.texels else { return Ok(()) };
    check(values.as_flattened().iter().all(|x| x.is_finite()), what, || "a texel is not finite".to_owned())
}

fn validate_light(what: &str, light: &Light) -> Checked {
    match light.kind {
        LightKind::Point { position, intensity } => {
            non_negative(what, "intensity", intensity)?;
            finite(what, position)
        }
        LightKind::Spot { position, direction, intensity, inner_angle, outer_angle, .. } => {
            non_negative(what, "intensity", intensity)?;
            finite(what, position)?;
            unit(what, direction)?;
            let holds =
                inner_angle >= 0.0 && inner_angle < outer_angle && outer_angle <= std::f32::consts::PI;
            check(holds, what, || {
                format!(
                    "its cones, {inner_angle} within {outer_angle} radians, are not 0 <= inner < outer <= π"
                )
            })
        }
        LightKind::Directional { direction, irradiance } => {
            non_negative(what, "irradiance", irradiance)?;
            unit(what, direction)
        }
    }
}

fn finite(what: &str, position: Vec3) -> Checked {
    check(position.is_finite(), what, || "its position is not finite".to_owned())
}

fn unit(what: &str, direction: Vec3) -> Checked {
    check((direction.length() - 1.0).abs() <= UNIT_TOLERANCE, what, || {
        format!("its direction, {direction}, is not of length 1")
    })
}

fn validate_environment(environment: &Environment) -> Checked {
    let what = "the environment";
    non_negative(what, "radiance", environment.radiance)?;
    let m = environment.world_from_environment;
    let off = m.transpose() * m - Mat3::IDENTITY;
    let orthonormal = off.to_cols_array().iter().all(|x| x.abs() <= UNIT_TOLERANCE);
    check(orthonormal, what, || "its transform is not a rotation".to_owned())
}

fn validate_mesh(what: &str, mesh: &Mesh) -> Checked {
    let n = mesh.positions.len();
    for &index in mesh.triangles.as_flattened() {
        in_range(what, "vertex", index, n)?;
    }
    let not_finite = mesh.positions.iter().position(|p| !p.is_finite());
    check(not_finite.is_none(), what, || format!("vertex {} is not finite", not_finite.unwrap_or_default()))?;
    check(mesh.normals.is_empty() || mesh.normals.len() == n, what, || {
        format!("{} normals for {n} vertices", mesh.normals.len())
    })?;
    let per_vertex = [
        ("texture coordinates", mesh.uvs[0].len()),
        ("second texture coordinates", mesh.uvs[1].len()),
        ("colours", mesh.colors.len()),
        ("tangents", mesh.tangents.len()),
    ];
    for (name, len) in per_vertex {
        check(len == 0 || len == n, what, || format!("{len} {name} for {n} vertices"))?;
    }
    let finite = mesh.uvs.iter().flatten().all(|uv| uv.is_finite())
        && mesh.colors.iter().chain(&mesh.tangents).all(|v| v.is_finite());
    check(finite, what, || "a texture coordinate, colour or tangent is not finite".to_owned())?;
    let is_unit = |v: &Vec3| (v.length() - 1.0).abs() <= UNIT_TOLERANCE;
    let odd = mesh.normals.iter().position(|v| !is_unit(v));
    check(odd.is_none(), what, || format!("normal {} is not of length 1", odd.unwrap_or_default()))
}

fn validate_instance(what: &str, instance: &Instance) -> Checked {
    let m = instance.world_from_mesh;
    check(m.is_finite() && m.row(3) == Vec4::W, what, || "its matrix is not finite and affine".to_owned())?;
    check(DMat3::from_mat4(m.as_dmat4()).determinant() != 0.0, what, || {
        "its matrix flattens it to nothing".to_owned()
    })
}
