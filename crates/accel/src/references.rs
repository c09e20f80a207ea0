//! References: the boxes a hierarchy is built over, one for each triangle, piece of a triangle, or
//! instance.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::{Boundable, aabb::Aabb, splits::split_aabbs_preset, triangle::Triangle};
use rayon::prelude::*;

use midway_scene::Bounds;

use crate::bounds::padded;

/// A triangle, what of it lies in a box, or an instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    /// Triangles count first, then instances.
    pub primitive: u32,
    /// Padded: conservative in f32.
    pub bounds: Bounds,
}

/// Maps the scene into [-1/2, 1/2]³, so that areas neither overflow nor vanish in f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Normalisation {
    centre: DVec3,
    extent: f64,
}

/// How far a clipped box may be off, in normalised units: rounding of the vertices (2⁻²⁶) and of
/// the interpolation along an edge (a few 2⁻²⁵), with a wide margin.
const CLIP_ERROR: f64 = 1.0 / (1 << 21) as f64;

impl Normalisation {
    pub fn of(triangles: &[[Vec3; 3]], instances: &[Bounds]) -> Self {
        let bounds =
            instances.iter().fold(Bounds::of_points(triangles.as_flattened()), |all, &b| all.union(b));
        if bounds.is_empty() {
            return Self { centre: DVec3::ZERO, extent: 1.0 };
        }
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let extent = (max - min).max_element();
        Self { centre: (min + max) * 0.5, extent: if extent > 0.0 { extent } else { 1.0 } }
    }

    fn point(&self, p: Vec3) -> Vec3A {
        ((p.as_dvec3() - self.centre) / self.extent).as_vec3().into()
    }

    /// What is empty is a point, so that areas are finite: a placed mesh may have nothing in it.
    pub fn bounds(&self, b: &Bounds) -> Aabb {
        if b.is_empty() {
            return Aabb::from_point(Vec3A::ZERO);
        }
        Aabb::new(self.point(b.min), self.point(b.max))
    }

    /// The part of `whole` that a clipped box in normalised space stands for, conservatively.
    fn unclipped(&self, clipped: &Aabb, whole: &Bounds) -> Bounds {
        let world = |p: Vec3A, error: f64| {
            (self.centre + (p.as_dvec3() + DVec3::splat(error)) * self.extent).as_vec3()
        };
        Bounds {
            min: world(clipped.min, -CLIP_ERROR).max(whole.min),
            max: world(clipped.max, CLIP_ERROR).min(whole.max),
        }
    }
}

/// One reference a triangle, more for large ones where they are to be split, and one an instance.
pub(crate) fn collect(
    triangles: &[[Vec3; 3]],
    instances: &[Bounds],
    normalisation: &Normalisation,
    spatial_splits: bool,
) -> Vec<Reference> {
    let mut references = if spatial_splits && !triangles.is_empty() {
        split(triangles, normalisation)
    } else {
        let reference = |(triangle, vertices): (usize, &[Vec3; 3])| Reference {
            primitive: triangle as u32,
            bounds: padded(Bounds::of_points(vertices)),
        };
        triangles.par_iter().enumerate().map(reference).collect()
    };
    let first = triangles.len() as u32;
    references.extend(
        (first..).zip(instances).map(|(primitive, &bounds)| Reference { primitive, bounds: padded(bounds) }),
    );
    references
}

fn split(triangles: &[[Vec3; 3]], normalisation: &Normalisation) -> Vec<Reference> {
    let normalised: Vec<Triangle> = triangles
        .par_iter()
        .map(|&[a, b, c]| Triangle {
            v0: normalisation.point(a),
            v1: normalisation.point(b),
            v2: normalisation.point(c),
        })
        .collect();
    let mut boxes: Vec<Aabb> = normalised.par_iter().map(Boundable::aabb).collect();
    let mut owners: Vec<u32> = (0..triangles.len() as u32).collect();
    let (sum, largest) = boxes.iter().fold((0.0f64, 0.0f32), |(sum, largest), b| {
        let area = b.half_area();
        (sum + f64::from(area), largest.max(area))
    });
    let average = (sum / boxes.len() as f64) as f32;
    split_aabbs_preset(&mut boxes, &mut owners, &normalised, average, largest);

    let mut n_pieces = vec![0u32; triangles.len()];
    for &owner in &owners {
        n_pieces[owner as usize] += 1;
    }
    owners
        .par_iter()
        .zip(&boxes)
        .map(|(&triangle, clipped)| {
            let whole = padded(Bounds::of_points(&triangles[triangle as usize]));
            let bounds = match n_pieces[triangle as usize] {
                1 => whole,
                _ => normalisation.unclipped(clipped, &whole),
            };
            Reference { primitive: triangle, bounds }
        })
        // Cutting a box that a thin triangle only touches leaves inverted ones: nothing is there.
        .filter(|r| !r.bounds.is_empty())
        .collect()
}
