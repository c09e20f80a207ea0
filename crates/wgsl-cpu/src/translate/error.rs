//! What can go wrong, and on which line.

use std::{error::Error, fmt};

use naga::{SourceLocation, Span, WithSpan, front::wgsl::ParseError, valid::ValidationError};

/// A place in the WGSL source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The line, from 1.
    pub line: u32,
    /// The column in bytes, from 1.
    pub column: u32,
    /// The line's text, trimmed.
    pub text: String,
}

impl Location {
    /// The place that naga names, else the source's first line.
    fn new(wgsl: &str, location: Option<SourceLocation>) -> Self {
        let (line, column) = location.map_or((1, 1), |at| (at.line_number, at.line_position));
        let text = wgsl.lines().nth(line as usize - 1).unwrap_or_default();
        Self { line, column, text: text.trim().to_owned() }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: `{}`", self.line, self.column, self.text)
    }
}

/// Why a WGSL module was not translated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TranslateError {
    /// It is not WGSL.
    #[error("{location}: {message}")]
    Parse {
        /// Where.
        location: Location,
        /// What naga says.
        message: String,
    },
    /// It is WGSL, but breaks its rules.
    #[error("{location}: {message}")]
    Validation {
        /// Where.
        location: Location,
        /// What naga says, with its causes.
        message: String,
    },
    /// It is valid, but uses what kernels that run on the CPU must not use.
    #[error("{location}: {construct} is not supported on the CPU")]
    Unsupported {
        /// Where.
        location: Location,
        /// What it is.
        construct: String,
    },
}

impl TranslateError {
    /// Where in the given source.
    pub fn location(&self) -> &Location {
        match self {
            Self::Parse { location, .. }
            | Self::Validation { location, .. }
            | Self::Unsupported { location, .. } => location,
        }
    }

    pub(super) fn parse(wgsl: &str, error: &ParseError) -> Self {
        let location = Location::new(wgsl, error.location(wgsl));
        Self::Parse { location, message: error.message().to_owned() }
    }

    pub(super) fn validation(wgsl: &str, error: &WithSpan<ValidationError>) -> Self {
        let mut message = error.as_inner().to_string();
        let mut cause = error.as_inner().source();
        while let Some(inner) = cause {
            message += &format!(": {inner}");
            cause = inner.source();
        }
        // The spans are of the construct and of what it is in; the shortest says most.
        let spans = error.spans().map(|(span, _)| *span);
        let span = spans.min_by_key(|span| span.to_range().map_or(usize::MAX, |range| range.len()));
        let span = span.or_else(|| find_wide_scalar(wgsl));
        let location = Location::new(wgsl, span.map(|span| span.location(wgsl)));
        Self::Validation { location, message }
    }
}

/// The first scalar type that is not of 32 bits: naga has no spans for those.
fn find_wide_scalar(wgsl: &str) -> Option<Span> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut names = wgsl.match_indices(['f', 'i', 'u']).filter(|&(at, _)| {
        let is_start = !wgsl[..at].ends_with(is_name);
        let rest = &wgsl[at + 1..];
        is_start && (rest.starts_with("64") || rest.starts_with("16")) && !rest[2..].starts_with(is_name)
    });
    names.next().map(|(at, _)| Span::from(at..at + 3))
}

/// What the translator refuses, before the source is at hand to find the line.
#[derive(Debug)]
pub(super) struct Unsupported {
    construct: String,
    span: Span,
}

/// The result of translating a part.
pub(super) type Result<T> = std::result::Result<T, Unsupported>;

impl Unsupported {
    pub(super) fn new(construct: impl Into<String>, span: Span) -> Self {
        Self { construct: construct.into(), span }
    }

    /// With `span` where there is none yet: naga has no spans for some types.
    pub(super) fn or_at(self, span: Span) -> Self {
        Self { span: if self.span.is_defined() { self.span } else { span }, ..self }
    }

    pub(super) fn at(self, wgsl: &str) -> TranslateError {
        let location = Some(self.span).filter(Span::is_defined).map(|span| span.location(wgsl));
        TranslateError::Unsupported { location: Location::new(wgsl, location), construct: self.construct }
    }
}
