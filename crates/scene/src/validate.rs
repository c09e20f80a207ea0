//! Checks everything that the rest of the program relies on.

use glam::{DMat3, Mat3, Vec3, Vec4};

use crate::{Camera, Instance, Material, Mesh, Scene, SceneError, Surface};

/// How far a normal's length and a camera's axes may be from 1: rounding in files that store
/// them with three or four decimals.
const UNIT_TOLERANCE: f32 = 1e-3;

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
            validate_material(&label("material", i, &material.name), material)?;
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
        let bounds = self.bounds();
        if bounds.is_empty() {
            return Err(SceneError::NoTriangles);
        }
        let finite = self.world_triangles().all(|t| t.positions.iter().all(|p| p.is_finite()));
        check(finite && bounds.diagonal().is_finite(), "the scene", || {
            "it is larger than a number of 32 bits holds".to_owned()
        })
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
    let yfov = camera.yfov;
    check(yfov > 0.0 && yfov < std::f32::consts::PI, what, || {
        format!("its field of view, {yfov} radians, is not in (0, π)")
    })?;
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

fn validate_material(what: &str, material: &Material) -> Checked {
    let emission = material.emission;
    check(emission.is_finite() && emission.cmpge(Vec3::ZERO).all(), what, || {
        format!("its emission, {emission}, is not finite and at least 0")
    })?;
    let fraction = |name: &str, value: Vec3| {
        let holds = value.cmpge(Vec3::ZERO).all() && value.cmple(Vec3::ONE).all();
        check(holds, what, || format!("its {name}, {value}, is not within 0 and 1"))
    };
    match material.surface {
        Surface::Diffuse { reflectance } | Surface::Mirror { reflectance } => {
            fraction("reflectance", reflectance)
        }
        Surface::Dielectric { ior, tint, sigma_a, .. } => {
            fraction("tint", tint)?;
            check(ior > 0.0 && ior.is_finite(), what, || {
                format!("its index of refraction, {ior}, is not positive")
            })?;
            let holds = sigma_a.is_finite() && sigma_a.cmpge(Vec3::ZERO).all();
            check(holds, what, || format!("its absorption, {sigma_a}, is not finite and at least 0"))
        }
    }
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
