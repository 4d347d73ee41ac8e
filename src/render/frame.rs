//! What one picture shows: plain data, nothing of the GPU.

use glam::{Mat4, Vec2, Vec3, Vec4, camera::rh};

use crate::geometry::Superquadric;

/// A viewing ray in scene space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    pub origin: Vec3,
    /// Unit length.
    pub direction: Vec3,
}

/// Where the camera stands and how it projects.
///
/// View space is right-handed: x right, y up, the camera looks along −z. Clip
/// depth is *reversed*: 1 at the near plane, 0 at the far plane (or at
/// infinity), which spreads the precision of a float depth buffer evenly.
/// [`CameraMatrices::perspective`] and [`CameraMatrices::orthographic`] build
/// such matrices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraMatrices {
    pub view_from_world: Mat4,
    pub clip_from_view: Mat4,
}

impl CameraMatrices {
    /// Perspective camera at `eye` looking at `target`, with the far plane at
    /// infinity. `fov_y` is the full vertical angle in radians, `aspect` is
    /// width / height, `near` a length in scene units.
    pub fn perspective(eye: Vec3, target: Vec3, up: Vec3, fov_y: f32, aspect: f32, near: f32) -> Self {
        Self {
            view_from_world: rh::view::look_at_mat4(eye, target, up),
            clip_from_view: rh::proj::directx::perspective_infinite_reverse(fov_y, aspect, near),
        }
    }

    /// Orthographic camera at `eye` looking at `target`; `height` is the
    /// height of the picture in scene units. What lies between `near` and
    /// `far` (distances along the view, `near` may be negative) is drawn.
    pub fn orthographic(
        eye: Vec3,
        target: Vec3,
        up: Vec3,
        height: f32,
        aspect: f32,
        near: f32,
        far: f32,
    ) -> Self {
        let (h, w) = (0.5 * height, 0.5 * height * aspect);
        Self {
            view_from_world: rh::view::look_at_mat4(eye, target, up),
            // Near and far exchanged: reversed depth.
            clip_from_view: rh::proj::directx::orthographic(-w, w, -h, h, far, near),
        }
    }

    /// clip_from_world.
    pub fn clip_from_world(&self) -> Mat4 {
        self.clip_from_view * self.view_from_world
    }

    /// Whether all viewing rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        self.clip_from_view.w_axis.w == 1.0
    }

    /// The camera's position in scene space (for an orthographic camera a
    /// point on its axis).
    pub fn eye(&self) -> Vec3 {
        self.view_from_world.inverse().w_axis.truncate()
    }

    /// Unit vector into the picture, in scene space.
    pub fn forward(&self) -> Vec3 {
        -self.view_from_world.inverse().z_axis.truncate().normalize_or_zero()
    }

    /// The viewing ray through a pixel position (y down, from the top left
    /// corner of a picture of `size_px`). An orthographic ray starts at the
    /// plane through the eye, moved back by 100 scene units.
    pub fn ray(&self, pixel: Vec2, size_px: [u32; 2]) -> Ray {
        let size = Vec2::new(size_px[0].max(1) as f32, size_px[1].max(1) as f32);
        let ndc = Vec2::new(2.0 * pixel.x / size.x - 1.0, 1.0 - 2.0 * pixel.y / size.y);
        let p = &self.clip_from_view;
        // x_clip = p00·x + p20·z (+ p30): solved for the view ray by hand, since
        // an infinite projection has no far point to unproject.
        let world_from_view = self.view_from_world.inverse();
        if self.is_orthographic() {
            let x = (ndc.x - p.w_axis.x) / p.x_axis.x;
            let y = (ndc.y - p.w_axis.y) / p.y_axis.y;
            Ray {
                origin: world_from_view.transform_point3(Vec3::new(x, y, 100.0)),
                direction: world_from_view.transform_vector3(Vec3::NEG_Z).normalize_or_zero(),
            }
        } else {
            let x = (ndc.x + p.z_axis.x) / p.x_axis.x;
            let y = (ndc.y + p.z_axis.y) / p.y_axis.y;
            Ray {
                origin: world_from_view.w_axis.truncate(),
                direction: world_from_view.transform_vector3(Vec3::new(x, y, -1.0)).normalize_or_zero(),
            }
        }
    }

    /// Pixel position of a scene point (y down), `None` behind the camera.
    pub fn project(&self, point: Vec3, size_px: [u32; 2]) -> Option<Vec2> {
        let clip = self.clip_from_world() * Vec4::from((point, 1.0));
        (clip.w > 1e-6).then(|| {
            let ndc = clip.truncate().truncate() / clip.w;
            Vec2::new((0.5 + 0.5 * ndc.x) * size_px[0] as f32, (0.5 - 0.5 * ndc.y) * size_px[1] as f32)
        })
    }

    /// Scene units a pixel covers at the depth of `point`: what a gizmo
    /// multiplies its size in pixels with.
    pub fn units_per_pixel(&self, point: Vec3, height_px: u32) -> f32 {
        let w = (self.clip_from_world() * Vec4::from((point, 1.0))).w;
        2.0 * w / (self.clip_from_view.y_axis.y * height_px.max(1) as f32)
    }
}

/// Which layers are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layers {
    pub input: bool,
    pub points: bool,
    pub primitives: bool,
    pub grid: bool,
    /// The segments given to [`super::Renderer::set_lines`].
    pub lines: bool,
}

impl Default for Layers {
    fn default() -> Self {
        Self { input: true, points: true, primitives: true, grid: true, lines: true }
    }
}

/// How primitives are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurfaceStyle {
    /// Lit and opaque.
    Solid,
    /// Lit, lets through what is inside and behind.
    #[default]
    Translucent,
    /// Thin parameter lines; those on the far side are fainter.
    Wire,
}

/// How the input mesh is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InputStyle {
    /// A faint film that is densest at the silhouette.
    #[default]
    Ghost,
    /// Lit and opaque, for when it is shown alone.
    Solid,
}

/// What is behind everything. Colours are RGBA in sRGB encoding, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Background {
    /// From the top edge to the bottom edge.
    Gradient { top: [f32; 4], bottom: [f32; 4] },
    /// Nothing: the picture has (premultiplied) alpha.
    Transparent,
}

/// The ground grid: a plane whose lines fade with the distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// A point of the plane, usually below the shape's lowest point.
    pub origin: Vec3,
    /// Unit axes of the plane, along its lines.
    pub axis_u: Vec3,
    pub axis_v: Vec3,
    /// Distance of two lines in scene units; every tenth line is stronger.
    pub spacing: f32,
    /// Distance from `origin` at which the lines have faded, in scene units.
    pub radius: f32,
}

impl Grid {
    /// Horizontal grid (y up) at the height `y`.
    pub fn horizontal(y: f32, spacing: f32) -> Self {
        Self { origin: Vec3::new(0.0, y, 0.0), axis_u: Vec3::X, axis_v: Vec3::Z, spacing, radius: 2.5 }
    }
}

/// Colours of what is not data. RGBA in sRGB encoding, 0 to 1, alpha not
/// premultiplied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneTheme {
    pub background: Background,
    pub grid: [f32; 4],
    /// The input mesh, alpha = its density face on.
    pub ghost: [f32; 4],
    /// Outline of selected primitives.
    pub selected: [f32; 4],
    /// Outline of the hovered primitive.
    pub hovered: [f32; 4],
    /// Outline of primitives that something is told about.
    pub lit: [f32; 4],
}

impl SceneTheme {
    /// Bright objects on charcoal.
    pub fn dark() -> Self {
        Self {
            background: Background::Gradient {
                top: [0.165, 0.18, 0.205, 1.0],
                bottom: [0.085, 0.092, 0.105, 1.0],
            },
            grid: [0.75, 0.8, 0.88, 0.3],
            ghost: [0.78, 0.84, 0.92, 0.07],
            selected: [1.0, 0.72, 0.22, 1.0],
            hovered: [1.0, 1.0, 1.0, 0.9],
            lit: [0.36, 0.86, 1.0, 1.0],
        }
    }

    /// Paper white with a breath of blue.
    pub fn light() -> Self {
        Self {
            background: Background::Gradient {
                top: [0.985, 0.988, 0.992, 1.0],
                bottom: [0.86, 0.875, 0.895, 1.0],
            },
            grid: [0.2, 0.25, 0.32, 0.24],
            ghost: [0.25, 0.31, 0.4, 0.06],
            selected: [0.93, 0.46, 0.0, 1.0],
            hovered: [0.1, 0.12, 0.15, 0.9],
            lit: [0.0, 0.5, 0.78, 1.0],
        }
    }
}

/// How a primitive stands out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Highlight {
    #[default]
    None,
    /// Under the pointer: outlined in [`SceneTheme::hovered`] and brighter.
    Hovered,
    /// Selected: outlined in [`SceneTheme::selected`].
    Selected,
    /// Told about, such as one of a pair that may be merged: outlined in
    /// [`SceneTheme::lit`].
    Lit,
}

/// One primitive to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrimitiveInstance {
    /// The stable id of the primitive: what picking returns, and the key under
    /// which its tessellation is kept until the shape changes.
    pub id: u32,
    /// Shape and pose in scene units.
    pub shape: Superquadric,
    pub color: [u8; 4],
    pub visible: bool,
    pub highlight: Highlight,
    /// Something that is not there yet: hatched, in the colour of what is
    /// selected, around what is there, and never picked. A ghost may have the
    /// id of a primitive.
    pub ghost: bool,
}

/// Colours of a primitive's surface, one for each vertex that
/// [`surface_vertices`](crate::geometry::tessellate::surface_vertices) gives
/// for [`Resolution::SCREEN`](crate::geometry::tessellate::Resolution::SCREEN),
/// in that order; alpha mixes them over the primitive's own colour.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePaint {
    /// Of the primitive.
    pub id: u32,
    pub colors: Vec<[u8; 4]>,
}

/// A straight line of constant width on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSegment {
    pub from: [f32; 3],
    pub to: [f32; 3],
    pub color: [u8; 4],
    /// Width in logical pixels.
    pub width: f32,
}

/// Everything that decides how one picture looks, apart from the data that was
/// uploaded before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Size of the picture in physical pixels; with a side of 0 nothing is drawn.
    pub size_px: [u32; 2],
    /// Physical pixels a logical pixel: sizes of points and lines are logical.
    pub pixels_per_point: f32,
    pub camera: CameraMatrices,
    pub layers: Layers,
    pub surface_style: SurfaceStyle,
    pub input_style: InputStyle,
    /// Diameter of a point at the scene's centre, in logical pixels.
    pub point_size: f32,
    /// Multiplies the alpha of translucent primitives, 0 to 1.
    pub translucency: f32,
    /// Strength of the depth cues (dark edges and creases), 0 for none, 1 usual.
    pub depth_cues: f32,
    pub grid: Grid,
    pub theme: SceneTheme,
}

impl Frame {
    /// A frame with the usual settings: all layers, translucent primitives,
    /// the dark theme, a grid half a scene unit below the centre.
    pub fn new(size_px: [u32; 2], camera: CameraMatrices) -> Self {
        Self {
            size_px,
            pixels_per_point: 1.0,
            camera,
            layers: Layers::default(),
            surface_style: SurfaceStyle::default(),
            input_style: InputStyle::default(),
            point_size: 4.0,
            translucency: 0.45,
            depth_cues: 1.0,
            grid: Grid::horizontal(-0.5, 0.1),
            theme: SceneTheme::dark(),
        }
    }
}
