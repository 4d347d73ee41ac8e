//! The 3D viewport's pictures: wgpu pipelines with a plain [`Frame`] as input.
//!
//! [`Renderer::prepare`] draws into its own multisampled colour and depth
//! textures and combines them into one picture, [`Renderer::paint`] only
//! copies that picture into the caller's render pass, so that the window, the
//! tests and the command line draw along one path. Nothing here knows egui,
//! the session or the sampler.
//!
//! # Scene space
//! Everything handed over is in *scene units*: the caller maps input
//! coordinates to a right-handed space, centred at 0, in which the shape's
//! longest edge is 1. Single precision is enough there, however far from the
//! origin or small the input is.
//!
//! # Colours
//! All colours are sRGB-encoded (what a colour picker shows). Bytes are not
//! premultiplied; a point with alpha 0 is not drawn, one with
//! alpha 128 is selected.

mod blit;
mod capture;
pub mod colormap;
mod composite;
mod error;
mod frame;
mod gpu;
mod grid;
mod lines;
mod mesh;
mod offscreen;
pub mod picking;
mod point_index;
mod points;
pub mod region;
mod renderer;
mod surfaces;

pub use capture::Capture;
pub use error::OffscreenError;
pub use frame::{
    Background, CameraMatrices, Frame, Grid, Highlight, InputStyle, Layers, LineSegment, PrimitiveInstance,
    Ray, SceneTheme, SurfacePaint, SurfaceStyle,
};
pub use offscreen::Offscreen;
pub use picking::{Pick, PickId, PickScene};
pub use point_index::PointIndex;
pub use region::Region;
pub use renderer::{RenderOptions, Renderer};
