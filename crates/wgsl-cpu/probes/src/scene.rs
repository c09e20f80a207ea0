//! Random triangles, a BVH2 over them and random rays, in the layout of `traverse.wgsl`.

/// What `traverse.wgsl` reads.
pub struct TraversalScene {
    /// Four vec4s a node.
    pub nodes: Vec<[f32; 4]>,
    /// A vertex and two edges a triangle.
    pub triangles: Vec<[f32; 4]>,
    /// An origin and a direction a ray.
    pub rays: Vec<[f32; 4]>,
}

/// The bit that marks a leaf.
pub const LEAF: u32 = 1 << 31;

type Point = [f32; 3];

/// A small generator (PCG), so that every run sees the same scene.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (word.rotate_right((self.0 >> 59) as u32) >> 8) as f32 / (1 << 24) as f32
    }

    /// In `[-scale, scale]` along each axis.
    fn point(&mut self, scale: f32) -> Point {
        [(); 3].map(|()| scale * (2.0 * self.unit() - 1.0))
    }
}

impl TraversalScene {
    /// Triangles and rays in the cube `[-1, 1]`, triangles as small as that about one in ten
    /// thousand pairs overlaps.
    pub fn random(n_triangles: usize, n_rays: usize) -> Self {
        let mut random = Random(42);
        let size = 0.7 / (n_triangles as f32).cbrt();
        let triangles: Vec<[Point; 3]> = (0..n_triangles.max(2))
            .map(|_| [random.point(1.0), random.point(size), random.point(size)])
            .collect();
        let rays = (0..n_rays).flat_map(|_| [random.point(1.0), random.point(1.0)]).map(padded).collect();
        let mut nodes = Vec::new();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        build(&triangles, &mut order, &mut nodes);
        Self { nodes, triangles: triangles.into_iter().flatten().map(padded).collect(), rays }
    }
}

fn padded([x, y, z]: Point) -> [f32; 4] {
    [x, y, z, 0.0]
}

/// Adds the subtree over the triangles in `order` and returns its reference and bounds.
fn build(triangles: &[[Point; 3]], order: &mut [u32], nodes: &mut Vec<[f32; 4]>) -> (u32, [Point; 2]) {
    let bounds = bounds(triangles, order);
    if let [triangle] = *order {
        return (LEAF | triangle, bounds);
    }
    let [low, high] = bounds;
    let extent = |axis: usize| high[axis] - low[axis];
    let axis = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| {
        triangles[a as usize][0][axis].total_cmp(&triangles[b as usize][0][axis])
    });
    let node = nodes.len() / 4;
    nodes.extend([[0.0; 4]; 4]);
    let (before, after) = order.split_at_mut(middle);
    let (left, [l0, l1]) = build(triangles, before, nodes);
    let (right, [r0, r1]) = build(triangles, after, nodes);
    nodes[4 * node] = [l0[0], l0[1], l0[2], l1[0]];
    nodes[4 * node + 1] = [l1[1], l1[2], r0[0], r0[1]];
    nodes[4 * node + 2] = [r0[2], r1[0], r1[1], r1[2]];
    nodes[4 * node + 3] = [f32::from_bits(left), f32::from_bits(right), 0.0, 0.0];
    (node as u32, bounds)
}

/// The low and the high corner.
fn bounds(triangles: &[[Point; 3]], order: &[u32]) -> [Point; 2] {
    let mut bounds = [[f32::MAX; 3], [f32::MIN; 3]];
    for &triangle in order {
        let [v0, e1, e2] = triangles[triangle as usize];
        for axis in 0..3 {
            for value in [v0[axis], v0[axis] + e1[axis], v0[axis] + e2[axis]] {
                bounds[0][axis] = bounds[0][axis].min(value);
                bounds[1][axis] = bounds[1][axis].max(value);
            }
        }
    }
    bounds
}
