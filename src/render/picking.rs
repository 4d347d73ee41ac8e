//! What lies under a pixel, found on the CPU.

use glam::Vec2;

use super::frame::{Frame, PrimitiveInstance};

/// The thing under the pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PickId {
    /// Index into [`PickScene::points`].
    Point(usize),
    /// Id of a primitive.
    Primitive(u32),
}

/// A hit, nearest to the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pick {
    pub id: PickId,
    /// Where the thing was hit, in scene space: the pivot of a double-click.
    pub position: glam::Vec3,
}

/// What can be hit. Borrowed from whoever uploads the same to the renderer.
#[derive(Debug, Clone, Copy, Default)]
pub struct PickScene<'a> {
    pub points: &'a [[f32; 3]],
    /// One a point, or empty; points of alpha 0 are not hit.
    pub point_colors: &'a [[u8; 4]],
    pub primitives: &'a [PrimitiveInstance],
}

/// What `frame` shows at the pixel position `pixel` (physical pixels, y down):
/// the nearest point or primitive of the visible layers, `None` for the
/// background.
pub fn pick(scene: &PickScene<'_>, frame: &Frame, pixel: Vec2) -> Option<Pick> {
    let _ = (scene, frame, pixel);
    None
}
