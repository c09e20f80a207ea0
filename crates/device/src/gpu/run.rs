//! Recording lists of commands and running them.

use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use super::{GpuDevice, SUBMIT_COMMANDS, clock::Clock};
use crate::{Command, DeviceError, RunTiming};

/// Commands that were submitted together.
pub(super) struct Part {
    pub(super) submission: wgpu::SubmissionIndex,
    pub(super) submitted: Instant,
}

/// How long parts take of which one runs after another.
#[derive(Default)]
pub(super) struct Stopwatch {
    pub(super) longest: Duration,
    end: Option<Instant>,
}

impl Stopwatch {
    /// The part that was next has ended: it began when it was submitted, or when the one before it ended.
    pub(super) fn ended(&mut self, submitted: Instant) {
        let now = Instant::now();
        let start = self.end.map_or(submitted, |end| end.max(submitted));
        self.longest = self.longest.max(now - start);
        self.end = Some(now);
    }
}

impl GpuDevice {
    /// Submits all commands, consecutive dispatches in one pass, in parts.
    pub(super) fn submit(&self, commands: &[Command]) -> Result<Vec<Part>, DeviceError> {
        let mut submitted = Vec::new();
        for part in parts(commands) {
            if self.write_all(part)? {
                continue;
            }
            let submission = self.guard("run kernels", || {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                for run in part.chunk_by(|one, next| is_dispatch(one) && is_dispatch(next)) {
                    self.record(&mut encoder, run, None)?;
                }
                Ok(self.queue.submit([encoder.finish()]))
            })??;
            submitted.push(Part { submission, submitted: Instant::now() });
        }
        self.save_cache();
        Ok(submitted)
    }

    /// Hands the bytes of a part that is writes to the queue, before whatever is submitted next; whether it
    /// is one.
    fn write_all(&self, part: &[Command]) -> Result<bool, DeviceError> {
        for command in part {
            let Command::Write { to, offset, data } = command else { return Ok(false) };
            self.guard("write a buffer", || self.enqueue(to, *offset, data))??;
        }
        Ok(true)
    }

    /// Submits the commands, each dispatch in a pass of its own between two timestamps, and waits for each part.
    pub(super) fn run_timed(&self, commands: &[Command]) -> Result<RunTiming, DeviceError> {
        let start = Instant::now();
        let clock = self.guard("measure time", || {
            self.clock.get_or_init(|| Mutex::new(Clock::new(&self.device, &self.queue)))
        })?;
        let clock = clock.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut dispatches, mut stopwatch) = (Vec::new(), Stopwatch::default());
        for commands in parts(commands) {
            if self.write_all(commands)? {
                continue;
            }
            let names: Vec<&'static str> = commands.iter().filter_map(kernel_name).collect();
            let (submission, times) = self.guard("run kernels", || {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                let mut n_dispatches = 0;
                for command in commands.chunks(1) {
                    let writes = is_dispatch(&command[0]).then(|| {
                        n_dispatches += 1;
                        clock.writes(n_dispatches - 1)
                    });
                    self.record(&mut encoder, command, writes)?;
                }
                let times = (n_dispatches > 0).then(|| clock.resolve(&mut encoder, n_dispatches));
                Ok((self.queue.submit([encoder.finish()]), times))
            })??;
            let submitted = Instant::now();
            self.save_cache();
            self.wait(submission)?;
            stopwatch.ended(submitted);
            if let Some(times) = times {
                let mut ticks = Vec::new();
                self.read(times, (0, names.len() as u64 * 16), &mut ticks)?;
                dispatches.extend(names.into_iter().zip(clock.durations(&ticks)));
            }
        }
        Ok(RunTiming { wall: start.elapsed(), longest_part: stopwatch.longest, dispatches })
    }

    /// Writes the pipeline cache, if it is due, while the device is at work.
    fn save_cache(&self) {
        if let Some(cache) = &self.cache {
            cache.save();
        }
    }

    /// Records dispatches as one pass, or one other command.
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        commands: &[Command],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) -> Result<(), DeviceError> {
        match commands {
            [Command::Clear(buffer)] => encoder.clear_buffer(self.buffer(buffer)?, 0, None),
            [Command::Copy { from, from_offset, to, to_offset, bytes }] => {
                let (from, to) = (self.buffer(from)?, self.buffer(to)?);
                encoder.copy_buffer_to_buffer(from, *from_offset, to, *to_offset, *bytes);
            }
            dispatches => {
                let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes };
                let mut pass = encoder.begin_compute_pass(&descriptor);
                for dispatch in dispatches {
                    self.record_dispatch(&mut pass, dispatch)?;
                }
            }
        }
        Ok(())
    }

    fn record_dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        command: &Command,
    ) -> Result<(), DeviceError> {
        let (Command::Dispatch { bound, .. } | Command::DispatchIndirect { bound, .. }) = command else {
            return Ok(());
        };
        let inner = self.bound(bound)?;
        pass.set_pipeline(&inner.pipeline);
        pass.set_bind_group(0, &inner.group, &[]);
        match command {
            Command::DispatchIndirect { args, offset, .. } => {
                pass.dispatch_workgroups_indirect(self.buffer(args)?, *offset);
            }
            Command::Dispatch { groups: [x, y, z], .. } => pass.dispatch_workgroups(*x, *y, *z),
            Command::Clear(_) | Command::Copy { .. } | Command::Write { .. } => {}
        }
        Ok(())
    }
}

/// Commands that are submitted together; writes apart from the rest, as they are no part of a submission.
fn parts(commands: &[Command]) -> impl Iterator<Item = &[Command]> {
    let is_write = |command: &Command| matches!(command, Command::Write { .. });
    commands
        .chunk_by(move |one, next| is_write(one) == is_write(next))
        .flat_map(|alike| alike.chunks(SUBMIT_COMMANDS))
}

fn kernel_name(command: &Command) -> Option<&'static str> {
    match command {
        Command::Dispatch { bound, .. } | Command::DispatchIndirect { bound, .. } => Some(bound.kernel.name),
        Command::Clear(_) | Command::Copy { .. } | Command::Write { .. } => None,
    }
}

fn is_dispatch(command: &Command) -> bool {
    kernel_name(command).is_some()
}
