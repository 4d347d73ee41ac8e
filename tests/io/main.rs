//! Files: what is read of them and what is written.
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/formats.rs"]
mod formats;
#[path = "../common/needs.rs"]
mod needs;
#[path = "../common/outcome.rs"]
mod outcome;

mod arrays;
mod clouds;
mod gltf;
mod hard_files;
mod meshes;
mod mutated;
mod odd;
mod python_read_back;
mod read;
mod write;
mod write_formats;
