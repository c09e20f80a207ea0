// All lights but surfaces as they are hit: records, the draw of one by power, a point on it, how it
// is seen from elsewhere, and what it emits.

/// vec4 per entry.
const LIGHT_STRIDE: u32 = 2u;

// Light.kind
/// An emissive triangle.
const LIGHT_TRIANGLE: u32 = 0u;
/// Without extent, a spot too.
const LIGHT_POINT: u32 = 1u;
/// At infinity in one direction.
const LIGHT_DIRECTIONAL: u32 = 2u;
/// At infinity all around.
const LIGHT_ENVIRONMENT: u32 = 3u;

struct Light {
    kind: u32,
    /// A triangle's index; the place in `scene` of what else there is of a point light (position and
    /// falloff; intensity and full; axis and zero) or of a directional one (the direction towards
    /// it; irradiance).
    data: u32,
    /// Chance of being chosen.
    pmf: f32,
    /// Alias table.
    threshold: f32,
    alias_entry: u32,
    /// What is drawn from uniformly, > 0: a triangle's area; the solid angle that a point light
    /// shines into; at infinity the area of the disk that covers the scene.
    measure: f32,
    /// The medium (material) around it, or NONE.
    medium: u32,
    /// Its group.
    group: u32,
}

/// A point on a light; at infinity a direction.
struct LightPoint {
    /// 0 at infinity.
    position: vec3<f32>,
    /// The triangle's normal; a spot's axis; at infinity towards the light.
    normal: vec3<f32>,
    /// Barycentrics on a triangle.
    uv: vec2<f32>,
    /// Radiance of a triangle's front and of the environment; full intensity; irradiance.
    emission: vec3<f32>,
    emits_back: bool,
    /// The medium (material) behind a triangle whose material has an inside, or NONE.
    inside: u32,
    /// Density of the point with the light's chance: per area; per solid angle (environment); the
    /// chance alone.
    pdf: f32,
}

/// A light as another point sees it.
struct LightSample {
    /// Unit, towards the light.
    wi: vec3<f32>,
    distance: f32,
    /// What a surface at a right angle to wi receives, for each unit of the measure of LightPoint.pdf.
    arriving: vec3<f32>,
    /// Density of the draw, in the measure of LightPoint.pdf.
    pdf: f32,
    /// LightPoint.pdf: as light paths start there.
    pdf_position: f32,
    /// From a density per solid angle here to one in the measure of pdf; 0 where the light cannot be hit.
    to_measure: f32,
    /// Density of the light's emission along the ray, per area at a right angle to it, without survival.
    pdf_emit: f32,
    /// Where a shadow ray ends.
    end: vec3<f32>,
    /// The medium that the ray arrives through where it comes from a triangle's inside, or NONE.
    inside: u32,
}

/// A light's ray.
struct Emitted {
    origin: vec3<f32>,
    direction: vec3<f32>,
    /// What LightPoint.emission is multiplied by: the cosine, or the spot's falloff.
    factor: f32,
    /// Per solid angle; at infinity per area of the disk.
    pdf: f32,
    /// As mis_begin_light takes it.
    cos_light: f32,
}

fn load_light(index: u32) -> Light {
    let at = params.lights_at + index * LIGHT_STRIDE;
    let a = scene[at];
    let b = scene[at + 1u];
    return Light(bitcast<u32>(b.z), bitcast<u32>(a.x), a.y, a.z, bitcast<u32>(a.w), b.x, bitcast<u32>(b.y),
        bitcast<u32>(b.w));
}

/// The group of a light by its place, where groups are kept apart.
fn group_of_light(index: u32) -> u32 {
    if (!keeps_groups() || index == NONE) {
        return 0u;
    }
    return load_light(index).group;
}

/// A light for u in [0, 1); n_lights > 0.
fn pick_light(u: f32) -> u32 {
    let scaled = u * f32(params.n_lights);
    let cell = min(u32(scaled), params.n_lights - 1u);
    let light = load_light(cell);
    return alias_pick(cell, scaled - f32(cell), light.threshold, light.alias_entry);
}

fn is_infinite(light: Light) -> bool {
    return may_have(FEATURE_DIRECTIONAL_LIGHTS | FEATURE_ENVIRONMENT) && light.kind >= LIGHT_DIRECTIONAL;
}

/// The triangle, or NONE.
fn light_triangle(light: Light) -> u32 {
    return select(NONE, light.data, light.kind == LIGHT_TRIANGLE);
}

fn load_cone(light: Light) -> Cone {
    let a = scene[light.data];
    let b = scene[light.data + 1u];
    let c = scene[light.data + 2u];
    return Cone(c.xyz, bitcast<u32>(a.w), b.w, c.w);
}

/// The point of a light at these barycentrics (triangle) or in this direction (environment).
fn light_point(light: Light, uv: vec2<f32>, direction: vec3<f32>) -> LightPoint {
    let zero = vec3<f32>(0.0);
    if (may_have(FEATURE_POINT_LIGHTS) && light.kind == LIGHT_POINT) {
        return LightPoint(scene[light.data].xyz, scene[light.data + 2u].xyz, uv, scene[light.data + 1u].xyz, false, NONE, light.pmf);
    }
    if (may_have(FEATURE_DIRECTIONAL_LIGHTS) && light.kind == LIGHT_DIRECTIONAL) {
        return LightPoint(zero, scene[light.data].xyz, uv, scene[light.data + 1u].xyz, false, NONE, light.pmf);
    }
    if (is_environment(light)) {
        let seen = environment_towards(load_environment(), direction);
        return LightPoint(zero, direction, uv, seen.radiance, false, NONE, light.pmf * seen.pdf);
    }
    let emitter = load_emitter(light.data, uv.x, uv.y);
    let surface = emitter.surface;
    let emits_back = (emitter.flags & MATERIAL_EMITS_BACK) != 0u;
    let inside = select(NONE, surface.material, has_inside(emitter.flags));
    return LightPoint(surface.position, surface.ng, uv, emitter.emission, emits_back, inside, light.pmf / light.measure);
}

fn is_environment(light: Light) -> bool {
    return may_have(FEATURE_ENVIRONMENT) && light.kind == LIGHT_ENVIRONMENT;
}

/// A point on a light: u for a triangle, four more numbers for the environment.
fn draw_light_point(light: Light, u: vec2<f32>, path: u32, sample: u32, environment_dimension: u32) -> LightPoint {
    if (is_environment(light)) {
        let bits = random_bits(path, sample, environment_dimension);
        return light_point(light, vec2<f32>(0.0), draw_environment(load_environment(), bits));
    }
    return light_point(light, sample_triangle(u), vec3<f32>(0.0));
}

/// How a point on a light is seen from elsewhere. ratio: of the chance by which the light was drawn to
/// that by power.
fn see_light(light: Light, point: LightPoint, place: vec3<f32>, ratio: f32) -> LightSample {
    let pdf = point.pdf * ratio;
    if (is_infinite(light)) {
        // From within the sphere its diameter leads out of it; a hundredth more for rounding.
        let end = place + point.normal * (2.02 * params.scene_radius);
        let to_measure = select(0.0, 1.0, light.kind == LIGHT_ENVIRONMENT);
        return LightSample(point.normal, F32_MAX, point.emission, pdf, point.pdf, to_measure, 1.0 / light.measure, end, NONE);
    }
    let between = point.position - place;
    let distance_squared = dot(between, between);
    if (distance_squared == 0.0) {
        return LightSample(vec3<f32>(0.0, 0.0, 1.0), 0.0, vec3<f32>(0.0), pdf, point.pdf, 0.0, 0.0, point.position, NONE);
    }
    let distance = sqrt(distance_squared);
    let wi = between / distance;
    if (may_have(FEATURE_POINT_LIGHTS) && light.kind == LIGHT_POINT) {
        let arriving = point.emission * (cone_falloff(load_cone(light), -wi) / distance_squared);
        return LightSample(wi, distance, arriving, pdf, point.pdf, 0.0, 1.0 / (light.measure * distance_squared), point.position, NONE);
    }
    let cos_light = dot(point.normal, -wi);
    let radiance = select(vec3<f32>(0.0), point.emission, emits_towards(cos_light, point.emits_back));
    let geometry = abs(cos_light) / distance_squared;
    let end = offset_origin(point.position, select(-point.normal, point.normal, cos_light > 0.0));
    return LightSample(wi, distance, radiance * geometry, pdf, point.pdf, geometry,
        emission_pdf_sa(cos_light, point.emits_back) / distance_squared, end, select(NONE, point.inside, cos_light < 0.0));
}

/// A ray from a point on a light.
fn emit(light: Light, point: LightPoint, u: vec3<f32>) -> Emitted {
    if (is_infinite(light)) {
        let disk = frame_from_normal(point.normal) * vec3<f32>(sample_disk(u.xy), 1.0);
        let hit_by_camera = select(0.0, 1.0, light.kind == LIGHT_ENVIRONMENT);
        return Emitted(params.scene_centre + params.scene_radius * disk, -point.normal, 1.0, 1.0 / light.measure, hit_by_camera);
    }
    if (may_have(FEATURE_POINT_LIGHTS) && light.kind == LIGHT_POINT) {
        let direction = sample_cone(point.normal, light.measure * (0.5 * INV_PI), u.xy);
        return Emitted(point.position, direction, cone_falloff(load_cone(light), direction), 1.0 / light.measure, 0.0);
    }
    let direction = sample_emission(point.normal, point.emits_back, u);
    let cos_front = dot(point.normal, direction);
    let origin = offset_origin(point.position, select(-point.normal, point.normal, cos_front > 0.0));
    return Emitted(origin, direction, abs(cos_front), emission_pdf_sa(cos_front, point.emits_back), abs(cos_front));
}
