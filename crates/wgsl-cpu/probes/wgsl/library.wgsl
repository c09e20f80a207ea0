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

// Constructs that are rare in kernels.

struct Ids { @builtin(global_invocation_id) global: vec3<u32>, @builtin(local_invocation_index) lane: u32 }
struct Table { rows: array<array<vec3<f32>, 2>, 3>, at: vec2<i32> }
struct Shared { left: u32, counts: array<array<atomic<i32>, 3>, 2>, tables: array<Table> }

@group(0) @binding(4) var<storage, read_write> shared_data: Shared;

const TABLE: array<Table, 2> = array<Table, 2>(
    Table(array<array<vec3<f32>, 2>, 3>(), vec2(1, -2147483648)),
    Table(array<array<vec3<f32>, 2>, 3>(), vec2(i32(3), 4)),
);
const ORIGIN: Table = Table();
const HALF_TURN: mat2x2<f32> = mat2x2<f32>(-1.0, 0.0, 0.0, -1.0);

fn bools(a: vec3<bool>, b: bool, v: vec3<f32>) -> vec3<bool> {
    let both = a & vec3(b, !b, true);
    let either = select(both, !a, v > vec3(0.0)) | (both == a);
    return vec3(any(either) != b, all(either), (b & either.x) | either.z);
}

fn of_table(i: i32, j: u32) -> i32 {
    let copy = TABLE;
    var table = TABLE[i];
    table.rows[j][i].y = 3.0;
    table.rows[j][i][j] += 1.0;
    let rows = table.rows;
    return copy[j].at[i] + table.at[j] + i32(rows[j][i].y) + ORIGIN.at.x + TABLE[1].at.y;
}

fn of_matrix(m: mat3x2<f32>, i: u32, x: f32) -> vec2<f32> {
    var n = 2.0 * m - m * x;
    n[i] = m[2];
    n[1][i] = x;
    n[i].x -= 1.0;
    let turned = HALF_TURN * n;
    return turned[i] + turned[0];
}

fn into_buffer(i: u32, x: vec3<f32>) -> i32 {
    shared_data.tables[i].rows[i][1] = x;
    shared_data.tables[i].rows[2] = array<vec3<f32>, 2>(x, -x);
    shared_data.tables[i].rows[i][0][i] = 9.0;
    shared_data.tables[i].at.y = shared_data.tables[i].at.x - 1;
    atomicStore(&shared_data.counts[i][2], -5);
    atomicAdd(&shared_data.counts[i % 2u][i], 2);
    let place = &shared_data.tables[i].rows[i];
    return i32((*place)[1].z) + atomicLoad(&shared_data.counts[i][2]);
}

fn only_default(n: i32) -> i32 {
    var sum = 0;
    switch n { default: { sum = 1; } }
    for (var i = 0; ; i++) {
        switch i {
            case -2147483648, default: { if i > n { break; } sum += i; continue; }
            case 3: { sum += 100; }
        }
        if i > n { break; }
    }
    return sum;
}

fn nested_loops(n: u32) -> u32 {
    var count = 0u;
    for (var i = 0u; i < n; i++) {
        var j = i;
        loop {
            if j == 2u { break; }
            if count > 50u { return count; }
            j += 1u;
            continuing {
                count += select(1u, 2u, j > 3u);
                break if j >= n;
            }
        }
        if i == 3u { continue; }
        while true { if j < 5u { j++; } else { break; } }
        count += j;
    }
    return count;
}

fn results(x: f32) -> f32 {
    let parts = frexp(vec2(x, 4.0 * x));
    var split = modf(x);
    split.fract += 1.0;
    return split.fract + f32(parts.exp.y) + parts.fract.x;
}

fn of_ids(ids: Ids) -> u32 { return ids.global.y + ids.lane; }
