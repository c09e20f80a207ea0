//! Acceleration structure: a bounding volume hierarchy, built, packed for kernels, validated.
//!
//! [`WideBvh`] has up to eight children a node, [`Bvh`] two; [`Level`] is either.
//!
//! The topology comes from `obvhs` (PLOC, reinsertion, leaf collapsing, triangle pre-splitting).
//! Everything that correctness depends on is done here: boxes are refitted from the triangles'
//! own coordinates and padded, coincident triangles are clustered, depth is bounded.
//!
//! Geometry that is placed several times is not copied: [`TwoLevel`] has one hierarchy over the
//! world, whose leaves hold triangles and placements, and one for each mesh that is placed.
//!
//! ```
//! use glam::Vec3;
//! use midway_accel::{build_wide, closest_hit, BuildOptions};
//!
//! let triangles = [[Vec3::ZERO, Vec3::X, Vec3::Y]];
//! let bvh = build_wide(&triangles, &BuildOptions::default()).unwrap();
//! bvh.validate(&triangles).unwrap();
//! let hit = closest_hit(&bvh, &triangles, Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z, f32::INFINITY);
//! assert_eq!(hit.unwrap().triangle, 0);
//! ```

mod bounds;
mod level;
mod met;
mod pack;
mod references;
mod topology;
mod traverse;
mod two_level;
mod validate;
mod wide;

use std::time::{Duration, Instant};

use glam::Vec3;

use rayon::prelude::*;
use references::{Normalisation, Reference};

pub use level::{Level, Width};
pub use midway_scene::Bounds;
pub use pack::Child;
pub use traverse::{Hierarchy, Hit, closest_hit};
pub use two_level::{Placement, TwoLevel, mesh_options};
pub use wide::{WideBvh, WideNode, build_wide, build_wide_with_instances};

/// The stack of a binary traversal holds this many entries: [`Bvh::max_depth`] is below it.
pub const STACK_SIZE: usize = 64;
/// That of a wide one, [`WideBvh::max_depth`] is below it. A GPU clears all of it for each ray.
pub const WIDE_STACK_SIZE: usize = 32;
/// The most references a leaf of the binary hierarchy can hold: its count takes four bits, and one
/// value is a mark.
pub const MAX_LEAF_SIZE: usize = 14;
/// The most references a hierarchy can hold: a leaf's first slot takes 27 bits.
pub const MAX_REFERENCES: usize = 1 << 27;
/// Set in a child reference that is a leaf.
pub const LEAF_BIT: u32 = 0x8000_0000;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum AccelError {
    /// A coordinate is NaN or infinite.
    #[error("triangle {triangle} has a vertex that is not finite; repair the mesh")]
    NotFinite {
        /// Index into the triangles given.
        triangle: usize,
    },
    /// More references than a node can address.
    #[error("{references} triangle references, more than the {MAX_REFERENCES} that a node can address")]
    TooManyTriangles {
        /// Triangles, or their pieces where they were split.
        references: usize,
    },
    /// [`Bvh::validate`] found the hierarchy broken.
    #[error("invalid hierarchy: {0}")]
    Invalid(String),
}

/// How much time to spend on a better hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// For previews: little optimisation.
    Fast,
    /// About the time of other renderers' builders.
    #[default]
    Balanced,
    /// Several times longer, a few per cent faster to trace.
    Best,
}

/// How to build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// Split large triangles into several boxes first; a triangle may then be in several leaves.
    pub spatial_splits: bool,
    /// Time spent against speed gained.
    pub quality: Quality,
    /// References a leaf holds at most, clamped to 1..=[`MAX_LEAF_SIZE`].
    pub max_leaf_size: usize,
    /// Where the optimised topology is deeper, a balanced one takes its place. Clamped to
    /// [`Width::balanced_depth`]..[`Width::stack_size`].
    pub max_depth: usize,
}

/// Deeper no balanced topology is: over [`MAX_REFERENCES`], each alone in its leaf, it has 27 levels.
pub const BALANCED_DEPTH: usize = 28;
/// The same of a wide one, whose nodes take three levels each.
pub const WIDE_BALANCED_DEPTH: usize = BALANCED_DEPTH.div_ceil(3);

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            spatial_splits: true,
            quality: Quality::default(),
            max_leaf_size: 4,
            max_depth: STACK_SIZE - 1,
        }
    }
}

/// A binary hierarchy, packed for kernels.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    /// Four vec4 for each inner node, depth first, the root first. As bits of f32, since a child
    /// reference may be the pattern of a NaN, which a float move need not preserve:
    ///
    /// | vec4 | x, y, z | w |
    /// |---|---|---|
    /// | 0 | left box's min | left reference |
    /// | 1 | left box's max | right reference |
    /// | 2 | right box's min | 0 |
    /// | 3 | right box's max | 0 |
    ///
    /// A reference is an inner node's index, or [`LEAF_BIT`]` | first << 4 | count`, `first` an
    /// index into `primitives`. See [`Child`].
    ///
    /// An absent child (the root's, where there are fewer than two leaves) is a leaf of count 0
    /// whose box is inverted (+∞ to -∞). A slab test that sorts the two planes takes that box for
    /// a hit; the count makes the visit harmless.
    pub nodes: Vec<[u32; 4]>,
    /// The triangle in each leaf slot; with spatial splits one may be in several leaves. From the
    /// number of triangles on: instances.
    pub primitives: Vec<u32>,
    /// Inner nodes on the longest way from the root down; below [`STACK_SIZE`].
    pub max_depth: usize,
    /// Around everything, padded; inverted where there is nothing.
    pub bounds: Bounds,
    /// What the build did.
    pub statistics: Statistics,
}

/// What a build did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Triangles given.
    pub triangles: usize,
    /// Inner nodes.
    pub inner_nodes: usize,
    /// Leaves that hold something.
    pub leaves: usize,
    /// Leaf slots beyond one a triangle, from splitting.
    pub duplicated_references: usize,
    /// Surface area heuristic: expected node visits plus triangle tests for a ray that meets the
    /// root's box.
    pub sah_cost: f32,
    /// Whether the optimised topology was too deep, so that a balanced one took its place.
    pub balanced_fallback: bool,
    /// Wall-clock time.
    pub build_time: Duration,
}

impl Bvh {
    /// How many vec4 a node takes.
    pub const NODE_VEC4: usize = 4;

    /// Bytes that `nodes` and `primitives` take.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.primitives.as_slice())
    }
}

/// Builds a binary hierarchy over triangles. The same triangles and options give the same hierarchy,
/// whatever the number of threads. Zero-area triangles are kept; no triangles give a root with two
/// absent children.
///
/// # Errors
///
/// [`AccelError::NotFinite`] for NaN or infinite vertices; [`AccelError::TooManyTriangles`] above
/// [`MAX_REFERENCES`].
pub fn build(triangles: &[[Vec3; 3]], options: &BuildOptions) -> Result<Bvh, AccelError> {
    build_with_instances(triangles, &[], options)
}

/// As [`build`], over instances too, each alone in its leaf and never split. `instances`: around each,
/// finite.
///
/// # Errors
///
/// As [`build`].
pub fn build_with_instances(
    triangles: &[[Vec3; 3]],
    instances: &[Bounds],
    options: &BuildOptions,
) -> Result<Bvh, AccelError> {
    let start = Instant::now();
    let (references, normalisation) = collect(triangles, instances, options)?;
    let tree = topology::build(&references, triangles.len(), &normalisation, options);
    let mut bvh = pack::pack(&tree, &references, triangles.len());
    bvh.statistics.duplicated_references -= instances.len();
    bvh.statistics.build_time = start.elapsed();
    Ok(bvh)
}

/// The boxes a hierarchy is over.
fn collect(
    triangles: &[[Vec3; 3]],
    instances: &[Bounds],
    options: &BuildOptions,
) -> Result<(Vec<Reference>, Normalisation), AccelError> {
    if let Some(triangle) = triangles.par_iter().position_first(|t| !t.iter().all(|v| v.is_finite())) {
        return Err(AccelError::NotFinite { triangle });
    }
    let normalisation = Normalisation::of(triangles, instances);
    let references = references::collect(triangles, instances, &normalisation, options.spatial_splits);
    if references.len() > MAX_REFERENCES {
        return Err(AccelError::TooManyTriangles { references: references.len() });
    }
    Ok((references, normalisation))
}
