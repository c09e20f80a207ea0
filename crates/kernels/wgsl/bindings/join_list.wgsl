// The joins of a bounce: list_joins writes them, connect makes them. So invocations of connect all have one to make,
// where camera vertices have none or many.

/// Joins that an invocation makes: on a CPU it shades a camera vertex once for all of its own, which lie side by side.
const JOIN_RUN: u32 = 16u;

/// Two words a join: the camera path, and the slot of the light vertex; where connect chooses that itself from
/// candidates, the join's number. Capacity is reserved: connections_per_bounce() a path and bounce, or K where
/// that is less.
@group(0) @binding(26) var<storage, read_write> joins: array<u32>;

struct ListedJoin {
    path: u32,
    slot_or_number: u32,
}

fn joins_per_invocation() -> u32 {
    return select(1u, JOIN_RUN, may_have(FEATURE_JOIN_RUNS));
}

fn load_join(index: u32) -> ListedJoin {
    return ListedJoin(joins[2u * index], joins[2u * index + 1u]);
}

fn store_join(index: u32, join: ListedJoin) {
    joins[2u * index] = join.path;
    joins[2u * index + 1u] = join.slot_or_number;
}
