//! Lights that are not surfaces.

use std::sync::Arc;

use glam::{Mat3, Vec3};

/// A light without extent.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The file's name for it, or empty.
    pub name: String,
    /// What it does.
    pub kind: LightKind,
    /// The group of lights that it is put into; none for its own, by its name.
    pub group: Option<Arc<str>>,
}

/// What a light without extent does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Shines alike in all directions.
    Point {
        /// In the world.
        position: Vec3,
        /// Radiant intensity, W·sr⁻¹.
        intensity: Vec3,
    },
    /// Shines into a cone.
    Spot {
        /// In the world.
        position: Vec3,
        /// Unit, along the axis, away from the light.
        direction: Vec3,
        /// Radiant intensity within the inner cone, W·sr⁻¹.
        intensity: Vec3,
        /// Half the angle up to which intensity is full, radians.
        inner_angle: f32,
        /// Half the angle beyond which it is 0, in (inner, π].
        outer_angle: f32,
        /// Between the two.
        falloff: SpotFalloff,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// Unit, the way the light travels.
        direction: Vec3,
        /// On a surface at a right angle to it, W·m⁻².
        irradiance: Vec3,
    },
}

/// A spot's intensity between its cones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpotFalloff {
    /// The square of the cosine's place between the cones' (glTF).
    CosineSquared,
    /// The smoothstep of the cosine's place (pbrt).
    Smoothstep,
    /// The angle's place (Mitsuba).
    Angle,
}

/// Light from all around, infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Radiance, or what the image is multiplied by.
    pub radiance: Vec3,
    /// Index into [`crate::Scene::images`], by latitude and longitude: the top row is +y, the middle
    /// column -z, and u grows towards +x from there.
    pub image: Option<u32>,
    /// A rotation: how the environment is turned in the world.
    pub world_from_environment: Mat3,
}
