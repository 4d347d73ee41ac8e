//! Handles that move, rotate, scale, taper and round a primitive: their geometry, and the effect of
//! a drag. Everything is in scene space; screen positions are in logical pixels from the viewport's
//! upper left corner.
//!
//! A drag is given by its start and its current position, always relative to the primitive at the
//! start of the drag: errors do not accumulate, and dragging back restores the primitive.

use nalgebra::{Point3, Rotation3, Unit, UnitQuaternion, Vector2, Vector3};

use super::camera::Camera;
use crate::geometry::Superquadric;
use crate::geometry::theta::Bounds;

mod screen;
#[cfg(test)]
mod tests;

pub use screen::Screen;

/// The least semi-axis, in scene units.
const LEAST_AXIS: f64 = 1e-4;
/// The most.
const MOST_AXIS: f64 = 1e3;

/// Logical pixels: length of an arrow, radius of the rings, and of the ring
/// that turns around the line of sight.
const ARROW: f64 = 72.0;
const RING: f64 = 62.0;
const OUTER_RING: f64 = 76.0;
/// Position and size of the squares for moving in a plane.
const PLANE: (f64, f64) = (20.0, 13.0);
/// Distance of the scale handles from the surface.
const STAND_OFF: f64 = 14.0;
/// Picking radius.
const REACH: f64 = 8.0;
/// Planes seen nearly edge-on and axes seen nearly end-on cannot be dragged.
const EDGE_ON: f64 = 0.06;
const RING_POINTS: usize = 64;

/// What the handles change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Mode {
    #[default]
    Move,
    Rotate,
    Scale,
    Taper,
    Roundness,
}

impl Mode {
    pub const ALL: [Self; 5] = [Self::Move, Self::Rotate, Self::Scale, Self::Taper, Self::Roundness];

    pub fn text(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Rotate => "Rotate",
            Self::Scale => "Scale",
            Self::Taper => "Taper",
            Self::Roundness => "Roundness",
        }
    }
}

/// A draggable handle. Axes are the primitive's own, 0 to 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Handle {
    MoveAxis(usize),
    /// In the plane across the axis.
    MovePlane(usize),
    /// In the plane of the screen.
    MoveFree,
    RotateAxis(usize),
    /// Around the line of sight.
    RotateView,
    ScaleAxis(usize),
    ScaleUniform,
    /// kx or ky.
    Taper(usize),
    /// ε1 or ε2.
    Exponent(usize),
}

impl Handle {
    /// The axis in whose colour the handle is drawn.
    pub fn axis(self) -> Option<usize> {
        match self {
            Self::MoveAxis(axis)
            | Self::MovePlane(axis)
            | Self::RotateAxis(axis)
            | Self::ScaleAxis(axis)
            | Self::Taper(axis) => Some(axis),
            // ε1 is the profile's, along z; ε2 the section's, across it.
            Self::Exponent(0) => Some(2),
            Self::Exponent(_) => Some(0),
            Self::MoveFree | Self::RotateView | Self::ScaleUniform => None,
        }
    }

    /// Display name.
    pub fn text(self) -> String {
        let axis = |i: usize| ["x", "y", "z"].get(i).copied().unwrap_or("?");
        match self {
            Self::MoveAxis(i) => format!("Move along {}", axis(i)),
            Self::MovePlane(i) => format!("Move across {}", axis(i)),
            Self::MoveFree => "Move freely".to_owned(),
            Self::RotateAxis(i) => format!("Rotate around {}", axis(i)),
            Self::RotateView => "Rotate around the line of sight".to_owned(),
            Self::ScaleAxis(i) => format!("Semi-axis a{}", axis(i)),
            Self::ScaleUniform => "Scale evenly".to_owned(),
            Self::Taper(i) => format!("Taper k{}", axis(i)),
            Self::Exponent(i) => format!("Roundness ε{}", i + 1),
        }
    }
}

/// Shape of a handle on the screen.
#[derive(Debug, Clone, PartialEq)]
pub enum Figure {
    /// From the primitive's centre.
    Arrow(Vector2<f64>, Vector2<f64>),
    /// Four corners.
    Square([Vector2<f64>; 4]),
    /// A closed line, with a flag per segment for facing the camera.
    Ring(Vec<(Vector2<f64>, bool)>),
    /// A knob, with a line from where it stands.
    Knob { from: Vector2<f64>, at: Vector2<f64> },
    /// A circle, of this radius.
    Circle(Vector2<f64>, f64),
}

/// A handle with its figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    pub handle: Handle,
    pub figure: Figure,
}

/// The handles of one primitive, as a camera sees them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gizmo {
    /// In scene units.
    pub shape: Superquadric,
    pub mode: Mode,
    pub screen: Screen,
}

/// The angle of the turn from one rotation to the other, in [0, π]. (That of the
/// matrices is not a number where rounding leaves their trace above 3.)
pub fn angle_between(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    UnitQuaternion::from_rotation_matrix(&(a.inverse() * b)).angle()
}

impl Gizmo {
    /// `size` of the viewport in logical pixels.
    pub fn new(shape: Superquadric, mode: Mode, camera: &Camera, size: Vector2<f64>) -> Self {
        Self { shape, mode, screen: Screen::new(camera, size) }
    }

    /// All handles that can be dragged now, in drawing order. None if the
    /// primitive's centre is behind the camera.
    pub fn parts(&self) -> Vec<Part> {
        let Some(center) = self.screen.pixel(&self.center()) else { return Vec::new() };
        let unit = self.screen.units_per_pixel(&self.center());
        let mut parts = Vec::new();
        let mut add = |handle, figure: Option<Figure>| {
            parts.extend(figure.map(|figure| Part { handle, figure }));
        };
        match self.mode {
            Mode::Move => {
                add(Handle::MoveFree, Some(Figure::Circle(center, 7.0)));
                for axis in 0..3 {
                    add(Handle::MovePlane(axis), self.square(axis, unit));
                }
                for axis in 0..3 {
                    let tip = self.center() + *self.axis(axis) * (ARROW * unit);
                    let tip = self.screen.pixel(&tip).filter(|_| !self.is_along_sight(axis));
                    add(Handle::MoveAxis(axis), tip.map(|tip| Figure::Arrow(center, tip)));
                }
            }
            Mode::Rotate => {
                add(Handle::RotateView, Some(Figure::Circle(center, OUTER_RING)));
                for axis in 0..3 {
                    add(Handle::RotateAxis(axis), self.ring(axis, unit));
                }
            }
            Mode::Scale => {
                add(Handle::ScaleUniform, Some(Figure::Circle(center, 0.5 * ARROW)));
                for axis in 0..3 {
                    let surface = self.center() + *self.axis(axis) * self.shape.semi_axes[axis];
                    let at = surface + *self.axis(axis) * (STAND_OFF * self.screen.units_per_pixel(&surface));
                    add(Handle::ScaleAxis(axis), self.knob(&surface, &at, self.is_along_sight(axis)));
                }
            }
            Mode::Taper => {
                for axis in 0..2 {
                    let top = self.world(&(Vector3::z() * self.shape.semi_axes.z));
                    add(
                        Handle::Taper(axis),
                        self.knob(&top, &self.taper_place(axis), self.is_along_sight(axis)),
                    );
                }
            }
            Mode::Roundness => {
                for which in 0..2 {
                    let at = self.exponent_place(which, self.shape.exponents[which]);
                    add(Handle::Exponent(which), self.knob(&self.center(), &at, false));
                }
            }
        }
        parts
    }

    /// The handle under the pointer: the nearest one, or of equally near ones the topmost.
    pub fn hit(&self, pointer: Vector2<f64>) -> Option<Handle> {
        let distances = self.parts().into_iter().map(|p| (p.figure.distance(pointer), p.handle));
        distances.filter(|(d, _)| *d <= REACH).reduce(|a, b| if b.0 <= a.0 { b } else { a }).map(|(_, h)| h)
    }

    /// The primitive after dragging a handle, within its limits; unchanged if
    /// the drag has no solution.
    pub fn drag(&self, handle: Handle, from: Vector2<f64>, to: Vector2<f64>) -> Superquadric {
        let dragged = self.dragged(handle, from, to).unwrap_or(self.shape);
        if dragged.is_valid() { dragged } else { self.shape }
    }

    fn dragged(&self, handle: Handle, from: Vector2<f64>, to: Vector2<f64>) -> Option<Superquadric> {
        let mut shape = self.shape;
        match handle {
            Handle::MoveAxis(axis) => {
                let step = self.step_along(axis, &self.center(), from, to)?;
                shape.translation += self.axis(axis).into_inner() * step;
            }
            Handle::MovePlane(axis) => shape.translation += self.step_across(&self.axis(axis), from, to)?,
            Handle::MoveFree => {
                let sight = Unit::new_normalize(self.screen.forward());
                shape.translation += self.step_across(&sight, from, to)?;
            }
            Handle::RotateAxis(axis) => {
                let normal = self.axis(axis);
                let angle = match self.angle_in_plane(&normal, from, to) {
                    Some(angle) => angle,
                    // Seen from the side the ring is a line: it rolls.
                    None => self.roll(&normal, from, to)?,
                };
                shape = self.turned(&normal, angle);
            }
            Handle::RotateView => {
                let center = self.screen.pixel(&self.center())?;
                let (a, b) = (from - center, to - center);
                // y grows downwards on the screen.
                let angle = -(a.x * b.y - a.y * b.x).atan2(a.dot(&b));
                shape = self.turned(&Unit::new_normalize(-self.screen.sight(&self.center())), angle);
            }
            Handle::ScaleAxis(axis) => {
                let surface = self.center() + *self.axis(axis) * shape.semi_axes[axis];
                let step = self.step_along(axis, &surface, from, to)?;
                shape.semi_axes[axis] = (shape.semi_axes[axis] + step).clamp(LEAST_AXIS, MOST_AXIS);
            }
            Handle::ScaleUniform => {
                let center = self.screen.pixel(&self.center())?;
                let factor = (to - center).norm() / (from - center).norm().max(1.0);
                // One factor for all, as far as all keep their limits.
                let least = LEAST_AXIS / shape.semi_axes.min();
                let most = MOST_AXIS / shape.semi_axes.max();
                shape.semi_axes *= factor.clamp(least.min(1.0), most.max(1.0));
            }
            Handle::Taper(axis) => {
                let step = self.step_along(axis, &self.taper_place(axis), from, to)?;
                let taper = shape.taper.get_mut(axis)?;
                *taper =
                    (*taper + step / shape.semi_axes[axis]).clamp(Bounds::FITS.taper.0, Bounds::FITS.taper.1);
            }
            Handle::Exponent(which) => {
                let held = self.screen.pixel(&self.exponent_place(which, *shape.exponents.get(which)?))?;
                *shape.exponents.get_mut(which)? = self.nearest_exponent(which, held + to - from);
            }
        }
        Some(shape)
    }

    fn center(&self) -> Point3<f64> {
        Point3::from(self.shape.translation)
    }

    /// One of the primitive's own axes.
    fn axis(&self, axis: usize) -> Unit<Vector3<f64>> {
        Unit::new_normalize(self.shape.rotation * Vector3::ith(axis, 1.0))
    }

    fn world(&self, local: &Vector3<f64>) -> Point3<f64> {
        Point3::from(self.shape.rotation * local + self.shape.translation)
    }

    /// Where the upper edge of the body's box is, along the axis that tapers:
    /// ax·(1 + kx) at the top.
    fn taper_place(&self, axis: usize) -> Point3<f64> {
        let taper = self.shape.taper.get(axis).copied().unwrap_or(0.0);
        let mut local = Vector3::z() * self.shape.semi_axes.z;
        local[axis] = self.shape.semi_axes[axis] * (1.0 + taper);
        self.world(&local)
    }

    /// The point of the surface where the profile (ε1) or the section (ε2) is
    /// as far along one axis as along the other: at 2^(−ε/2) of both.
    fn exponent_place(&self, which: usize, exponent: f64) -> Point3<f64> {
        let s = (-0.5 * exponent).exp2();
        let n = if which == 0 { Vector3::new(s, 0.0, s) } else { Vector3::new(s, s, 0.0) };
        self.shape.world_from_normalized(&n)
    }

    /// The exponent whose place is seen nearest to a pixel.
    fn nearest_exponent(&self, which: usize, pixel: Vector2<f64>) -> f64 {
        let distance = |e: f64| {
            let seen = self.screen.pixel(&self.exponent_place(which, e));
            seen.map_or(f64::INFINITY, |p| (p - pixel).norm())
        };
        let (low, high) = Bounds::FITS.exponents;
        let steps = 64;
        let step = (high - low) / f64::from(steps);
        let nearest = (0..=steps)
            .map(|i| low + f64::from(i) * step)
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap_or(self.shape.exponents[which]);
        // Between its neighbours the distance has one minimum.
        let (mut a, mut b) = ((nearest - step).max(low), (nearest + step).min(high));
        for _ in 0..40 {
            let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
            if distance(c) <= distance(d) {
                b = d;
            } else {
                a = c;
            }
        }
        0.5 * (a + b)
    }

    fn turned(&self, axis: &Unit<Vector3<f64>>, angle: f64) -> Superquadric {
        let mut rotation = Rotation3::from_axis_angle(axis, angle) * self.shape.rotation;
        rotation.renormalize();
        Superquadric { rotation, ..self.shape }
    }

    /// Whether an axis points so much towards the eye that it can't be dragged
    /// along.
    fn is_along_sight(&self, axis: usize) -> bool {
        let sight = self.screen.sight(&self.center());
        sight.cross(&self.axis(axis)).norm() < EDGE_ON
    }

    /// How far the place of an axis that is seen nearest to the pointer moves.
    fn step_along(
        &self,
        axis: usize,
        through: &Point3<f64>,
        from: Vector2<f64>,
        to: Vector2<f64>,
    ) -> Option<f64> {
        let axis = self.axis(axis);
        // A drag is of the handle, wherever in it the pointer took hold.
        let held = self.screen.pixel(through)?;
        let place = |pixel: Vector2<f64>| {
            let (origin, direction) = self.screen.ray(pixel);
            let across = direction.cross(&axis);
            let size = across.norm_squared();
            (size > EDGE_ON * EDGE_ON)
                .then(|| (origin - through).cross(&direction).dot(&axis.cross(&direction)) / size)
        };
        // Seen as a line on the screen: only movement along it counts.
        let tip = self.screen.pixel(&(through + *axis * self.screen.units_per_pixel(through)))?;
        let along = (tip - held).try_normalize(1e-9)?;
        let on_line = held + along * (to - from).dot(&along);
        Some(place(on_line)? - place(held)?)
    }

    /// How far the place in the plane through the centre that is seen under the
    /// pointer moves.
    fn step_across(
        &self,
        normal: &Unit<Vector3<f64>>,
        from: Vector2<f64>,
        to: Vector2<f64>,
    ) -> Option<Vector3<f64>> {
        Some(self.in_plane(normal, to)? - self.in_plane(normal, from)?)
    }

    fn in_plane(&self, normal: &Unit<Vector3<f64>>, pixel: Vector2<f64>) -> Option<Point3<f64>> {
        let (origin, direction) = self.screen.ray(pixel);
        let slope = direction.dot(normal);
        let t = (self.center() - origin).dot(normal) / slope;
        (slope.abs() > EDGE_ON && t.is_finite() && t > 0.0).then(|| origin + direction * t)
    }

    fn angle_in_plane(
        &self,
        normal: &Unit<Vector3<f64>>,
        from: Vector2<f64>,
        to: Vector2<f64>,
    ) -> Option<f64> {
        // Steeper than for a step: far along a flat plane angles hardly change.
        let sight = self.screen.sight(&self.center());
        if sight.dot(normal).abs() < 3.0 * EDGE_ON {
            return None;
        }
        let a = self.in_plane(normal, from)? - self.center();
        let b = self.in_plane(normal, to)? - self.center();
        Some(normal.dot(&a.cross(&b)).atan2(a.dot(&b)))
    }

    /// A wheel that is seen from the side turns with the pointer that rolls
    /// along its front.
    fn roll(&self, normal: &Unit<Vector3<f64>>, from: Vector2<f64>, to: Vector2<f64>) -> Option<f64> {
        let front = -self.screen.sight(&self.center());
        let along = normal.cross(&front).try_normalize(1e-9)?;
        let unit = self.screen.units_per_pixel(&self.center());
        let center = self.screen.pixel(&self.center())?;
        let along = (self.screen.pixel(&(self.center() + along * unit))? - center).try_normalize(1e-9)?;
        Some((to - from).dot(&along) / RING)
    }

    fn square(&self, axis: usize, unit: f64) -> Option<Figure> {
        let normal = self.axis(axis);
        if self.screen.sight(&self.center()).dot(&normal).abs() < 2.0 * EDGE_ON {
            return None;
        }
        let [u, v] = [self.axis((axis + 1) % 3), self.axis((axis + 2) % 3)];
        let (near, far) = (PLANE.0 * unit, (PLANE.0 + PLANE.1) * unit);
        let corner = |a: f64, b: f64| self.screen.pixel(&(self.center() + *u * a + *v * b));
        Some(Figure::Square([corner(near, near)?, corner(far, near)?, corner(far, far)?, corner(near, far)?]))
    }

    fn ring(&self, axis: usize, unit: f64) -> Option<Figure> {
        let [u, v] = [self.axis((axis + 1) % 3), self.axis((axis + 2) % 3)];
        let sight = self.screen.sight(&self.center());
        let points: Option<Vec<_>> = (0..RING_POINTS)
            .map(|i| {
                let angle = std::f64::consts::TAU * i as f64 / RING_POINTS as f64;
                let arm = *u * angle.cos() + *v * angle.sin();
                let pixel = self.screen.pixel(&(self.center() + arm * (RING * unit)))?;
                Some((pixel, arm.dot(&sight) <= 0.05))
            })
            .collect();
        points.map(Figure::Ring)
    }

    fn knob(&self, from: &Point3<f64>, at: &Point3<f64>, is_unusable: bool) -> Option<Figure> {
        if is_unusable {
            return None;
        }
        Some(Figure::Knob { from: self.screen.pixel(from)?, at: self.screen.pixel(at)? })
    }
}

impl Figure {
    /// From a pixel to what can be taken hold of.
    fn distance(&self, p: Vector2<f64>) -> f64 {
        match self {
            // Where all arrows meet none is meant.
            Self::Arrow(from, to) => to_segment(p, from + (to - from) * 0.25, *to),
            Self::Square(corners) => {
                let edges = corners.iter().zip(corners.iter().cycle().skip(1));
                let sides: Vec<f64> = edges.map(|(a, b)| (b - a).perp(&(p - a))).collect();
                let is_inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
                let edges = corners.iter().zip(corners.iter().cycle().skip(1));
                if is_inside {
                    0.0
                } else {
                    edges.map(|(a, b)| to_segment(p, *a, *b)).fold(f64::INFINITY, f64::min)
                }
            }
            Self::Ring(points) => {
                let parts = points.iter().zip(points.iter().cycle().skip(1));
                // What lies behind is not in the way.
                let front = parts.filter(|((_, faces), _)| *faces);
                front.map(|((a, _), (b, _))| to_segment(p, *a, *b)).fold(f64::INFINITY, f64::min)
            }
            Self::Knob { at, .. } => ((p - at).norm() - 3.0).max(0.0),
            Self::Circle(center, radius) if *radius < 10.0 => ((p - center).norm() - radius).max(0.0),
            Self::Circle(center, radius) => ((p - center).norm() - radius).abs(),
        }
    }
}

fn to_segment(p: Vector2<f64>, a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
    (p - a - along * t).norm()
}
