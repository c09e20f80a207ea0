// The compacted list of paths under way, double-buffered, and the counters that never leave the
// device within a pass. Paths that go on are pushed from the front of a half, those that have just started
// from its end: a workgroup then holds the one kind or the other, and first rays, of neighbours, stay beside
// each other.

@group(0) @binding(5) var<storage, read_write> queues: array<u32>;
@group(0) @binding(6) var<storage, read_write> counters: array<atomic<u32>>;

const COUNT_IN: u32 = 0u;
const COUNT_OUT: u32 = 1u;
/// Which half of `queues` is read: 0 or 1.
const COUNT_PARITY: u32 = 2u;
/// Shadow rays pushed, and those to be traced now.
const COUNT_SHADOW: u32 = 3u;
const COUNT_SHADOW_TRACE: u32 = 4u;
/// Light vertices appended, and the range to be projected onto the film now.
const COUNT_VERTICES: u32 = 5u;
const COUNT_SPLAT_FIRST: u32 = 6u;
const COUNT_SPLAT_END: u32 = 7u;
/// The next place of the batch that waits for a slot.
const COUNT_NEXT: u32 = 8u;
/// Paths pushed from the end, and how many of those that are read now are at the front.
const COUNT_STARTED: u32 = 9u;
const COUNT_FRONT: u32 = 10u;
/// Joins listed in this bounce.
const COUNT_JOINS: u32 = 11u;
/// Bounces that had a path in the queue.
const COUNT_BOUNCES: u32 = 12u;
/// Queued paths that wait with joins to be listed: they trace no ray.
const COUNT_WAITING: u32 = 13u;
/// Rays traced in all: two words.
const COUNT_RAYS_LOW: u32 = 14u;
const COUNT_RAYS_HIGH: u32 = 15u;
/// Contributions that were NaN, infinite or negative, and film sums that overflowed.
const COUNT_REJECTED: u32 = 16u;
const COUNT_OVERFLOW: u32 = 17u;
/// How many counters there are.
const N_COUNTERS: u32 = 18u;

fn queue_length() -> u32 {
    return atomicLoad(&counters[COUNT_IN]);
}

fn queued_path(place: u32) -> u32 {
    let front = atomicLoad(&counters[COUNT_FRONT]);
    let in_half = select(params.n_paths - 1u - (place - front), place, place < front);
    return queues[atomicLoad(&counters[COUNT_PARITY]) * params.n_paths + in_half];
}

/// A place of the batch that has no path yet, for the slot of one that ended; NONE where all have. So
/// the queue stays as long as there are slots until the batch runs out of places.
fn take_place() -> u32 {
    // Counted beyond n_places once for each slot at most: no wrap-around.
    let place = atomicAdd(&counters[COUNT_NEXT], 1u);
    return select(NONE, place, place < params.n_places);
}

/// A path that goes on. Every slot is pushed at most once a bounce, so each half holds n_paths.
fn push_path(id: u32) {
    let place = atomicAdd(&counters[COUNT_OUT], 1u);
    queues[(1u - atomicLoad(&counters[COUNT_PARITY])) * params.n_paths + place] = id;
}

/// A path that has just started.
fn push_started(id: u32) {
    let place = atomicAdd(&counters[COUNT_STARTED], 1u);
    queues[(1u - atomicLoad(&counters[COUNT_PARITY])) * params.n_paths + params.n_paths - 1u - place] = id;
}
