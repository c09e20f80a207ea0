//! Ctrl-C: the first asks to stop, the second does not ask.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use crate::status::{OrStatus, Outcome, Status};

/// Whether Ctrl-C has been pressed.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Takes over Ctrl-C for the rest of the program.
    ///
    /// # Errors
    /// If the system refuses the handler.
    pub fn install() -> Outcome<Self> {
        let interrupt = Self::default();
        let pressed = interrupt.clone();
        ctrlc::set_handler(move || {
            if pressed.0.swap(true, Ordering::SeqCst) {
                std::process::exit(Status::Interrupted.code().into());
            }
        })
        .or_status(Status::Internal)?;
        Ok(interrupt)
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
