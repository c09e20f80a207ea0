// Vertices of light paths that are kept whole lie behind each other, in the order in which they come.

/// Stores a linked vertex of a light path; its slot, or NONE where it did not fit.
fn place_linked_vertex(light_path: u32, vertex: LightVertex) -> u32 {
    return append_light_vertex(vertex);
}
