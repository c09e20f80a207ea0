//! A CSV file of error against time and samples.

use std::{
    fs::File,
    io::{self, Write},
    path::{Path, PathBuf},
};

use crate::FilmError;

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorRow {
    /// Seconds spent rendering, measuring not included.
    pub seconds: f64,
    /// Samples per pixel so far.
    pub samples: u64,
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Mean of (a - b)² / (b² + 0.01).
    pub relmse: f64,
}

/// Appends [`ErrorRow`]s to a CSV file, each on the disk's side once [`ErrorLog::push`] returns.
#[derive(Debug)]
pub struct ErrorLog {
    path: PathBuf,
    file: File,
}

impl ErrorLog {
    /// The first line of the file.
    pub const HEADER: &'static str = "seconds,samples,rmse,relmse";

    /// Makes the file, replacing one that is there, and writes [`ErrorLog::HEADER`].
    ///
    /// # Errors
    /// [`FilmError::Write`].
    pub fn create(path: &Path) -> Result<Self, FilmError> {
        let fail = |source| FilmError::Write { path: path.to_owned(), source };
        let file = File::create(path).map_err(fail)?;
        let mut log = Self { path: path.to_owned(), file };
        log.line(Self::HEADER).map_err(fail)?;
        Ok(log)
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`FilmError::Write`].
    pub fn push(&mut self, row: &ErrorRow) -> Result<(), FilmError> {
        let ErrorRow { seconds, samples, rmse, relmse } = row;
        self.line(&format!("{seconds:.6},{samples},{rmse:e},{relmse:e}"))
            .map_err(|source| FilmError::Write { path: self.path.clone(), source })
    }

    fn line(&mut self, text: &str) -> io::Result<()> {
        self.file.write_all(format!("{text}\n").as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_the_header() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("errors.csv");
        let mut log = ErrorLog::create(&path).unwrap();
        log.push(&ErrorRow { seconds: 1.5, samples: 16, rmse: 0.25, relmse: 0.001 }).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "seconds,samples,rmse,relmse\n1.500000,16,2.5e-1,1e-3\n");
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(ErrorLog::create(&folder.path().join("none/e.csv")).is_err());
    }
}
