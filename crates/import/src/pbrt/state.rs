//! The graphics state: what directives set and blocks restore.

use std::{collections::HashMap, rc::Rc};

use glam::{DMat4, DVec3};

use super::{
    colours::ColourSpace,
    params::{Param, Params},
};
use crate::ImportError;

/// Blocks within blocks: each holds a state.
const MAX_DEPTH: usize = 1 << 16;

/// What the next shape or light is made with.
#[derive(Clone)]
pub(super) struct State {
    /// World from object; camera from world before `WorldBegin`.
    pub ctm: DMat4,
    pub reverse_orientation: bool,
    /// Index into the materials that have been read.
    pub material: usize,
    pub area_light: Option<Rc<AreaLight>>,
    /// Names of media.
    pub inside: Rc<str>,
    pub colour_space: ColourSpace,
    /// Parameters by `Attribute`, by its target.
    pub defaults: Rc<HashMap<String, Rc<[Param]>>>,
    /// Whether transforms apply to the time at which the shutter opens.
    pub at_start: bool,
}

/// An `AreaLightSource`.
pub(super) struct AreaLight {
    pub index: usize,
    pub params: Params,
    pub colour_space: ColourSpace,
}

impl State {
    pub fn new() -> Self {
        Self {
            ctm: DMat4::IDENTITY,
            reverse_orientation: false,
            material: 0,
            area_light: None,
            inside: "".into(),
            colour_space: ColourSpace::SRGB,
            defaults: Rc::default(),
            at_start: true,
        }
    }

    /// Multiplies the transform from the right.
    pub fn concat(&mut self, m: DMat4) {
        if self.at_start {
            self.ctm *= m;
        }
    }

    pub fn set(&mut self, m: DMat4) {
        if self.at_start {
            self.ctm = m;
        }
    }

    /// Adds `Attribute`'s parameters for a target; those given last come first.
    pub fn add_defaults(&mut self, target: &str, params: Params) {
        let mut all = params.into_list();
        let defaults = Rc::make_mut(&mut self.defaults);
        all.extend(defaults.get(target).into_iter().flat_map(|known| known.iter().cloned()));
        defaults.insert(target.to_owned(), all.into());
    }
}

/// What a block restores.
enum Saved {
    Attributes(State),
    Transform(DMat4),
    Object(State),
}

/// States that blocks will restore.
#[derive(Default)]
pub(super) struct Stack(Vec<Saved>);

impl Stack {
    pub fn push_attributes(&mut self, state: &State, params: &Params) -> Result<(), ImportError> {
        self.push(Saved::Attributes(state.clone()), params)
    }

    pub fn push_transform(&mut self, state: &State, params: &Params) -> Result<(), ImportError> {
        self.push(Saved::Transform(state.ctm), params)
    }

    pub fn push_object(&mut self, state: &State, params: &Params) -> Result<(), ImportError> {
        self.push(Saved::Object(state.clone()), params)
    }

    fn push(&mut self, saved: Saved, params: &Params) -> Result<(), ImportError> {
        if self.0.len() >= MAX_DEPTH {
            let (place, what) = (params.place.clone(), "blocks are nested too deeply".to_owned());
            return Err(ImportError::TooBig { place, what, limit: MAX_DEPTH as u64 });
        }
        self.0.push(saved);
        Ok(())
    }

    pub fn pop_attributes(&mut self, state: &mut State, params: &Params) -> Result<(), ImportError> {
        match self.0.pop() {
            Some(Saved::Attributes(saved)) => *state = saved,
            _ => return Err(params.malformed("AttributeEnd has no AttributeBegin")),
        }
        Ok(())
    }

    pub fn pop_transform(&mut self, state: &mut State, params: &Params) -> Result<(), ImportError> {
        match self.0.pop() {
            Some(Saved::Transform(saved)) => state.ctm = saved,
            _ => return Err(params.malformed("TransformEnd has no TransformBegin")),
        }
        Ok(())
    }

    pub fn pop_object(&mut self, state: &mut State, params: &Params) -> Result<(), ImportError> {
        match self.0.pop() {
            Some(Saved::Object(saved)) => *state = saved,
            _ => return Err(params.malformed("ObjectEnd has no ObjectBegin")),
        }
        Ok(())
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// pbrt's `LookAt`: camera from world, x right, y up, z forward. None where the view has no direction.
pub(super) fn look_at([ex, ey, ez, lx, ly, lz, ux, uy, uz]: [f64; 9]) -> Option<DMat4> {
    let eye = DVec3::new(ex, ey, ez);
    let forward = (DVec3::new(lx, ly, lz) - eye).try_normalize()?;
    let right = DVec3::new(ux, uy, uz).try_normalize()?.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    let world_from_camera =
        DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0));
    Some(world_from_camera.inverse())
}
