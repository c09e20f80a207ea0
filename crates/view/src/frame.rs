//! Frames on their way to browsers: encoded apart from the renderer, the newest winning.
//!
//! A frame's message is little-endian: `MWF1`, then u32 sequence, input, width, height and number of
//! pictures, then each picture as its length in bytes (u32) and a JPEG.

use std::{
    sync::{Arc, Condvar, Mutex, PoisonError},
    thread,
};

use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use tokio::sync::watch;

/// Quality while the camera moves, and while it rests.
const QUALITY: [u8; 2] = [82, 93];
/// What each frame's message begins with.
const MAGIC: &[u8; 4] = b"MWF1";

/// Pictures that are not encoded yet.
#[derive(Debug, Default)]
pub struct Pixels {
    /// The last input that they show.
    pub input: u32,
    /// Across, of each.
    pub width: u32,
    /// Down, of each.
    pub height: u32,
    /// RGBA of each: one, or two side by side.
    pub pictures: Vec<Vec<u8>>,
    /// Whether the camera moves.
    pub moving: bool,
}

/// An encoded frame.
#[derive(Debug, Default)]
pub struct Frame {
    /// Counts from 1; 0 where there is none yet.
    pub sequence: u32,
    /// The message.
    pub bytes: Vec<u8>,
}

/// Takes pixels from the renderer and gives frames to whoever watches.
pub struct Encoding {
    slot: Arc<(Mutex<Slot>, Condvar)>,
}

#[derive(Default)]
struct Slot {
    next: Option<Pixels>,
    closed: bool,
}

impl Encoding {
    /// Starts the thread that encodes.
    ///
    /// # Errors
    /// If the system refuses the thread.
    pub fn start() -> std::io::Result<(Self, watch::Receiver<Arc<Frame>>)> {
        let slot = Arc::new((Mutex::<Slot>::default(), Condvar::new()));
        let (sender, receiver) = watch::channel(Arc::new(Frame::default()));
        let theirs = Arc::clone(&slot);
        thread::Builder::new().name("encode".into()).spawn(move || run(&theirs, &sender))?;
        Ok((Self { slot }, receiver))
    }

    /// Hands over pixels; those that wait still are forgotten.
    pub fn show(&self, pixels: Pixels) {
        self.slot.0.lock().unwrap_or_else(PoisonError::into_inner).next = Some(pixels);
        self.slot.1.notify_one();
    }
}

impl Drop for Encoding {
    fn drop(&mut self) {
        self.slot.0.lock().unwrap_or_else(PoisonError::into_inner).closed = true;
        self.slot.1.notify_one();
    }
}

fn run((slot, filled): &(Mutex<Slot>, Condvar), frames: &watch::Sender<Arc<Frame>>) {
    let mut sequence = 0u32;
    loop {
        let mut waiting = slot.lock().unwrap_or_else(PoisonError::into_inner);
        while waiting.next.is_none() && !waiting.closed {
            waiting = filled.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
        let Some(pixels) = waiting.next.take() else { return };
        drop(waiting);
        sequence = sequence.wrapping_add(1).max(1);
        frames.send_replace(Arc::new(Frame { sequence, bytes: encode(&pixels, sequence) }));
    }
}

/// A frame's message. A picture that JPEG cannot hold (a side over 65,535) is left empty.
fn encode(pixels: &Pixels, sequence: u32) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    let count = pixels.pictures.len() as u32;
    for number in [sequence, pixels.input, pixels.width, pixels.height, count] {
        bytes.extend(number.to_le_bytes());
    }
    for picture in &pixels.pictures {
        let mut jpeg = Vec::with_capacity(picture.len() / 8);
        let mut encoder = Encoder::new(&mut jpeg, QUALITY[usize::from(!pixels.moving)]);
        encoder.set_sampling_factor(if pixels.moving {
            SamplingFactor::F_2_2
        } else {
            SamplingFactor::F_1_1
        });
        let (width, height) = (pixels.width.min(65_535) as u16, pixels.height.min(65_535) as u16);
        if encoder.encode(picture, width, height, ColorType::Rgba).is_err() {
            jpeg.clear();
        }
        bytes.extend((jpeg.len() as u32).to_le_bytes());
        bytes.extend(jpeg);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_what_its_description_says() {
        let picture = [200u8, 40, 10, 255].repeat(16 * 8);
        let pixels =
            Pixels { input: 9, width: 16, height: 8, pictures: vec![picture.clone(), picture], moving: true };
        let bytes = encode(&pixels, 3);
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(&bytes[..4], MAGIC);
        assert_eq!([4, 8, 12, 16, 20].map(number), [3, 9, 16, 8, 2]);
        let length = number(24) as usize;
        let decoded = image::load_from_memory(&bytes[28..28 + length]).expect("a JPEG").to_rgb8();
        assert_eq!(decoded.dimensions(), (16, 8));
        for (value, expected) in decoded.get_pixel(8, 4).0.iter().zip([200u8, 40, 10]) {
            assert!(value.abs_diff(expected) <= 6);
        }
        assert_eq!(number(28 + length) as usize, bytes.len() - 32 - length);
    }

    #[test]
    fn the_newest_wins_and_the_renderer_never_waits() {
        let (encoding, frames) = Encoding::start().unwrap();
        for input in 1..=200 {
            let picture = vec![input as u8; 64 * 64 * 4];
            encoding.show(Pixels { input, width: 64, height: 64, pictures: vec![picture], moving: true });
        }
        let deadline = std::time::Instant::now() + std::time::Duration::from_secs(20);
        let last =
            || u32::from_le_bytes(frames.borrow().bytes.get(8..12).map_or([0; 4], |b| b.try_into().unwrap()));
        while last() != 200 {
            assert!(std::time::Instant::now() < deadline, "the last frame never came");
            thread::yield_now();
        }
        assert!(frames.borrow().sequence <= 200);
    }
}
