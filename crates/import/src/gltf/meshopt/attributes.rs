//! Mode ATTRIBUTES: differences from vertex to vertex, byte by byte, in as few bits as they need.

use super::{CUT_SHORT, Reader};

const HEADER: u8 = 0xa0;
/// Bytes of a stream's end, the first vertex among them, where a vertex is shorter.
const SHORTEST_TAIL: usize = 32;
/// Bytes of a block, and the most vertices in it.
const BLOCK_BYTES: usize = 8192;
const BLOCK_VERTICES: usize = 256;
/// Bytes that are packed with the same number of bits.
const GROUP: usize = 16;
/// The longest vertex.
const MAX_STRIDE: usize = 256;

/// `count` vertices of `stride` bytes.
pub(super) fn decode(stream: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, &'static str> {
    if stride == 0 || !stride.is_multiple_of(4) || stride > MAX_STRIDE {
        return Err("the stride of attributes is a multiple of 4, and at most 256");
    }
    let (&header, body) = stream.split_first().ok_or(CUT_SHORT)?;
    if header != HEADER {
        return Err(
            "its compressed attributes are of a version that is not read; decompress the file first, for example with gltf-transform",
        );
    }
    let tail = stride.max(SHORTEST_TAIL);
    let blocks = body.len().checked_sub(tail).ok_or(CUT_SHORT)?;
    let mut last = body[body.len() - stride..].to_vec();
    let mut reader = Reader(&body[..blocks]);
    let per_block = (BLOCK_BYTES / stride / GROUP * GROUP).clamp(GROUP, BLOCK_VERTICES);
    let mut vertices = Vec::new();
    while vertices.len() / stride < count {
        let n = per_block.min(count - vertices.len() / stride);
        block(&mut reader, n, &mut last, &mut vertices)?;
    }
    if reader.0.is_empty() { Ok(vertices) } else { Err("its compressed data is longer than its vertices") }
}

/// Appends `n` vertices; `last` is the one before them.
fn block(reader: &mut Reader, n: usize, last: &mut [u8], vertices: &mut Vec<u8>) -> Result<(), &'static str> {
    let stride = last.len();
    let start = vertices.len();
    for (k, previous) in last.iter_mut().enumerate() {
        let plane = plane(reader, n.next_multiple_of(GROUP))?;
        if k == 0 {
            vertices.resize(start + n * stride, 0);
        }
        for (i, delta) in plane[..n].iter().enumerate() {
            *previous = previous.wrapping_add((delta >> 1) ^ (delta & 1).wrapping_neg());
            vertices[start + i * stride + k] = *previous;
        }
    }
    Ok(())
}

/// One byte of each of `n` vertices, in groups whose number of bits stands before them all.
fn plane(reader: &mut Reader, n: usize) -> Result<[u8; BLOCK_VERTICES], &'static str> {
    let mut plane = [0; BLOCK_VERTICES];
    let n_groups = n / GROUP;
    let header = reader.take(n_groups.div_ceil(4))?;
    for (g, group) in plane[..n].chunks_exact_mut(GROUP).enumerate() {
        match header[g / 4] >> (g % 4 * 2) & 3 {
            0 => {}
            1 => packed(reader, group, 2)?,
            2 => packed(reader, group, 4)?,
            _ => group.copy_from_slice(reader.take(GROUP)?),
        }
    }
    Ok(plane)
}

/// Values of so many bits, the highest first; those that are all ones follow as whole bytes.
fn packed(reader: &mut Reader, group: &mut [u8], bits: usize) -> Result<(), &'static str> {
    let words = reader.take(GROUP * bits / 8)?;
    let escape = (1u8 << bits) - 1;
    let per_byte = 8 / bits;
    for (i, value) in group.iter_mut().enumerate() {
        let shift = 8 - bits * (i % per_byte + 1);
        let packed = words[i / per_byte] >> shift & escape;
        *value = if packed == escape { reader.byte()? } else { packed };
    }
    Ok(())
}
