// The tree over lights in the buffer `scene`: nodes, the root first and children side by side, then for
// each light the way to its leaf, a bit a level from the lowest, 1 for the second child.

/// vec4 per node.
const LIGHT_NODE_STRIDE: u32 = 3u;

/// Levels that are descended by the first of two random numbers; the second has the bits for the rest.
const LEVELS_BY_FIRST_NUMBER: u32 = 12u;

fn load_light_node(index: u32) -> LightNode {
    let at = params.light_tree_at + index * LIGHT_NODE_STRIDE;
    let a = scene[at];
    let b = scene[at + 1u];
    let c = scene[at + 2u];
    return LightNode(a.xyz, a.w, b.xyz, b.w, c.x, c.y, bitcast<u32>(c.z), bitcast<u32>(c.w));
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
    var node = load_light_node(0u);
    var chance = 1.0;
    var number = u.x;
    var level = 0u;
    while ((node.link & LIGHT_NODE_LEAF) == 0u) { // at most 32 times
        let first = load_light_node(node.link);
        let second = load_light_node(node.link + 1u);
        let share = first_child_chance(light_node_importance(first, place), light_node_importance(second, place));
        if (share < 0.0) {
            return DrawnLight(NONE, 0.0);
        }
        if (number < share) {
            node = first;
            chance *= share;
            number = number / share;
        } else {
            node = second;
            chance *= 1.0 - share;
            number = (number - share) / (1.0 - share); // share < 1: the number is
        }
        number = min(number, LAST_BELOW_ONE);
        level += 1u;
        if (level == LEVELS_BY_FIRST_NUMBER) {
            number = u.y;
        }
    }
    let index = node.link & ~LIGHT_NODE_LEAF;
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
    var node = load_light_node(0u);
    var chance = 1.0;
    while ((node.link & LIGHT_NODE_LEAF) == 0u) { // at most 32 times
        let first = load_light_node(node.link);
        let second = load_light_node(node.link + 1u);
        let share = first_child_chance(light_node_importance(first, place), light_node_importance(second, place));
        if (share < 0.0) {
            return 0.0;
        }
        if ((way & 1u) == 0u) {
            node = first;
            chance *= share;
        } else {
            node = second;
            chance *= 1.0 - share;
        }
        way >>= 1u;
    }
    return chance / light.pmf;
}
