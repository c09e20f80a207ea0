//! Images: write, read, tone-map, compare.
//!
//! Pixels are linear Rec. 709 radiance, row-major from the top left. Nothing here accumulates
//! samples: the kernels do that, and hand over a finished [`Image`].
//!
//! ```
//! use midway_film::{Image, compare};
//!
//! let reference = Image::filled(16, 16, [0.5; 3]);
//! let test = Image::filled(16, 16, [0.505; 3]);
//! let errors = compare(&test, &reference).unwrap();
//! assert!((errors.mean_ratio[0] - 1.01).abs() < 1e-6);
//! ```

mod atomic;
mod error;
mod error_log;
mod exr_file;
mod flip;
mod half;
mod heatmap;
mod image;
mod metadata;
mod metrics;
mod png_file;
mod tone_map;

pub use crate::{
    atomic::{check_writable, write_atomically},
    error::FilmError,
    error_log::{ErrorLog, ErrorRow},
    exr_file::{Channel, ExrFile, Framing, write_exr, write_exr_with},
    flip::{DEFAULT_PIXELS_PER_DEGREE, flip},
    half::{HalfError, half_error, mean_and_trimmed},
    heatmap::{heatmap, magma},
    image::Image,
    metadata::{Metadata, Value},
    metrics::{Comparison, compare, relative_error, rmse_and_relmse},
    png_file::{write_png, write_srgb8_png},
    tone_map::{Display, ToneMap},
};
