// Starts light subpaths: a light by power, a point on it (at infinity: a direction), a direction (at
// infinity: a point on the disk that covers the scene).

#include "bindings/environment.wgsl"
#include "bindings/lights.wgsl"
#include "bindings/light_vertices.wgsl"
#include "bindings/light_store.wgsl"

struct LightStart {
    path: Path,
    /// Whether there is a path to be traced.
    is_traced: bool,
}

/// The light path of a place of the batch, its MIS state as after y_0 (lib/mis.wgsl). Keeps y_0 where it
/// can be an end.
fn light_path(place: u32) -> LightStart {
    var start: LightStart;
    start.is_traced = false;
    let in_pass = params.first_path + place;
    // Paths are told apart by pixel and sample, or in a pool by their number and the pass.
    let pool = has_flag(FLAG_POOL);
    let index = select(film_pixel(in_pass % params.n_pixels), in_pass, pool);
    let sample = params.first_sample + select(in_pass / params.n_pixels, 0u, pool);
    let slot = select(place, in_pass, pool);
    begin_light_path(slot);
    if (params.n_lights == 0u) {
        return start;
    }
    let u_point = random(index, sample, dimension(DRAW_LIGHT + DRAW_EMIT_POINT, 0u));
    let u_direction = random(index, sample, dimension(DRAW_LIGHT + DRAW_EMIT_DIRECTION, 0u));
    let light_index = pick_light(u_point.x);
    let light = load_light(light_index);
    let point = draw_light_point(light, u_point.yz, index, sample, dimension(DRAW_LIGHT + DRAW_ENVIRONMENT, 0u));
    if (point.pdf <= 0.0 || !any(point.emission > vec3<f32>(0.0))) {
        return start;
    }
    let vertex = LightVertex(point.position, light_triangle(light), point.emission / point.pdf, 0.0,
        point.normal, 0.0, point.uv.x, point.uv.y, light_index, 1u, light.group);
    let splats = has_flag(FLAG_SPLAT_EMITTERS) && light.kind == LIGHT_TRIANGLE;
    if (splats) {
        append_light_vertex(vertex);
    }
    if (u_direction.w >= params.emitter_survival) {
        end_light_path(slot, vertex);
        return start;
    }
    let emitted = emit(light, point, u_direction.xyz);
    let pdf_direction = emitted.pdf * params.emitter_survival;
    var throughput = vec3<f32>(0.0); // at the edge of a spot: its vertices would be chosen by an importance of 0
    if (pdf_direction > 0.0) {
        throughput = point.emission * (emitted.factor / (point.pdf * pdf_direction));
    }
    let lights = any(throughput > vec3<f32>(0.0));
    if (!lights && !splats) {
        return start;
    }
    // A path without light takes its slot for a bounce, so that a slot appends one y_0 a bounce at most.
    let config = mis_config();
    let ending = ending_chance(config, params.emitter_survival);
    var state = MisState(0.0, 0.0, ending);
    if (lights) {
        state = mis_begin_light(config, point.pdf, point.pdf, pdf_direction, emitted.cos_light, ending);
    }
    return LightStart(Path(emitted.origin, index, emitted.direction, 0u, 0u, is_infinite(light), throughput, sample, state,
        light.medium, NO_FACING), true);
}

/// That path, in a slot, where there is one to be traced; whether there is.
fn start_light_path(id: u32, place: u32) -> bool {
    let start = light_path(place);
    if (start.is_traced) {
        store_path(id, start.path);
    }
    return start.is_traced;
}

/// A light path's light: drawn again by the numbers that it was drawn by, so that a path under way needs
/// no room for it.
fn light_of_path(path: Path) -> u32 {
    let u_point = random(path.index, path.sample, dimension(DRAW_LIGHT + DRAW_EMIT_POINT, 0u));
    return pick_light(u_point.x); // there is a light: the path began at one
}

/// The group of a light path's light, where groups are kept apart.
fn light_path_group(path: Path) -> u32 {
    if (!keeps_groups()) {
        return 0u;
    }
    return load_light(light_of_path(path)).group;
}

/// The next light paths of the batch, until one is there to be traced, in the slot of one that ended.
fn next_light_path(id: u32) {
    loop { // ends with the batch's places
        let place = take_place();
        if (place == NONE) {
            return;
        }
        if (start_light_path(id, place)) {
            push_started(id);
            return;
        }
    }
}
