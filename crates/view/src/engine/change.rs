//! Changes of the scene, prepared on a thread of their own while its picture goes on: what is around it, and
//! the materials that its meshes have.

use std::sync::Arc;

use glam::{Mat3, Vec3};
use midway_render::{Basis, Hold, RenderSettings, Renderer};
use midway_scene::{Environment, Image, Scene, Surround};

use super::{Engine, Half, compile_beside, hold_limits};
use crate::{
    ViewError,
    protocol::{Method, Surroundings},
};

/// Stands for the environment of a scene that has none.
pub(super) const WHITE: Environment =
    Environment { radiance: Vec3::ONE, image: None, world_from_environment: Mat3::IDENTITY };

/// A change of a scene.
pub enum Change {
    /// Another strength or turn of the environment, or an image in place of it.
    Surround(Surroundings, Option<Image>),
    /// The material of each mesh.
    Dress(Vec<u32>),
}

/// A scene and its renderers as they are, for a thread that prepares a change of them.
pub struct Sketch {
    basis: Basis,
    scene: Arc<Scene>,
    /// The environment as it was loaded, or dropped, with its image.
    base: Surround,
    n_images: usize,
    settings: RenderSettings,
    right: Option<RenderSettings>,
}

/// A change that is ready to be shown.
pub struct Prepared {
    left: Renderer,
    right: Option<Renderer>,
    outcome: Outcome,
}

enum Outcome {
    Surround { base: Surround, surroundings: Surroundings, environment: Option<Environment> },
    Dress(Arc<Scene>),
}

/// What is shown no more. To give its memory back may take a while.
pub type Left = Box<dyn Send>;

impl Sketch {
    /// Prepares a change.
    ///
    /// # Errors
    /// If the scene cannot be rendered with it.
    pub fn prepare(self, change: Change) -> Result<Prepared, ViewError> {
        let Self { basis, scene, base, n_images, settings, right } = self;
        let (left, outcome) = match change {
            Change::Surround(surroundings, image) => {
                let base = match image {
                    Some(image) => {
                        let index = Some(n_images as u32);
                        Surround {
                            environment: Some(Environment { image: index, ..WHITE }),
                            image: Some(image),
                        }
                    }
                    None => base,
                };
                let environment = base.environment.and_then(|base| surroundings.of_environment(base));
                let image = environment.and(base.image.clone());
                let left = basis.surrounded(&scene, &Surround { environment, image }, settings)?;
                (left, Outcome::Surround { base, surroundings, environment })
            }
            Change::Dress(materials) => {
                let dressed = Arc::new(dressed(&scene, &materials)?);
                let left = basis.dressed(&scene, &dressed, settings)?;
                compile_beside(&left)?;
                (left, Outcome::Dress(dressed))
            }
        };
        let right = right.map(|settings| left.beside(settings)).transpose()?;
        Ok(Prepared { left, right, outcome })
    }
}

fn dressed(scene: &Scene, materials: &[u32]) -> Result<Scene, ViewError> {
    if materials.len() != scene.meshes.len() {
        return Err(ViewError::Refused("these materials are another scene's".into()));
    }
    let mut dressed = scene.clone();
    for (mesh, &material) in dressed.meshes.iter_mut().zip(materials) {
        mesh.material = material;
    }
    Ok(dressed)
}

impl Surroundings {
    /// Checks what a browser asks for.
    ///
    /// # Errors
    /// If it is out of range.
    pub fn check(&self) -> Result<(), ViewError> {
        if !((0.0..=1e6).contains(&self.strength) && self.rotation.is_finite()) {
            return Err(ViewError::Refused("an environment's strength is 0 to a million".into()));
        }
        Ok(())
    }

    /// An environment so strong and so turned; none where nothing of it is left.
    fn of_environment(&self, base: Environment) -> Option<Environment> {
        let turn = Mat3::from_rotation_y(self.rotation.to_radians());
        (self.strength > 0.0).then(|| Environment {
            radiance: base.radiance * self.strength,
            world_from_environment: turn * base.world_from_environment,
            ..base
        })
    }
}

impl Engine {
    /// What changes of the scene are prepared from.
    pub fn sketch(&self) -> Sketch {
        let right = self.right.as_ref().map(|half| self.right_settings(half, &self.settings));
        Sketch {
            basis: self.left.renderer.basis(),
            scene: Arc::clone(&self.scene),
            base: self.base.clone(),
            n_images: self.n_images,
            settings: self.settings.clone(),
            right,
        }
    }

    fn right_settings(&self, right: &Half, settings: &RenderSettings) -> RenderSettings {
        // Less than its K may be under way while the camera moves.
        let method = Method { k: self.right_k, ..Method::of(&right.renderer.settings().integrator) };
        RenderSettings { integrator: method.settings(), ..settings.clone() }
    }

    /// Shows a change that was prepared from this engine's last [`Engine::sketch`], as all else is asked for by
    /// now. After an error all is as it was.
    ///
    /// # Errors
    /// If what was asked for meanwhile does not fit it.
    pub fn take(&mut self, prepared: Prepared) -> Result<Left, ViewError> {
        let Prepared { mut left, right, outcome } = prepared;
        let scene = match &outcome {
            Outcome::Surround { .. } => &self.scene,
            Outcome::Dress(scene) => scene,
        };
        // Factors are of groups by their places.
        let same_groups = match &outcome {
            Outcome::Surround { .. } => true,
            Outcome::Dress(scene) => scene.light_groups().names == self.scene.light_groups().names,
        };
        let mut settings = self.settings.clone();
        settings.light_groups &= same_groups;
        left.set_settings(settings.clone())?;
        left.set_camera(scene, &self.camera)?;
        let right = match (&self.right, right) {
            (None, _) => None,
            (Some(half), Some(mut right)) => {
                right.set_settings(self.right_settings(half, &settings))?;
                right.set_camera(scene, &self.camera)?;
                Some(right)
            }
            (Some(half), None) => Some(left.beside(self.right_settings(half, &settings))?),
        };
        let halves = (std::mem::replace(&mut self.left, Half::new(left)), self.right.take());
        self.right = right.map(Half::new);
        if !same_groups {
            self.mix.clear();
        }
        self.settings = settings;
        self.hold = Hold::new(hold_limits(&self.settings, self.hold_time));
        self.previewed = false;
        Ok(match outcome {
            Outcome::Dress(scene) => Box::new((halves, std::mem::replace(&mut self.scene, scene))),
            Outcome::Surround { base, surroundings, environment } => {
                // Whoever prepared this has let go of the scene.
                let scene = Arc::make_mut(&mut self.scene);
                let images: Vec<Image> = scene.images.drain(self.n_images..).collect();
                let index = base.environment.and_then(|base| base.image);
                let is_dropped = index == Some(self.n_images as u32);
                scene.images.extend(base.image.clone().filter(|_| is_dropped));
                scene.environment = environment;
                (self.base, self.surroundings) = (base, surroundings);
                Box::new((halves, images))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use midway_render::IntegratorSettings;
    use midway_scene::Texels;

    use super::*;
    use crate::{
        engine::tests::{engine, scene},
        protocol::View,
    };

    fn sky() -> Image {
        let texels: Vec<[f32; 4]> = (0..32).map(|i| [0.1 * i as f32, 0.5, 0.2, 1.0]).collect();
        Image { name: String::new(), width: 8, height: 4, texels: Texels::Float(texels.into()) }
    }

    fn two_samples(engine: &mut Engine) -> [midway_film::Image; 2] {
        let image = |renderer: &mut Renderer| {
            renderer.restart().unwrap();
            while renderer.samples() < 2 {
                renderer.step(2 - renderer.samples()).unwrap();
            }
            renderer.image().unwrap()
        };
        [image(&mut engine.left.renderer), image(&mut engine.right.as_mut().unwrap().renderer)]
    }

    /// What is asked for while a change is prepared holds when it is shown, and the picture has the bits of a
    /// scene that was opened that way.
    #[test]
    fn a_change_is_shown_as_all_else_is_by_then() {
        let (turned, whole) =
            (Surroundings { strength: 0.5, rotation: 40.0 }, Surroundings { strength: 1.0, rotation: 0.0 });
        let path = Method::of(&IntegratorSettings::default());
        let look = View {
            eye: [0.2, 1.0, 3.0],
            ..serde_json::from_str(r#"{"eye":[0,0,0],"target":[0,1,0],"up":[0,1,0]}"#).unwrap()
        };
        let mut live = engine(scene());
        let materials: Vec<u32> = live.scene.meshes.iter().rev().map(|mesh| mesh.material).collect();
        let mut expected = scene();
        for (mesh, &material) in expected.meshes.iter_mut().zip(&materials) {
            mesh.material = material;
        }
        expected.images.push(sky());
        let image = Some(expected.images.len() as u32 - 1);
        expected.environment = turned.of_environment(Environment { image, ..WHITE });
        let mut expected = engine(expected);
        expected.look(&look).unwrap();
        expected.left.renderer.set_camera(&expected.scene, &expected.camera).unwrap();
        expected.split(Some(path)).unwrap();
        let changes =
            [Change::Surround(whole, Some(sky())), Change::Dress(materials), Change::Surround(turned, None)];
        for change in changes {
            let sketch = live.sketch();
            live.look(&look).unwrap();
            if live.right.is_none() {
                live.split(Some(path)).unwrap();
            }
            live.take(sketch.prepare(change).unwrap()).unwrap();
            assert_eq!((live.left.renderer.samples(), live.scene.images.len()), (0, 1 + live.n_images));
        }
        assert_eq!(two_samples(&mut live), two_samples(&mut expected));
        // A second image takes the place of the first; without an environment there is none.
        live.take(live.sketch().prepare(Change::Surround(whole, Some(sky()))).unwrap()).unwrap();
        assert_eq!(live.scene.images.len(), 1 + live.n_images);
        let none = Surroundings { strength: 0.0, rotation: 0.0 };
        live.take(live.sketch().prepare(Change::Surround(none, None)).unwrap()).unwrap();
        assert_eq!(live.scene.environment, None);
    }

    #[test]
    fn what_cannot_be_prepared_leaves_all_as_it_was() {
        let mut live = engine(scene());
        live.split(Some(Method::of(&IntegratorSettings::default()))).unwrap();
        let before = two_samples(&mut live);
        let n = live.scene.meshes.len();
        let broken = Image { texels: Texels::Float([[f32::NAN; 4]; 32].into()), ..sky() };
        for change in [
            Change::Dress(vec![u32::MAX; n]),
            Change::Dress(vec![0; n + 1]),
            Change::Surround(Surroundings { strength: 1.0, rotation: 0.0 }, Some(broken)),
        ] {
            assert!(live.sketch().prepare(change).is_err());
        }
        assert_eq!(two_samples(&mut live), before);
    }
}
