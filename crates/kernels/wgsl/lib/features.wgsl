// What the scene in hand may need of a kernel. A GPU compiles each kernel without what its scene has
// none of: less code to compile, fewer registers. On the CPU all of it is there, and the scene's own
// data decide.

/// Bits of FEATURE_*.
override FEATURES: u32 = 0xffffffffu;

/// Meshes that are placed, with hierarchies of their own.
const FEATURE_INSTANCES: u32 = 1u;
/// Texture coordinates, vertex colours or tangents.
const FEATURE_ATTRIBUTES: u32 = 2u;
/// Materials with textures, normal maps among them.
const FEATURE_TEXTURES: u32 = 4u;
/// Surfaces that are not everywhere there.
const FEATURE_CUTOUTS: u32 = 8u;
// A kind of surface, as in lib/material.wgsl.
const FEATURE_CONDUCTOR: u32 = 16u;
const FEATURE_DIELECTRIC: u32 = 32u;
const FEATURE_PLASTIC: u32 = 64u;
const FEATURE_METALLIC_ROUGHNESS: u32 = 128u;
/// Surfaces with an inside that light travels in.
const FEATURE_INSIDES: u32 = 256u;
/// Of metallic-roughness: coat or sheen.
const FEATURE_LAYERS: u32 = 512u;
const FEATURE_ANISOTROPY: u32 = 1024u;
/// Lights that are no triangles.
const FEATURE_POINT_LIGHTS: u32 = 2048u;
const FEATURE_DIRECTIONAL_LIGHTS: u32 = 4096u;
const FEATURE_ENVIRONMENT: u32 = 8192u;
/// Anything but diffuse surfaces.
const FEATURE_INTERFACES: u32 = 16384u;
/// Rough ones of them.
const FEATURE_ROUGHNESS: u32 = 65536u;
/// Rough ones of these that let light through.
const FEATURE_TRANSMISSION: u32 = 131072u;
/// Emissive surfaces whose emission has a texture, or that are not everywhere there.
const FEATURE_TEXTURED_LIGHTS: u32 = 262144u;
/// A table of pre-generated random numbers.
const FEATURE_RANDOM_TABLE: u32 = 32768u;
/// What each group of lights adds to the image is kept apart.
const FEATURE_LIGHT_GROUPS: u32 = 524288u;
/// The wide hierarchy, not the binary one.
const FEATURE_WIDE: u32 = 1048576u;
/// Surfaces with an inside whose index differs by colour.
const FEATURE_DISPERSION: u32 = 2097152u;
/// Coats whose normals are not those of the surface below.
const FEATURE_COAT_NORMALS: u32 = 4194304u;
/// The tree over lights is descended.
const FEATURE_LIGHT_TREE: u32 = 8388608u;
/// Anisotropic surfaces with an inside that light travels in.
const FEATURE_STRETCHED_SOLIDS: u32 = 16777216u;
/// An invocation of connect makes several joins, one after another: no scene asks for it, so that a CPU alone has it.
/// plan_joins and connect go by it, and have to be compiled with the same FEATURES.
const FEATURE_JOIN_RUNS: u32 = 33554432u;

/// Whether the scene may have something.
fn may_have(feature: u32) -> bool {
    return (FEATURES & feature) != 0u;
}
