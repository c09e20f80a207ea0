//! A node of eight children with boxes of a byte a plane.

use glam::{DVec3, Vec3};
use midway_scene::Bounds;

use crate::Child;

/// What is left free at both ends of the grid, in steps of it: rounding in the kernels' slab test is
/// below 2⁻²² of the node's extent (its origin is subtracted first), which is 2⁻¹⁴ steps.
const SLACK: f64 = 1.0 / 256.0;
/// The last place of the grid.
const LAST: f64 = 255.0;
/// Exponents of f32 that stand for normal numbers.
const EXPONENTS: std::ops::RangeInclusive<i32> = 1..=254;

/// A node as kernels read it, 80 bytes:
///
/// | vec4 | |
/// |---|---|
/// | 0 | the grid's origin; the exponents of its steps along x, y, z (bytes 0 to 2), and which children are nodes (byte 3) |
/// | 1 | first node among the children; first leaf slot of the children; a byte for each child |
/// | 2 | least x of each child, least y: bytes |
/// | 3 | least z, greatest x |
/// | 4 | greatest y, greatest z |
///
/// A child's byte: of a node 0b001 and 24 plus its slot; of a leaf the number of its triangles in unary in
/// the three highest bits and the place of the first, counted from the node's first leaf slot; of
/// nothing 0. Children that are nodes follow each other in the order of their slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct WideNode(pub [[u32; 4]; 5]);

impl WideNode {
    /// Without children.
    pub const EMPTY: Self = Self([[0; 4]; 5]);

    /// How many vec4 it takes.
    pub const VEC4: usize = 5;

    /// As it is where this many nodes and leaf slots lie before those of its hierarchy.
    pub(crate) fn moved(mut self, first_node: u32, first_slot: u32) -> Self {
        self.0[1][0] += first_node;
        self.0[1][1] += first_slot;
        self
    }

    /// `bounds` are around all children; inner ones follow each other in the order of their slots,
    /// and leaves lie within 24 leaf slots.
    pub(super) fn new(bounds: &Bounds, children: &[Option<(Bounds, Child)>; 8]) -> Self {
        let grid = Grid::around(bounds);
        let mut bytes = [0u8; 80];
        for axis in 0..3 {
            bytes[4 * axis..4 * axis + 4].copy_from_slice(&grid.origin[axis].to_le_bytes());
            bytes[12 + axis] = grid.exponents[axis];
        }
        let firsts = |wanted: fn(Child) -> Option<u32>| {
            children.iter().flatten().filter_map(|child| wanted(child.1)).min().unwrap_or(0)
        };
        let first_node = firsts(|child| match child {
            Child::Inner(node) => Some(node),
            Child::Leaf { .. } => None,
        });
        let first_slot = firsts(|child| match child {
            Child::Inner(_) => None,
            Child::Leaf { first, .. } => Some(first),
        });
        bytes[16..20].copy_from_slice(&first_node.to_le_bytes());
        bytes[20..24].copy_from_slice(&first_slot.to_le_bytes());
        for (slot, child) in children.iter().enumerate() {
            // What is not there has an inverted box, which no ray from outside meets.
            let ([min, max], meta) = match child {
                None => ([[255; 3], [0; 3]], 0),
                Some((bounds, Child::Inner(_))) => {
                    bytes[15] |= 1 << slot;
                    (grid.quantise(bounds), 0b0010_0000 | (24 + slot as u8))
                }
                Some((bounds, Child::Leaf { first, count })) => {
                    let unary = (1u8 << count) - 1;
                    (grid.quantise(bounds), unary << 5 | (first - first_slot) as u8)
                }
            };
            bytes[24 + slot] = meta;
            for axis in 0..3 {
                bytes[32 + 8 * axis + slot] = min[axis];
                bytes[56 + 8 * axis + slot] = max[axis];
            }
        }
        let word = |i: usize| u32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
        Self(std::array::from_fn(|row| std::array::from_fn(|column| word(16 * row + 4 * column))))
    }

    /// Its children with their boxes, by slot.
    pub fn children(&self) -> [Option<(Bounds, Child)>; 8] {
        let byte = |at: usize| (self.0[at / 16][at / 4 % 4] >> (8 * (at % 4))) as u8;
        let grid = Grid {
            origin: Vec3::from_array(std::array::from_fn(|axis| f32::from_bits(self.0[0][axis]))),
            exponents: std::array::from_fn(|axis| byte(12 + axis)),
        };
        let mut n_inner = 0;
        std::array::from_fn(|slot| {
            let meta = byte(24 + slot);
            let corner = |at: usize| std::array::from_fn(|axis| byte(at + 8 * axis + slot));
            let bounds = || Bounds { min: grid.place(corner(32)), max: grid.place(corner(56)) };
            if byte(15) >> slot & 1 != 0 {
                n_inner += 1;
                return Some((bounds(), Child::Inner(self.0[1][0] + n_inner - 1)));
            }
            let first = self.0[1][1] + u32::from(meta & 0x1f);
            (meta != 0).then(|| (bounds(), Child::Leaf { first, count: (meta >> 5).count_ones() }))
        })
    }
}

/// Where a node's boxes lie: steps that are powers of two from an origin.
struct Grid {
    origin: Vec3,
    exponents: [u8; 3],
}

impl Grid {
    /// The finest that holds `bounds` with some slack. Boxes that f32 cannot address so finely, since
    /// they are far from the world's origin, get coarser steps.
    fn around(bounds: &Bounds) -> Self {
        let mut grid = Self { origin: Vec3::ZERO, exponents: [*EXPONENTS.start() as u8; 3] };
        if bounds.is_empty() {
            return grid;
        }
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        for axis in 0..3 {
            let extent = (max[axis] - min[axis]).max(f64::from(f32::MIN_POSITIVE));
            let mut exponent = ((extent / LAST).log2().floor() as i32 + 127).clamp(*EXPONENTS.start(), 253);
            loop {
                let step = step(exponent as u8);
                let origin = below(min[axis] - 2.0 * SLACK * step);
                if (max[axis] - f64::from(origin)) / step + 2.0 * SLACK <= LAST || exponent == 254 {
                    grid.origin[axis] = origin;
                    grid.exponents[axis] = exponent as u8;
                    break;
                }
                exponent += 1;
            }
        }
        grid
    }

    fn quantise(&self, bounds: &Bounds) -> [[u8; 3]; 2] {
        let places = |corner: Vec3| -> DVec3 {
            let steps = DVec3::from_array(self.exponents.map(step));
            (corner.as_dvec3() - self.origin.as_dvec3()) / steps
        };
        let byte = |place: f64| place.clamp(0.0, LAST) as u8;
        let min = places(bounds.min).to_array().map(|place| byte((place - SLACK).floor()));
        let max = places(bounds.max).to_array().map(|place| byte((place + SLACK).ceil()));
        [min, max]
    }

    fn place(&self, bytes: [u8; 3]) -> Vec3 {
        let place = |axis: usize| {
            (f64::from(self.origin[axis]) + f64::from(bytes[axis]) * step(self.exponents[axis])) as f32
        };
        Vec3::new(place(0), place(1), place(2))
    }
}

/// 2^(exponent - 127).
fn step(exponent: u8) -> f64 {
    f64::from(i32::from(exponent) - 127).exp2()
}

/// The greatest finite f32 that is not above, where there is one.
fn below(x: f64) -> f32 {
    let nearest = x as f32;
    let below = if f64::from(nearest) > x { nearest.next_down() } else { nearest };
    below.max(f32::MIN)
}
