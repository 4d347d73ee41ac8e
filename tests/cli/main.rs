//! The program as a process: what a person or a script types, and what is
//! installed.
#![allow(clippy::unwrap_used)] // What can't be had in a helper fails the test, too.

#[path = "../common/needs.rs"]
mod needs;
#[path = "../common/program.rs"]
mod process;

mod batch;
mod batch_common;
#[cfg(unix)]
mod batch_docs;
#[cfg(unix)]
mod batch_killed;
mod bench;
mod evaluate;
mod export;
mod manual;
#[cfg(target_os = "linux")]
mod packaging;
mod program;
mod ray_cluster;
mod render;
mod shapes;
#[cfg(all(feature = "window", target_os = "linux"))]
mod window;
