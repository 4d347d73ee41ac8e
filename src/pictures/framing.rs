//! Where the camera stands so that all is in the picture, and fills it.

use nalgebra::{Point3, Vector3};

use crate::session::camera::Camera;

/// Room around what is shown, as a factor of its size on the picture.
const MARGIN: f64 = 1.14;
/// Least distance of eye and content, in scene units: that of a lone point.
const LEAST: f64 = 0.05;

/// Keeps the camera's direction and form, and moves it so that all points fill
/// the picture, but for a margin.
///
/// In the camera's own axes a point (x, y, z), z into the picture, is seen by
/// an eye at e if |x − eₓ| ≤ k·(z − e_z), with k the tangent of half the angle
/// of view; likewise for y. The nearest such eye is where the tightest of the
/// constraints from left and right, or from above and below, meet.
pub(super) fn fill(camera: &mut Camera, content: &[Point3<f64>]) {
    let axes = Axes::of(camera);
    let (kx, ky) = axes.slopes(camera);
    let mut reach = Reach::default();
    for p in content {
        reach.take(axes.of_point(&p.coords), if camera.orthographic { (0.0, 0.0) } else { (kx, ky) });
    }
    if content.is_empty() {
        return;
    }
    let [x, y] = reach.middle();
    let middle = 0.5 * (reach.near + reach.far);
    let [width, height] = reach.spans();
    let distance = if camera.orthographic {
        (0.5 * width / kx).max(0.5 * height / ky).max(LEAST)
    } else {
        // Depth of the eye from each pair of constraints. Where one point hides all
        // others that would be its own place.
        let eye = (-0.5 * width / kx).min(-0.5 * height / ky).min(reach.near - LEAST);
        middle - eye
    };
    camera.target = Point3::from(axes.right * x + axes.up * y + axes.forward * middle);
    camera.distance = distance;
}

/// As [`fill`], for a camera that goes around the upright axis in as many steps:
/// where it stands fits all of them.
pub(super) fn fill_turn(camera: &mut Camera, content: &[Point3<f64>], steps: u32) {
    let Some(bounds) = crate::session::camera::Bounds::around(content.iter().copied()) else { return };
    camera.target = bounds.center();
    let mut distance: f64 = LEAST;
    for step in 0..steps {
        let turned = turned(camera, step, steps);
        let axes = Axes::of(&turned);
        let (kx, ky) = axes.slopes(&turned);
        for p in content {
            let [x, y, z] = axes.of_point(&(p - camera.target));
            let wanted = (x.abs() / kx).max(y.abs() / ky);
            distance = distance.max(if camera.orthographic { wanted } else { wanted - z });
        }
    }
    camera.distance = distance;
}

/// The camera after so many of the steps of a turn: the shape turns to the right.
pub(super) fn turned(camera: &Camera, step: u32, steps: u32) -> Camera {
    let mut camera = *camera;
    camera.orbit(std::f64::consts::TAU * f64::from(step) / f64::from(steps.max(1)), 0.0);
    camera
}

/// The camera's axes in scene space.
struct Axes {
    right: Vector3<f64>,
    up: Vector3<f64>,
    forward: Vector3<f64>,
}

impl Axes {
    fn of(camera: &Camera) -> Self {
        Self { right: camera.right(), up: camera.up(), forward: camera.forward() }
    }

    fn of_point(&self, p: &Vector3<f64>) -> [f64; 3] {
        [p.dot(&self.right), p.dot(&self.up), p.dot(&self.forward)]
    }

    /// Tangents of half the angles of view, less the margin.
    fn slopes(&self, camera: &Camera) -> (f64, f64) {
        let ky = (0.5 * camera.fov_y()).tan() / MARGIN;
        (ky * camera.aspect.max(1e-3), ky)
    }
}

/// What the points ask of the eye.
struct Reach {
    /// Greatest of x − k·z and least of x + k·z, for x and for y, the latter
    /// negated: both are maxima.
    high: [f64; 2],
    low: [f64; 2],
    near: f64,
    far: f64,
}

impl Default for Reach {
    fn default() -> Self {
        let none = f64::NEG_INFINITY;
        Self { high: [none; 2], low: [none; 2], near: f64::INFINITY, far: none }
    }
}

impl Reach {
    fn take(&mut self, [x, y, z]: [f64; 3], (kx, ky): (f64, f64)) {
        for (axis, (v, k)) in [(x, kx), (y, ky)].into_iter().enumerate() {
            self.high[axis] = self.high[axis].max(v - k * z);
            self.low[axis] = self.low[axis].max(-v - k * z);
        }
        self.near = self.near.min(z);
        self.far = self.far.max(z);
    }

    /// Where the eye stands, across the picture.
    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|axis| 0.5 * (self.high[axis] - self.low[axis]))
    }

    /// 2·k times how far the eye is behind the origin, or the size of what is
    /// seen along parallel rays.
    fn spans(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.high[axis] + self.low[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use proptest::prelude::*;

    fn any_content() -> impl Strategy<Value = Vec<Point3<f64>>> {
        let point = (-0.5..0.5, -0.3..0.3, -0.5..0.5).prop_map(|(x, y, z)| Point3::new(x, y, z));
        let fixed = [Point3::new(-0.4, -0.2, 0.0), Point3::new(0.4, 0.2, 0.1)];
        prop::collection::vec(point, 0..40).prop_map(move |points| [&fixed[..], &points].concat())
    }

    fn any_camera() -> impl Strategy<Value = Camera> {
        (0.0..std::f64::consts::TAU, -1.5..1.5, any::<bool>(), 0.4..3.0).prop_map(
            |(yaw, pitch, orthographic, aspect)| Camera {
                yaw,
                pitch,
                orthographic,
                aspect,
                ..Camera::default()
            },
        )
    }

    fn seen(camera: &Camera, content: &[Point3<f64>]) -> Vec<Vector2<f64>> {
        content.iter().map(|p| camera.project(p).expect("in front of the eye")).collect()
    }

    proptest! {
        #[test]
        fn all_is_in_the_picture_and_touches_its_margin(content in any_content(), camera in any_camera()) {
            let mut camera = camera;
            fill(&mut camera, &content);
            let reached = seen(&camera, &content).iter().map(|p| p.amax()).fold(0.0, f64::max);
            let eye = camera.target - camera.forward() * camera.distance;
            let depth = |p: &Point3<f64>| (p - eye).dot(&camera.forward());
            let nearest = content.iter().map(depth).fold(f64::INFINITY, f64::min);
            if !camera.orthographic && nearest < LEAST * (1.0 + 1e-9) {
                // It may come no nearer.
                prop_assert!(reached * MARGIN < 1.0 + 1e-6, "{reached}");
                return Ok(());
            }
            prop_assert!((reached * MARGIN - 1.0).abs() < 1e-6, "{reached}");
            // Both margins of the tighter direction are reached.
            let (mut min, mut max) = (Vector2::repeat(1.0), Vector2::repeat(-1.0));
            for p in seen(&camera, &content) {
                min = min.inf(&p);
                max = max.sup(&p);
            }
            let tight = (max - min) * (0.5 * MARGIN);
            prop_assert!((tight.max() - 1.0).abs() < 1e-6, "{tight:?}");
        }

        #[test]
        fn a_turn_never_leaves_the_picture(content in any_content(), camera in any_camera()) {
            let mut camera = camera;
            fill_turn(&mut camera, &content, 12);
            let reached = (0..12)
                .flat_map(|step| seen(&turned(&camera, step, 12), &content))
                .map(|p| p.amax())
                .fold(0.0, f64::max);
            prop_assert!((reached * MARGIN - 1.0).abs() < 1e-6, "{reached}");
        }
    }

    #[test]
    fn a_lone_point_and_nothing_leave_a_usable_camera() {
        for content in [&[][..], &[Point3::new(0.2, 0.1, 0.0)]] {
            for orthographic in [false, true] {
                let mut camera = Camera { orthographic, ..Camera::default() };
                fill(&mut camera, content);
                assert!(camera.is_sound(), "{camera:?}");
                fill_turn(&mut camera, content, 4);
                assert!(camera.is_sound(), "{camera:?}");
            }
        }
    }
}
