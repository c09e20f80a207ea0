// Sums of what camera rays hit first, for the auxiliary layers.

/// vec4 per pixel of the window: albedo, samples that hit something; shading normal, depth along the
/// view direction; position.
const AOV_STRIDE: u32 = 3u;

@group(0) @binding(20) var<storage, read_write> aov_sums: array<vec4<f32>>;
