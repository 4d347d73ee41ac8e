//! Sessions on disk: their file, and the journal of a running window.
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.
#![allow(clippy::print_stdout)] // The child that is killed says how far it has come.

mod autosave;
mod file;
mod material;
