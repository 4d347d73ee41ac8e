//! The window, driven by the labels that a person reads.
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.

mod driver;
#[path = "../common/needs.rs"]
mod needs;

mod edit;
mod export;
mod files;
mod fits;
mod live;
mod looks;
mod manners;
mod merge;
mod pictures;
mod run;
mod seeds;
mod sessions;
mod timeline;
mod understand;
mod viewport;
