//! Runs the built program: its exit codes, its words, its files.

mod bad_input;
mod benching;
mod comparing;
mod rendering;
mod showing;
mod support;
mod variants;
