//! What is known of a set of lights: where they are, whither they shine, how brightly.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use midway_scene::Bounds;

/// The directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit.
    pub axis: DVec3,
    /// Half its opening, radians in [0, π].
    pub angle: f64,
}

impl Cone {
    /// The least cone that holds both, or nearly so: all directions where it would be wider than half of
    /// them and the axes are opposite.
    pub fn union(self, other: Self) -> Self {
        let (wide, narrow) = if self.angle >= other.angle { (self, other) } else { (other, self) };
        let across = wide.axis.cross(narrow.axis);
        let between = across.length().atan2(wide.axis.dot(narrow.axis));
        if (between + narrow.angle).min(PI) <= wide.angle {
            return wide;
        }
        let angle = 0.5 * (wide.angle + between + narrow.angle);
        match across.try_normalize() {
            Some(about) if angle < PI => {
                Self { axis: DQuat::from_axis_angle(about, angle - wide.angle) * wide.axis, angle }
            }
            _ => Self { axis: wide.axis, angle: PI },
        }
    }
}

/// What kind of lights a set has, each including those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// They emit about their normals.
    Front,
    /// Some do to both sides.
    Both,
    /// Some are at infinity.
    Infinite,
}

/// A set of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBound {
    /// Around them; empty for those at infinity.
    pub bounds: Bounds,
    /// Of their normals.
    pub normals: Cone,
    /// Up to this angle from a normal there is emission, radians.
    pub emission: f64,
    /// Luminance of the intensity ahead, W/sr; at infinity of the irradiance, W/m².
    pub intensity: f64,
    /// Of which kind.
    pub reach: Reach,
}

impl LightBound {
    /// Of two sets together.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            normals: self.normals.union(other.normals),
            emission: self.emission.max(other.emission),
            intensity: self.intensity + other.intensity,
            reach: self.reach.max(other.reach),
        }
    }

    /// How often and how vainly it is asked for: intensity times the measure of its directions (Conty
    /// Estevez and Kulla 2018, section 4.4) times the square of its size, which is what intensity is at
    /// least divided by. Lights on a line have a size, where their box has no area.
    pub fn cost(&self) -> f64 {
        self.intensity * self.directions() * self.bounds.diagonal().as_dvec3().length_squared()
    }

    /// The integral over the cone of normals and what they emit into, each weighed by its cosine there.
    fn directions(&self) -> f64 {
        let normals = self.normals.angle;
        let all = (normals + self.emission).min(PI);
        let (sin, cos) = normals.sin_cos();
        2.0 * PI * (1.0 - cos)
            + FRAC_PI_2 * (2.0 * all * sin - (normals - 2.0 * all).cos() - 2.0 * normals * sin + cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unions_of_cones_hold_both() {
        let cones = [
            Cone { axis: DVec3::Z, angle: 0.0 },
            Cone { axis: DVec3::NEG_Z, angle: 0.0 },
            Cone { axis: DVec3::new(0.6, 0.0, 0.8), angle: 0.3 },
            Cone { axis: DVec3::new(-0.8, 0.6, 0.0), angle: 2.0 },
            Cone { axis: DVec3::X, angle: PI },
        ];
        for (a, b) in cones.iter().flat_map(|a| cones.iter().map(move |b| (*a, *b))) {
            let both = a.union(b);
            for cone in [a, b] {
                let between = both.axis.cross(cone.axis).length().atan2(both.axis.dot(cone.axis));
                let holds = (between + cone.angle).min(PI) <= both.angle + 1e-12;
                assert!(holds && both.angle <= PI, "{a:?} and {b:?}: {both:?}");
            }
            assert!((both.axis.length() - 1.0).abs() <= 1e-12);
        }
    }

    /// The measure of directions by the sum over rings of a sphere.
    #[test]
    fn directions_are_those_of_the_integral() {
        for (normals, emission) in [(0.0, FRAC_PI_2), (0.3, 0.4), (1.2, FRAC_PI_2), (PI, FRAC_PI_2)] {
            let normals = Cone { axis: DVec3::Z, angle: normals };
            let bound =
                LightBound { bounds: Bounds::EMPTY, normals, emission, intensity: 1.0, reach: Reach::Front };
            let all = (normals.angle + emission).min(PI);
            let n = 100_000;
            let ring = |i: i32| {
                let angle = (f64::from(i) + 0.5) * all / f64::from(n);
                2.0 * PI * angle.sin() * (angle - normals.angle).max(0.0).cos() * all / f64::from(n)
            };
            let expected: f64 = (0..n).map(ring).sum();
            let directions = bound.directions();
            assert!((directions - expected).abs() <= 1e-6, "{directions} for {expected}");
        }
    }
}
