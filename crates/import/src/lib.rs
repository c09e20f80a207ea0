//! Readers of scene files, one per format, with structured warnings.
