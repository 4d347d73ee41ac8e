//! Superform turns a 3D shape into a small number of tapered superquadrics.
//!
//! The crate implements the nonparametric Bayesian shape abstraction of Wu,
//! Liu, Ruan and Chirikjian (*Primitive-based Shape Abstraction via
//! Nonparametric Bayesian Inference*, ECCV 2022) as a library, with the feature
//! `cli` a command line and, with the feature `window`, an interactive desktop
//! viewer.
//!
//! # The map
//!
//! ```text
//! file → io → geometry::SampleCloud → worker(inference) ── Arc<Snapshot> ──▶ session ─▶ ui / render
//!                                          ▲──────────── Command ────────────────┘
//! ```
//!
//! | module | content | may use |
//! |---|---|---|
//! | [`geometry`] | the tapered superquadric, meshes, clouds, sampling, neighbours, metrics | nothing of ours |
//! | [`inference`] | the sampler: seeded, pure, no clock | `geometry` |
//! | [`io`] | reading and writing files | `geometry`, `inference` |
//! | [`worker`] | the background thread and its protocol | `inference`, `io`, `geometry` |
//! | [`session`] | the state behind the window, as plain data | `worker`, `inference`, `io`, `geometry` |
//! | [`project`] | the session file and the recovery journal | `session`, and what it uses |
//! | `render` | wgpu pipelines | `geometry` |
//! | `pictures` | pictures without a window | `project`, `render`, and what they use |
//! | `ui` | egui panels and the viewport | `pictures::frame`, `session`, `render`, `worker`, `inference`, `io`, `geometry` |
//! | `cli` | the command line | `pictures`, `session`, `inference`, `io`, `worker`, `geometry` |
//! | `app` | the window's composition root | all |
//!
//! `tests/repository/architecture.rs` reads this table and fails on a dependency that it
//! does not allow, where the files of a module use one another in a circle, and where they
//! leave the order of the layers that their module's documentation gives.
//!
//! # As a library
//!
//! ```
//! use std::sync::Arc;
//!
//! use superform::geometry::SamplingOptions;
//! use superform::inference::{Cancel, Params, Run};
//! use superform::io;
//!
//! let shape = io::built_in()?; // or io::read("chair.obj".as_ref())?
//! let sampling = SamplingOptions { points: 800, ..SamplingOptions::default() };
//! let cloud = Arc::new(io::sample(&shape, &sampling)?);
//!
//! let (params, cancel) = (Params { iterations: 5, ..Params::default() }, Cancel::default());
//! let mut run = Run::new(cloud, params, &cancel)?;
//! while !run.is_finished() {
//!     run.step(&cancel)?;
//! }
//! let result = run.abstraction();
//! assert!(!result.primitives.is_empty());
//! assert_eq!(result.labels.len(), 800); // for each sample the id of its primitive
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod geometry;
pub mod inference;
pub mod io;
pub mod project;
pub mod session;
pub mod worker;

#[cfg(feature = "cli")]
pub mod cli;

#[cfg(feature = "window")]
pub mod app;
#[cfg(feature = "window")]
pub mod pictures;
#[cfg(feature = "window")]
pub mod render;
#[cfg(feature = "window")]
pub mod ui;
