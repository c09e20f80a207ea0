// Atomics whose end state does not depend on the order of invocations. One invocation is one
// number.

struct Sums {
    added: atomic<u32>,
    subtracted: atomic<u32>,
    least: atomic<i32>,
    greatest: atomic<i32>,
    least_u: atomic<u32>,
    greatest_u: atomic<u32>,
    all: atomic<u32>,
    some: atomic<u32>,
    odd: atomic<u32>,
    claimed: atomic<u32>,
    by_loop: atomic<u32>,
    swaps: atomic<u32>,
}

@group(0) @binding(0) var<storage, read> inputs: array<u32>;
@group(0) @binding(1) var<storage, read_write> sums: Sums;
@group(0) @binding(2) var<storage, read_write> bins: array<atomic<u32>>;

@compute @workgroup_size(64)
fn atomics(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&inputs) { return; }
    let n = inputs[id.x];
    atomicAdd(&sums.added, n);
    atomicSub(&sums.subtracted, n);
    atomicMin(&sums.least, bitcast<i32>(n));
    atomicMax(&sums.greatest, bitcast<i32>(n));
    atomicMin(&sums.least_u, n);
    atomicMax(&sums.greatest_u, n);
    atomicAnd(&sums.all, n | 0xffu);
    atomicOr(&sums.some, n & 0xff00u);
    atomicXor(&sums.odd, n);
    let before = atomicAdd(&bins[n % arrayLength(&bins)], 1u);
    if before == 0u { atomicAdd(&sums.swaps, 1u); }
    loop {
        let old = atomicLoad(&sums.by_loop);
        let tried = atomicCompareExchangeWeak(&sums.by_loop, old, old + 3u);
        if tried.exchanged { break; }
    }
    if id.x == 0u {
        atomicStore(&sums.claimed, 5u);
        let was = atomicExchange(&sums.claimed, 6u);
        let failed = atomicCompareExchangeWeak(&sums.claimed, 5u, 9u);
        atomicAdd(&sums.claimed, 10u * was + 100u * failed.old_value + 1000u * u32(failed.exchanged));
    }
}
