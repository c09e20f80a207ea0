// The environment's map of directions, in its own frame: latitude and longitude, row 0 about +y, the
// middle column -z, columns growing towards +x. Radiance is bilinear between texels' centres, and
// constant in latitude between the outermost centres and the poles; drawn directions follow its
// luminance. Both work by cells: cell (c, r) lies between the centres of columns c and c + 1 (mod
// width) and of rows r - 1 and r; rows of cells 0 and `height` reach to the poles.

/// A place in a cell, [0, 1] in both.
struct EnvironmentPlace {
    cell: vec2<u32>,
    within: vec2<f32>,
}

/// Where a unit direction lies.
fn environment_place(direction: vec3<f32>, size: vec2<u32>) -> EnvironmentPlace {
    let turns = angle_of(direction.x, -direction.z) * (0.5 * INV_PI); // in [-1/2, 1/2]
    let v = angle_of(length(direction.xz), direction.y) * INV_PI;
    let x = (turns + 0.5) * f32(size.x) - 0.5;
    let y = v * f32(size.y) + 0.5;
    let left = floor(x);
    let row = min(floor(y), f32(size.y));
    return EnvironmentPlace(vec2<u32>((u32(i32(left) + i32(size.x))) % size.x, u32(row)), vec2<f32>(x - left, min(y - row, 1.0)));
}

fn is_polar_cell(row: u32, height: u32) -> bool {
    return row == 0u || row == height;
}

/// A direction in a cell for two numbers in [0, 1), by the luminances at its corners (upper left,
/// upper right, lower left, lower right): bilinear in latitude and longitude; at a pole linear in
/// longitude and uniform in the sine of latitude.
fn environment_direction(cell: vec2<u32>, size: vec2<u32>, corners: vec4<f32>, u: vec2<f32>) -> vec3<f32> {
    var y = 0.0;
    var polar = vec2<f32>(0.0); // cosine and sine of the angle to +y
    if (is_polar_cell(cell.y, size.y)) {
        let half = sin_quarter(PI_OVER_4 / f32(size.y));
        let drop = u.y * 2.0 * half * half; // of 1 - cos(π / 2 height)
        polar = vec2<f32>(select(drop - 1.0, 1.0 - drop, cell.y == 0u), sqrt(drop * (2.0 - drop)));
    } else {
        y = sample_linear(u.y, corners.x + corners.y, corners.z + corners.w);
        polar = unit_circle(0.5 * (f32(cell.y) - 0.5 + y) / f32(size.y));
    }
    let x = sample_linear(u.x, mix(corners.x, corners.z, y), mix(corners.y, corners.w, y));
    let azimuth = unit_circle((f32(cell.x) + 0.5 + x) / f32(size.x) - 0.5);
    return vec3<f32>(polar.y * azimuth.y, polar.x, -polar.y * azimuth.x);
}

/// The density per solid angle of such a direction, over its luminance's share of the integral of
/// luminance over the sphere, where a cell is drawn by the mean of its corners times its solid
/// angle: 1 but for the difference between latitude and the sine of it within a cell.
fn environment_density_ratio(direction: vec3<f32>, row: u32, height: u32) -> f32 {
    if (is_polar_cell(row, height)) {
        return 1.0;
    }
    let half_step = PI_OVER_2 / f32(height); // at most π/4: other cells are there for height >= 2
    let middle = unit_circle(0.5 * f32(row) / f32(height)).y;
    // Away from the poles by half a step: the length is not 0.
    return middle * sin_quarter(half_step) / (half_step * length(direction.xz));
}
