//! A render from its first pass to its files.

use midway_device::DeviceInfo;
use midway_film::{ErrorRow, Framing, Image, Metadata};
use midway_render::RenderStats;
use serde_json::json;

use super::{
    frame::Frame,
    header,
    job::RenderJob,
    live::Live,
    outputs::Outputs,
    progress::{self, Reporter},
    schedule::{self, Job, Limits, State, StoppedBy},
    watch::{ErrorMeter, SnapshotClock},
};
use crate::{
    interrupt::Interrupt,
    status::{Outcome, Status},
};

/// Everything a running render needs.
pub struct Session {
    /// When it ends.
    pub limits: Limits,
    /// Where it goes.
    pub outputs: Outputs,
    /// Its place in the frame, if it is a crop.
    pub framing: Option<Framing>,
    /// What is known of it beforehand.
    pub header: Metadata,
    /// Who is told.
    pub reporter: Reporter,
    /// When it is written before its end.
    pub snapshots: SnapshotClock,
    /// Where it is shown while it runs.
    pub live: Live,
    /// Where it renders.
    pub device: DeviceInfo,
    /// What it is measured against.
    pub meter: Option<ErrorMeter>,
}

impl Session {
    /// Says what is about to happen: integrator, bias.
    ///
    /// # Errors
    /// If standard output cannot take it.
    pub fn announce(&self, job: &RenderJob, frame: &Frame) -> Outcome {
        let [width, height] = frame.image_size();
        let memory = job.memory();
        let bias = job.bias();
        self.reporter.note(&format!("integrator: {}, {width}x{height} pixels", job.integrator()));
        bias.iter().for_each(|bias| self.reporter.note(&format!("bias: {bias}")));
        let outputs: Vec<_> = self.outputs.paths().map(|path| path.to_string_lossy()).collect();
        let start = json!({
            "device": self.device.name, "memory_bytes": memory.total(), "integrator": job.integrator(),
            "bias": bias, "width": width, "height": height, "outputs": outputs,
        });
        self.reporter.event("start", &start)
    }

    /// Renders until a limit or an [`Interrupt`], then writes the image. If the render fails after its first
    /// pass, what there is is written all the same where it can still be read.
    ///
    /// # Errors
    /// Of the renderer, the outputs or the log.
    pub fn render(mut self, mut job: RenderJob, interrupt: &Interrupt) -> Outcome<Status> {
        let mut last = None;
        let outcome = schedule::run(&mut job, self.limits, interrupt, |job, state| {
            last = Some(*state);
            self.after_pass(job, state)
        });
        self.reporter.finish();
        match outcome {
            Ok((reason, state)) => self.conclude(&mut job, reason, &state),
            Err(failure) => {
                last.inspect(|state| self.rescue(&mut job, state));
                Err(failure)
            }
        }
    }

    fn after_pass(&mut self, job: &mut RenderJob, state: &State) -> Outcome {
        self.reporter.progress(state)?;
        if let Some(meter) = self.meter.as_mut().filter(|meter| meter.is_due(state.samples)) {
            let ErrorRow { seconds, samples, rmse, relmse } = meter.measure(&job.image()?, state)?;
            let row = json!({ "seconds": seconds, "samples": samples, "rmse": rmse, "relmse": relmse });
            self.reporter.event("error", &row)?;
        }
        self.live.after_pass(job, state, &self.device, state.fraction() >= 1.0)?;
        // After the last pass the image is written anyway.
        if self.snapshots.is_due() && state.fraction() < 1.0 {
            let header = header::of_state(&self.header, job, state);
            let image = job.image()?;
            if let Err(failure) = self.write(job, &image, &header) {
                self.reporter.warning(&format!("snapshot: {}", failure.to_line()));
            }
        }
        Ok(())
    }

    /// Writes an image of the job with the layers that go with it.
    fn write(&self, job: &mut RenderJob, image: &Image, header: &Metadata) -> Outcome {
        self.outputs.write(image, &job.channels()?, self.framing, header)
    }

    fn conclude(&mut self, job: &mut RenderJob, reason: StoppedBy, state: &State) -> Outcome<Status> {
        if state.samples == 0 {
            self.reporter.note("interrupted before the first pass: nothing to write");
            return Ok(Status::Interrupted);
        }
        let image = job.image()?;
        let mut header = header::of_state(&self.header, job, state);
        header.set("stopped_by", reason.name());
        self.write(job, &image, &header)?;
        if let Some(meter) = self.meter.as_mut().filter(|meter| !meter.is_measured(state.samples)) {
            meter.measure(&image, state)?;
        }
        self.report_end(job, reason, state)?;
        self.report_health(job, &image);
        Ok(if reason == StoppedBy::Interrupt { Status::Interrupted } else { Status::Success })
    }

    fn report_end(&self, job: &RenderJob, reason: StoppedBy, state: &State) -> Outcome {
        let why = match reason {
            StoppedBy::Samples => "all samples are done",
            StoppedBy::Time => "the time is over",
            StoppedBy::Interrupt => "interrupted",
        };
        let (time, pace) = (progress::seconds(state.seconds()), state.mrays_per_second());
        self.reporter
            .note(&format!("stopped: {why} ({} samples in {time}, {pace:.1} Mrays/s)", state.samples));
        for path in self.outputs.paths() {
            self.reporter.note(&format!("written: {}", path.display()));
        }
        let end = json!({
            "stopped_by": reason.name(), "samples": state.samples, "seconds": state.seconds(),
            "mrays_per_second": state.mrays_per_second(), "rejected_contributions": job.stats().rejected,
        });
        self.reporter.event("end", &end)
    }

    /// What a look at the image would have people ask.
    fn report_health(&self, job: &RenderJob, image: &Image) {
        let &RenderStats { rejected, overflowed, .. } = job.stats();
        if rejected > 0 {
            self.reporter.warning(&format!(
                "{rejected} contributions were NaN, infinite or negative and are left out; please report the scene"
            ));
        }
        if overflowed > 0 {
            self.reporter
                .warning(&format!("{overflowed} sums left the film's range: their pixels are wrong"));
        }
        if image.is_black() {
            self.reporter.warning(
                "the image is black: does anything emit (`midway info`), does the camera look at it, \
                 is it inside an object, and can this integrator reach the light?",
            );
        }
    }

    /// Saves what a failed render has, if the device still gives it; the failure itself is what is
    /// reported.
    fn rescue(&self, job: &mut RenderJob, state: &State) {
        let Ok(image) = job.image() else { return };
        let mut header = header::of_state(&self.header, job, state);
        header.set("stopped_by", "failure");
        if self.write(job, &image, &header).is_ok() {
            self.reporter
                .note(&format!("written: the image of the {} samples before the failure", state.samples));
        }
    }
}
