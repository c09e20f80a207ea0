//! A scene's fingerprint.

use glam::{Mat4, Vec3};

use crate::{Camera, Instance, Material, Mesh, Scene, Surface};

/// Changes whenever what is hashed, or how, changes.
const FORMAT: &[u8] = b"midway-scene 1";

impl Scene {
    /// BLAKE3 of everything that the image depends on, in hexadecimal: the same on every machine,
    /// and for the same content read from another format. Names do not count.
    pub fn hash(&self) -> String {
        let mut hasher = Hasher(blake3::Hasher::new());
        hasher.bytes(FORMAT);
        hasher.list(&self.cameras, Hasher::camera);
        hasher.list(&self.meshes, Hasher::mesh);
        hasher.list(&self.instances, Hasher::instance);
        hasher.list(&self.materials, Hasher::material);
        hasher.0.finalize().to_hex().to_string()
    }
}

struct Hasher(blake3::Hasher);

impl Hasher {
    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    fn float(&mut self, x: f32) {
        self.bytes(&x.to_le_bytes());
    }

    fn vec3(&mut self, v: &Vec3) {
        v.to_array().into_iter().for_each(|x| self.float(x));
    }

    fn matrix(&mut self, m: &Mat4) {
        m.to_cols_array().into_iter().for_each(|x| self.float(x));
    }

    fn list<T>(&mut self, items: &[T], one: impl Fn(&mut Self, &T)) {
        self.bytes(&(items.len() as u64).to_le_bytes());
        for item in items {
            one(self, item);
        }
    }

    fn camera(&mut self, camera: &Camera) {
        self.matrix(&camera.world_from_camera);
        self.float(camera.yfov);
        self.float(camera.aspect.unwrap_or(0.0));
    }

    fn mesh(&mut self, mesh: &Mesh) {
        self.list(&mesh.positions, Self::vec3);
        self.list(&mesh.normals, Self::vec3);
        self.list(mesh.triangles.as_flattened(), |h, i| h.bytes(&i.to_le_bytes()));
        self.bytes(&mesh.material.to_le_bytes());
    }

    fn instance(&mut self, instance: &Instance) {
        self.bytes(&instance.mesh.to_le_bytes());
        self.matrix(&instance.world_from_mesh);
    }

    fn material(&mut self, material: &Material) {
        match &material.surface {
            Surface::Diffuse { reflectance } => {
                self.bytes(&[0]);
                self.vec3(reflectance);
            }
            Surface::Mirror { reflectance } => {
                self.bytes(&[1]);
                self.vec3(reflectance);
            }
            Surface::Dielectric { ior, tint, sigma_a, thin } => {
                self.bytes(&[2, u8::from(*thin)]);
                self.float(*ior);
                self.vec3(tint);
                self.vec3(sigma_a);
            }
        }
        self.vec3(&material.emission);
        self.bytes(&[u8::from(material.double_sided)]);
    }
}
