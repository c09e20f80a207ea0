// Statements: loops, switches, early returns, pointers, private variables. One invocation is one
// number.

@group(0) @binding(0) var<storage, read> inputs: array<u32>;
@group(0) @binding(1) var<storage, read_write> outputs: array<array<u32, 8>>;

const PRIMES = array<u32, 5>(2u, 3u, 5u, 7u, 11u);

struct Pair { first: u32, second: array<u32, 3> }

var<private> state: u32 = 17u;
var<private> calls: u32;
var<private> drawn: u32;

fn collatz(start: u32) -> u32 {
    var n = start % 1000u + 1u;
    var steps = 0u;
    while n != 1u && steps < 200u {
        if n % 2u == 0u { n /= 2u; } else { n = 3u * n + 1u; }
        steps++;
    }
    return steps;
}

fn skip(n: u32) -> u32 {
    var sum = 0u;
    for (var i = 0u; i < n % 50u; i++) {
        var digits: array<u32, 4>;
        if i % 3u == 0u { continue; }
        digits[i % 4u] += i;
        switch i % 7u {
            case 1u, 2u: { continue; }
            case 3u: { if i > 20u { break; } sum += 100u; }
            default: { sum += digits[0] + digits[1]; }
            case 5u: { sum ^= i; }
        }
        if sum > 5000u { return sum; }
        sum += digits[2] + digits[3];
    }
    return sum;
}

fn continuing_reads_the_body(n: u32) -> u32 {
    var i = 0u;
    var sum = 0u;
    loop {
        let doubled = 2u * i;
        var twice = doubled + 1u;
        i += 1u;
        if i % 3u == 1u { continue; }
        sum += twice;
        continuing {
            sum += doubled;
            break if i > n % 20u;
        }
    }
    return sum;
}

fn bump(at: ptr<function, u32>, by: u32) -> u32 {
    let before = *at;
    *at = before + by;
    return before;
}

fn rotate(values: ptr<function, array<u32, 3>>) {
    let last = (*values)[2];
    for (var i = 2; i > 0; i--) { (*values)[i] = (*values)[i - 1]; }
    (*values)[0] = last;
}

fn next() -> u32 {
    state = state * 1664525u + 1013904223u;
    calls += 1u;
    return state >> 8u;
}

fn draw_into(place: ptr<private, u32>) { *place = *place + next(); }

fn pointers(n: u32) -> u32 {
    var pair = Pair(n, array<u32, 3>(1u, 2u, 3u));
    let at = &pair.second[n % 3u];
    var seen = *at;
    *at += 10u;
    seen += bump(&seen, *at);
    pair.first += *at;
    var second = pair.second;
    rotate(&second);
    let copy = second;
    pair = Pair();
    pair.first++;
    return seen + 7u * copy[n % 3u] + 31u * n + pair.first + copy[0];
}

fn choose(n: u32) -> i32 {
    switch i32(n % 6u) - 2 {
        case -2: { return 5; }
        case -1, 0: { return -7; }
        case 3: { if n > 100u { return 1; } return 2; }
        default: { return 0; }
    }
}

fn guarded(n: u32, limit: u32) -> bool {
    return n < limit && (PRIMES[n] == 5u || bump_is_even(n)) || n == 1000u;
}

fn bump_is_even(n: u32) -> bool {
    var local = n;
    return bump(&local, 1u) % 2u == 0u;
}

@compute @workgroup_size(64)
fn control(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32,
           @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    if id.x >= arrayLength(&inputs) { return; }
    let n = inputs[id.x];
    let first = next() ^ next();
    draw_into(&drawn);
    outputs[id.x] = array<u32, 8>(
        collatz(n), skip(n), continuing_reads_the_body(n), pointers(n), u32(choose(n)),
        first + drawn * calls, u32(guarded(n % 9u, 5u)) + 2u * PRIMES[n % 5u],
        lane + 64u * group.x + 1000u * groups.x,
    );
}
