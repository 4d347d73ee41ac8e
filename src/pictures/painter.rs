//! The one who draws: a driver without a display, and what it was given.

use nalgebra::Point3;
use rayon::prelude::*;

use super::frame;
use super::framing;
use super::legend::{self, Legend};
use super::lettering::Lettering;
use super::subject::Subject;
use super::theme::Theme;
use crate::geometry::metrics::Nearest;
use crate::geometry::palette::UNASSIGNED_COLOR;
use crate::inference::Abstraction;
use crate::io::ShapeGeometry;
use crate::render::colormap::viridis;
use crate::render::{
    Background, Highlight, InputStyle, Offscreen, OffscreenError, PrimitiveInstance, RenderOptions,
    SurfacePaint,
};
use crate::session::camera::Camera;
use crate::session::paint::{Paint, shown_colors, shown_points};
use crate::session::scalar::{Scalar, SurfaceScalar, nearest_distances, own_distances, surface_distances};
use crate::session::scene::SceneFromInput;
use crate::session::view::{ColorBy, Layer, View};

/// Height in pixels at which points, lines and text are as large as in the
/// window.
const HEIGHT: f32 = 800.0;

/// Draws without a display.
#[derive(Debug)]
pub struct Painter {
    offscreen: Offscreen,
    lettering: Lettering,
}

/// A subject that the painter was given: all that a picture takes but the camera.
#[derive(Debug)]
pub struct Stage {
    view: View,
    theme: Theme,
    is_transparent: bool,
    scene: SceneFromInput,
    input_style: InputStyle,
    /// What is shown, in scene units.
    content: Vec<Point3<f64>>,
    legend: Option<Legend>,
}

impl Stage {
    /// The camera in the direction and of the kind of `camera`, from where all
    /// that is shown fills a picture of that size.
    pub fn framed(&self, camera: Camera, size: [u32; 2]) -> Camera {
        let mut camera = Camera { aspect: aspect(size), ..camera };
        framing::fill(&mut camera, &self.content);
        camera
    }

    /// The cameras of a whole turn around the upright axis, in so many steps, all
    /// equally far.
    pub fn turntable(&self, camera: Camera, size: [u32; 2], steps: u32) -> Vec<Camera> {
        let mut camera = Camera { aspect: aspect(size), ..camera };
        framing::fill_turn(&mut camera, &self.content, steps);
        (0..steps).map(|step| framing::turned(&camera, step, steps)).collect()
    }
}

fn aspect([width, height]: [u32; 2]) -> f64 {
    f64::from(width.max(1)) / f64::from(height.max(1))
}

impl Painter {
    /// Opens the best graphics driver; no display is needed.
    ///
    /// # Errors
    /// Where there is none.
    pub fn new() -> Result<Self, OffscreenError> {
        Ok(Self { offscreen: Offscreen::new(RenderOptions::default())?, lettering: Lettering::default() })
    }

    /// Hands the subject to the driver, in place of the last one. A transparent
    /// picture has no background and no grid.
    pub fn take(&mut self, subject: &Subject, view: &View, theme: Theme, is_transparent: bool) -> Stage {
        let scene = subject.scene(view.up);
        let told = told(subject, view.color_by, &scene);
        let to_scene = |p: &Point3<f64>| -> [f32; 3] { scene.point(p).coords.map(|c| c as f32).into() };
        let loaded = &subject.loaded;
        let points: Vec<[f32; 3]> = shown_points(loaded).par_iter().map(to_scene).collect();
        let has_points = view.shows(Layer::Points) && !points.is_empty();
        let has_primitives = view.shows(Layer::Primitives) && !subject.primitives().is_empty();
        let labels = subject.state.as_ref().map_or(&[][..], |state| &state.labels);
        let pinned = subject.state.as_ref().map_or(&[][..], |state| &state.pinned);
        let paint = match &told {
            ColorValues::Points(scalar) => Paint::Scalar(scalar, viridis),
            ColorValues::Surfaces(_) => Paint::Plain,
            ColorValues::Nothing => match view.color_by {
                ColorBy::Input => Paint::Input,
                ColorBy::Plain => Paint::Plain,
                _ if subject.has_labels() => Paint::Clusters(&subject.colors),
                _ if subject.has_input_colors() => Paint::Input,
                _ => Paint::Plain,
            },
        };
        let mut colors = shown_colors(loaded, labels, &subject.hidden, &[], pinned, paint);
        if let (Paint::Plain, Theme::Light) = (paint, theme) {
            // The usual grey is lost on paper white.
            let [r, g, b] = theme.weak();
            colors
                .par_iter_mut()
                .filter(|color| color[3] != 0)
                .for_each(|color| *color = [r, g, b, color[3]]);
        }
        let is_grey = matches!(told, ColorValues::Points(_));
        let primitives: Vec<PrimitiveInstance> = subject
            .primitives()
            .iter()
            .filter(|primitive| primitive.shape.is_valid())
            .map(|primitive| {
                let [r, g, b] = if is_grey { UNASSIGNED_COLOR } else { subject.colors.of(primitive.id) };
                PrimitiveInstance {
                    id: primitive.id,
                    shape: scene.shape(&primitive.shape),
                    color: [r, g, b, 255],
                    visible: !subject.hidden.contains(&primitive.id),
                    highlight: Highlight::None,
                    ghost: false,
                }
            })
            .collect();
        let (renderer, device, queue) = self.offscreen.parts();
        renderer.set_points(device, queue, &points);
        renderer.set_point_colors(queue, &colors);
        match &loaded.shape.geometry {
            ShapeGeometry::Mesh(mesh) => {
                let vertices: Vec<[f32; 3]> = mesh.vertices.par_iter().map(to_scene).collect();
                renderer.set_mesh(device, queue, &vertices, &mesh.faces);
            }
            ShapeGeometry::Cloud(_) => renderer.set_mesh(device, queue, &[], &[]),
        }
        renderer.set_primitives(device, queue, &primitives);
        renderer.set_paint(device, queue, &told.paint());

        let points_shown = has_points && view.color_by != ColorBy::SurfaceDistance;
        let is_alone = !points_shown && !has_primitives;
        let shows = [view.shows(Layer::Input), points_shown, has_primitives];
        let mut content = subject.content(shows);
        content.par_iter_mut().for_each(|p| *p = scene.point(p));
        if content.is_empty() {
            content.extend(scene.bounds.corners());
        }
        Stage {
            view: *view,
            theme,
            is_transparent,
            scene,
            input_style: if is_alone { InputStyle::Solid } else { InputStyle::Ghost },
            content,
            legend: told.legend(),
        }
    }

    /// Draws what was taken last, which gave the stage. The pixels have straight
    /// (not premultiplied) alpha; where colours tell numbers, a legend says which.
    ///
    /// # Errors
    /// Where the size can't be drawn or the driver gives no picture.
    pub fn picture(
        &mut self,
        stage: &Stage,
        camera: &Camera,
        size: [u32; 2],
    ) -> Result<image::RgbaImage, OffscreenError> {
        let scale = size[1] as f32 / HEIGHT;
        let theme = stage.theme.scene();
        let mut frame = frame::sized(&stage.view, &stage.scene, camera, size, scale, theme);
        frame.input_style = stage.input_style;
        if stage.is_transparent {
            frame.theme.background = Background::Transparent;
            frame.layers.grid = false;
        }
        let mut picture = self.offscreen.render(&frame)?;
        if let Some(legend) = &stage.legend {
            legend::draw(&mut picture, &mut self.lettering, legend, stage.theme, scale);
        }
        Ok(picture)
    }

    /// What writes on pictures.
    pub(super) fn lettering(&mut self) -> &mut Lettering {
        &mut self.lettering
    }
}

/// The numbers that colours tell.
enum ColorValues {
    Nothing,
    Points(Scalar),
    Surfaces(SurfaceScalar),
}

impl ColorValues {
    /// Of the primitives' surfaces.
    fn paint(&self) -> Vec<SurfacePaint> {
        let Self::Surfaces(scalar) = self else { return Vec::new() };
        let color = |&value: &f32| {
            let [r, g, b] = viridis(scalar.share(value));
            [r, g, b, if value.is_nan() { 0 } else { 255 }]
        };
        let of_one = |(id, values): &(u32, Vec<f32>)| SurfacePaint {
            id: *id,
            colors: values.iter().map(color).collect(),
        };
        scalar.values.iter().map(of_one).collect()
    }

    fn legend(&self) -> Option<Legend> {
        let (title, range, is_cut) = match self {
            Self::Nothing => return None,
            Self::Points(s) => (&s.title, s.range, s.exceeds_range()),
            Self::Surfaces(s) => (&s.title, s.range, s.exceeds_range()),
        };
        Some(Legend { title: title.clone(), range, is_cut })
    }
}

/// What can be told of a single state; clusters stand in for what takes several.
fn told(subject: &Subject, by: ColorBy, scene: &SceneFromInput) -> ColorValues {
    let state: Option<&Abstraction> = subject.state.as_ref().filter(|s| !s.primitives.is_empty());
    let Some(state) = state else { return ColorValues::Nothing };
    let samples = &subject.loaded.cloud.points;
    match by {
        ColorBy::OwnDistance if subject.has_labels() => {
            let distances = own_distances(samples, state, scene);
            ColorValues::Points(Scalar::from_zero("Distance to own primitive", distances))
        }
        ColorBy::NearestDistance if !samples.is_empty() => {
            let distances = nearest_distances(samples, state, scene);
            ColorValues::Points(Scalar::from_zero("Distance to nearest primitive", distances))
        }
        ColorBy::SurfaceDistance => {
            let nearest = match &subject.loaded.shape.geometry {
                ShapeGeometry::Mesh(mesh) => Nearest::of_mesh(mesh),
                ShapeGeometry::Cloud(cloud) => Nearest::of_cloud(&cloud.points),
            };
            nearest.map_or(ColorValues::Nothing, |nearest| {
                let distances = surface_distances(&state.primitives, &nearest);
                ColorValues::Surfaces(SurfaceScalar::from_zero("Distance to input", distances))
            })
        }
        _ => ColorValues::Nothing,
    }
}
