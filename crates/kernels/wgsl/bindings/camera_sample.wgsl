// The camera ray of one sample of a pixel: what the beauty and the auxiliary layers both see.

/// Through a film point drawn by the pixel's filter and a point drawn on the lens. `pixel`: its
/// number in the full film.
fn camera_sample(pixel: u32, sample: u32) -> CameraRay {
    let u = random(pixel, sample, dimension(DRAW_FILM, 0u));
    let corner = vec2<f32>(vec2<u32>(pixel % params.film_width, pixel / params.film_width));
    let offset = vec2<f32>(sample_filter(pixel_filter(), u.x), sample_filter(pixel_filter(), u.y));
    return camera_ray(params.camera, corner + 0.5 + offset, sample_lens(params.camera, u.zw));
}
