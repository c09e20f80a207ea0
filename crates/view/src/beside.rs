//! Work that would keep the render thread: on a thread of its own, one piece at a time.

use std::{
    sync::mpsc::{self, Receiver, TryRecvError},
    thread,
};

use crate::ViewError;

type Piece = Box<dyn FnOnce() + Send>;

/// At most one piece of work that is under way. The thread stays for the next: what threads that come and go
/// allocate ends up spread over the allocator's arenas, which then grow.
pub struct Beside<T> {
    thread: Option<mpsc::Sender<Piece>>,
    running: Option<Receiver<Result<T, ViewError>>>,
}

impl<T> Default for Beside<T> {
    fn default() -> Self {
        Self { thread: None, running: None }
    }
}

impl<T: Send + 'static> Beside<T> {
    /// Whether there is none.
    pub fn is_free(&self) -> bool {
        self.running.is_none()
    }

    /// Starts a piece; what became of one before is not told any more.
    ///
    /// # Errors
    /// If the system refuses a thread.
    pub fn start(
        &mut self,
        work: impl FnOnce() -> Result<T, ViewError> + Send + 'static,
    ) -> Result<(), ViewError> {
        let (sender, receiver) = mpsc::sync_channel(1);
        // Nobody may wait for it any more.
        let piece: Piece = Box::new(move || drop(sender.send(work())));
        let thread = self.thread.take().filter(|_| self.running.is_none());
        let thread = thread.map_or_else(new_thread, Ok)?;
        thread.send(piece).map_err(|_| lost())?;
        (self.thread, self.running) = (Some(thread), Some(receiver));
        Ok(())
    }

    /// What became of the piece that was started; none while it takes its time, and where there is none.
    pub fn done(&mut self) -> Option<Result<T, ViewError>> {
        let outcome = match self.running.as_ref()?.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                self.thread = None; // it panicked
                Err(lost())
            }
            Ok(outcome) => outcome,
        };
        self.running = None;
        Some(outcome)
    }
}

fn lost() -> ViewError {
    ViewError::Refused("it could not be made ready".into())
}

fn new_thread() -> Result<mpsc::Sender<Piece>, ViewError> {
    let (sender, pieces) = mpsc::channel::<Piece>();
    thread::Builder::new().name("beside".into()).spawn(move || pieces.iter().for_each(|piece| piece()))?;
    Ok(sender)
}

/// Gives back the memory of what is needed no more: pages of large buffers take a while.
pub fn put_away(what: impl Send + 'static) {
    // Where there is no thread to be had it is given back here.
    let _ = thread::Builder::new().name("put away".into()).spawn(move || drop(what));
}

#[cfg(test)]
mod tests {
    use std::{sync::mpsc, thread, time::Duration};

    use super::Beside;
    use crate::ViewError;

    fn wait<T: Send + 'static>(beside: &mut Beside<T>) -> Result<T, ViewError> {
        loop {
            if let Some(outcome) = beside.done() {
                return outcome;
            }
            thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn outcomes_come_once_and_those_of_pieces_that_were_given_up_never() {
        let mut beside = Beside::default();
        assert!(beside.is_free() && beside.done().is_none());
        let (go, gate) = mpsc::channel::<()>();
        beside.start(move || Ok(gate.recv().map_or(1, |()| 2))).unwrap();
        assert!(!beside.is_free() && beside.done().is_none());
        beside.start(|| Ok(3)).unwrap();
        go.send(()).unwrap();
        assert_eq!(wait(&mut beside).unwrap(), 3);
        assert!(beside.is_free() && beside.done().is_none());
        beside.start(|| Err(ViewError::Refused("no".into()))).unwrap();
        assert_eq!(wait(&mut beside).unwrap_err().to_string(), "no");
    }

    #[test]
    fn a_piece_that_panics_is_told_of() {
        let mut beside = Beside::<()>::default();
        beside.start(|| panic!("on purpose")).unwrap();
        assert!(wait(&mut beside).is_err() && beside.is_free());
        beside.start(|| Ok(())).unwrap();
        wait(&mut beside).unwrap();
    }
}
