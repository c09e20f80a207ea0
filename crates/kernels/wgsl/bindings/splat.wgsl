// Strategy (s, 1): a stored light vertex projected onto the film, through a lens point of its own and into
// a pixel drawn by the filter.

/// One shadow ray, where the vertex is seen.
fn splat_light_vertex(stored: LightVertex) {
    let u = splat_numbers(stored);
    let lens = sample_lens(params.camera, u.xy);
    let film_point = camera_project(params.camera, stored.position, lens);
    if (!reaches_window(film_point) || !length_allowed(stored.s, 1u)) {
        return;
    }
    let place = splat_place(film_point.xy, u.zw);
    let start = camera_start(params.camera, film_point.xy, lens);
    let to_camera = start - stored.position;
    let distance_squared = dot(to_camera, to_camera);
    if (place.pixel == NONE || distance_squared == 0.0) {
        return;
    }
    let distance = sqrt(distance_squared);
    let wi = to_camera / distance;
    let surface = load_stored_surface(stored);
    if (stored.s > 1u && !may_scatter(surface, stored.wo, wi)) {
        return;
    }
    let end = shade_surface(surface, stored.throughput);
    let terms = light_end_terms(stored, end, wi);
    // the cosine is > 0: the vertex is in front of the camera
    let pdf_camera = camera_pdf_across(params.camera, film_point.z / distance, distance_squared);
    let cosine = abs(dot(surface.ng, wi));
    var weight = 1.0; // `light` has no other strategy: no camera path hits what it sees
    if (stored.s > 1u && has_flag(FLAG_HIT)) {
        let config = mis_config();
        let ending = ending_chance(config, survival(end.material));
        weight = mis_weight_splat(config, pdf_camera * cosine, light_earlier(stored, ending, terms.pdf_rev));
    }
    let medium = medium_before(params.camera_medium, surface, end.material.flags, wi);
    // splat_factor > 0: light paths per sample of every pixel
    let contribution = terms.f * medium_transmittance(medium, distance)
        * (cosine * pdf_camera / params.splat_factor * strategy_weight(stored.s, 1u, weight) * place.weight);
    if (contributes(contribution)) {
        push_shadow_ray(place.pixel, stored.group, offset_origin(stored.position, normal_towards(surface, wi)), start, contribution);
    }
}

/// Numbers for the lens (x, y) and the filter (z, w), where these need any: by where the vertex lies
/// and whence it was reached, which tells light vertices apart and does not depend on the order of
/// appends. A stored vertex has no room for its path's number.
fn splat_numbers(stored: LightVertex) -> vec4<f32> {
    if (params.camera.lens_radius == 0.0 && is_unit_box(pixel_filter())) {
        return vec4<f32>(0.0);
    }
    let at = bitcast<vec3<u32>>(stored.position);
    let from_direction = bitcast<vec3<u32>>(stored.wo);
    return random(mix32(at.x ^ mix32(from_direction.x)), mix32(at.y ^ mix32(from_direction.y)),
        mix32(at.z ^ mix32(from_direction.z)) ^ dimension(DRAW_FILM + DRAW_LIGHT, stored.s));
}

/// The window's size in pixels.
fn window_size() -> vec2<f32> {
    return vec2<f32>(f32(params.crop_width), f32(params.n_pixels / params.crop_width)); // crop_width > 0: an empty film is refused
}

/// Whether a film point is in front of the camera and within a filter's reach of the window.
fn reaches_window(film_point: vec3<f32>) -> bool {
    let x = film_point.x - f32(params.crop_x);
    let y = film_point.y - f32(params.crop_y);
    let reach = 0.5 * params.filter_width;
    let size = window_size() + reach;
    return film_point.z > 0.0 && x >= -reach && y >= -reach && x <= size.x && y <= size.y;
}

struct SplatPlace {
    /// In the full film, or NONE where it is outside the window.
    pixel: u32,
    weight: f32,
}

/// The pixel that a splat at a film point goes to, and what it is multiplied by.
fn splat_place(film: vec2<f32>, u: vec2<f32>) -> SplatPlace {
    let column = pick_pixel(pixel_filter(), film.x, u.x);
    let row = pick_pixel(pixel_filter(), film.y, u.y);
    let x = column.place - f32(params.crop_x);
    let y = row.place - f32(params.crop_y);
    let size = window_size();
    if (!(x >= 0.0 && y >= 0.0 && x < size.x && y < size.y)) {
        return SplatPlace(NONE, 0.0);
    }
    return SplatPlace(u32(row.place) * params.film_width + u32(column.place), column.weight * row.weight);
}
