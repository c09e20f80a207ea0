// Which light to sample at a place: a binary tree over all lights, descended from its root by what each
// child may send there (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
// Splitting", 2018). The bound on what a node sends is that of pbrt-v4 (section 12.6.3), by the place and
// the side that is lit there alone: a camera subpath that hits a light must find the same chance when it
// has left the vertex.

// LightNode.kind
/// Lights that are somewhere: their normals within a cone, their emission around the normals.
const LIGHT_NODE_FRONT: u32 = 0u;
/// The same for lights that emit to both sides, some of them at least.
const LIGHT_NODE_BOTH: u32 = 1u;
/// Lights at infinity: they and the rest part at the root.
const LIGHT_NODE_INFINITE: u32 = 2u;

/// In LightNode.link of a leaf, with its light's index; else the index of the first of two children.
const LIGHT_NODE_LEAF: u32 = 0x80000000u;

struct LightNode {
    /// A sphere around its lights.
    centre: vec3<f32>,
    radius: f32,
    /// Of the cone that holds their normals, unit, and the cosine of its half angle.
    axis: vec3<f32>,
    cos_normals: f32,
    /// Luminance of the intensity ahead, W/sr, at infinity of the irradiance, W/m²; of all lights 1.
    intensity: f32,
    /// The cosine of the angle to a normal up to which there is emission.
    cos_emission: f32,
    kind: u32,
    link: u32,
}

/// What a light is drawn for.
struct LightPlace {
    position: vec3<f32>,
    /// Unit, on the side that is lit; 0 where both are.
    facing: vec3<f32>,
}

/// The most that a node counts, so that sums stay finite.
const MAX_LIGHT_IMPORTANCE: f32 = 1e18;

/// The least cosine that a node which shines counts with: spots shine aside of their axis too, and
/// surfaces shine at grazing angles.
const LEAST_LIGHT_COSINE: f32 = 0.05;

/// A node counts as behind a surface where this is more than the cosine: rounding puts none there.
const LEAST_FACING_COSINE: f32 = -2e-3;

/// The cosine of a - b, of angles in [0, π]; 1 where b is greater.
fn cos_of_difference(cos_a: f32, cos_b: f32) -> f32 {
    if (cos_a > cos_b) {
        return 1.0;
    }
    let sines = sqrt(max(1.0 - cos_a * cos_a, 0.0) * max(1.0 - cos_b * cos_b, 0.0));
    return cos_a * cos_b + sines;
}

/// In proportion to about the irradiance that a node's lights cause at a place, blockers left out; 0 where
/// none of them shines there.
fn light_node_importance(node: LightNode, place: LightPlace) -> f32 {
    if (node.kind == LIGHT_NODE_INFINITE) {
        return min(node.intensity, MAX_LIGHT_IMPORTANCE);
    }
    let between = place.position - node.centre;
    let distance_squared = dot(between, between);
    let radius_squared = node.radius * node.radius;
    let near = node.intensity / max(max(distance_squared, radius_squared), 1e-30);
    if (distance_squared <= radius_squared) {
        return min(near, MAX_LIGHT_IMPORTANCE);
    }
    let direction = between * inverseSqrt(distance_squared); // > 0: the radius squared is less
    let cos_sphere = sqrt(1.0 - radius_squared / distance_squared);
    var cosine = 1.0;
    if (node.cos_normals > -1.0) {
        // of the least angle between a normal and a direction to the place
        let ahead = dot(node.axis, direction);
        let cos_axis = clamp(select(ahead, abs(ahead), node.kind == LIGHT_NODE_BOTH), -1.0, 1.0);
        cosine = cos_of_difference(cos_of_difference(cos_axis, node.cos_normals), cos_sphere);
        if (cosine <= node.cos_emission) {
            return 0.0;
        }
        cosine = max(cosine, LEAST_LIGHT_COSINE);
    }
    if (any(place.facing != vec3<f32>(0.0))) {
        let facing = cos_of_difference(clamp(-dot(place.facing, direction), -1.0, 1.0), cos_sphere);
        if (facing <= LEAST_FACING_COSINE) {
            return 0.0;
        }
        cosine *= max(facing, LEAST_LIGHT_COSINE);
    }
    return min(near * cosine, MAX_LIGHT_IMPORTANCE);
}

/// The chance of going to the first of two children; negative where neither shines.
fn first_child_chance(first: f32, second: f32) -> f32 {
    let sum = first + second;
    if (sum <= 0.0) {
        return -1.0;
    }
    return first / sum;
}
