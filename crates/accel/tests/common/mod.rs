//! Inputs, degenerate ones among them, and rays.

use glam::Vec3;

pub type Triangles = Vec<[Vec3; 3]>;

/// A small generator, so that the inputs are the same everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn point(&mut self, scale: f32) -> Vec3 {
        (Vec3::new(self.unit(), self.unit(), self.unit()) - 0.5) * scale
    }
}

pub fn soup(n: usize, size: f32, scale: f32, seed: u64) -> Triangles {
    let mut random = Random(seed);
    (0..n)
        .map(|_| {
            let centre = random.point(scale);
            [(); 3].map(|()| centre + random.point(size))
        })
        .collect()
}

/// Slivers across the whole scene among small triangles: what splitting is for.
pub fn slivers() -> Triangles {
    let mut all = soup(400, 0.02, 1.0, 5);
    let mut random = Random(9);
    all.extend((0..50).map(|_| {
        let (a, b) = (random.point(2.0), random.point(2.0));
        [a, b, b + random.point(1e-3)]
    }));
    all
}

pub fn inputs() -> Vec<(&'static str, Triangles)> {
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let grid = (0..900).map(|i| {
        let o = Vec3::new((i % 30) as f32, (i / 30) as f32, 0.0);
        [o, o + Vec3::X, o + Vec3::Y]
    });
    let concentric = (0..2000).map(|i| one.map(|v| (v - 1.0 / 3.0) * (1.0 + i as f32)));
    vec![
        ("none", vec![]),
        ("one", vec![one]),
        ("two", vec![one, one.map(|v| v + Vec3::Z)]),
        ("soup", soup(3000, 0.1, 1.0, 1)),
        ("slivers", slivers()),
        ("grid", grid.collect()),
        ("concentric", concentric.collect()),
        ("coincident", vec![one; 10_000]),
        ("points", vec![[Vec3::splat(3.0); 3]; 100]),
        ("zero area", (0..100).map(|i| [Vec3::X * i as f32, Vec3::ZERO, Vec3::X * 2.0]).collect()),
        ("huge", soup(500, 1e37, 3e38, 2)),
        ("largest", vec![[Vec3::splat(f32::MAX), Vec3::splat(f32::MIN), Vec3::ZERO]; 3]),
        ("tiny", soup(500, 1e-39, 1e-38, 3)),
        ("far away", soup(500, 0.5, 1.0, 4).iter().map(|t| t.map(|v| v + 1e7)).collect()),
        ("small in large", [soup(500, 1e-3, 1e-2, 6), soup(3, 1e6, 1e6, 7)].concat()),
    ]
}

/// From about the scene towards a point of a triangle, edges and vertices among them; a third
/// along an axis.
#[allow(dead_code, reason = "not every test casts rays at edges")]
pub fn ray(triangles: &[[Vec3; 3]], random: &mut Random) -> (Vec3, Vec3) {
    if triangles.is_empty() {
        return (Vec3::ZERO, Vec3::Z);
    }
    let pick = (random.unit() * triangles.len() as f32) as usize;
    let [a, b, c] = triangles[pick.min(triangles.len() - 1)];
    let u = (random.unit() * 1.2 - 0.1).clamp(0.0, 1.0);
    let v = (random.unit() * 1.2 - 0.1).clamp(0.0, 1.0) * (1.0 - u);
    let target = a * (1.0 - u - v) + b * u + c * v;
    let size = (a - b).abs().max_element().max(1e-3);
    let dir = match (random.unit() * 3.0) as u32 {
        0 => [Vec3::X, Vec3::Y, Vec3::NEG_Z][(random.unit() * 3.0) as usize % 3],
        _ => random.point(2.0),
    };
    (target - dir * size * 3.0, dir * size)
}
