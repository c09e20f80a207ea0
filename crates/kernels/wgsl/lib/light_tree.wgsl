// Which light to sample at a place: a tree over all lights, four children a node, descended from its root
// by what each child may send there (Conty Estevez and Kulla, "Importance Sampling of Many Lights with
// Adaptive Tree Splitting", 2018). The bound on what a child sends is that of pbrt-v4 (section 12.6.3), by
// the place and the side that is lit there alone: a camera subpath that hits a light must find the same
// chance when it has left the vertex.

// In LightNode.links, beside an index:
/// Of a light; else the index is a node's.
const LIGHT_NODE_LEAF: u32 = 0x80000000u;
/// Some of its lights emit to both sides.
const LIGHT_NODE_BOTH: u32 = 0x40000000u;
/// Its lights are at infinity.
const LIGHT_NODE_INFINITE: u32 = 0x20000000u;
const LIGHT_NODE_INDEX: u32 = 0x1fffffffu;

/// What is known of four sets of lights, a component each.
struct LightNode {
    /// A sphere around the lights.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    radius_squared: vec4<f32>,
    /// Of the cone that holds their normals, unit, and the cosine of its half angle.
    axis_x: vec4<f32>,
    axis_y: vec4<f32>,
    axis_z: vec4<f32>,
    cos_normals: vec4<f32>,
    /// The cosine of the angle to a normal up to which there is emission.
    cos_emission: vec4<f32>,
    /// Luminance of the intensity ahead, W/sr, at infinity of the irradiance, W/m²; of all lights 1. 0 where
    /// there is no set.
    intensity: vec4<f32>,
    links: vec4<u32>,
}

/// What a light is drawn for.
struct LightPlace {
    position: vec3<f32>,
    /// Unit, on the side that is lit; 0 where both are.
    facing: vec3<f32>,
}

/// The most that a set counts, so that sums stay finite, and the least of one that shines.
const MAX_LIGHT_IMPORTANCE: f32 = 1e18;
const MIN_LIGHT_IMPORTANCE: f32 = 1e-30;

/// The least cosine that a set which shines counts with: spots shine aside of their axis too, and surfaces
/// shine at grazing angles.
const LEAST_LIGHT_COSINE: f32 = 0.05;

/// A set counts as behind a surface where this is more than the cosine: rounding puts none there.
const LEAST_FACING_COSINE: f32 = -2e-3;

/// Closer places count as so close, m²: about the least normal float.
const LEAST_APART: f32 = 1.2e-38;

/// The cosines of a - b, of angles in [0, π]; 1 where b is greater.
fn cos_of_differences(cos_a: vec4<f32>, cos_b: vec4<f32>) -> vec4<f32> {
    let one = vec4<f32>(1.0);
    let zero = vec4<f32>(0.0);
    let sines = sqrt(max(one - cos_a * cos_a, zero) * max(one - cos_b * cos_b, zero));
    return select(cos_a * cos_b + sines, one, cos_a > cos_b);
}

/// In proportion to about the irradiance that each set of lights causes at a place, blockers left out; 0
/// where none of them shines there.
fn light_importances(node: LightNode, place: LightPlace) -> vec4<f32> {
    let zero = vec4<f32>(0.0);
    let one = vec4<f32>(1.0);
    let least = vec4<f32>(LEAST_LIGHT_COSINE);
    let x = vec4<f32>(place.position.x) - node.x;
    let y = vec4<f32>(place.position.y) - node.y;
    let z = vec4<f32>(place.position.z) - node.z;
    let distance_squared = x * x + y * y + z * z;
    let near = node.intensity / max(max(distance_squared, node.radius_squared), vec4<f32>(1e-30));
    // Where the place is in the sphere what follows is not looked at.
    let apart = max(distance_squared, vec4<f32>(LEAST_APART));
    let over_distance = inverseSqrt(apart);
    let cos_sphere = sqrt(max(one - node.radius_squared / apart, zero));

    // Of the least angle between a normal and a direction to the place.
    let ahead = (node.axis_x * x + node.axis_y * y + node.axis_z * z) * over_distance;
    let both = (node.links & vec4<u32>(LIGHT_NODE_BOTH)) != vec4<u32>(0u);
    let cos_axis = clamp(select(ahead, abs(ahead), both), -one, one);
    let cosine = cos_of_differences(cos_of_differences(cos_axis, node.cos_normals), cos_sphere);
    let every_way = node.cos_normals <= -one;
    var factor = select(select(max(cosine, least), zero, cosine <= node.cos_emission), one, every_way);

    if (any(place.facing != vec3<f32>(0.0))) {
        let toward = -(place.facing.x * x + place.facing.y * y + place.facing.z * z) * over_distance;
        let facing = cos_of_differences(clamp(toward, -one, one), cos_sphere);
        factor *= select(max(facing, least), zero, facing <= vec4<f32>(LEAST_FACING_COSINE));
    }
    let is_within = distance_squared <= node.radius_squared;
    let infinite = (node.links & vec4<u32>(LIGHT_NODE_INFINITE)) != vec4<u32>(0u);
    let seen = select(select(factor, one, is_within), one, infinite);
    let importance = select(near * seen, node.intensity, infinite);
    let shines = min(seen, node.intensity) > zero;
    return select(zero, clamp(importance, vec4<f32>(MIN_LIGHT_IMPORTANCE), vec4<f32>(MAX_LIGHT_IMPORTANCE)), shines);
}

/// One of four for a number in [0, 1).
struct LightChild {
    /// From 0 to 3; NONE where none of them shines.
    index: u32,
    /// Its chance.
    share: f32,
    /// Within its share, in [0, 1).
    number: f32,
}

/// One by its importance. Sums are of the same order everywhere: draws have the chances that
/// `light_child_share` says.
fn draw_light_child(importances: vec4<f32>, number: f32) -> LightChild {
    let a = importances.x;
    let b = a + importances.y;
    let c = b + importances.z;
    let sum = c + importances.w;
    if (sum <= 0.0) {
        return LightChild(NONE, 0.0, 0.0);
    }
    let place = number * sum; // < sum: the number is at most LAST_BELOW_ONE, and the sum no denormal
    let index = select(0u, 1u, place >= a) + select(0u, 1u, place >= b) + select(0u, 1u, place >= c);
    let importance = importances[index]; // > 0: sums before it and after it differ
    let before = vec4<f32>(0.0, a, b, c)[index];
    return LightChild(index, importance / sum, min((place - before) / importance, LAST_BELOW_ONE));
}

/// The chance of one of four, 0 where none of them shines.
fn light_child_share(importances: vec4<f32>, index: u32) -> f32 {
    let sum = importances.x + importances.y + importances.z + importances.w;
    if (sum <= 0.0) {
        return 0.0;
    }
    return importances[index] / sum;
}
