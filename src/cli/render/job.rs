//! What to render, and how.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::session::camera::AxisView;
use crate::session::scene::UpAxis;
use crate::session::view::{ColorBy, Layer, SurfaceStyle, View};

/// From where a picture is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Viewpoint {
    /// As the session was left; elsewhere from the usual place.
    AsLeft,
    /// Angles of the eye around the upright axis and above the ground, in degrees.
    Perspective { azimuth: f64, elevation: f64 },
    /// Along an axis, without perspective.
    Along(AxisView),
}

impl Viewpoint {
    /// For names of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::AsLeft | Self::Perspective { .. } => "perspective",
            Self::Along(AxisView::Front) => "front",
            Self::Along(AxisView::Back) => "back",
            Self::Along(AxisView::Right) => "right",
            Self::Along(AxisView::Left) => "left",
            Self::Along(AxisView::Top) => "top",
            Self::Along(AxisView::Bottom) => "bottom",
        }
    }
}

/// What was asked for of the look; the rest is as in the window, or as the
/// session was left.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    pub is_light: bool,
    pub is_transparent: bool,
    pub style: Option<SurfaceStyle>,
    /// All that is shown.
    pub layers: Option<Vec<Layer>>,
    pub color_by: Option<ColorBy>,
    pub point_size: Option<f32>,
    pub up: Option<UpAxis>,
}

impl Look {
    /// The settings of the viewport with those that were asked for.
    pub fn over(&self, mut view: View) -> View {
        // What is told on surfaces is hard to read where they shine through.
        let tells = self.color_by == Some(ColorBy::SurfaceDistance);
        let usual = if tells { SurfaceStyle::Solid } else { view.surface_style };
        view.surface_style = self.style.unwrap_or(usual);
        view.color_by = self.color_by.unwrap_or(view.color_by);
        view.point_size = self.point_size.unwrap_or(view.point_size);
        view.up = self.up.unwrap_or(view.up);
        for layer in Layer::ALL {
            if let Some(layers) = &self.layers {
                view.set_layer(layer, layers.contains(&layer));
            }
        }
        view
    }
}

/// A contact sheet to make.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SheetWish {
    pub path: PathBuf,
    pub columns: Option<u32>,
}

/// A turn around the shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    pub frames: u32,
    /// Of the whole turn.
    pub seconds: f64,
}

/// Pictures to take.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderJob {
    pub inputs: Vec<PathBuf>,
    /// A file, by its ending, or a folder; `None` where only a sheet is wanted.
    pub output: Option<PathBuf>,
    pub sheet: Option<SheetWish>,
    pub turn: Option<Turn>,
    /// At least one.
    pub views: Vec<Viewpoint>,
    /// Of single pictures, and of a sheet's cells.
    pub size: [u32; 2],
    pub cell: [u32; 2],
    pub look: Look,
    pub quiet: bool,
}

impl RenderJob {
    /// Does the job: what was written is told on standard output. The exit
    /// status tells how many results gave no picture.
    #[cfg(feature = "window")]
    pub fn run(&self) -> ExitCode {
        super::work::run(self)
    }

    /// Says why there is no picture.
    #[cfg(not(feature = "window"))]
    pub fn run(&self) -> ExitCode {
        crate::cli::fail(
            "this program was built without a window and cannot render; build it with the feature `window` \
             (cargo build --release)",
        )
    }
}
