//! A panic ends the program with its own exit code and one line.

use std::{
    backtrace::{Backtrace, BacktraceStatus},
    panic::{self, AssertUnwindSafe, PanicHookInfo},
    sync::Mutex,
};

use crate::{console, status::Status};

/// The last panic. Libraries that catch their own leave theirs here, unprinted.
static LAST_PANIC: Mutex<Option<String>> = Mutex::new(None);

/// Runs `program`; a panic in it, or in a thread it waits for, becomes [`Status::Panic`].
pub fn catching_panics(program: impl FnOnce() -> Status) -> Status {
    let previous = panic::take_hook();
    panic::set_hook(Box::new(remember));
    let outcome = panic::catch_unwind(AssertUnwindSafe(program));
    panic::set_hook(previous);
    outcome.unwrap_or_else(|_| {
        let last = LAST_PANIC.lock().ok().and_then(|mut last| last.take());
        let what = last.unwrap_or_else(|| "unknown".to_owned());
        console::error(&format!("internal error: {what}; please report it with the command line"));
        Status::Panic
    })
}

fn remember(info: &PanicHookInfo<'_>) {
    let payload = info.payload();
    let literal = payload.downcast_ref::<&str>().copied();
    let message =
        literal.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
    let mut text: String = message.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some(location) = info.location() {
        text.push_str(&format!(" at {}:{}", location.file(), location.line()));
    }
    let backtrace = Backtrace::capture();
    if backtrace.status() == BacktraceStatus::Captured {
        text.push_str(&format!("\n{backtrace}"));
    }
    if let Ok(mut last) = LAST_PANIC.lock() {
        *last = Some(text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_has_its_own_status() {
        assert_eq!(catching_panics(|| panic!("deliberate")), Status::Panic);
        assert_eq!(
            catching_panics(|| std::thread::spawn(|| panic!("deliberate"))
                .join()
                .map_or(Status::Device, |()| Status::Success)),
            Status::Device
        );
        assert_eq!(catching_panics(|| Status::Usage), Status::Usage);
    }
}
