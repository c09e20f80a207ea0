// Whether a contribution's segment is free.

/// The part of a segment that is searched: its end lies on a surface, and the end of a long segment
/// is known to 2^-24 of its length only, divided by the cosine it arrives at.
const SEGMENT_END: f32 = 0.99999;

/// From a point along a segment, both its ends already offset from their surfaces.
fn is_free(start: vec3<f32>, segment: vec3<f32>) -> bool {
    return !any_hit(start, segment, SEGMENT_END);
}
