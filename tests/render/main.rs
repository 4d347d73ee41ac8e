//! What the renderer draws, and what lies under the pointer.
#![cfg(feature = "window")]
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.

#[path = "../common/needs.rs"]
mod needs;

mod picking;
mod pictures;
mod regions;
mod validation;
