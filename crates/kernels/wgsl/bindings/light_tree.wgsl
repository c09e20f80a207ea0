// The tree over lights in the buffer `scene`: nodes, the root first, then for each light the way to it, two
// bits a level from the lowest, which of the four.

/// vec4 per node.
const LIGHT_NODE_STRIDE: u32 = 11u;

/// Levels that are descended by the first of two random numbers; the second has the bits for the rest.
const LEVELS_BY_FIRST_NUMBER: u32 = 6u;

fn load_light_node(index: u32) -> LightNode {
    let at = params.light_tree_at + index * LIGHT_NODE_STRIDE;
    return LightNode(scene[at], scene[at + 1u], scene[at + 2u], scene[at + 3u], scene[at + 4u], scene[at + 5u],
        scene[at + 6u], scene[at + 7u], scene[at + 8u], scene[at + 9u], bitcast<vec4<u32>>(scene[at + 10u]));
}

/// A light drawn for next-event estimation.
struct DrawnLight {
    /// NONE where none shines there.
    index: u32,
    /// Its chance over that by power.
    ratio: f32,
}

/// A light for two numbers in [0, 1) to be sampled at a place; n_lights > 0.
fn draw_light(place: LightPlace, u: vec2<f32>) -> DrawnLight {
    if (!uses_light_tree()) {
        return DrawnLight(pick_light(u.x), 1.0);
    }
    var link = 0u;
    var chance = 1.0;
    var number = u.x;
    var level = 0u;
    while ((link & LIGHT_NODE_LEAF) == 0u) { // at most 16 times
        let node = load_light_node(link & LIGHT_NODE_INDEX);
        let child = draw_light_child(light_importances(node, place), number);
        if (child.index == NONE) {
            return DrawnLight(NONE, 0.0);
        }
        link = node.links[child.index];
        chance *= child.share;
        level += 1u;
        number = select(child.number, u.y, level == LEVELS_BY_FIRST_NUMBER);
    }
    let index = link & LIGHT_NODE_INDEX;
    return DrawnLight(index, chance / load_light(index).pmf); // > 0: others are not in the tree
}

/// DrawnLight.ratio of a light at a place.
fn light_chance_ratio(index: u32, light: Light, place: LightPlace) -> f32 {
    if (!uses_light_tree()) {
        return 1.0;
    }
    if (light.pmf <= 0.0) {
        return 0.0;
    }
    var way = bitcast<u32>(scene[params.light_ways_at + (index >> 2u)][index & 3u]);
    var link = 0u;
    var chance = 1.0;
    while ((link & LIGHT_NODE_LEAF) == 0u && chance > 0.0) { // at most 16 times
        let node = load_light_node(link & LIGHT_NODE_INDEX);
        let child = way & 3u;
        chance *= light_child_share(light_importances(node, place), child);
        link = node.links[child];
        way >>= 2u;
    }
    return chance / light.pmf;
}
