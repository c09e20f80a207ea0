//! Exit codes, and errors that know theirs.

use std::fmt::Display;

use midway_film::FilmError;

/// How the program ends. All codes are below 100, so that none can be taken for Rust's 101 or a
/// shell's 126 and above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// 0: all that was asked for is done.
    Success,
    /// 1: something failed that none of the other codes covers.
    Internal,
    /// 2: the command line cannot be understood or contradicts itself.
    Usage,
    /// 3: a scene, or an image to read, is missing or damaged.
    Input,
    /// 4: no such device, or it failed, or it lacks memory.
    Device,
    /// 5: an output cannot be written.
    Output,
    /// 6: the images cannot be compared: other sizes, or NaN or infinity in one.
    NotComparable,
    /// 10: interrupted by Ctrl-C, SIGTERM or SIGHUP; what was rendered until then has been written.
    Interrupted,
    /// 70: a mistake in Midway itself, to be reported.
    Panic,
}

impl Status {
    /// Every one, for the help text.
    pub const ALL: [Self; 9] = [
        Self::Success,
        Self::Internal,
        Self::Usage,
        Self::Input,
        Self::Device,
        Self::Output,
        Self::NotComparable,
        Self::Interrupted,
        Self::Panic,
    ];

    /// The number the shell sees.
    pub const fn code(self) -> u8 {
        match self {
            Self::Success => 0,
            Self::Internal => 1,
            Self::Usage => 2,
            Self::Input => 3,
            Self::Device => 4,
            Self::Output => 5,
            Self::NotComparable => 6,
            Self::Interrupted => 10,
            Self::Panic => 70,
        }
    }

    /// What it means, for the help text.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Success => "done",
            Self::Internal => "unexpected failure",
            Self::Usage => "wrong command line",
            Self::Input => "scene or image missing or damaged",
            Self::Device => "device missing, failed or too small",
            Self::Output => "output cannot be written",
            Self::NotComparable => "images not comparable (size, NaN)",
            Self::Interrupted => "interrupted; the image so far is written",
            Self::Panic => "internal error, please report",
        }
    }
}

/// An error and the code the program ends with because of it.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub status: Status,
    /// What happened.
    pub error: anyhow::Error,
}

/// What fallible parts of the program return.
pub type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// A failure described by `message`.
    pub fn new(status: Status, message: impl Display) -> Self {
        Self { status, error: anyhow::anyhow!("{message}") }
    }

    /// A wrong command line.
    pub fn usage(message: impl Display) -> Self {
        Self::new(Status::Usage, message)
    }

    /// The error and its causes, in one line.
    pub fn to_line(&self) -> String {
        format!("{:#}", self.error).split_whitespace().collect::<Vec<_>>().join(" ")
    }
}

impl From<FilmError> for Failure {
    fn from(error: FilmError) -> Self {
        let status = match error {
            FilmError::Read { .. } | FilmError::Malformed { .. } | FilmError::MissingChannels { .. } => {
                Status::Input
            }
            FilmError::Write { .. } => Status::Output,
            FilmError::SizeMismatch(..) | FilmError::NotFinite { .. } => Status::NotComparable,
            _ => Status::Internal,
        };
        // The variants that have a source print it themselves.
        Self::new(status, error)
    }
}

/// Gives an error its exit code.
pub trait OrStatus<T> {
    /// The value, or a [`Failure`] with `status`.
    fn or_status(self, status: Status) -> Outcome<T>;
}

impl<T, E: Display> OrStatus<T> for Result<T, E> {
    fn or_status(self, status: Status) -> Outcome<T> {
        self.map_err(|error| Failure::new(status, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_distinct_and_below_100() {
        let mut codes = Status::ALL.map(Status::code).to_vec();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), Status::ALL.len());
        assert!(codes.iter().all(|code| *code < 100));
    }

    #[test]
    fn an_error_is_one_line() {
        let failure = Failure::new(Status::Input, "first\n  second\r\nthird");
        assert_eq!(failure.to_line(), "first second third");
    }
}
