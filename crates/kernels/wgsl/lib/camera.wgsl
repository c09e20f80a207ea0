// Cameras: pinhole, thin lens, and parallel (orthographic) rays. Film points are in pixels, (0, 0)
// the top left corner, y down, continuous; they go on beyond the edges, as pixels' filters do.
//
// A camera ray follows from a film point f and a lens point l. With d the view direction, F the
// distance of focus, and f and l as vectors across d (f at distance 1 where rays are not parallel):
//
//   perspective   from origin + l         along d + f - l / F
//   parallel      from origin + f + l     along d - l / F
//
// All rays of one f meet at depth F, so that what is there is sharp. A pinhole has l = 0; parallel
// rays without a lens all run along d.
//
// Measure. A pixel is the mean of L over f by its filter (lib/pixel_filter.wgsl) and over l uniform
// on the lens. For a fixed l, one film point a pixel's area A has the density
//
//   perspective   1 / (A cos³) per solid angle: from any l the plane of focus is the same film
//   parallel      1 / (A cos) per area across the ray, whose direction l alone decides
//
// with cos the ray's angle to d; `camera_pdf`. Per area of z_1 both are divided by cos(z_1), the
// first by the squared distance too: parallel rays do not spread (`camera_pdf_across`, and
// Path.parallel for the camera subpath's first segment).
//
// MIS. Every strategy has t >= 1 and draws l alike: camera subpaths, and splats afresh for each
// light vertex. Its density 1 / (lens area) is a factor of all of them and cancels in weights, as a
// pinhole's Dirac does; in a splat it cancels against the measure too. The direction of parallel rays, a Dirac
// once l is drawn, is such a factor as well: t = 1 projects along it. What is left is the density
// of z_1, above.

struct Camera {
    /// The middle of the lens or of the film.
    origin: vec3<f32>,
    /// A pixel's area in the units of half_width and half_height.
    pixel_area: f32,
    /// Unit vectors of the world frame, each with half the film's extent: at distance 1, or of
    /// parallel rays.
    right: vec3<f32>,
    half_width: f32,
    up: vec3<f32>,
    half_height: f32,
    /// Unit view direction.
    forward: vec3<f32>,
    width: f32,
    height: f32,
    /// 0 for a pinhole.
    lens_radius: f32,
    /// 1 / F.
    inverse_focus: f32,
    /// 1 where rays are parallel.
    parallel: u32,
}

struct CameraRay {
    origin: vec3<f32>,
    /// Unit.
    direction: vec3<f32>,
    /// `camera_pdf`.
    pdf: f32,
}

/// A film point as a vector across the view direction.
fn film_offset(camera: Camera, film: vec2<f32>) -> vec3<f32> {
    let x = (2.0 * film.x / camera.width - 1.0) * camera.half_width;
    let y = (1.0 - 2.0 * film.y / camera.height) * camera.half_height;
    return x * camera.right + y * camera.up;
}

/// A point of the lens, uniform in area, as a vector from its middle.
fn sample_lens(camera: Camera, u: vec2<f32>) -> vec3<f32> {
    if (camera.lens_radius == 0.0) {
        return vec3<f32>(0.0);
    }
    let p = camera.lens_radius * sample_disk(u);
    return p.x * camera.right + p.y * camera.up;
}

/// z_0: where the ray of a film point and a lens point starts.
fn camera_start(camera: Camera, film: vec2<f32>, lens: vec3<f32>) -> vec3<f32> {
    if (camera.parallel != 0u) {
        return camera.origin + (film_offset(camera, film) + lens);
    }
    return camera.origin + lens;
}

/// The ray of a film point and a lens point.
fn camera_ray(camera: Camera, film: vec2<f32>, lens: vec3<f32>) -> CameraRay {
    let spread = select(film_offset(camera, film), vec3<f32>(0.0), camera.parallel != 0u);
    let direction = normalize(camera.forward + (spread - lens * camera.inverse_focus));
    return CameraRay(camera_start(camera, film, lens), direction, camera_pdf(camera, dot(direction, camera.forward)));
}

/// Density of a ray at the angle cos_forward > 0 to the view direction when one film point is drawn
/// for each pixel's area: per solid angle, or per area across parallel rays.
fn camera_pdf(camera: Camera, cos_forward: f32) -> f32 {
    let spread = select(cos_forward * cos_forward, 1.0, camera.parallel != 0u);
    return 1.0 / (camera.pixel_area * cos_forward * spread);
}

/// The same per area across the ray at a distance from its start.
fn camera_pdf_across(camera: Camera, cos_forward: f32, distance_squared: f32) -> f32 {
    return camera_pdf(camera, cos_forward) / select(distance_squared, 1.0, camera.parallel != 0u);
}

/// The film point (x, y) whose ray through a lens point meets a point of the world, and that
/// point's depth along the view direction (z): in front of the camera where z > 0.
fn camera_project(camera: Camera, position: vec3<f32>, lens: vec3<f32>) -> vec3<f32> {
    let between = position - camera.origin;
    let depth = dot(between, camera.forward);
    if (!(depth > 0.0)) {
        return vec3<f32>(-1.0, -1.0, 0.0);
    }
    let across = between - lens * (1.0 - depth * camera.inverse_focus);
    let scale = select(depth, 1.0, camera.parallel != 0u);
    let x = dot(across, camera.right) / (scale * camera.half_width);
    let y = dot(across, camera.up) / (scale * camera.half_height);
    return vec3<f32>((x + 1.0) * 0.5 * camera.width, (1.0 - y) * 0.5 * camera.height, depth);
}
