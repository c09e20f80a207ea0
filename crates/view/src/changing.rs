//! Changes of the scene that is shown: prepared one at a time on a thread of their own, so that the picture goes
//! on until they are ready.

use midway_scene::Image;

use crate::{
    ViewError,
    beside::Beside,
    engine::{Change, Prepared, Sketch},
    protocol::Surroundings,
};

/// What is told once a change is shown.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// What is around the scene.
    Surroundings,
    /// An environment from a file, and what of this is not used.
    Environment(Vec<String>),
    /// A variant of materials.
    Variant(Option<u32>),
}

/// At most one change that is being prepared, and of each kind that was asked for meanwhile the last.
#[derive(Default)]
pub struct Changing {
    running: Beside<(Prepared, News)>,
    surround: Option<(Surroundings, Option<Image>, News)>,
    dress: Option<(Vec<u32>, Option<u32>)>,
    wanted: Wanted,
}

/// What was asked for and is not shown yet; none where nothing was.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// The environment.
    pub surroundings: Option<Surroundings>,
    /// The variant of materials.
    pub variant: Option<Option<u32>>,
}

impl Changing {
    /// Asks for another strength or turn of the environment.
    pub fn surround(&mut self, surroundings: Surroundings) {
        let (image, news) = match self.surround.take() {
            Some((_, image, news)) => (image, news),
            None => (None, News::Surroundings),
        };
        self.surround = Some((surroundings, image, news));
        self.wanted.surroundings = Some(surroundings);
    }

    /// Asks for another environment.
    pub fn replace(&mut self, image: Image, warnings: Vec<String>) {
        let whole = Surroundings { strength: 1.0, rotation: 0.0 };
        self.surround = Some((whole, Some(image), News::Environment(warnings)));
        self.wanted.surroundings = Some(whole);
    }

    /// Asks for the materials of a variant.
    pub fn dress(&mut self, materials: Vec<u32>, variant: Option<u32>) {
        self.dress = Some((materials, variant));
        self.wanted.variant = Some(variant);
    }

    /// What the scene is to be.
    pub fn wanted(&self) -> Wanted {
        self.wanted
    }

    /// The change that has become ready since this was last asked.
    pub fn ready(&mut self) -> Option<Result<(Prepared, News), ViewError>> {
        let outcome = self.running.done()?;
        self.settle();
        Some(outcome)
    }

    /// Begins with what was asked for, if nothing is being prepared. `sketch`: of the scene as it is shown
    /// now, with all that has become ready.
    ///
    /// # Errors
    /// If the system refuses a thread.
    pub fn go_on(&mut self, sketch: impl FnOnce() -> Sketch) -> Result<(), ViewError> {
        if !self.running.is_free() {
            return Ok(());
        }
        let Some((change, news)) = self.next() else { return Ok(()) };
        let sketch = sketch();
        let started = self.running.start(move || Ok((sketch.prepare(change)?, news)));
        if started.is_err() {
            self.settle();
        }
        started
    }

    /// Where nothing more is asked for the scene is what it is.
    fn settle(&mut self) {
        if self.surround.is_none() && self.dress.is_none() {
            self.wanted = Wanted::default();
        }
    }

    fn next(&mut self) -> Option<(Change, News)> {
        if let Some((materials, variant)) = self.dress.take() {
            return Some((Change::Dress(materials), News::Variant(variant)));
        }
        let (surroundings, image, news) = self.surround.take()?;
        Some((Change::Surround(surroundings, image), news))
    }

    /// Forgets all changes: another scene is shown.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use std::{
        thread,
        time::{Duration, Instant},
    };

    use super::*;
    use crate::engine::tests::{engine, scene};

    /// So that nobody's slider falls back to what there was.
    #[test]
    fn what_is_asked_for_is_wanted_until_it_is_ready() {
        let engine = engine(scene());
        let turned = |rotation: f32| Surroundings { strength: 0.5, rotation };
        let mut changing = Changing::default();
        let mut wanted = Vec::new();
        changing.surround(turned(10.0));
        wanted.push(changing.wanted().surroundings);
        changing.go_on(|| engine.sketch()).unwrap();
        wanted.push(changing.wanted().surroundings);
        changing.surround(turned(20.0));
        for _ in 0..2 {
            let start = Instant::now();
            while changing.ready().is_none() {
                assert!(start.elapsed() < Duration::from_secs(60), "it is never ready");
                thread::sleep(Duration::from_millis(1));
            }
            wanted.push(changing.wanted().surroundings);
            changing.go_on(|| engine.sketch()).unwrap();
        }
        assert_eq!(wanted, [Some(turned(10.0)), Some(turned(10.0)), Some(turned(20.0)), None]);
        changing.dress(Vec::new(), Some(1));
        assert_eq!(changing.wanted().variant, Some(Some(1)));
        changing.forget();
        assert_eq!(changing.wanted().variant, None);
    }
}
