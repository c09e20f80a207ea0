//! The devices as their users see them. The GPU's half needs an adapter, software will do; without
//! one it says that it did not run, which `MIDWAY_REQUIRE_GPU=1` makes a failure.

mod common;
mod every_device;
mod selection;
