//! The program `midway`.
fn main() {}
