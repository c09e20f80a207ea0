//! Ctrl-C, SIGTERM, by which schedulers and `kill` end a program, and SIGHUP, when its terminal or connection
//! goes: the first asks to stop, the second does not ask.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use crate::status::{OrStatus, Outcome, Status};

/// Whether Ctrl-C has been pressed, or one of these signals has come.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Takes them over for the rest of the program.
    ///
    /// # Errors
    /// If the system refuses a handler.
    pub fn install() -> Outcome<Self> {
        let interrupt = Self::default();
        let pressed = interrupt.clone();
        // Asked by what does not wait: sessions that end may send SIGTERM right after SIGHUP.
        let asked: Arc<AtomicBool> = Arc::default();
        #[cfg(unix)]
        interrupt.take_over_signals(&asked).or_status(Status::Internal)?;
        ctrlc::set_handler(move || {
            if asked.swap(true, Ordering::SeqCst) {
                std::process::exit(Status::Interrupted.code().into());
            }
            pressed.0.store(true, Ordering::SeqCst);
        })
        .or_status(Status::Internal)?;
        Ok(interrupt)
    }

    #[cfg(unix)]
    fn take_over_signals(&self, asked: &Arc<AtomicBool>) -> std::io::Result<()> {
        use signal_hook::{
            consts::{SIGHUP, SIGTERM},
            flag,
        };
        // In this order: the first signal finds the flag not set yet.
        let code = Status::Interrupted.code().into();
        flag::register_conditional_shutdown(SIGTERM, code, Arc::clone(asked))?;
        flag::register(SIGTERM, Arc::clone(asked))?;
        flag::register(SIGTERM, Arc::clone(&self.0))?;
        // A terminal that goes may send it twice, by the system and by the shell.
        if !ignores_hangups() {
            flag::register(SIGHUP, Arc::clone(&self.0))?;
        }
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

/// Whether SIGHUP is ignored, as `nohup` has it: it stays so. Taken to be so where the system does not say.
#[cfg(unix)]
fn ignores_hangups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let bits = ignored.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok());
    bits.is_none_or(|bits| bits & 1 << (signal_hook::consts::SIGHUP - 1) != 0)
}
