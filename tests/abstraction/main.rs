//! From points to primitives: samples, surfaces, the sampler's results and the
//! worker that runs it.
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.

#[path = "../common/mod.rs"]
mod common;

mod hard;
mod invariance;
mod isolated;
mod sampling;
mod tessellation;
mod trade;
mod worker;
