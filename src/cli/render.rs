//! `superform render`: renders results without a window.

#[cfg(feature = "window")]
mod inputs;
mod job;
#[cfg(feature = "window")]
mod work;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::names::{is_folder, is_png};
use crate::io;
use crate::session::camera::AxisView;
use crate::session::scene::UpAxis;
use crate::session::view::{ColorBy, Layer, SurfaceStyle, View};

pub use job::{Look, RenderJob, SheetWish, Turn, Viewpoint};

/// Limits of a side of a picture, in pixels.
const SIDE: (u32, u32) = (16, 16_384);
/// Size of a picture, of a turntable's frame and of a sheet's cell.
const PICTURE: [u32; 2] = [1200, 900];
const FRAME: [u32; 2] = [640, 480];
const CELL: [u32; 2] = [480, 360];
/// Limits of the frames of a turntable.
const FRAMES: (u32, u32) = (2, 720);
/// Limits of the seconds of a turn.
const SECONDS: (f64, f64) = (0.1, 600.0);
/// Where the eye stands, in degrees, as in the window.
const AZIMUTH: f64 = 35.0;
const ELEVATION: f64 = 22.0;

#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    /// Folders of runs or batches, files of primitives (JSON, NPZ, CSV), sessions or input shapes
    #[arg(value_name = "RESULT", required = true)]
    inputs: Vec<PathBuf>,
    /// Picture (.png, .gif, - for standard output) or folder for pictures [default: the current
    /// folder, unless --sheet is given]
    #[arg(short, long, value_name = "FILE|DIR")]
    output: Option<PathBuf>,
    /// Print only errors and warnings
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    sheet: SheetArgs,
    #[command(flatten)]
    turntable: TurntableArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
struct CameraArgs {
    /// Picture size in pixels [default: 1200x900; turntable 640x480, sheet cell 480x360]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Views, separated by commas; one picture per view
    #[arg(long, value_name = "VIEW", value_enum, value_delimiter = ',')]
    view: Vec<ViewChoice>,
    /// Camera angle around the up axis in degrees: 0 is the front, 90 the right [default: 35]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = degrees)]
    azimuth: Option<f64>,
    /// Camera angle above the ground in degrees, from -90 to 90 [default: 22]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = degrees)]
    elevation: Option<f64>,
    /// Axis of the input that points up [default: y]
    #[arg(long, value_enum)]
    up: Option<UpChoice>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Appearance")]
struct LookArgs {
    /// Background and text colours
    #[arg(long, value_enum, default_value_t = ThemeChoice::Dark)]
    theme: ThemeChoice,
    /// Without background and ground grid
    #[arg(long)]
    transparent: bool,
    /// How primitives are drawn [default: translucent; solid with --color-by surface]
    #[arg(long, value_enum)]
    style: Option<StyleChoice>,
    /// Layers to draw, separated by commas [default: all]
    #[arg(long, value_name = "LAYERS", value_enum, value_delimiter = ',', conflicts_with = "hide")]
    show: Vec<LayerChoice>,
    /// Layers to hide, separated by commas
    #[arg(long, value_name = "LAYERS", value_enum, value_delimiter = ',')]
    hide: Vec<LayerChoice>,
    /// What colours show [default: cluster]
    #[arg(long, value_enum)]
    color_by: Option<ColorChoice>,
    /// Point diameter from 1 to 12, in pixels at a picture height of 800 [default: 3.5; 6 for an
    /// input cloud]
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true)]
    point_size: Option<f32>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Contact sheet")]
struct SheetArgs {
    /// One picture of all results, with names and metrics
    #[arg(long, value_name = "PNG", conflicts_with = "turntable")]
    sheet: Option<PathBuf>,
    /// Columns of the sheet [default: chosen for an aspect ratio of about 3:2]
    #[arg(long, value_name = "N", requires = "sheet", value_parser = clap::value_parser!(u32).range(1..=1000))]
    columns: Option<u32>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Turntable")]
struct TurntableArgs {
    /// Write a GIF of a full turn with this number of frames, from 2 to 720
    #[arg(
        long, value_name = "FRAMES",
        value_parser = clap::value_parser!(u32).range(i64::from(FRAMES.0)..=i64::from(FRAMES.1))
    )]
    turntable: Option<u32>,
    /// Seconds per turn
    #[arg(long, value_name = "S", requires = "turntable", default_value_t = 6.0)]
    seconds: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ViewChoice {
    /// From --azimuth and --elevation; for a session, from its saved camera
    Perspective,
    Front,
    Right,
    Top,
    Back,
    Left,
    Bottom,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum UpChoice {
    /// As in most OBJ and glTF files
    Y,
    /// As in most scans and CAD files
    Z,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ThemeChoice {
    Dark,
    Light,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum StyleChoice {
    Solid,
    Translucent,
    Wire,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LayerChoice {
    Points,
    Primitives,
    /// The input mesh
    Input,
    /// The ground grid
    Grid,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ColorChoice {
    /// The primitive of each point
    Cluster,
    /// The distance of each point to its primitive, with a legend
    Error,
    /// The distance of the primitives' surfaces to the input, with a legend
    Surface,
    /// The colours of the input file
    Input,
    /// One colour
    Plain,
}

impl RenderArgs {
    /// The job, with all numbers within their limits.
    pub(super) fn resolve(self) -> Result<RenderJob, String> {
        let Self { inputs, output, quiet, camera, look, sheet, turntable } = self;
        let turn = turntable.resolve()?;
        if let Some(output) = output.as_deref() {
            check_name(output, turn.is_some())?;
        }
        let sheet = sheet.sheet.map(|path| SheetWish { path, columns: sheet.columns });
        if let Some(SheetWish { path, .. }) = sheet.as_ref().filter(|sheet| !is_png(&sheet.path)) {
            return Err(format!("a sheet is a PNG file; give {} the ending .png", path.display()));
        }
        let views = camera.views()?;
        let usual = if turn.is_some() { FRAME } else { PICTURE };
        // Beside a sheet, pictures of their own are only made where there is a place for them.
        let output = output.or_else(|| sheet.is_none().then(|| PathBuf::from(".")));
        Ok(RenderJob {
            inputs,
            turn,
            views,
            size: camera.size.unwrap_or(usual),
            cell: camera.size.filter(|_| output.is_none()).unwrap_or(CELL),
            look: look.resolve(camera.up)?,
            output,
            sheet,
            quiet,
        })
    }
}

impl CameraArgs {
    fn views(&self) -> Result<Vec<Viewpoint>, String> {
        let turned = self.azimuth.or(self.elevation).is_some();
        let perspective = if turned {
            let elevation = self.elevation.unwrap_or(ELEVATION);
            if !(-90.0..=90.0).contains(&elevation) {
                return Err(format!("the elevation is {elevation}, but must be between -90 and 90 degrees"));
            }
            Viewpoint::Perspective { azimuth: self.azimuth.unwrap_or(AZIMUTH), elevation }
        } else {
            Viewpoint::AsLeft
        };
        if turned && !self.view.is_empty() && !self.view.contains(&ViewChoice::Perspective) {
            return Err("--azimuth and --elevation apply to the perspective view; add perspective \
                 to --view or omit --view"
                .to_owned());
        }
        let mut views = Vec::new();
        for choice in &self.view {
            let view = match choice {
                ViewChoice::Perspective => perspective,
                ViewChoice::Front => Viewpoint::Along(AxisView::Front),
                ViewChoice::Right => Viewpoint::Along(AxisView::Right),
                ViewChoice::Top => Viewpoint::Along(AxisView::Top),
                ViewChoice::Back => Viewpoint::Along(AxisView::Back),
                ViewChoice::Left => Viewpoint::Along(AxisView::Left),
                ViewChoice::Bottom => Viewpoint::Along(AxisView::Bottom),
            };
            if !views.contains(&view) {
                views.push(view);
            }
        }
        if views.is_empty() {
            views.push(perspective);
        }
        Ok(views)
    }
}

impl LookArgs {
    fn resolve(self, up: Option<UpChoice>) -> Result<Look, String> {
        let (least, most) = View::POINT_SIZE;
        if let Some(size) = self.point_size.filter(|size| !(least..=most).contains(size)) {
            return Err(format!("the point size is {size}, but must be between {least} and {most}"));
        }
        let layer = |choice: &LayerChoice| match choice {
            LayerChoice::Points => Layer::Points,
            LayerChoice::Primitives => Layer::Primitives,
            LayerChoice::Input => Layer::Input,
            LayerChoice::Grid => Layer::Grid,
        };
        let hidden: Vec<Layer> = self.hide.iter().map(layer).collect();
        let layers = if !self.show.is_empty() {
            Some(self.show.iter().map(layer).collect())
        } else if !hidden.is_empty() {
            Some(Layer::ALL.into_iter().filter(|layer| !hidden.contains(layer)).collect())
        } else {
            None
        };
        Ok(Look {
            is_light: self.theme == ThemeChoice::Light,
            is_transparent: self.transparent,
            style: self.style.map(|style| match style {
                StyleChoice::Solid => SurfaceStyle::Solid,
                StyleChoice::Translucent => SurfaceStyle::Translucent,
                StyleChoice::Wire => SurfaceStyle::Wire,
            }),
            layers,
            color_by: self.color_by.map(|by| match by {
                ColorChoice::Cluster => ColorBy::Cluster,
                ColorChoice::Error => ColorBy::OwnDistance,
                ColorChoice::Surface => ColorBy::SurfaceDistance,
                ColorChoice::Input => ColorBy::Input,
                ColorChoice::Plain => ColorBy::Plain,
            }),
            point_size: self.point_size,
            up: up.map(|up| match up {
                UpChoice::Y => UpAxis::Y,
                UpChoice::Z => UpAxis::Z,
            }),
        })
    }
}

impl TurntableArgs {
    fn resolve(&self) -> Result<Option<Turn>, String> {
        let Some(frames) = self.turntable else { return Ok(None) };
        let (least, most) = SECONDS;
        if !(least..=most).contains(&self.seconds) {
            return Err(format!(
                "a turn takes {} seconds, but must take between {least} and {most}",
                self.seconds
            ));
        }
        Ok(Some(Turn { frames, seconds: self.seconds }))
    }
}

/// # Errors
/// Where a name is neither that of a folder nor that of a picture that can be
/// written.
fn check_name(output: &Path, is_turntable: bool) -> Result<(), String> {
    if is_folder(output) || io::is_written_through(output) {
        return Ok(());
    }
    match (ending_of(output).as_deref(), is_turntable) {
        (None, _) | (Some("png"), false) | (Some("gif"), true) => Ok(()),
        (Some("png"), true) => Err("a turntable is a GIF file; use the ending .gif".to_owned()),
        (Some("gif"), false) => {
            Err("a picture is a PNG file; use the ending .png, or add --turntable".to_owned())
        }
        (Some(ending), _) => {
            let shown = output.display();
            Err(format!(
                "pictures are written as .png and turntables as .gif, but {shown} ends with .{ending}; for \
                 a folder of that name write {shown}/"
            ))
        }
    }
}

/// The ending of a name in small letters, unless it is rather a part of the name,
/// as of `2.5`.
fn ending_of(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_string_lossy().to_ascii_lowercase();
    ending.starts_with(|c: char| !c.is_ascii_digit()).then_some(ending)
}

/// "1200x900", also with ×.
fn size(text: &str) -> Result<[u32; 2], String> {
    let (least, most) = SIDE;
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| (least..=most).contains(side));
    let sides = text.split_once(['x', 'X', '×', '*']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    sides.ok_or_else(|| {
        format!("expected width and height in pixels, {least} to {most} each, such as 1200x900")
    })
}

fn degrees(text: &str) -> Result<f64, String> {
    let number = text.trim_end_matches('°').parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "expected an angle in degrees".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Cli, Request};
    use clap::Parser as _;

    fn job(args: &[&str]) -> Result<RenderJob, String> {
        let args = ["superform", "render"].iter().chain(args);
        match Cli::try_parse_from(args).map_err(|e| e.to_string())?.request()? {
            Request::Render(job) => Ok(job),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn all_options_arrive() {
        let plain = job(&["out"]).unwrap();
        assert_eq!((plain.size, plain.views.as_slice()), (PICTURE, &[Viewpoint::AsLeft][..]));
        assert_eq!(plain.output, Some(PathBuf::from(".")));
        assert_eq!(plain.look.over(View::default()), View::default());
        let full = job(&[
            "a",
            "b",
            "-o",
            "pictures",
            "--size",
            "640×480",
            "--view",
            "front,perspective,front",
            "--azimuth",
            "-20",
            "--elevation",
            "10",
            "--theme",
            "light",
            "--transparent",
            "--style",
            "wire",
            "--hide",
            "grid,points",
            "--color-by",
            "surface",
            "--up",
            "z",
            "--point-size",
            "5",
        ])
        .unwrap();
        assert_eq!(full.size, [640, 480]);
        let turned = Viewpoint::Perspective { azimuth: -20.0, elevation: 10.0 };
        assert_eq!(full.views, [Viewpoint::Along(AxisView::Front), turned]);
        let view = full.look.over(View::default());
        let shown = Layer::ALL.map(|layer| view.shows(layer));
        assert_eq!(shown, [true, false, true, false], "input and primitives");
        assert_eq!((view.color_by, view.up, view.point_size), (ColorBy::SurfaceDistance, UpAxis::Z, 5.0));
        assert!(full.look.is_light && full.look.is_transparent);
        assert_eq!(view.surface_style, SurfaceStyle::Wire);
    }

    #[test]
    fn sheets_and_turntables_have_sizes_of_their_own() {
        let sheet = job(&["out", "--sheet", "all.png", "--columns", "4"]).unwrap();
        assert_eq!((sheet.output, sheet.cell), (None, CELL));
        let large = job(&["out", "--sheet", "all.png", "--size", "300x300"]).unwrap();
        assert_eq!(large.cell, [300, 300]);
        let both = job(&["out", "--sheet", "all.png", "-o", "pictures", "--size", "300x200"]).unwrap();
        assert_eq!((both.size, both.cell), ([300, 200], CELL));
        let turn = job(&["out", "--turntable", "36", "-o", "turn.gif"]).unwrap();
        assert_eq!((turn.size, turn.turn), (FRAME, Some(Turn { frames: 36, seconds: 6.0 })));
    }

    #[test]
    fn what_makes_no_sense_is_refused_with_its_reason() {
        for (args, word) in [
            (&["out", "--size", "10x10"][..], "16 to 16384"),
            (&["out", "--size", "big"], "such as 1200x900"),
            (&["out", "--azimuth", "nan"], "angle in degrees"),
            (&["out", "--elevation", "100"], "between -90 and 90"),
            (&["out", "--azimuth", "10", "--view", "front"], "perspective"),
            (&["out", "--point-size", "40"], "between 1 and 12"),
            (&["out", "-o", "a.gif"], "--turntable"),
            (&["out", "-o", "a.png", "--turntable", "10"], ".gif"),
            (&["out", "--turntable", "1"], "2..=720"),
            (&["out", "--turntable", "10", "--seconds", "0"], "between 0.1"),
            (&["out", "--sheet", "all.jpg"], ".png"),
            (&["out", "--sheet", "a.png", "--turntable", "10"], "cannot be used with"),
            (&["out", "--show", "points", "--hide", "grid"], "cannot be used with"),
            (&["out", "--columns", "3"], "--sheet"),
            (&[], "RESULT"),
        ] {
            let problem = job(args).unwrap_err();
            assert!(problem.contains(word), "{args:?}: {problem}");
        }
    }
}
