//! What the repository says of itself is so.
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.

mod architecture;
mod code;
mod docs;
mod guide;
mod licences;
