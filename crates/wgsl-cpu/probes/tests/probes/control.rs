//! Statements, pointers and atomics, against the same written in Rust.

use std::cell::Cell;

use wgsl_cpu::runtime::Vec3;
use wgsl_cpu_probes::{
    ATOMICS, CONTROL, TRAVERSE, by_hand, cases, library, scene::TraversalScene, words::Words,
};

use crate::assert_rows;

const PRIMES: [u32; 5] = [2, 3, 5, 7, 11];

#[test]
fn statements_do_what_they_say() {
    let case = cases::of(&CONTROL);
    let inputs: Vec<(usize, u32)> = case.buffers[0].iter().copied().enumerate().collect();
    let groups = case.groups;
    assert_rows(&case.run_native(), &inputs, |&(id, n)| {
        [
            collatz(n),
            skip(n),
            continuing(n),
            pointers(n),
            choose(n) as u32,
            drawn(),
            u32::from(guarded(n % 9)) + 2 * PRIMES[n as usize % 5],
            id as u32 % 64 + 64 * (id as u32 / 64) + 1000 * groups,
        ]
    });
}

fn collatz(start: u32) -> u32 {
    let next = |n: &u32| (*n != 1).then_some(if n.is_multiple_of(2) { n / 2 } else { 3 * n + 1 });
    std::iter::successors(Some(start % 1000 + 1), next).count().min(201) as u32 - 1
}

fn skip(n: u32) -> u32 {
    let mut sum = 0;
    for i in (0..n % 50).filter(|i| i % 3 != 0 && !matches!(i % 7, 1 | 2)) {
        let digit = |at: u32| if i % 4 == at { i } else { 0 };
        match i % 7 {
            3 if i > 20 => {}
            3 => sum += 100,
            5 => sum ^= i,
            _ => sum += digit(0) + digit(1),
        }
        if sum > 5000 {
            break;
        }
        sum += digit(2) + digit(3);
    }
    sum
}

fn continuing(n: u32) -> u32 {
    // The body's `i` is one less than that of the condition.
    (0..=n % 20).map(|i| if (i + 1) % 3 == 1 { 2 * i } else { 4 * i + 1 }).sum()
}

fn pointers(n: u32) -> u32 {
    let at = n as usize % 3;
    let mut second = [1u32, 2, 3];
    let before = second[at];
    second[at] += 10;
    // `seen += bump(&seen, x)`: what `seen` was before the call is read first.
    let seen = before + before;
    second.rotate_right(1);
    let rest = 7 * second[at] + 1 + second[0];
    n.wrapping_mul(31).wrapping_add(seen + rest)
}

fn choose(n: u32) -> i32 {
    match n % 6 {
        0 => 5,
        1 | 2 => -7,
        5 if n > 100 => 1,
        5 => 2,
        _ => 0,
    }
}

fn drawn() -> u32 {
    let state = Cell::new(17u32);
    let next = || {
        state.set(state.get().wrapping_mul(1664525).wrapping_add(1013904223));
        state.get() >> 8
    };
    let first = next() ^ next();
    first.wrapping_add(next().wrapping_mul(3))
}

fn guarded(n: u32) -> bool {
    n < 5 && (PRIMES[n as usize] == 5 || n.is_multiple_of(2))
}

#[test]
fn libraries_are_called_as_functions() {
    assert_eq!(library::scaled(Vec3::new(1.0, 2.0, 3.0), 2.0), Vec3::new(2.0, 4.0, 6.0));
    let mut value = 5;
    assert_eq!(library::bump(&mut value, 3), 5);
    assert_eq!(value, 8);
    assert_eq!(library::GOLDEN, 1.618_034);
}

#[test]
fn pointers_lead_into_variables() {
    for n in 0..9u32 {
        let at = n as usize % 3;
        let mut second = [1u32, 2, 3];
        let was = second[at];
        second[at] += 10;
        let first = n + second[at];
        second.rotate_right(1);
        assert_eq!(library::into_parts(n), was + n + 7 * second[at] + 31 * first);
    }
    let mut private = library::Private::new();
    assert_eq!(library::count_into_part(&mut private, 1), 4);
    assert_eq!(library::count_into_part(&mut private, 1), 9);
    assert_eq!(private.drawn, [0, 9]);
}

#[test]
fn atomics_add_up() {
    let case = cases::of(&ATOMICS);
    let inputs = &case.buffers[0];
    let mut buffers: Vec<Words> = case.buffers.iter().map(|words| Words::new(words)).collect();
    std::thread::scope(|scope| {
        // Every invocation of each dispatch runs; both dispatches share the buffers.
        for _ in 0..2 {
            let storages: Vec<_> = buffers.iter().map(Words::storage).collect();
            let invocations =
                wgsl_cpu::Invocations { first: 0, count: case.groups, grid: [case.groups, 1, 1] };
            // SAFETY: what both threads write is atomic.
            scope.spawn(move || unsafe { (ATOMICS.native)(&storages, invocations) });
        }
    });
    let sums = buffers[1].to_vec();
    let total = inputs.iter().fold(0u32, |sum, &n| sum.wrapping_add(n)).wrapping_mul(2);
    assert_eq!(sums[0], total);
    assert_eq!(sums[1], total.wrapping_neg());
    assert_eq!(sums[2] as i32, inputs.iter().map(|&n| n as i32).min().unwrap_or(0).min(0));
    assert_eq!(sums[3] as i32, inputs.iter().map(|&n| n as i32).max().unwrap_or(0).max(0));
    assert_eq!(Some(&sums[4]), inputs.iter().min());
    assert_eq!(Some(&sums[5]), inputs.iter().max());
    assert_eq!(sums[6], inputs.iter().fold(u32::MAX, |all, n| all & (n | 0xff)));
    assert_eq!(sums[7], inputs.iter().fold(0, |some, n| some | n & 0xff00));
    assert_eq!(sums[8], 0, "what is toggled twice");
    assert_eq!(sums[10], 3 * 2 * inputs.len() as u32);
    let bins = buffers[2].to_vec();
    assert_eq!(bins.iter().sum::<u32>(), 2 * inputs.len() as u32);
    assert_eq!(sums[11] as usize, bins.iter().filter(|&&bin| bin > 0).count());
}

#[test]
fn exchanges_return_what_was_there() {
    let sums = cases::of(&ATOMICS).run_native();
    assert_eq!(sums[9], 6 + 10 * 5 + 100 * 6);
}

#[test]
fn traversal_finds_what_the_hand_written_loop_finds() {
    let case = cases::of(&TRAVERSE);
    let scene = TraversalScene::random(2000, 512);
    let hits = case.run_native();
    let mut n_hits = 0;
    for (ray, hit) in scene.rays.chunks_exact(2).zip(hits.chunks_exact(4)) {
        let expected = by_hand::closest(&scene.nodes, &scene.triangles, ray[0], ray[1]);
        assert_eq!(hit[3], expected[3].to_bits(), "the triangle");
        assert!((f32::from_bits(hit[0]) - expected[0]).abs() <= 1e-5 * expected[0].abs(), "the distance");
        n_hits += usize::from(hit[3] != u32::MAX);
    }
    assert!((50..510).contains(&n_hits), "{n_hits} hits");
}
