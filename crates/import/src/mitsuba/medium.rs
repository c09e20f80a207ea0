//! Participating media: of those that only absorb, the absorption.

use glam::Vec3;
use midway_scene::{Material, Roughness, Surface};

use super::{Loader, document::Class, node::Node, value::Quantity};
use crate::{ImportError, warning::WarningKind};

/// What stands for scattering, and for all of it together, where the file does not say.
const ALBEDO: f32 = 0.75;
const SIGMA_T: f32 = 1.0;

impl Loader<'_> {
    /// Gives a surface the absorption of the medium inside of it.
    pub(super) fn fill(&mut self, medium: Node, material: &mut Material) -> Result<(), ImportError> {
        let Some(absorption) = self.absorption(medium)? else { return Ok(()) };
        match &mut material.surface {
            Surface::Dielectric { sigma_a, thin: false, .. } => *sigma_a = absorption,
            // A boundary of index 1 is none, and has an inside.
            Surface::Null => {
                material.surface = Surface::Dielectric {
                    ior: 1.0,
                    dispersion: 0.0,
                    reflection: Vec3::ONE.into(),
                    transmission: Vec3::ONE.into(),
                    sigma_a: absorption,
                    thin: false,
                    roughness: Roughness::smooth(),
                };
            }
            _ => self.warn(WarningKind::Unused, medium, "media in opaque surfaces are not rendered"),
        }
        Ok(())
    }

    /// The absorption coefficient per unit length of a homogeneous medium; none where it is no such.
    fn absorption(&mut self, node: Node) -> Result<Option<Vec3>, ImportError> {
        if node.class() != Class::Medium || node.plugin() != "homogeneous" {
            let message = format!("media of type {:?} are not rendered", node.plugin());
            self.warn(WarningKind::Unused, node, &message);
            return Ok(None);
        }
        node.disregard(&["sample_emitters"]);
        if ["sigma_t", "albedo", "sigma_a", "sigma_s"]
            .iter()
            .any(|name| matches!(node.child(name), Ok(Some(_))))
        {
            self.warn(WarningKind::Unused, node, "media whose coefficients vary are not rendered");
            return Ok(None);
        }
        let scale = node.float_or("scale", 1.0)?.max(0.0);
        let color = |name: &str| node.color(name, Quantity::Unbounded);
        let (sigma_a, sigma_s) = match (color("sigma_a")?, color("sigma_s")?) {
            (None, None) => {
                let sigma_t = color("sigma_t")?.unwrap_or(Vec3::splat(SIGMA_T));
                let albedo = color("albedo")?.unwrap_or(Vec3::splat(ALBEDO)).min(Vec3::ONE);
                (sigma_t * (Vec3::ONE - albedo), sigma_t * albedo)
            }
            (a, s) => (a.unwrap_or(Vec3::ZERO), s.unwrap_or(Vec3::ZERO)),
        };
        if sigma_s.max_element() > 0.0 {
            self.warn(WarningKind::Unused, node, "scattering media are rendered as empty");
            return Ok(None);
        }
        Ok(Some(sigma_a * scale))
    }
}
