//! Lines of words.

use std::path::Path;

use crate::{ImportError, Place};

/// A line that says something: its number, its first word, and the rest.
pub(super) struct Line<'a> {
    pub file: &'a Path,
    pub number: usize,
    pub keyword: &'a str,
    pub rest: &'a str,
}

/// The lines of a text that say something; comments and blank lines do not. `text` has no
/// continued lines: see [`joined`].
pub(super) fn lines<'a>(file: &'a Path, text: &'a str) -> impl Iterator<Item = Line<'a>> {
    text.lines().enumerate().filter_map(move |(i, line)| {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        (!keyword.is_empty()).then_some(Line { file, number: i + 1, keyword, rest })
    })
}

/// A text with lines that end in a backslash joined to the next one, each followed by as many
/// empty lines as keep the numbers of those after it.
pub(super) fn joined(text: &str) -> std::borrow::Cow<'_, str> {
    if !text.contains("\\\n") && !text.contains("\\\r\n") {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 16);
    let mut pending = 0;
    for line in text.lines() {
        match line.strip_suffix('\\') {
            Some(begun) => {
                out.push_str(begun);
                out.push(' ');
                pending += 1;
            }
            None => {
                out.push_str(line);
                (0..=pending).for_each(|_| out.push('\n'));
                pending = 0;
            }
        }
    }
    out.into()
}

/// A place for a warning.
pub(super) fn place_of(file: &Path, line: usize) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    format!("{name}:{line}")
}

impl<'a> Line<'a> {
    pub fn place(&self) -> Place {
        Place::new(self.file, self.number.to_string())
    }

    /// For a warning.
    pub fn short_place(&self) -> String {
        place_of(self.file, self.number)
    }

    pub fn malformed(&self, problem: impl Into<String>) -> ImportError {
        ImportError::Malformed { place: self.place(), problem: problem.into() }
    }

    pub fn words(&self) -> std::str::SplitWhitespace<'a> {
        self.rest.split_whitespace()
    }

    /// All words as numbers, at least one. NaN and infinities parse: the caller checks.
    pub fn floats(&self) -> Result<Vec<f32>, ImportError> {
        let floats: Result<Vec<f32>, _> = self.words().map(str::parse).collect();
        match floats {
            Ok(floats) if !floats.is_empty() => Ok(floats),
            _ => Err(self.malformed(format!("numbers are expected after \"{}\"", self.keyword))),
        }
    }

    pub fn finite(&self) -> Result<Vec<f32>, ImportError> {
        let floats = self.floats()?;
        if floats.iter().all(|x| x.is_finite()) {
            return Ok(floats);
        }
        Err(self.malformed(format!("finite numbers are expected after \"{}\"", self.keyword)))
    }
}
