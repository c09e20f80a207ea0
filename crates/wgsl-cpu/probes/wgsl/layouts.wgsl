// Structs, arrays and matrices in buffers: offsets, strides, padding. One invocation is one
// record, of which it writes a changed copy, and parts into what was there.

struct Inner { position: vec3<f32>, id: u32, corners: array<vec2<f32>, 3> }
struct Record { flag: u32, inner: Inner, frame: mat3x3<f32>, tail: array<Inner, 2>, small: mat2x2<f32> }
struct Header { scale: f32, offset: vec3<f32>, picks: array<vec4<u32>, 2>, turn: mat4x3<f32> }
struct Counted { count: atomic<u32>, total: atomic<i32>, records: array<Record> }

@group(0) @binding(2) var<storage, read_write> result: Counted;
@group(0) @binding(0) var<uniform> header: Header;
@group(0) @binding(1) var<storage, read> records: array<Record>;

fn moved(inner: Inner) -> Inner {
    var copy = inner;
    copy.position = header.scale * inner.position + header.offset;
    copy.corners[1].y += 1.0;
    return copy;
}

@compute @workgroup_size(64)
fn layouts(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&records) { return; }
    let count = atomicAdd(&result.count, 1u);
    atomicSub(&result.total, i32(records[id.x].flag));
    let to = &result.records[id.x];
    if id.x % 2u == 0u {
        var record = records[id.x];
        record.inner = moved(record.inner);
        record.tail[1] = moved(record.tail[0]);
        record.frame = record.frame * record.frame;
        *to = record;
    } else {
        (*to).flag = header.picks[id.x % 2u].z + arrayLength(&result.records);
        (*to).inner.position.y = records[id.x].tail[id.x % 2u].corners[2].x;
        (*to).tail[id.x % 2u].corners[id.x % 3u] = records[id.x].small[1];
        (*to).frame[id.x % 3u] = header.turn[3];
        (*to).frame[0][id.x % 3u] = header.turn[id.x % 4u].z;
        (*to).tail[0] = records[id.x].inner;
        (*to).small = transpose(records[id.x].small);
    }
}
