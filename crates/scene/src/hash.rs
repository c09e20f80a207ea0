//! A scene's fingerprint.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::{Camera, Image, Instance, Material, Mesh, Projection, Scene, Texels};

/// Changes whenever what is hashed, or how, changes.
const FORMAT: &[u8] = b"midway-scene 4";

/// Words that are hashed at once.
const BLOCK: usize = 4096;

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

    /// Many words of N bytes, by the thousand: one at a time they take ten times as long.
    fn words<const N: usize>(&mut self, words: impl IntoIterator<Item = [u8; N]>) {
        let mut words = words.into_iter();
        let mut block = Vec::with_capacity(BLOCK * N);
        loop {
            block.clear();
            block.extend(words.by_ref().take(BLOCK).flatten());
            if block.is_empty() {
                return;
            }
            self.bytes(&block);
        }
    }

    /// How many there are, and all of them.
    fn floats<const N: usize>(&mut self, items: impl ExactSizeIterator<Item = [f32; N]>) {
        self.bytes(&(items.len() as u64).to_le_bytes());
        self.words(items.flatten().map(f32::to_le_bytes));
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
        for list in [&mesh.positions, &mesh.normals] {
            self.floats(list.iter().map(Vec3::to_array));
        }
        for set in &mesh.uvs {
            self.floats(set.iter().map(Vec2::to_array));
        }
        for list in [&mesh.colors, &mesh.tangents] {
            self.floats(list.iter().map(Vec4::to_array));
        }
        let indices = mesh.triangles.as_flattened();
        self.bytes(&(indices.len() as u64).to_le_bytes());
        self.words(indices.iter().map(|i| i.to_le_bytes()));
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
                self.words(t.as_flattened().iter().map(|x| x.to_le_bytes()));
            }
            Texels::Float(t) => {
                self.bytes(&[3]);
                self.words(t.as_flattened().iter().map(|x| x.to_le_bytes()));
            }
        }
    }

    /// Materials, lights and the environment by what they print as: all their values, floats to the
    /// last bit.
    fn printed(&mut self, value: &impl std::fmt::Debug) {
        self.bytes(format!("{value:?}").as_bytes());
    }
}
