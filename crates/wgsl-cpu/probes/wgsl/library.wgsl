// A module without an entry point: functions that Rust calls. The pointers here lead into parts of
// variables, which naga's SPIR-V writer cannot pass, so that no GPU runs them.

const GOLDEN: f32 = 1.618034;

struct Pair { first: u32, second: array<u32, 3> }

var<private> count: u32 = 3u;
var<private> drawn: array<u32, 2>;

fn scaled(v: vec3<f32>, by: f32) -> vec3<f32> { return by * v; }

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

fn into_parts(n: u32) -> u32 {
    var pair = Pair(n, array<u32, 3>(1u, 2u, 3u));
    let at = &pair.second[n % 3u];
    let seen = bump(at, 10u) + bump(&pair.first, *at);
    rotate(&pair.second);
    return seen + 7u * pair.second[n % 3u] + 31u * pair.first;
}

fn next() -> u32 {
    count += 1u;
    return count;
}

fn count_into(place: ptr<private, u32>) { *place += next(); }

fn count_into_part(i: u32) -> u32 {
    count_into(&drawn[i]);
    return drawn[i];
}
