//! One test body, every device: buffers, dispatches, order, atomics, errors.

use midway_device::{BufferUsage, Command, Device, DeviceError};

use crate::common::{self, ADD_ALL, STEP, WRITE_ARGS, WRITE_INDEX, buffer_of, dispatch, words, zeros};

/// Makes a test of each body on each device.
macro_rules! on_every_device {
    ($($body:ident)*) => {
        mod on_cpu {$(
            #[test]
            fn $body() {
                super::$body(&*crate::common::cpu());
            }
        )*}
        mod on_gpu {$(
            #[test]
            fn $body() {
                if let Some(gpu) = crate::common::gpu() {
                    super::$body(&*gpu);
                }
            }
        )*}
    };
}

on_every_device! {
    buffers_start_zeroed_and_keep_what_is_written
    ranges_outside_a_buffer_are_refused
    buffers_too_large_are_refused
    buffers_of_no_words_are_refused
    clears_and_copies_move_words
    writes_keep_their_place_in_a_list
    a_copy_within_a_buffer_is_refused
    a_grid_of_three_dimensions_covers_each_index_once
    an_empty_grid_runs_nothing
    a_grid_too_large_is_refused
    atomics_sum_exactly
    an_indirect_grid_is_what_an_earlier_kernel_wrote
    indirect_args_are_checked
    commands_see_what_earlier_ones_wrote
    many_commands_run_in_order
    lanes_run_lists_of_their_own
    many_threads_read_at_once
    bindings_are_checked
    other_devices_resources_are_refused
    timed_runs_name_their_dispatches
    info_is_consistent
}

fn buffers_start_zeroed_and_keep_what_is_written(device: &dyn Device) {
    // Larger than any one transfer's staging memory, and no multiple of it.
    let n = (65 << 20) / 4 + 3;
    let buffer = zeros(device, "large", n);
    assert!(words(device, &buffer).iter().all(|&word| word == 0));
    let values: Vec<u32> = (0..n as u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect();
    device.write_buffer(&buffer, 0, bytemuck::cast_slice(&values)).expect("written");
    assert!(words(device, &buffer) == values);
    device.write_buffer(&buffer, 8, &[1, 0, 0, 0, 2, 0, 0, 0]).expect("written");
    let read = device.read_buffer(&buffer, 4, 16).expect("read");
    assert_eq!(bytemuck::pod_collect_to_vec::<u8, u32>(&read), [values[1], 1, 2, values[4]]);
    assert_eq!(device.read_buffer(&buffer, 4, 0).expect("nothing is read"), []);
    device.write_buffer(&buffer, 4, &[]).expect("nothing is written");
}

fn ranges_outside_a_buffer_are_refused(device: &dyn Device) {
    let buffer = zeros(device, "small", 4);
    for (offset, bytes) in [(0, 20), (16, 4), (20, 0), (u64::MAX - 3, 8), (2, 4), (0, 3)] {
        let error = device.read_buffer(&buffer, offset, bytes).expect_err("outside");
        let expected = DeviceError::Range { label: "small".into(), offset, bytes, size: 16 };
        assert_eq!(error, expected);
    }
    let error = device.write_buffer(&buffer, 12, &[0; 8]).expect_err("outside");
    assert!(matches!(error, DeviceError::Range { offset: 12, bytes: 8, size: 16, .. }), "{error}");
}

fn buffers_too_large_are_refused(device: &dyn Device) {
    let info = device.info();
    for bytes in [info.max_binding_bytes + 4, 1 << 62] {
        let error = device.create_buffer("huge", bytes, BufferUsage::Storage).expect_err("too large");
        let (device, limit) = (info.name.clone(), info.max_binding_bytes);
        assert_eq!(error, DeviceError::BufferTooLarge { device, label: "huge".into(), bytes, limit });
    }
}

fn buffers_of_no_words_are_refused(device: &dyn Device) {
    for bytes in [0, 3, 6] {
        let error = device.create_buffer("odd", bytes, BufferUsage::Storage).expect_err("odd");
        assert_eq!(error, DeviceError::BufferSize { label: "odd".into(), bytes });
    }
}

fn clears_and_copies_move_words(device: &dyn Device) {
    let from = buffer_of(device, "from", BufferUsage::Storage, &[1u32, 2, 3, 4, 5]);
    let to = buffer_of(device, "to", BufferUsage::Storage, &[9u32; 5]);
    let copy = Command::Copy { from: from.clone(), from_offset: 4, to: to.clone(), to_offset: 8, bytes: 12 };
    device.run(&[copy, Command::Clear(from.clone())], false).expect("runs");
    assert_eq!(words(device, &to), [9, 9, 2, 3, 4]);
    assert_eq!(words(device, &from), [0; 5]);
}

/// More of them than a GPU takes in one submission, each read by the copy after it and by none before.
fn writes_keep_their_place_in_a_list(device: &dyn Device) {
    const N: u32 = 300;
    let from = zeros(device, "from", 2);
    let to = zeros(device, "to", u64::from(N));
    let write = |word: u32| Command::Write {
        to: from.clone(),
        offset: 4,
        data: word.to_ne_bytes().as_slice().into(),
    };
    let copy = |at: u32| Command::Copy {
        from: from.clone(),
        from_offset: 4,
        to: to.clone(),
        to_offset: u64::from(at) * 4,
        bytes: 4,
    };
    let written = (0..N / 3).flat_map(|i| [write(i), copy(i)]);
    let unchanged = (N / 3..N).map(copy);
    let commands: Vec<Command> = written.chain(unchanged).chain([write(7)]).collect();
    let expected: Vec<u32> = (0..N).map(|i| i.min(N / 3 - 1)).collect();
    for timed in [false, true] {
        let bytes = u64::from(N) * 4;
        let (timing, read) = device.run_and_read(&commands, timed, &to, (0, bytes)).expect("runs");
        assert_eq!(bytemuck::pod_collect_to_vec::<_, u32>(&read), expected);
        assert!(timing.longest_part <= timing.wall, "{timing:?}");
        assert_eq!(words(device, &from), [0, 7]);
    }
    let outside = Command::Write { to: from, offset: 4, data: [0; 8].into() };
    let error = device.run(&[outside], false).expect_err("outside");
    assert!(matches!(error, DeviceError::Range { offset: 4, bytes: 8, size: 8, .. }), "{error}");
}

fn a_copy_within_a_buffer_is_refused(device: &dyn Device) {
    let buffer = zeros(device, "both", 8);
    let copy =
        Command::Copy { from: buffer.clone(), from_offset: 0, to: buffer.clone(), to_offset: 16, bytes: 16 };
    let error = device.run(&[copy], false).expect_err("one buffer");
    assert_eq!(error, DeviceError::CopyWithin { label: "both".into() });
    let other = zeros(device, "other", 4);
    let copy = Command::Copy { from: buffer, from_offset: 0, to: other.clone(), to_offset: 4, bytes: 16 };
    // Nothing runs of a list with one bad command.
    let fill = dispatch(device, &STEP, &[&other], [1, 1, 1]);
    let error = device.run(&[fill, copy], false).expect_err("outside");
    assert!(matches!(error, DeviceError::Range { offset: 4, bytes: 16, size: 16, .. }), "{error}");
    assert_eq!(words(device, &other), [0; 4]);
}

fn a_grid_of_three_dimensions_covers_each_index_once(device: &dyn Device) {
    let params = buffer_of(device, "params", BufferUsage::Uniform, &[100u32, 0, 0, 0]);
    for groups in [[1, 1, 1], [7, 1, 1], [5, 6, 1], [3, 4, 5], [700, 3, 1]] {
        let n = groups.iter().map(|&axis| u64::from(axis)).product::<u64>() * 64 - 1;
        let out = zeros(device, "out", n);
        let command = dispatch(device, &WRITE_INDEX, &[&params, &out], groups);
        device.run(&[command], false).expect("runs");
        let expected: Vec<u32> = (0..n as u32).map(|i| 100 + i).collect();
        assert!(words(device, &out) == expected, "{groups:?}");
    }
}

fn an_empty_grid_runs_nothing(device: &dyn Device) {
    let sum = zeros(device, "sum", 1);
    for groups in [[0, 1, 1], [1, 0, 1], [65535, 65535, 0]] {
        let command = dispatch(device, &ADD_ALL, &[&sum], groups);
        device.run(&[command], false).expect("runs");
    }
    device.run(&[], true).expect("nothing to run");
    assert_eq!(words(device, &sum), [0]);
}

fn a_grid_too_large_is_refused(device: &dyn Device) {
    let sum = zeros(device, "sum", 1);
    for groups in [[65536, 1, 1], [1, 1, u32::MAX], [65535, 65535, 2]] {
        let command = dispatch(device, &ADD_ALL, &[&sum], groups);
        let error = device.run(&[command], false).expect_err("too large");
        assert_eq!(error, DeviceError::DispatchTooLarge { kernel: "add_all", groups });
    }
}

fn atomics_sum_exactly(device: &dyn Device) {
    let sum = zeros(device, "sum", 1);
    let groups = 1000u32;
    let command = dispatch(device, &ADD_ALL, &[&sum], [groups, 1, 1]);
    device.run(&[command.clone(), command], false).expect("runs");
    let n = groups * common::WORKGROUP;
    // Twice the sum of 1..=n, modulo the word as all of WGSL's arithmetic.
    assert_eq!(words(device, &sum), [n.wrapping_mul(n + 1)]);
}

fn an_indirect_grid_is_what_an_earlier_kernel_wrote(device: &dyn Device) {
    let count = buffer_of(device, "count", BufferUsage::Storage, &[0u32]);
    let args = buffer_of(device, "args", BufferUsage::Indirect, &[77u32, 0, 0, 0]);
    let sum = zeros(device, "sum", 1);
    let Command::Dispatch { bound, .. } = dispatch(device, &ADD_ALL, &[&sum], [1, 1, 1]) else {
        unreachable!("a dispatch was asked for");
    };
    let indirect = Command::DispatchIndirect { bound, args: args.clone(), offset: 4 };
    let commands = [
        // `count` becomes 1, then 4.
        dispatch(device, &STEP, &[&count], [1, 1, 1]),
        dispatch(device, &STEP, &[&count], [1, 1, 1]),
        dispatch(device, &WRITE_ARGS, &[&count, &args], [1, 1, 1]),
        indirect,
    ];
    for timed in [false, true] {
        device.run(&[Command::Clear(count.clone()), Command::Clear(sum.clone())], timed).expect("runs");
        device.run(&commands, timed).expect("runs");
        assert_eq!(words(device, &args), [77, 4, 1, 1]);
        assert_eq!(words(device, &sum), [256 * 257 / 2]);
    }
}

fn indirect_args_are_checked(device: &dyn Device) {
    let args = buffer_of(device, "args", BufferUsage::Indirect, &[1u32, 1, 1, 1]);
    let plain = buffer_of(device, "plain", BufferUsage::Storage, &[1u32, 1, 1, 1]);
    let pipeline = device.load_kernel(&ADD_ALL).expect("loaded");
    let refused = |sum, args, offset| {
        let bound = device.bind(&pipeline, &[sum]).expect("bound");
        device.run(&[Command::DispatchIndirect { bound, args, offset }], false).expect_err("refused")
    };
    let error = refused(&plain, plain.clone(), 0);
    assert!(matches!(&error, DeviceError::IndirectArgs { label, .. } if label == "plain"), "{error}");
    let error = refused(&args, args.clone(), 0);
    assert!(matches!(&error, DeviceError::IndirectArgs { label, .. } if label == "args"), "{error}");
    for offset in [8, 2] {
        let error = refused(&plain, args.clone(), offset);
        assert!(matches!(&error, DeviceError::Range { bytes: 12, size: 16, .. }), "{error}");
    }
}

fn commands_see_what_earlier_ones_wrote(device: &dyn Device) {
    let n = 10_000;
    let (data, copy) = (zeros(device, "data", n), zeros(device, "copy", n));
    let step = |buffer| dispatch(device, &STEP, &[buffer], [(n as u32).div_ceil(64), 1, 1]);
    let copied =
        Command::Copy { from: data.clone(), from_offset: 0, to: copy.clone(), to_offset: 0, bytes: n * 4 };
    let commands = [
        step(&data),
        step(&data),
        copied,
        step(&data),
        step(&copy),
        Command::Clear(data.clone()),
        step(&data),
    ];
    device.run(&commands, false).expect("runs");
    assert_eq!(words(device, &data), vec![1; n as usize]);
    assert_eq!(words(device, &copy), vec![13; n as usize]);
}

fn many_commands_run_in_order(device: &dyn Device) {
    // More than one submission takes.
    let n = 2500;
    let data = zeros(device, "data", 3);
    let command = dispatch(device, &STEP, &[&data], [1, 1, 1]);
    let commands = vec![command; n];
    let expected = (0..n).fold(0u32, |word, _| word.wrapping_mul(3).wrapping_add(1));
    for timed in [false, true] {
        device.run(&[Command::Clear(data.clone())], false).expect("runs");
        let timing = device.run(&commands, timed).expect("runs");
        assert_eq!(words(device, &data), [expected; 3]);
        assert!(timing.dispatches.len() == n || !timed || timing.dispatches.is_empty());
    }
}

fn lanes_run_lists_of_their_own(device: &dyn Device) {
    let n = device.lanes();
    let lanes: Vec<_> = (0..n).map(|_| zeros(device, "data", 3)).collect();
    let sum = zeros(device, "sum", 1);
    let ran = std::sync::atomic::AtomicUsize::new(0);
    // SAFETY: each lane has a buffer of its own; the sum they share is atomic.
    unsafe {
        device.for_each_lane(&|lane| {
            ran.fetch_add(1 << (8 * lane), std::sync::atomic::Ordering::Relaxed);
            let commands = vec![dispatch(device, &STEP, &[&lanes[lane]], [1, 1, 1]); lane + 1];
            device.run(&commands, false).expect("runs");
            device.run(&[dispatch(device, &ADD_ALL, &[&sum], [4, 1, 1])], false).expect("runs");
            assert_eq!(words(device, &lanes[lane])[0], (0..=lane).fold(0, |word, _| word * 3 + 1));
        });
    }
    assert_eq!(ran.into_inner(), (0..n).map(|lane| 1 << (8 * lane)).sum::<usize>());
    assert_eq!(words(device, &sum), [n as u32 * (256 * 257 / 2)]);
}

fn many_threads_read_at_once(device: &dyn Device) {
    let buffers: Vec<_> =
        (0..8).map(|value| buffer_of(device, "data", BufferUsage::Storage, &[value; 16])).collect();
    std::thread::scope(|threads| {
        for (value, buffer) in (0..).zip(&buffers) {
            threads.spawn(move || {
                for _ in 0..2000 {
                    device.run(&[Command::Clear(zeros(device, "other", 1))], false).expect("run");
                    assert_eq!(words(device, buffer), [value; 16]);
                }
            });
        }
    });
}

fn bindings_are_checked(device: &dyn Device) {
    let params = buffer_of(device, "params", BufferUsage::Uniform, &[0u32; 4]);
    let short = buffer_of(device, "short", BufferUsage::Uniform, &[0u32; 3]);
    let out = zeros(device, "out", 64);
    let pipeline = device.load_kernel(&WRITE_INDEX).expect("loaded");
    let error = device.bind(&pipeline, &[&params]).expect_err("too few");
    assert_eq!(error, DeviceError::BindingCount { kernel: "write_index", expected: 2, given: 1 });
    for (buffers, wrong) in
        [([&short, &out], "params"), ([&out, &out], "params"), ([&params, &params], "out")]
    {
        let error = device.bind(&pipeline, &buffers).expect_err("does not fit");
        assert!(
            matches!(error, DeviceError::BindingMismatch { kernel: "write_index", binding, .. } if binding == wrong),
            "{error}"
        );
    }
    let pipeline = device.load_kernel(&WRITE_ARGS).expect("loaded");
    let error = device.bind(&pipeline, &[&out, &out]).expect_err("written under two names");
    assert!(error.to_string().contains("also bound as `count`"), "{error}");
}

fn other_devices_resources_are_refused(device: &dyn Device) {
    let other = common::cpu();
    let theirs = zeros(&*other, "theirs", 4);
    let ours = zeros(device, "ours", 4);
    let pipeline = device.load_kernel(&STEP).expect("loaded");
    let their_pipeline = other.load_kernel(&STEP).expect("loaded");
    let their_command = dispatch(&*other, &STEP, &[&theirs], [1, 1, 1]);
    let copy =
        Command::Copy { from: ours.clone(), from_offset: 0, to: theirs.clone(), to_offset: 0, bytes: 4 };
    let errors = [
        device.read_buffer(&theirs, 0, 4).expect_err("read"),
        device.write_buffer(&theirs, 0, &[0; 4]).expect_err("written"),
        device.bind(&pipeline, &[&theirs]).expect_err("bound"),
        device.bind(&their_pipeline, &[&ours]).expect_err("bound"),
        device.run(&[their_command], false).expect_err("run"),
        device.run(&[Command::Clear(theirs)], false).expect_err("cleared"),
        device.run(&[copy], false).expect_err("copied"),
    ];
    for error in errors {
        assert!(matches!(error, DeviceError::Foreign { .. }), "{error}");
    }
}

fn timed_runs_name_their_dispatches(device: &dyn Device) {
    let sum = zeros(device, "sum", 1);
    let data = zeros(device, "data", 64);
    let commands = [
        dispatch(device, &STEP, &[&data], [1, 1, 1]),
        Command::Clear(sum.clone()),
        dispatch(device, &ADD_ALL, &[&sum], [2000, 1, 1]),
    ];
    let untimed = device.run(&commands, false).expect("runs");
    assert!(untimed.dispatches.is_empty() && untimed.longest_dispatch().is_none());
    let timing = device.run(&commands, true).expect("runs");
    let names: Vec<&str> = timing.dispatches.iter().map(|&(name, _)| name).collect();
    if names.is_empty() {
        println!("{} measures no dispatches", device.info().name);
        return;
    }
    assert_eq!(names, ["step_words", "add_all"]);
    let (name, longest) = timing.longest_dispatch().expect("measured");
    assert_eq!(name, "add_all");
    assert!(!longest.is_zero() && longest <= timing.wall, "{timing:?}");
}

fn info_is_consistent(device: &dyn Device) {
    let info = device.info();
    println!("{info:?}");
    assert!(!info.name.is_empty() && !info.backend.is_empty());
    assert!(info.max_binding_bytes <= info.max_buffer_bytes);
    assert!(info.max_binding_bytes >= 128 << 20 && info.max_storage_buffers >= 8);
    assert!(info.memory_bytes.is_none_or(|bytes| bytes >= info.max_binding_bytes.min(1 << 30)));
}
