//! A scene's fingerprint.

use glam::{Mat4, Vec3};

use crate::{Camera, Image, Instance, Material, Mesh, Projection, Scene, Texels};

/// Changes whenever what is hashed, or how, changes.
const FORMAT: &[u8] = b"midway-scene 4";

impl Scene {
    /// BLAKE3 of everything that the image depends on, in hexadecimal: the same on every machine,
    /// and for the same content read from another format. Names do not count.
    pub fn hash(&self) -> String {
        let mut hasher = Hasher(blake3::Hasher::new());
        hasher.bytes(FORMAT);
        hasher.list(&self.cameras, Hasher::camera);
        hasher.list(&self.meshes, Hasher::mesh);
        hasher.list(&self.instances, Hasher::instance);
        hasher.list(&self.images, Hasher::image);
        hasher.list(&self.materials, |h, material| {
            h.printed(&Material { name: String::new(), ..material.clone() })
        });
        hasher.list(&self.lights, |h, light| h.printed(&light.kind));
        hasher.printed(&self.environment);
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
        let (kind, size) = match camera.projection {
            Projection::Perspective { yfov } => (0, yfov),
            Projection::Orthographic { height } => (1, height),
        };
        self.bytes(&[kind]);
        [size, camera.lens_radius, camera.focus_distance].into_iter().for_each(|x| self.float(x));
        self.float(camera.aspect.unwrap_or(0.0));
    }

    fn mesh(&mut self, mesh: &Mesh) {
        self.list(&mesh.positions, Self::vec3);
        self.list(&mesh.normals, Self::vec3);
        for set in &mesh.uvs {
            self.list(set, |h, uv| uv.to_array().into_iter().for_each(|x| h.float(x)));
        }
        for list in [&mesh.colors, &mesh.tangents] {
            self.list(list, |h, v| v.to_array().into_iter().for_each(|x| h.float(x)));
        }
        self.list(mesh.triangles.as_flattened(), |h, i| h.bytes(&i.to_le_bytes()));
        self.bytes(&mesh.material.to_le_bytes());
    }

    fn instance(&mut self, instance: &Instance) {
        self.bytes(&instance.mesh.to_le_bytes());
        self.matrix(&instance.world_from_mesh);
    }

    fn image(&mut self, image: &Image) {
        self.bytes(&image.width.to_le_bytes());
        self.bytes(&image.height.to_le_bytes());
        match &image.texels {
            Texels::Srgb8(t) => {
                self.bytes(&[0]);
                self.bytes(t.as_flattened());
            }
            Texels::Linear8(t) => {
                self.bytes(&[1]);
                self.bytes(t.as_flattened());
            }
            Texels::Linear16(t) => {
                self.bytes(&[2]);
                t.as_flattened().iter().for_each(|x| self.bytes(&x.to_le_bytes()));
            }
            Texels::Float(t) => {
                self.bytes(&[3]);
                t.as_flattened().iter().for_each(|x| self.float(*x));
            }
        }
    }

    /// Materials, lights and the environment by what they print as: all their values, floats to the
    /// last bit.
    fn printed(&mut self, value: &impl std::fmt::Debug) {
        self.bytes(format!("{value:?}").as_bytes());
    }
}
