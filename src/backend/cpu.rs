//! The CPU backend: every stage on all cores (rayon).
