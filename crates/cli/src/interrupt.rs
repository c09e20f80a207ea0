//! Ctrl-C, and SIGTERM, by which schedulers and `kill` end a program: the first asks to stop, the second does
//! not ask. SIGHUP stays as it is: `nohup` has it ignored.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use crate::status::{OrStatus, Outcome, Status};

/// Whether Ctrl-C has been pressed, or SIGTERM has come.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Takes over both for the rest of the program.
    ///
    /// # Errors
    /// If the system refuses a handler.
    pub fn install() -> Outcome<Self> {
        let interrupt = Self::default();
        let pressed = interrupt.clone();
        ctrlc::set_handler(move || {
            if pressed.0.swap(true, Ordering::SeqCst) {
                std::process::exit(Status::Interrupted.code().into());
            }
        })
        .or_status(Status::Internal)?;
        #[cfg(unix)]
        interrupt.take_over_sigterm().or_status(Status::Internal)?;
        Ok(interrupt)
    }

    #[cfg(unix)]
    fn take_over_sigterm(&self) -> std::io::Result<()> {
        use signal_hook::{consts::SIGTERM, flag};
        // In this order: the first signal finds the flag not set yet.
        let code = Status::Interrupted.code().into();
        flag::register_conditional_shutdown(SIGTERM, code, Arc::clone(&self.0))?;
        flag::register(SIGTERM, Arc::clone(&self.0))?;
        Ok(())
    }

    /// Whether to stop at the next chance.
    pub fn is_pressed(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }

    /// As if Ctrl-C had been pressed.
    #[cfg(test)]
    pub fn press(&self) {
        self.0.store(true, Ordering::SeqCst);
    }
}
