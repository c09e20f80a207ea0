// The environment in the buffer `scene`: at params.environment_at its frame, then its texels, row by
// row, then the alias table of its cells (lib/environment.wgsl), two entries a vec4.

const ENVIRONMENT_STRIDE: u32 = 4u;

struct Environment {
    /// Columns are its axes in the world.
    frame: mat3x3<f32>,
    /// Of the image.
    size: vec2<u32>,
    /// Its place among the lights; NONE where it is black.
    light: u32,
    /// 1 / the integral of luminance over the sphere.
    inverse_total: f32,
}

/// What comes from a direction.
struct EnvironmentLight {
    radiance: vec3<f32>,
    /// Density per solid angle with which draw_environment draws the direction.
    pdf: f32,
}

/// params.environment_at is not NONE.
fn load_environment() -> Environment {
    let at = params.environment_at;
    let x = scene[at];
    let y = scene[at + 1u];
    let z = scene[at + 2u];
    let d = scene[at + 3u];
    return Environment(mat3x3<f32>(x.xyz, y.xyz, z.xyz), vec2<u32>(bitcast<u32>(x.w), bitcast<u32>(y.w)), bitcast<u32>(z.w), d.x);
}

/// Radiance of a texel.
fn environment_texel(environment: Environment, x: u32, y: u32) -> vec3<f32> {
    return scene[params.environment_at + ENVIRONMENT_STRIDE + y * environment.size.x + x].xyz;
}

/// Radiance at the corners of a cell.
struct EnvironmentCorners {
    upper_left: vec3<f32>,
    upper_right: vec3<f32>,
    lower_left: vec3<f32>,
    lower_right: vec3<f32>,
}

fn environment_corners(environment: Environment, cell: vec2<u32>) -> EnvironmentCorners {
    let right = select(cell.x + 1u, 0u, cell.x + 1u == environment.size.x);
    let upper = max(cell.y, 1u) - 1u;
    let lower = min(cell.y, environment.size.y - 1u);
    return EnvironmentCorners(environment_texel(environment, cell.x, upper), environment_texel(environment, right, upper),
        environment_texel(environment, cell.x, lower), environment_texel(environment, right, lower));
}

/// What the environment sends from a direction of the world, which points away from the scene.
fn environment_towards(environment: Environment, direction: vec3<f32>) -> EnvironmentLight {
    let own = direction * environment.frame; // dot products with its axes
    let place = environment_place(own, environment.size);
    let corners = environment_corners(environment, place.cell);
    let upper = mix(corners.upper_left, corners.upper_right, place.within.x);
    let lower = mix(corners.lower_left, corners.lower_right, place.within.x);
    let radiance = mix(upper, lower, place.within.y);
    let ratio = environment_density_ratio(own, place.cell.y, environment.size.y);
    return EnvironmentLight(radiance, luminance(radiance) * environment.inverse_total * ratio);
}

/// A cell in proportion to its luminance: 32 bits for its number, as there may be more than 2^24.
fn draw_environment_cell(environment: Environment, bits: u32, u: f32) -> vec2<u32> {
    let size = environment.size;
    let cell = uniform_index_bits(bits, size.x * (size.y + 1u));
    let pair = scene[params.environment_at + ENVIRONMENT_STRIDE + size.x * size.y + cell / 2u];
    let entry = select(pair.xy, pair.zw, cell % 2u == 1u);
    let drawn = alias_pick(cell, u, entry.x, bitcast<u32>(entry.y));
    return vec2<u32>(drawn % size.x, drawn / size.x);
}

/// A direction of the world by importance, away from the scene.
fn draw_environment(environment: Environment, bits: vec4<u32>) -> vec3<f32> {
    let u = unit_float(bits);
    let cell = draw_environment_cell(environment, bits.x, u.y);
    let corners = environment_corners(environment, cell);
    let luminances = vec4<f32>(luminance(corners.upper_left), luminance(corners.upper_right),
        luminance(corners.lower_left), luminance(corners.lower_right));
    return environment.frame * environment_direction(cell, environment.size, luminances, u.zw);
}
