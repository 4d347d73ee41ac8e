//! Thumbnails of the runs' results, seen from the window's camera.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use egui::{Color32, ColorImage, Painter, Rect, TextureHandle, TextureOptions, Ui, pos2};

use crate::render::Capture;
use crate::session::Session;
use crate::session::camera::Camera;
use crate::session::scene::SceneFromInput;
use crate::session::seeds::SeedResult;
use crate::session::view::{ColorBy, Layer, View};
use crate::ui::scene::SceneView;
use crate::ui::theme;
use crate::ui::viewport::{Shot, Studio};

/// Pixels of a picture: twice those of its place, for dense screens.
const SIZE: [u32; 2] = [264, 192];
/// Larger clouds are left out of the pictures: there are more points than
/// pixels, and each picture would upload them anew.
const MOST_POINTS: usize = 100_000;

/// How a picture was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pose {
    camera: Camera,
    scene: SceneFromInput,
    is_dark: bool,
}

/// The pictures, by the keys of the states that they show.
#[derive(Default)]
pub(super) struct Thumbnails {
    pictures: BTreeMap<u64, (Pose, TextureHandle)>,
    under_way: Option<(u64, Pose, Capture)>,
    /// How things stood in the frame before.
    last: Option<Pose>,
    /// States whose picture failed: not tried again.
    failed: BTreeSet<u64>,
}

impl std::fmt::Debug for Thumbnails {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Thumbnails").field("pictures", &self.pictures.len()).finish_non_exhaustive()
    }
}

impl Thumbnails {
    /// Takes what has become of the picture under way, and begins the next: the
    /// missing ones, and once the camera rests those that it has left behind.
    pub(super) fn advance(&mut self, ui: &Ui, session: &Session, studio: &mut Studio) {
        let pose = Pose { camera: session.camera, scene: session.scene, is_dark: ui.visuals().dark_mode };
        let rests = self.last == Some(pose);
        self.last = Some(pose);
        if let Some((key, of, capture)) = self.under_way.take() {
            match studio.poll(&capture) {
                None => self.under_way = Some((key, of, capture)),
                Some(Ok(image)) => {
                    let size = [image.width() as usize, image.height() as usize];
                    let picture = ColorImage::from_rgba_unmultiplied(size, image.as_raw());
                    let texture =
                        ui.ctx().load_texture(format!("seed {key}"), picture, TextureOptions::LINEAR);
                    self.pictures.insert(key, (of, texture));
                }
                Some(Err(error)) => {
                    tracing::warn!("cannot render a seed's thumbnail: {error}");
                    self.failed.insert(key);
                }
            }
        }
        let results = session.seeds.results();
        let is_present = |key: &u64| results.iter().any(|r| r.last().is_some_and(|s| s.key == *key));
        self.pictures.retain(|key, _| is_present(key));
        self.failed.retain(is_present);
        if self.under_way.is_none() {
            let wanted = results.iter().find(|result| {
                let Some(key) = result.last().map(|s| s.key) else { return false };
                let is_due = match self.pictures.get(&key) {
                    None => true,
                    Some((of, _)) => rests && *of != pose,
                };
                is_due && !self.failed.contains(&key)
            });
            if let Some(result) = wanted {
                self.begin(ui, session, studio, result, pose);
            }
        }
        let is_behind = self.pictures.iter().any(|(key, (of, _))| *of != pose && !self.failed.contains(key));
        if self.under_way.is_some() || is_behind {
            ui.ctx().request_repaint();
        }
    }

    fn begin(&mut self, ui: &Ui, session: &Session, studio: &mut Studio, result: &SeedResult, pose: Pose) {
        let Some(last) = result.last() else { return };
        let mut view: View = session.view;
        view.color_by = ColorBy::Cluster;
        // Points are drawn as in a window of usual height, and should still be seen.
        view.point_size = (2.0 * view.point_size).min(View::POINT_SIZE.1);
        view.set_layer(Layer::Grid, false);
        view.set_layer(Layer::Input, false);
        view.set_layer(Layer::Primitives, true);
        let loaded = &result.run.loaded;
        let none = BTreeSet::new();
        let scene = SceneView {
            loaded: Some(loaded).filter(|l| l.cloud.points.len() <= MOST_POINTS),
            snapshot: Some(last),
            colors: Arc::clone(&result.run.colors),
            view: &view,
            selection: &none,
            selected_points: &Arc::default(),
            hidden: &none,
            scalar: None,
            surface_scalar: None,
            lit: Vec::new(),
            draft: None,
            handles: None,
            ghosts: Vec::new(),
            marked: None,
            ..SceneView::of(session)
        };
        // There is nothing around the shape that the window leaves room for.
        let camera = Camera { distance: 0.8 * pose.camera.distance, ..pose.camera };
        let shot = Shot { size: SIZE, camera, theme: theme::scene(ui), transparent: true };
        match studio.begin(&scene, &shot) {
            Ok(capture) => self.under_way = Some((last.key, pose, capture)),
            Err(error) => {
                tracing::warn!("cannot render a seed's thumbnail: {error}");
                self.failed.insert(last.key);
            }
        }
    }

    /// Paints the picture of a state into its place, if there is one yet.
    pub(super) fn paint(&self, painter: &Painter, key: u64, place: Rect) {
        let Some((_, texture)) = self.pictures.get(&key) else { return };
        let size = texture.size_vec2();
        let scale = (place.width() / size.x).min(place.height() / size.y);
        let rect = Rect::from_center_size(place.center(), size * scale);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(texture.id(), rect, whole, Color32::WHITE);
    }
}
