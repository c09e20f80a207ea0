//! Midway's proofs: tests that span several rooms.
