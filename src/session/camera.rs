//! The camera: an orbit around a target, in scene space (y up, the shape's
//! longest edge is 1).

use nalgebra::{Point3, Vector2, Vector3};

/// Full vertical angle of view.
const FOV_Y: f64 = 35.0 * std::f64::consts::PI / 180.0;
/// Distances from the target that zooming keeps to, in scene units.
const DISTANCE: (f64, f64) = (1e-3, 1e3);
/// Room around a framed box.
const MARGIN: f64 = 1.12;

/// The six views along the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisView {
    Front,
    Back,
    Right,
    Left,
    Top,
    Bottom,
}

impl AxisView {
    pub const ALL: [Self; 6] = [Self::Front, Self::Back, Self::Right, Self::Left, Self::Top, Self::Bottom];

    /// Unit vector from the shape to the eye, in scene space.
    pub fn towards_eye(self) -> Vector3<f64> {
        match self {
            Self::Front => Vector3::z(),
            Self::Back => -Vector3::z(),
            Self::Right => Vector3::x(),
            Self::Left => -Vector3::x(),
            Self::Top => Vector3::y(),
            Self::Bottom => -Vector3::y(),
        }
    }

    /// The view from the opposite side.
    pub fn opposite(self) -> Self {
        match self {
            Self::Front => Self::Back,
            Self::Back => Self::Front,
            Self::Right => Self::Left,
            Self::Left => Self::Right,
            Self::Top => Self::Bottom,
            Self::Bottom => Self::Top,
        }
    }
}

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub min: Point3<f64>,
    pub max: Point3<f64>,
}

impl Bounds {
    /// The smallest box around the finite ones of the points; `None` if there
    /// is none.
    pub fn around(points: impl IntoIterator<Item = Point3<f64>>) -> Option<Self> {
        points.into_iter().filter(|p| p.iter().all(|c| c.is_finite())).fold(None, |bounds, p| {
            Some(match bounds {
                None => Self { min: p, max: p },
                Some(Self { min, max }) => Self { min: min.inf(&p), max: max.sup(&p) },
            })
        })
    }

    pub fn center(&self) -> Point3<f64> {
        nalgebra::center(&self.min, &self.max)
    }

    pub fn size(&self) -> Vector3<f64> {
        self.max - self.min
    }

    pub fn corners(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        (0..8).map(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            Point3::new(pick(0), pick(1), pick(2))
        })
    }
}

/// Looks at `target` from `distance` away.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Camera {
    pub target: Point3<f64>,
    /// Distance of the eye from the target, in scene units.
    pub distance: f64,
    /// Angle of the eye around the y axis in radians, 0 on +z, growing towards +x.
    pub yaw: f64,
    /// Height of the eye over the horizon in radians, within ±π/2.
    pub pitch: f64,
    pub orthographic: bool,
    /// Width / height of the picture.
    pub aspect: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            target: Point3::origin(),
            distance: 2.5,
            yaw: 35.0_f64.to_radians(),
            pitch: 22.0_f64.to_radians(),
            orthographic: false,
            aspect: 1.0,
        }
    }
}

impl Camera {
    /// Whether all numbers are within their limits.
    pub fn is_sound(&self) -> bool {
        // Far beyond what a hand reaches, and far from what overflows on the screen.
        self.target.iter().chain([&self.yaw]).all(|c| c.abs() <= 1e9)
            && (DISTANCE.0..=DISTANCE.1).contains(&self.distance)
            && self.pitch.abs() <= std::f64::consts::FRAC_PI_2
            && (1e-4..=1e4).contains(&self.aspect)
    }

    /// Full vertical angle of view in radians.
    pub fn fov_y(&self) -> f64 {
        FOV_Y
    }

    /// Unit vector from the eye to the target.
    pub fn forward(&self) -> Vector3<f64> {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        -Vector3::new(cos_pitch * sin_yaw, sin_pitch, cos_pitch * cos_yaw)
    }

    /// Unit vector to the right of the picture; defined also straight from above.
    pub fn right(&self) -> Vector3<f64> {
        Vector3::new(self.yaw.cos(), 0.0, -self.yaw.sin())
    }

    /// Unit vector to the top of the picture.
    pub fn up(&self) -> Vector3<f64> {
        self.right().cross(&self.forward())
    }

    pub fn eye(&self) -> Point3<f64> {
        self.target - self.forward() * self.distance
    }

    /// Half the size of what is seen in the target's plane, in scene units.
    pub fn half_extent(&self) -> Vector2<f64> {
        let height = self.distance * (0.5 * FOV_Y).tan();
        Vector2::new(height * self.aspect, height)
    }

    /// Turns around the target, by angles in radians: `right` moves the shape
    /// to the right, `up` upwards.
    pub fn orbit(&mut self, right: f64, up: f64) {
        self.yaw = (self.yaw - right).rem_euclid(std::f64::consts::TAU);
        self.pitch = (self.pitch - up).clamp(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2);
    }

    /// Moves the shape with the pointer: `offset` in fractions of the
    /// picture's half size, y up.
    pub fn pan(&mut self, offset: Vector2<f64>) {
        let half = self.half_extent();
        self.target -= self.right() * (offset.x * half.x) + self.up() * (offset.y * half.y);
    }

    /// Changes the distance by `factor` and keeps what lies under the cursor
    /// in the target's plane where it is. `cursor` in [−1, 1]², y up.
    pub fn zoom_to(&mut self, cursor: Vector2<f64>, factor: f64) {
        let distance = (self.distance * factor).clamp(DISTANCE.0, DISTANCE.1);
        let factor = distance / self.distance;
        let half = self.half_extent();
        let under_cursor = self.target + self.right() * (cursor.x * half.x) + self.up() * (cursor.y * half.y);
        self.target = under_cursor + (self.target - under_cursor) * factor;
        self.distance = distance;
    }

    /// Makes `point` the centre of the picture and of later orbits.
    pub fn set_pivot(&mut self, point: Point3<f64>) {
        if point.iter().all(|c| c.is_finite()) {
            self.target = point;
        }
    }

    /// Keeps the direction and shows the whole box, with some room around it.
    pub fn frame(&mut self, bounds: &Bounds) {
        self.target = bounds.center();
        let tan_y = (0.5 * FOV_Y).tan();
        let tan_x = tan_y * self.aspect.max(1e-3);
        let (right, up, forward) = (self.right(), self.up(), self.forward());
        let distance = bounds
            .corners()
            .map(|corner| {
                let v = corner - self.target;
                MARGIN * (v.dot(&right).abs() / tan_x).max(v.dot(&up).abs() / tan_y) - v.dot(&forward)
            })
            .fold(0.0, f64::max);
        // A single point has no size to fill the picture with.
        self.distance = if distance > 0.0 { distance.clamp(DISTANCE.0, DISTANCE.1) } else { 1.0 };
    }

    /// Looks along an axis.
    pub fn look(&mut self, view: AxisView) {
        let quarter = std::f64::consts::FRAC_PI_2;
        (self.yaw, self.pitch) = match view {
            AxisView::Front => (0.0, 0.0),
            AxisView::Back => (2.0 * quarter, 0.0),
            AxisView::Right => (quarter, 0.0),
            AxisView::Left => (3.0 * quarter, 0.0),
            AxisView::Top => (0.0, quarter),
            AxisView::Bottom => (0.0, -quarter),
        };
    }

    /// The camera a `share` in [0, 1] of the way to another, the short way round.
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        use std::f64::consts::{PI, TAU};
        let turn = (other.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        Self {
            target: self.target + (other.target - self.target) * share,
            distance: self.distance * (other.distance / self.distance).powf(share),
            yaw: (self.yaw + turn * share).rem_euclid(TAU),
            pitch: self.pitch + (other.pitch - self.pitch) * share,
            ..*other
        }
    }

    /// The view along an axis that the camera has, if it has one.
    pub fn axis_view(&self) -> Option<AxisView> {
        AxisView::ALL.into_iter().find(|view| {
            let mut there = *self;
            there.look(*view);
            (there.forward() - self.forward()).norm() < 1e-6 && (there.up() - self.up()).norm() < 1e-6
        })
    }

    /// Where a scene point is seen, in [−1, 1]² within the picture, y up;
    /// `None` at or behind the eye.
    pub fn project(&self, point: &Point3<f64>) -> Option<Vector2<f64>> {
        let v = point - self.target;
        let depth = self.distance + v.dot(&self.forward());
        if depth <= 0.0 && !self.orthographic {
            return None;
        }
        let shrink = if self.orthographic { 1.0 } else { self.distance / depth };
        let half = self.half_extent();
        Some(Vector2::new(v.dot(&self.right()) * shrink / half.x, v.dot(&self.up()) * shrink / half.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_camera() -> impl Strategy<Value = Camera> {
        (-2.0..2.0, -2.0..2.0, 0.01..50.0, 0.0..std::f64::consts::TAU, -1.57..1.57, any::<bool>(), 0.3..4.0)
            .prop_map(|(x, z, distance, yaw, pitch, orthographic, aspect)| Camera {
                target: Point3::new(x, 0.3, z),
                distance,
                yaw,
                pitch,
                orthographic,
                aspect,
            })
    }

    proptest! {
        #[test]
        fn the_basis_is_right_handed_and_orthonormal(camera in any_camera()) {
            let (r, u, f) = (camera.right(), camera.up(), camera.forward());
            prop_assert!((r.cross(&u) + f).norm() < 1e-12);
            for v in [r, u, f] {
                prop_assert!((v.norm() - 1.0).abs() < 1e-12);
            }
        }

        #[test]
        fn zooming_keeps_the_point_under_the_cursor(
            camera in any_camera(), x in -1.0..1.0, y in -1.0..1.0, factor in 0.3..3.0,
        ) {
            let half = camera.half_extent();
            let point = camera.target + camera.right() * (x * half.x) + camera.up() * (y * half.y);
            let mut zoomed = camera;
            zoomed.zoom_to(Vector2::new(x, y), factor);
            let seen = zoomed.project(&point).expect("in front");
            prop_assert!((seen - Vector2::new(x, y)).norm() < 1e-9);
        }

        #[test]
        fn panning_moves_the_target_with_the_pointer(camera in any_camera(), x in -1.0..1.0, y in -1.0..1.0) {
            let mut panned = camera;
            panned.pan(Vector2::new(x, y));
            let seen = panned.project(&camera.target).expect("in front");
            prop_assert!((seen - Vector2::new(x, y)).norm() < 1e-9);
        }

        #[test]
        fn framing_shows_every_corner(
            camera in any_camera(), x in -9.0..9.0_f64, sx in 0.0..3.0, sy in 0.0..3.0, sz in 0.01..3.0,
        ) {
            let min = Point3::new(x, -x, 0.5 * x);
            let bounds = Bounds { min, max: min + Vector3::new(sx, sy, sz) };
            let mut framed = camera;
            framed.frame(&bounds);
            for corner in bounds.corners() {
                let seen = framed.project(&corner).expect("in front");
                prop_assert!(seen.amax() <= 1.0, "{seen:?}");
            }
        }

        #[test]
        fn a_way_to_another_camera_has_both_at_its_ends_and_turns_the_short_way(
            a in any_camera(), b in any_camera(), share in 0.0..1.0,
        ) {
            let close = |x: &Camera, y: &Camera| {
                (x.eye() - y.eye()).norm() < 1e-6 && (x.target - y.target).norm() < 1e-9
            };
            let begun = Camera { orthographic: b.orthographic, ..a };
            prop_assert!(close(&a.towards(&b, 0.0), &begun));
            prop_assert!(close(&a.towards(&b, 1.0), &b));
            let between = a.towards(&b, share);
            let turned = |x: f64, y: f64| ((x - y).sin().atan2((x - y).cos())).abs();
            prop_assert!(turned(a.yaw, between.yaw) <= turned(a.yaw, b.yaw) + 1e-9);
            prop_assert!(between.distance >= a.distance.min(b.distance) - 1e-9);
        }

        #[test]
        fn orbiting_keeps_the_target_and_the_distance(camera in any_camera(), a in -9.0..9.0, b in -9.0..9.0) {
            let mut orbited = camera;
            orbited.orbit(a, b);
            prop_assert!(orbited.project(&camera.target).expect("in front").norm() < 1e-9);
            prop_assert!(((orbited.eye() - camera.target).norm() - camera.distance).abs() < 1e-9);
            prop_assert!(orbited.pitch.abs() <= std::f64::consts::FRAC_PI_2);
        }
    }

    #[test]
    fn the_views_look_along_their_axes() {
        let mut camera = Camera::default();
        for (view, eye, up) in [
            (AxisView::Front, Vector3::z(), Vector3::y()),
            (AxisView::Back, -Vector3::z(), Vector3::y()),
            (AxisView::Right, Vector3::x(), Vector3::y()),
            (AxisView::Left, -Vector3::x(), Vector3::y()),
            (AxisView::Top, Vector3::y(), -Vector3::z()),
            (AxisView::Bottom, -Vector3::y(), Vector3::z()),
        ] {
            camera.look(view);
            assert!((camera.forward() + eye).norm() < 1e-12, "{view:?}");
            assert!((camera.up() - up).norm() < 1e-12, "{view:?}");
            assert_eq!(camera.axis_view(), Some(view));
            assert_eq!(view.towards_eye(), eye);
            assert_eq!(view.opposite().towards_eye(), -eye);
        }
    }

    #[test]
    fn degenerate_boxes_leave_a_usable_camera() {
        let mut camera = Camera::default();
        let point = Point3::new(1.0, 2.0, 3.0);
        camera.frame(&Bounds { min: point, max: point });
        assert!(camera.distance.is_finite() && camera.distance > 0.0);
        assert_eq!(camera.target, point);
        let nan = Point3::new(f64::NAN, 0.0, 0.0);
        assert_eq!(Bounds::around([nan]), None);
        camera.set_pivot(nan);
        assert_eq!(camera.target, point);
    }
}
