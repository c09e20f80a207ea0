//! Scenes with known answers.
