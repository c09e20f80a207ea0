//! Packing, integrators as lists of passes, sample scheduling.
