//! How fast translated kernels are: rays a second through `traverse.wgsl`, translated, and through
//! the same loop written in Rust by hand, on one thread, in interleaved pairs.
//!
//! ```text
//! cargo run --release -p wgsl-cpu-probes --example traversal_probe
//! ```

use std::{hint::black_box, time::Instant};

use wgsl_cpu_probes::{
    TRAVERSE,
    by_hand::closest,
    scene::TraversalScene,
    words::{Words, run_native},
};

const N_TRIANGLES: usize = 30_000;
const N_RAYS: usize = 1 << 16;
const N_PAIRS: usize = 15;

fn main() {
    let scene = TraversalScene::random(N_TRIANGLES, N_RAYS);
    let translated = Translated::new(&scene);
    let mut pairs: Vec<(f64, f64)> = (0..N_PAIRS)
        .map(|_| (seconds(|| translated.run()), seconds(|| drop(black_box(by_hand(&scene))))))
        .collect();
    let ratio = |(translated, by_hand): &(f64, f64)| by_hand / translated;
    pairs.sort_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let (translated_s, by_hand_s) = pairs[N_PAIRS / 2];
    let mrays = |seconds: f64| N_RAYS as f64 * 1e-6 / seconds;
    println!("translated {:.3} Mrays/s, by hand {:.3} Mrays/s", mrays(translated_s), mrays(by_hand_s));
    println!(
        "ratio {:.3} (median of {N_PAIRS} pairs; {:.3} to {:.3})",
        ratio(&pairs[N_PAIRS / 2]),
        ratio(&pairs[0]),
        ratio(&pairs[N_PAIRS - 1])
    );
}

fn seconds(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

fn by_hand(scene: &TraversalScene) -> Vec<[f32; 4]> {
    scene.rays.chunks_exact(2).map(|ray| closest(&scene.nodes, &scene.triangles, ray[0], ray[1])).collect()
}

/// The buffers of the translated kernel.
struct Translated([Words; 5]);

impl Translated {
    fn new(scene: &TraversalScene) -> Self {
        Self([
            Words::new(&[N_RAYS as u32]),
            Words::of_f32(scene.nodes.as_flattened()),
            Words::of_f32(scene.triangles.as_flattened()),
            Words::of_f32(scene.rays.as_flattened()),
            Words::new(&vec![0; 4 * N_RAYS]),
        ])
    }

    fn run(&self) {
        run_native(&TRAVERSE, &self.0.each_ref(), (N_RAYS as u32).div_ceil(TRAVERSE.workgroup_size));
    }
}
