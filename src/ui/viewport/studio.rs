//! Offscreen pictures rendered by the window's device: thumbnails, saved pictures, turntables.

use egui_wgpu::wgpu;

use super::frame;
use super::gpu::Gpu;
use crate::render::{Background, Capture, OffscreenError, RenderOptions, SceneTheme};
use crate::session::camera::Camera;
use crate::ui::scene::{Scene, SceneView};

/// Pixels of the largest picture whose textures are kept for the next.
const KEPT: u32 = 1 << 20;
/// Height in logical pixels at which points and lines look as in the window.
const HEIGHT: f32 = 800.0;

/// How a picture is taken.
#[derive(Debug, Clone, Copy)]
pub(in crate::ui) struct Shot {
    /// Physical pixels.
    pub(in crate::ui) size: [u32; 2],
    /// The form of the picture is the picture's own.
    pub(in crate::ui) camera: Camera,
    pub(in crate::ui) theme: SceneTheme,
    /// Without background and grid.
    pub(in crate::ui) transparent: bool,
}

/// Draws any state of any shape with a renderer of its own; it is built with
/// the first picture.
pub(in crate::ui) struct Studio {
    state: egui_wgpu::RenderState,
    gpu: Option<Gpu>,
    scene: Scene,
}

impl std::fmt::Debug for Studio {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Studio").field("is_built", &self.gpu.is_some()).finish_non_exhaustive()
    }
}

impl Studio {
    pub(in crate::ui) fn new(state: &egui_wgpu::RenderState) -> Self {
        Self { state: state.clone(), gpu: None, scene: Scene::default() }
    }

    /// The largest side of a picture, in pixels.
    pub(in crate::ui) fn largest_side(&self) -> u32 {
        self.state.device.limits().max_texture_dimension_2d
    }

    /// Has the device draw a picture; [`Studio::poll`] gives it when it is
    /// there, and nothing waits meanwhile.
    ///
    /// # Errors
    /// Where the size can't be drawn.
    pub(in crate::ui) fn begin(
        &mut self,
        view: &SceneView<'_>,
        shot: &Shot,
    ) -> Result<Capture, OffscreenError> {
        let (device, queue) = (&self.state.device, &self.state.queue);
        self.scene.update(view, None, None);
        let gpu = self.gpu.get_or_insert_with(|| {
            Gpu::new(device, wgpu::TextureFormat::Rgba8Unorm, RenderOptions::default())
        });
        gpu.upload(device, queue, &self.scene);
        let [width, height] = shot.size;
        let camera = Camera { aspect: f64::from(width.max(1)) / f64::from(height.max(1)), ..shot.camera };
        let mut frame = frame::sized(view, &camera, shot.size, height as f32 / HEIGHT, shot.theme);
        if shot.transparent {
            frame.theme.background = Background::Transparent;
            frame.layers.grid = false;
        }
        let capture = Capture::begin(&mut gpu.renderer, device, queue, &frame);
        if width.saturating_mul(height) > KEPT {
            // A large picture's textures are worth hundreds of megabytes.
            gpu.renderer.release();
        }
        capture
    }

    /// A picture that was begun, once it is there.
    pub(in crate::ui) fn poll(&self, capture: &Capture) -> Option<Result<image::RgbaImage, OffscreenError>> {
        capture.poll(&self.state.device)
    }
}
