//! What happens between passes: progress, snapshots, measurements.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use midway_film::{ErrorLog, ErrorRow, ExrFile, FilmError, Image, rmse_and_relmse};

use super::{frame::Frame, schedule::State};
use crate::status::{Failure, Outcome};

/// Says when the next snapshot is due.
pub struct SnapshotClock {
    every: Option<Duration>,
    last: Instant,
}

impl SnapshotClock {
    /// Starts now; never due if `every` is none.
    pub fn new(every: Option<Duration>) -> Self {
        Self { every, last: Instant::now() }
    }

    /// Whether one is due; if so, the next is due `every` from now.
    pub fn is_due(&mut self) -> bool {
        let due = self.every.is_some_and(|every| self.last.elapsed() >= every);
        if due {
            self.last = Instant::now();
        }
        due
    }
}

/// Measures the image against a reference and logs it.
pub struct ErrorMeter {
    reference: Image,
    log: Option<ErrorLog>,
    next_samples: u64,
    last_samples: u64,
}

/// Samples grow by at least this between two measurements, so that their cost stays a small part.
const MEASURE_GROWTH: f64 = 1.1;

impl ErrorMeter {
    /// Reads the reference, which is as large as the image or, with a crop, as the whole frame.
    ///
    /// # Errors
    /// If it cannot be read, has another size or pixels that are not finite, or if the log cannot
    /// be made.
    pub fn new(reference: &Path, log: Option<&Path>, frame: &Frame) -> Outcome<Self> {
        let image = fit(ExrFile::read(reference)?.image()?, frame);
        // Against itself: all that can fail is what is wrong with it.
        rmse_and_relmse(&image, &image)?;
        if image.size() != frame.image_size() {
            return Err(FilmError::SizeMismatch(frame.image_size(), image.size()).into());
        }
        let log = log.map(ErrorLog::create).transpose()?;
        Ok(Self { reference: image, log, next_samples: 1, last_samples: 0 })
    }

    /// Whether enough samples have come since the last measurement.
    pub fn is_due(&self, samples: u64) -> bool {
        samples >= self.next_samples
    }

    /// Whether the last measurement is of exactly these samples.
    pub fn is_measured(&self, samples: u64) -> bool {
        self.last_samples == samples
    }

    /// Measures and logs. An image that is not finite is logged as NaN.
    ///
    /// # Errors
    /// If the log cannot be written.
    pub fn measure(&mut self, image: &Image, state: &State) -> Outcome<ErrorRow> {
        let (rmse, relmse) = match rmse_and_relmse(image, &self.reference) {
            Ok(errors) => errors,
            Err(FilmError::NotFinite { .. }) => (f64::NAN, f64::NAN),
            Err(error) => return Err(Failure::from(error)),
        };
        let row = ErrorRow { seconds: state.seconds(), samples: state.samples, rmse, relmse };
        if let Some(log) = &mut self.log {
            log.push(&row)?;
        }
        self.last_samples = state.samples;
        self.next_samples = (state.samples as f64 * MEASURE_GROWTH).ceil() as u64;
        self.next_samples = self.next_samples.max(state.samples + 1);
        Ok(row)
    }
}

/// Cuts the frame's crop out of a reference of the whole frame.
fn fit(reference: Image, frame: &Frame) -> Image {
    let whole = [frame.width as usize, frame.height as usize];
    match frame.crop {
        Some(crop) if reference.size() == whole => {
            let (x0, y0) = (crop.x as usize, crop.y as usize);
            Image::from_fn(crop.width as usize, crop.height as usize, |x, y| {
                reference.pixels[(y0 + y) * whole[0] + x0 + x]
            })
        }
        _ => reference,
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use midway_film::{Metadata, write_exr};
    use midway_scene::Camera;

    use super::*;
    use crate::{args::CropArg, render::schedule::Limits, status::Status};

    fn frame(crop: Option<CropArg>) -> Frame {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0).unwrap();
        Frame { camera, width: 8, height: 6, crop }
    }

    fn meter(reference: &Image, frame: &Frame) -> Outcome<ErrorMeter> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.exr");
        write_exr(&path, reference, None, &Metadata::new()).unwrap();
        ErrorMeter::new(&path, None, frame)
    }

    #[test]
    fn a_crop_is_measured_against_its_part_of_the_reference() {
        let reference = Image::from_fn(8, 6, |x, y| [x as f32, y as f32, 1.0]);
        let crop = CropArg { x: 2, y: 1, width: 3, height: 4 };
        let mut meter = meter(&reference, &frame(Some(crop))).unwrap();
        let image = Image::from_fn(3, 4, |x, y| [(x + 2) as f32, (y + 1) as f32, 1.0]);
        let limits = Limits { samples: Some(9), time: None };
        let state = State { samples: 4, rays: 0, rendering: Duration::from_secs(1), limits };
        assert!(meter.is_due(1) && !meter.is_measured(4));
        assert_eq!(meter.measure(&image, &state).unwrap().rmse, 0.0);
        assert!(meter.is_measured(4) && !meter.is_due(4) && meter.is_due(5));
        let bad = Image::filled(3, 4, [f32::NAN; 3]);
        assert!(meter.measure(&bad, &state).unwrap().rmse.is_nan());
    }

    #[test]
    fn a_bad_reference_is_refused_before_rendering() {
        let small = Image::filled(7, 6, [1.0; 3]);
        assert_eq!(meter(&small, &frame(None)).err().unwrap().status, Status::NotComparable);
        let bad = Image::filled(8, 6, [f32::INFINITY; 3]);
        assert_eq!(meter(&bad, &frame(None)).err().unwrap().status, Status::NotComparable);
    }

    #[test]
    fn snapshots_keep_their_distance() {
        assert!(!SnapshotClock::new(None).is_due());
        let mut clock = SnapshotClock::new(Some(Duration::from_millis(20)));
        assert!(!clock.is_due());
        std::thread::sleep(Duration::from_millis(25));
        assert!(clock.is_due() && !clock.is_due());
    }
}
