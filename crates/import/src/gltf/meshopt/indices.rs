//! Modes TRIANGLES and INDICES: by edges and vertices met lately, and by differences.

use super::{CUT_SHORT, Reader, unzigzag};

const TRIANGLES_HEADER: u8 = 0xe0;
const SEQUENCE_HEADER: u8 = 0xd0;
/// At the end of a stream of triangles: codes that are frequent.
const TABLE_BYTES: usize = 16;
const SEQUENCE_TAIL: usize = 4;

/// The last sixteen of something.
struct Fifo<T> {
    items: [T; 16],
    next: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(fill: T) -> Self {
        Self { items: [fill; 16], next: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.next] = item;
        self.next = (self.next + 1) % 16;
    }

    /// The item pushed `back` before the next one.
    fn get(&self, back: usize) -> T {
        self.items[(self.next + 16 - back) % 16]
    }
}

/// `count` indices of `stride` bytes, three a triangle.
pub(super) fn triangles(stream: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, &'static str> {
    if !count.is_multiple_of(3) {
        return Err("triangles have three indices each");
    }
    let (&header, body) = stream.split_first().ok_or(CUT_SHORT)?;
    if !matches!(header, TRIANGLES_HEADER | 0xe1) {
        return Err("its compressed triangles are of a version that is not read");
    }
    let (codes, rest) = body.split_at_checked(count / 3).ok_or(CUT_SHORT)?;
    let data = rest.len().checked_sub(TABLE_BYTES).ok_or(CUT_SHORT)?;
    let (data, table) = rest.split_at(data);
    let mut decoder = Decoder {
        reader: Reader(data),
        edges: Fifo::new([0; 2]),
        vertices: Fifo::new(0),
        next: 0,
        last: 0,
        newest: if header == TRIANGLES_HEADER { 15 } else { 13 },
    };
    let mut out = Output::new(stride)?;
    for &code in codes {
        decoder.triangle(code, table)?.into_iter().for_each(|i| out.push(i));
    }
    if decoder.reader.0.is_empty() {
        Ok(out.bytes)
    } else {
        Err("its compressed data is longer than its triangles")
    }
}

struct Decoder<'a> {
    reader: Reader<'a>,
    edges: Fifo<[u32; 2]>,
    vertices: Fifo<u32>,
    next: u32,
    last: u32,
    /// Codes of a third vertex from here on are not of the FIFO.
    newest: u8,
}

impl Decoder<'_> {
    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], &'static str> {
        if code < 0xf0 {
            return self.by_edge(code);
        }
        if code < 0xfe {
            let auxiliary = table[usize::from(code & 15)];
            return self.by_vertices(0, auxiliary);
        }
        let auxiliary = self.reader.byte()?;
        if auxiliary == 0 {
            self.next = 0;
        }
        self.by_vertices(if code == 0xfe { 0 } else { 15 }, auxiliary)
    }

    /// On an edge met lately.
    fn by_edge(&mut self, code: u8) -> Result<[u32; 3], &'static str> {
        let [a, b] = self.edges.get(usize::from(code >> 4) + 1);
        let third = code & 15;
        let c = if third == 0 {
            self.fresh()
        } else if third < self.newest {
            self.vertices.get(usize::from(third) + 1)
        } else {
            self.last = match third {
                13 => self.last.wrapping_sub(1),
                14 => self.last.wrapping_add(1),
                _ => self.reader.index(self.last)?,
            };
            self.last
        };
        if third == 0 || third >= self.newest {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// On three vertices, each new, met lately, or told.
    fn by_vertices(&mut self, first: u8, others: u8) -> Result<[u32; 3], &'static str> {
        let fields = [first, others >> 4, others & 15];
        let mut corners = [0; 3];
        // All of the FIFO are looked up before any is pushed, and those told come last.
        for (corner, &field) in corners.iter_mut().zip(&fields) {
            *corner = match field {
                0 => self.fresh(),
                15 => 0,
                back => self.vertices.get(usize::from(back)),
            };
        }
        for (corner, _) in corners.iter_mut().zip(&fields).filter(|(_, field)| **field == 15) {
            self.last = self.reader.index(self.last)?;
            *corner = self.last;
        }
        for (&corner, _) in corners.iter().zip(&fields).filter(|(_, field)| matches!(field, 0 | 15)) {
            self.vertices.push(corner);
        }
        let [a, b, c] = corners;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok(corners)
    }

    fn fresh(&mut self) -> u32 {
        let index = self.next;
        self.next = self.next.wrapping_add(1);
        index
    }
}

/// `count` indices of `stride` bytes, in no order.
pub(super) fn sequence(stream: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, &'static str> {
    let (&header, body) = stream.split_first().ok_or(CUT_SHORT)?;
    if !matches!(header, SEQUENCE_HEADER | 0xd1) {
        return Err("its compressed indices are of a version that is not read");
    }
    let end = body.len().checked_sub(SEQUENCE_TAIL).ok_or(CUT_SHORT)?;
    let mut reader = Reader(&body[..end]);
    let mut last = [0u32; 2];
    let mut out = Output::new(stride)?;
    for _ in 0..count {
        let value = reader.varint()?;
        let of = &mut last[(value & 1) as usize];
        *of = of.wrapping_add(unzigzag(value >> 1));
        out.push(*of);
    }
    if reader.0.is_empty() { Ok(out.bytes) } else { Err("its compressed data is longer than its indices") }
}

struct Output {
    bytes: Vec<u8>,
    stride: usize,
}

impl Output {
    fn new(stride: usize) -> Result<Self, &'static str> {
        match stride {
            2 | 4 => Ok(Self { bytes: Vec::new(), stride }),
            _ => Err("the stride of indices is 2 or 4"),
        }
    }

    fn push(&mut self, index: u32) {
        self.bytes.extend_from_slice(&index.to_le_bytes()[..self.stride]);
    }
}
