// The pinhole camera. Film coordinates are pixels, (0, 0) the top left corner, continuous.
// The film lies at distance 1 along the view direction; a pixel's area there is `pixel_area`.

struct Camera {
    origin: vec3<f32>,
    pixel_area: f32,
    /// Unit vectors of the world frame, each with half the film's extent at distance 1.
    right: vec3<f32>,
    half_width: f32,
    up: vec3<f32>,
    half_height: f32,
    /// Unit view direction.
    forward: vec3<f32>,
    width: f32,
    height: f32,
}

/// Unit direction through a film point.
fn camera_direction(camera: Camera, film: vec2<f32>) -> vec3<f32> {
    let x = (2.0 * film.x / camera.width - 1.0) * camera.half_width;
    let y = (1.0 - 2.0 * film.y / camera.height) * camera.half_height;
    return normalize(camera.forward + x * camera.right + y * camera.up);
}

/// Solid-angle density of a direction when one film point is drawn uniformly in its pixel.
/// cos_forward > 0 is the angle to the view direction.
fn camera_pdf_sa(camera: Camera, cos_forward: f32) -> f32 {
    return 1.0 / (camera.pixel_area * cos_forward * cos_forward * cos_forward);
}

/// Where the unit direction (from the origin) meets the film; z is its cosine to the view
/// direction, and the point is valid only for z > 0 and inside [0, width) x [0, height).
fn camera_project(camera: Camera, direction: vec3<f32>) -> vec3<f32> {
    let cos_forward = dot(direction, camera.forward);
    if (cos_forward <= 0.0) {
        return vec3<f32>(-1.0, -1.0, 0.0);
    }
    let x = dot(direction, camera.right) / (cos_forward * camera.half_width);
    let y = dot(direction, camera.up) / (cos_forward * camera.half_height);
    return vec3<f32>((x + 1.0) * 0.5 * camera.width, (1.0 - y) * 0.5 * camera.height, cos_forward);
}
