//! Emitters that are no surfaces.

use glam::{Mat3, Mat4, Vec3};
use midway_scene::{Environment, Light, LightKind, SpotFalloff};

use super::{
    Loader,
    document::Class,
    node::Node,
    value::{Quantity, Value},
};
use crate::{ImportError, images::Encoding, warning::WarningKind};

type Result<T> = std::result::Result<T, ImportError>;

impl Loader<'_> {
    pub(super) fn emitter(&mut self, node: Node) -> Result<()> {
        node.disregard(&["sampling_weight", "samples"]);
        match node.plugin() {
            "point" => self.point(node),
            "spot" => self.spot(node),
            "directional" => self.directional(node),
            "constant" => self.constant(node),
            "envmap" => self.envmap(node),
            "area" => Err(node.malformed("an area emitter has to be in a shape")),
            other => {
                let message = format!("emitters of type {other:?} are not rendered");
                self.warn(WarningKind::Light, node, &message);
                Ok(())
            }
        }
    }

    fn light(&mut self, node: Node, kind: LightKind) {
        self.scene.lights.push(Light { name: node.id().to_owned(), kind, group: None });
    }

    /// What an emitter emits, W·m⁻²·sr⁻¹, W·sr⁻¹ or W·m⁻²; 1 where the file says nothing.
    fn emission(&mut self, node: Node, name: &str) -> Result<Vec3> {
        if node.child(name)?.is_some_and(|child| child.class() == Class::Texture) {
            let input = self.color(node, name, Quantity::Unbounded, 1.0)?;
            if input.texture.is_some() {
                self.warn(WarningKind::Texture, node, "textures of lights without extent are not used");
            }
            return Ok(input.value);
        }
        self.warn_of_constant(node, name);
        let scale = node.float_or("scale", 1.0)?.max(0.0);
        Ok(scale * node.color(name, Quantity::Unbounded)?.unwrap_or(Vec3::ONE))
    }

    /// `<spectrum value="1"/>` was white in Mitsuba's RGB mode for long.
    pub(super) fn warn_of_constant(&mut self, node: Node, name: &str) {
        if let Some(Value::Constant(_)) = node.value(name) {
            let message =
                "constant spectra of lights are white (Mitsuba 3.9 has them at 1.205, 0.948, 0.909)";
            self.warn(WarningKind::Approximation, node, message);
        }
    }

    fn point(&mut self, node: Node) -> Result<()> {
        let position = match node.vector("position")? {
            Some(position) => position,
            None => node.to_world()?.transform_point3(Vec3::ZERO),
        };
        let intensity = self.emission(node, "intensity")?;
        self.light(node, LightKind::Point { position, intensity });
        Ok(())
    }

    /// Full within the beam width, falling with the angle to nothing at the cutoff.
    fn spot(&mut self, node: Node) -> Result<()> {
        let cutoff = node.float_or("cutoff_angle", 20.0)?;
        let beam = node.float_or("beam_width", 0.75 * cutoff)?;
        if !(cutoff > 0.0 && cutoff <= 180.0 && beam >= 0.0) {
            return Err(
                node.malformed("its cutoff angle has to be in (0, 180] and its beam width at least 0")
            );
        }
        if node.child("texture")?.is_some() {
            node.disregard_textures()?;
            self.warn(WarningKind::Texture, node, "textures that spot lights project are not used");
        }
        let to_world = node.to_world()?;
        let outer_angle = cutoff.to_radians();
        // An edge without a transition: one that is too narrow to see.
        let inner_angle = beam.to_radians().min(outer_angle * (1.0 - 1e-4));
        let kind = LightKind::Spot {
            position: to_world.transform_point3(Vec3::ZERO),
            direction: forward(node, to_world)?,
            intensity: self.emission(node, "intensity")?,
            inner_angle,
            outer_angle,
            falloff: SpotFalloff::Angle,
        };
        self.light(node, kind);
        Ok(())
    }

    fn directional(&mut self, node: Node) -> Result<()> {
        let direction = match node.vector("direction")? {
            Some(direction) => {
                let unit = direction.as_dvec3().try_normalize();
                unit.ok_or_else(|| node.malformed("its direction has no length"))?.as_vec3()
            }
            None => forward(node, node.to_world()?)?,
        };
        let irradiance = self.emission(node, "irradiance")?;
        self.light(node, LightKind::Directional { direction, irradiance });
        Ok(())
    }

    fn constant(&mut self, node: Node) -> Result<()> {
        let radiance = self.emission(node, "radiance")?;
        self.surround(node, Environment { radiance, image: None, world_from_environment: Mat3::IDENTITY });
        Ok(())
    }

    /// By latitude and longitude: the top row is +y, the left edge -z, and u grows towards +x from
    /// there. Rows' centres span pole to pole, while here their edges do: half a row's difference.
    fn envmap(&mut self, node: Node) -> Result<()> {
        let name = node.filename()?;
        let scale = node.float_or("scale", 1.0)?;
        if scale < 0.0 {
            return Err(node.malformed("its scale is below 0"));
        }
        node.disregard(&["mis_compensation"]);
        if let Err(ImportError::MissingBuffer { uri, .. }) = self.folder.find(&name, node.place()) {
            let message =
                format!("the environment's image {uri:?} does not exist: there is no light from it");
            self.warn(WarningKind::MissingFile, node, &message);
            return Ok(());
        }
        let image = self.images.file(&self.folder, &name, Encoding::Srgb, node.place(), self.warnings)?;
        let (turn, mirrored) = rotation(node, node.to_world()?)?;
        self.environment_is_mirrored = mirrored;
        let half_turn = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, -1.0));
        let world_from_environment = turn * half_turn;
        self.surround(node, Environment { radiance: Vec3::splat(scale), image, world_from_environment });
        Ok(())
    }

    fn surround(&mut self, node: Node, environment: Environment) {
        if self.scene.environment.replace(environment).is_some() {
            self.warn(WarningKind::Light, node, "of several environments the last one is rendered");
        }
    }
}

/// Where +z points, as a unit vector.
fn forward(node: Node, to_world: Mat4) -> Result<Vec3> {
    let direction = to_world.z_axis.truncate().as_dvec3().try_normalize();
    Ok(direction.ok_or_else(|| node.malformed("its transform leaves it no direction"))?.as_vec3())
}

/// The rotation in a transform, scale removed, and whether it mirrors; where it does, x is flipped
/// before it.
pub(super) fn rotation(node: Node, to_world: Mat4) -> Result<(Mat3, bool)> {
    let axes = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|a| a.truncate().as_dvec3());
    let z = axes[2].try_normalize();
    let y = z.and_then(|z| (axes[1] - z * axes[1].dot(z)).try_normalize());
    let (Some(y), Some(z)) = (y, z) else {
        return Err(node.malformed("its transform flattens it to nothing"));
    };
    let x = y.cross(z);
    let mirrored = x.dot(axes[0]) < 0.0;
    Ok((Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()), mirrored))
}
