// Triangles for shading, in the buffer `scene`: those of the world, then those of each mesh that is
// placed, in the mesh's frame; what only some meshes have, behind them; and the instances.
//
// A triangle's id: below n_baked its place among the surfaces; from there on ids count the triangles
// of the first instance, of the second, and so on.

/// vec4 per entry.
const SURFACE_STRIDE: u32 = 4u;
const INSTANCE_STRIDE: u32 = 4u;

/// What attributes have beside texture coordinates of set 0 (2 vec4), in this order: set 1 (2 vec4),
/// colours in halves (2), tangents (1).
const ATTRIBUTE_UV1: u32 = 1u;
const ATTRIBUTE_COLORS: u32 = 2u;
const ATTRIBUTE_TANGENTS: u32 = 4u;

/// A triangle's data for shading, in the world.
struct Triangle {
    v0: vec3<f32>,
    e1: vec3<f32>,
    e2: vec3<f32>,
    material: u32,
    /// Its place among the lights, or NONE.
    light: u32,
    /// Packed normals at the vertices, of the mesh where an instance places it; FLAT_NORMAL for none.
    normals: vec3<u32>,
    /// Where its attributes are, or NONE.
    attributes: u32,
    /// Where its instance is, or NONE.
    instance: u32,
    /// -1 where its instance mirrors it, so that cross(e1, e2) points to the back.
    front: f32,
}

/// A point on a surface.
struct Surface {
    position: vec3<f32>,
    /// Geometric normal, front side.
    ng: vec3<f32>,
    /// Shading normal, in ng's hemisphere.
    ns: vec3<f32>,
    material: u32,
    light: u32,
    /// Texture coordinates, (0, 0) where there are none.
    uv0: vec2<f32>,
    uv1: vec2<f32>,
    /// Linear RGBA, white where there is none.
    color: vec4<f32>,
    /// Unit, orthogonal to ns: the mesh's, else along growing u of set 0, else any.
    tangent: vec3<f32>,
    /// The bitangent is bitangent_sign · cross(ns, tangent).
    bitangent_sign: f32,
    /// Of a coat that has a normal of its own, as ns.
    coat_ns: vec3<f32>,
}

/// A triangle as it is stored: of the world, or in its mesh's frame.
fn load_stored_triangle(index: u32) -> Triangle {
    let at = params.surfaces_at + index * SURFACE_STRIDE;
    let a = scene[at];
    let b = scene[at + 1u];
    let c = scene[at + 2u];
    let d = bitcast<vec4<u32>>(scene[at + 3u]);
    return Triangle(a.xyz, b.xyz, c.xyz, bitcast<u32>(a.w), bitcast<u32>(b.w), d.xyz, d.w, NONE, 1.0);
}

/// Where the instance is that a triangle's id, n_baked or more, belongs to: the last whose first id is
/// not beyond it. At most 32 steps.
fn find_instance(id: u32) -> u32 {
    var low = 0u;
    var high = params.n_instances; // > 0: else no id reaches n_baked
    while (high - low > 1u) {
        let middle = (low + high) / 2u;
        if (bitcast<u32>(scene[params.instances_at + middle * INSTANCE_STRIDE].x) <= id) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return params.instances_at + low * INSTANCE_STRIDE;
}

fn load_placed_triangle(id: u32) -> Triangle {
    let at = find_instance(id);
    let head = scene[at];
    let translation = vec3<f32>(scene[at + 1u].w, scene[at + 2u].w, scene[at + 3u].w);
    var triangle = load_stored_triangle(bitcast<u32>(head.y) + (id - bitcast<u32>(head.x)));
    triangle.v0 = place_vector(at, triangle.v0) + translation;
    triangle.e1 = place_vector(at, triangle.e1);
    triangle.e2 = place_vector(at, triangle.e2);
    triangle.instance = at;
    triangle.front = head.z;
    return triangle;
}

/// A vector of an instance's mesh in the world.
fn place_vector(instance: u32, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(scene[instance + 1u].xyz, v), dot(scene[instance + 2u].xyz, v), dot(scene[instance + 3u].xyz, v));
}

fn load_triangle(id: u32) -> Triangle {
    if (may_have(FEATURE_INSTANCES) && id >= params.n_baked) {
        return load_placed_triangle(id);
    }
    return load_stored_triangle(id);
}

/// Unit geometric normal, front side.
fn triangle_normal(triangle: Triangle) -> vec3<f32> {
    // not zero: degenerate triangles are not hit
    return normalize(cross(triangle.e1, triangle.e2)) * triangle.front;
}

/// Unit normal of a vertex in the world.
fn vertex_normal(instance: u32, packed: u32) -> vec3<f32> {
    let normal = oct_decode(packed);
    if (!may_have(FEATURE_INSTANCES) || instance == NONE) {
        return normal;
    }
    let head = scene[instance];
    let size = head.w; // what brings the rows' largest component to 1
    return place_normal(scene[instance + 1u].xyz * size, scene[instance + 2u].xyz * size, scene[instance + 3u].xyz * size,
        head.z, normal);
}

fn interpolated_normal(triangle: Triangle, ng: vec3<f32>, u: f32, v: f32) -> vec3<f32> {
    let n0 = vertex_normal(triangle.instance, triangle.normals.x);
    let n1 = vertex_normal(triangle.instance, triangle.normals.y);
    let n2 = vertex_normal(triangle.instance, triangle.normals.z);
    return shading_normal(ng, (1.0 - u - v) * n0 + u * n1 + v * n2);
}

/// The point at barycentric coordinates u and v of the second and third vertex.
fn load_surface(id: u32, u: f32, v: f32) -> Surface {
    let triangle = load_triangle(id);
    let ng = triangle_normal(triangle);
    var ns = ng;
    if (triangle.normals.x != FLAT_NORMAL) {
        ns = interpolated_normal(triangle, ng, u, v);
    }
    let frame = frame_from_normal(ns);
    var surface = Surface(triangle.v0 + u * triangle.e1 + v * triangle.e2, ng, ns, triangle.material, triangle.light,
        vec2<f32>(0.0), vec2<f32>(0.0), vec4<f32>(1.0), frame[0], 1.0, ns);
    if (may_have(FEATURE_ATTRIBUTES) && triangle.attributes != NONE) {
        surface = add_attributes(surface, triangle, u, v);
    }
    return surface;
}

/// The geometric normal on a direction's side.
fn normal_towards(surface: Surface, direction: vec3<f32>) -> vec3<f32> {
    return select(-surface.ng, surface.ng, dot(surface.ng, direction) > 0.0);
}

fn add_attributes(plain: Surface, triangle: Triangle, u: f32, v: f32) -> Surface {
    let w = 1.0 - u - v;
    let a = scene[triangle.attributes];
    let b = scene[triangle.attributes + 1u];
    let kinds = bitcast<u32>(b.z);
    var at = triangle.attributes + 2u;
    var surface = plain;
    surface.uv0 = w * a.xy + u * a.zw + v * b.xy;
    var along = uv_tangent(triangle.e1, triangle.e2, a.zw - a.xy, b.xy - a.xy, triangle.front);
    if ((kinds & ATTRIBUTE_UV1) != 0u) {
        let c = scene[at];
        surface.uv1 = w * c.xy + u * c.zw + v * scene[at + 1u].xy;
        at += 2u;
    }
    if ((kinds & ATTRIBUTE_COLORS) != 0u) {
        let c = bitcast<vec4<u32>>(scene[at]);
        let d = bitcast<vec4<u32>>(scene[at + 1u]);
        surface.color = w * unpack_color(c.xy) + u * unpack_color(c.zw) + v * unpack_color(d.xy);
        at += 2u;
    }
    if ((kinds & ATTRIBUTE_TANGENTS) != 0u) {
        along = load_tangent(triangle, scene[at], u, v);
    }
    surface.tangent = tangent_along(surface.ns, along.xyz);
    surface.bitangent_sign = along.w;
    return surface;
}

/// A mesh's own tangent in the world, not unit, and the bitangent's sign.
fn load_tangent(triangle: Triangle, packed: vec4<f32>, u: f32, v: f32) -> vec4<f32> {
    let t = bitcast<vec4<u32>>(packed);
    let blend = (1.0 - u - v) * vertex_tangent(triangle.instance, t.x) + u * vertex_tangent(triangle.instance, t.y)
        + v * vertex_tangent(triangle.instance, t.z);
    return vec4<f32>(blend, packed.w * triangle.front);
}

fn vertex_tangent(instance: u32, packed: u32) -> vec3<f32> {
    let tangent = oct_decode(packed);
    if (!may_have(FEATURE_INSTANCES) || instance == NONE) {
        return tangent;
    }
    return normalize(place_vector(instance, tangent)); // not zero: transforms are not singular
}

fn unpack_color(halves: vec2<u32>) -> vec4<f32> {
    return vec4<f32>(unpack2x16float(halves.x), unpack2x16float(halves.y));
}
