//! Errors of wgpu as values: nothing it reports may panic or pass unseen.

use std::{
    cell::Cell,
    panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook},
    sync::{Arc, Mutex, Once, OnceLock, PoisonError},
};

use wgpu::ErrorFilter;

/// What wgpu reported, before it is known which call of ours it is about.
#[derive(Debug)]
pub(super) enum Fault {
    OutOfMemory,
    Refused(String),
    Lost(String),
}

/// Where a device's errors arrive.
#[derive(Clone, Default)]
pub(super) struct Faults {
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    lost: OnceLock<String>,
    /// The first error that no scope caught.
    stray: Mutex<Option<String>>,
}

impl Faults {
    /// Listens to a new device.
    pub(super) fn of(device: &wgpu::Device) -> Self {
        let faults = Self::default();
        let lost = faults.shared.clone();
        device.set_device_lost_callback(move |_, message| {
            // The first message stays.
            let _ = lost.lost.set(one_line(&message));
        });
        let stray = faults.shared.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut stray = stray.stray.lock().unwrap_or_else(PoisonError::into_inner);
            stray.get_or_insert_with(|| one_line(&error.to_string()));
        }));
        faults
    }

    /// Makes `calls` and returns what they return, or the first error they cause.
    pub(super) fn guard<T>(&self, device: &wgpu::Device, calls: impl FnOnce() -> T) -> Result<T, Fault> {
        self.still_there()?;
        let out_of_memory = device.push_error_scope(ErrorFilter::OutOfMemory);
        let internal = device.push_error_scope(ErrorFilter::Internal);
        let validation = device.push_error_scope(ErrorFilter::Validation);
        let value = calls();
        let errors = [validation.pop(), internal.pop(), out_of_memory.pop()].map(pollster::block_on);
        self.still_there()?;
        // A failed allocation makes what is built on it invalid too: it is the cause.
        if matches!(errors[2], Some(wgpu::Error::OutOfMemory { .. })) {
            return Err(Fault::OutOfMemory);
        }
        let stray = self.shared.stray.lock().unwrap_or_else(PoisonError::into_inner).take();
        let error = errors.into_iter().flatten().next().map(|error| one_line(&error.to_string()));
        error.or(stray).map_or(Ok(value), |message| Err(Fault::Refused(message)))
    }

    /// Waits for a submission. wgpu panics here when the device is lost.
    pub(super) fn wait(&self, device: &wgpu::Device, submission: wgpu::SubmissionIndex) -> Result<(), Fault> {
        let poll = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
        let failure = match catch_quietly(|| device.poll(poll)) {
            Ok(Ok(_)) => return self.still_there(),
            Ok(Err(error)) => Fault::Refused(one_line(&error.to_string())),
            Err(panic) => Fault::Lost(one_line(&panic)),
        };
        // A submission that a lost device did not take is only told of by a poll that waits for none.
        let _ = catch_quietly(|| device.poll(wgpu::PollType::Poll));
        self.still_there()?;
        if let Fault::Lost(message) = &failure {
            let _ = self.shared.lost.set(message.clone());
        }
        Err(failure)
    }

    fn still_there(&self) -> Result<(), Fault> {
        self.shared.lost.get().map_or(Ok(()), |message| Err(Fault::Lost(message.clone())))
    }
}

/// wgpu's messages are trees over several lines, with frames around excerpts of kernels.
fn one_line(message: &str) -> String {
    let lines = message.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    let told = lines.filter(|line| !matches!(line.as_str(), "" | "│" | "Validation Error" | "Caused by:"));
    told.collect::<Vec<_>>().join("; ")
}

/// Makes a call whose panic is turned into its message and not printed.
fn catch_quietly<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    thread_local!(static QUIET: Cell<bool> = const { Cell::new(false) });
    HOOK.call_once(|| {
        let previous = take_hook();
        set_hook(Box::new(move |info| {
            if !QUIET.get() {
                previous(info);
            }
        }));
    });
    QUIET.set(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    QUIET.set(false);
    result.map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        text.or_else(|| panic.downcast_ref().copied()).unwrap_or("the driver failed").to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::{catch_quietly, one_line};

    #[test]
    fn a_panic_becomes_its_message() {
        assert_eq!(catch_quietly(|| 3), Ok(3));
        assert_eq!(catch_quietly(|| panic!("lost {}", 1)), Err::<(), _>("lost 1".into()));
        assert_eq!(catch_quietly(|| panic!("lost")), Err::<(), _>("lost".into()));
    }

    #[test]
    fn a_tree_becomes_a_line() {
        let tree = "Validation Error\n\nCaused by:\n  In a_call\n    the reason\n";
        assert_eq!(one_line(tree), "In a_call; the reason");
    }
}
