//! Writing to the terminal without dying of a closed pipe.

use std::{
    borrow::Cow,
    io::{self, Write},
};

use crate::status::{Failure, Outcome, Status};

/// A line for other programs, on standard output.
///
/// # Errors
/// [`Status::Output`] if nobody can take it. A reader that has had enough (`| head`) is no error.
pub fn output(line: &str) -> Outcome {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{}", shown(line)).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(Status::Output, format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// A line for people, on standard error.
pub fn note(line: &str) {
    // If standard error is gone there is nobody to tell.
    let _ = writeln!(io::stderr().lock(), "{}", shown(line));
}

/// Names of a scene's cameras, lights and materials are in lines: none steers the terminal.
fn shown(line: &str) -> Cow<'_, str> {
    let steers = |c: char| c.is_control() && c != '\n';
    if line.contains(steers) { line.replace(steers, "?").into() } else { line.into() }
}

/// A line about something that was not as it should be.
pub fn warning(line: &str) {
    note(&format!("warning: {line}"));
}

/// The line that says why the program ends. It carries the program's name: drivers print `error:` too.
pub fn error(line: &str) {
    note(&format!("midway: error: {line}"));
}

#[cfg(test)]
mod tests {
    use super::shown;

    #[test]
    fn no_line_steers_the_terminal() {
        assert_eq!(shown("a\u{1b}[31m\u{7f}\rb\nc"), "a?[31m??b\nc");
        assert_eq!(shown("Käse, 10 µm"), "Käse, 10 µm");
    }
}
