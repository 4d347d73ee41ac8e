use proptest::prelude::*;

use super::*;

const SIZE: Vector2<f64> = Vector2::new(900.0, 600.0);

fn any_gizmo(mode: Mode) -> impl Strategy<Value = Gizmo> {
    let camera = (0.0..std::f64::consts::TAU, -1.4..1.4, 1.5..4.0, any::<bool>());
    let turn = (-2.0..2.0, -2.0..2.0, -2.0..2.0);
    let shape = (0.2..1.8, 0.2..1.8, 0.1..0.4, 0.1..0.4, 0.1..0.4, -0.8..0.8, -0.8..0.8);
    let place = (-0.3..0.3, -0.3..0.3, -0.3..0.3);
    (camera, turn, shape, place).prop_map(move |(camera, turn, shape, place)| {
        let (yaw, pitch, distance, orthographic) = camera;
        let camera = Camera { yaw, pitch, distance, orthographic, ..Camera::default() };
        let (e1, e2, ax, ay, az, kx, ky) = shape;
        let shape = Superquadric {
            exponents: [e1, e2],
            semi_axes: Vector3::new(ax, ay, az),
            rotation: Rotation3::new(Vector3::new(turn.0, turn.1, turn.2)),
            translation: Vector3::new(place.0, place.1, place.2),
            taper: [kx, ky],
        };
        Gizmo::new(shape, mode, &camera, SIZE)
    })
}

/// Where an axis leads on the screen, for one scene unit at the centre; `None`
/// where it points too much at the eye for a drag.
fn arm(gizmo: &Gizmo, axis: usize) -> Option<Vector2<f64>> {
    let sight = gizmo.screen.sight(&gizmo.center());
    if sight.cross(&gizmo.axis(axis)).norm() < 0.3 {
        return None;
    }
    let step = 1e-4;
    let at = gizmo.screen.pixel(&gizmo.center())?;
    Some((gizmo.screen.pixel(&(gizmo.center() + *gizmo.axis(axis) * step))? - at) / step)
}

/// The place of the body that a handle holds.
fn held(gizmo: &Gizmo, handle: Handle) -> Point3<f64> {
    match handle {
        Handle::ScaleAxis(axis) => gizmo.center() + *gizmo.axis(axis) * gizmo.shape.semi_axes[axis],
        Handle::Taper(axis) => gizmo.taper_place(axis),
        Handle::Exponent(which) => gizmo.exponent_place(which, gizmo.shape.exponents[which]),
        _ => gizmo.center(),
    }
}

/// Drags what the handle holds to where the same place of `goal` is seen.
fn drag_towards(gizmo: &Gizmo, handle: Handle, goal: &Superquadric) -> Option<(Vector2<f64>, Superquadric)> {
    let from = gizmo.screen.pixel(&held(gizmo, handle))?;
    let to = gizmo.screen.pixel(&held(&Gizmo { shape: *goal, ..*gizmo }, handle))?;
    Some((to, gizmo.drag(handle, from, to)))
}

proptest! {
    /// Whatever is held stays under the pointer.
    #[test]
    fn the_place_that_is_held_moves_with_the_pointer(
        gizmo in any_gizmo(Mode::Move), axis in 0_usize..3, change in -0.08..0.08_f64,
    ) {
        prop_assume!(arm(&gizmo, axis).is_some());
        let mut moved = gizmo.shape;
        moved.translation += *gizmo.axis(axis) * change;
        let mut scaled = gizmo.shape;
        scaled.semi_axes[axis] += change;
        let mut tapered = gizmo.shape;
        tapered.taper[axis % 2] = (tapered.taper[axis % 2] + change).clamp(-1.0, 1.0);
        for (handle, goal) in [
            (Handle::MoveAxis(axis), moved),
            (Handle::ScaleAxis(axis), scaled),
            (Handle::Taper(axis % 2), tapered),
        ] {
            if arm(&gizmo, handle.axis().unwrap_or(axis)).is_none() {
                continue;
            }
            let Some((to, dragged)) = drag_towards(&gizmo, handle, &goal) else { continue };
            let seen = gizmo.screen.pixel(&held(&Gizmo { shape: dragged, ..gizmo }, handle)).expect("in front");
            prop_assert!((seen - to).norm() < 0.05, "{handle:?}: {seen} for {to}");
            prop_assert!((dragged.translation - goal.translation).norm() < 1e-3, "{handle:?}");
            prop_assert!((dragged.semi_axes - goal.semi_axes).norm() < 1e-3, "{handle:?}");
        }
    }

    /// The change by a pixel is that of the projection, by central differences.
    #[test]
    fn a_pixel_of_dragging_is_a_pixel_of_movement(gizmo in any_gizmo(Mode::Move), axis in 0_usize..3) {
        let arm = arm(&gizmo, axis);
        prop_assume!(arm.is_some());
        let arm = arm.expect("checked");
        let center = gizmo.screen.pixel(&gizmo.center()).expect("in front");
        let h = 0.5 * arm.normalize();
        let there = gizmo.drag(Handle::MoveAxis(axis), center, center + h).translation;
        let back = gizmo.drag(Handle::MoveAxis(axis), center, center - h).translation;
        let slope = (there - back).dot(&gizmo.axis(axis)) * arm.norm();
        prop_assert!((slope - 1.0).abs() < 1e-3, "{slope}");
    }

    #[test]
    fn planes_and_the_screen_keep_the_centre_under_the_pointer(
        gizmo in any_gizmo(Mode::Move), axis in 0_usize..3, x in -60.0..60.0, y in -60.0..60.0,
    ) {
        let center = gizmo.screen.pixel(&gizmo.center()).expect("in front");
        let facing = gizmo.screen.sight(&gizmo.center()).dot(&gizmo.axis(axis)).abs() > 0.35;
        let mut handles = vec![Handle::MoveFree];
        if facing {
            handles.push(Handle::MovePlane(axis));
        }
        for handle in handles {
            let to = center + Vector2::new(x, y);
            let dragged = gizmo.drag(handle, center, to);
            let seen = gizmo.screen.pixel(&Point3::from(dragged.translation)).expect("in front");
            prop_assert!((seen - to).norm() < 1e-6, "{handle:?}");
            if handle == Handle::MovePlane(axis) {
                let step = dragged.translation - gizmo.shape.translation;
                prop_assert!(step.dot(&gizmo.axis(axis)).abs() < 1e-9, "it stays in the plane");
            }
        }
    }

    /// A point of the ring goes where the pointer drags it.
    #[test]
    fn rings_turn_with_the_pointer(gizmo in any_gizmo(Mode::Rotate), axis in 0_usize..3, angle in -1.0..1.0_f64) {
        let normal = gizmo.axis(axis);
        prop_assume!(gizmo.screen.sight(&gizmo.center()).dot(&normal).abs() > 0.35);
        let unit = gizmo.screen.units_per_pixel(&gizmo.center());
        let arm = *gizmo.axis((axis + 1) % 3) * (RING * unit);
        let end = Rotation3::from_axis_angle(&normal, angle) * arm;
        let pixel = |v: Vector3<f64>| gizmo.screen.pixel(&(gizmo.center() + v)).expect("in front");
        let dragged = gizmo.drag(Handle::RotateAxis(axis), pixel(arm), pixel(end));
        let turned = dragged.rotation * gizmo.shape.rotation.inverse() * arm;
        prop_assert!((turned - end).norm() < 1e-9 * end.norm().max(1.0));
        let sight = Unit::new_normalize(-gizmo.screen.sight(&gizmo.center()));
        let center = gizmo.screen.pixel(&gizmo.center()).expect("in front");
        let (right, up) = (Vector2::new(OUTER_RING, 0.0), Vector2::new(0.0, -OUTER_RING));
        let quarter = gizmo.drag(Handle::RotateView, center + right, center + up);
        let expected = Rotation3::from_axis_angle(&sight, std::f64::consts::FRAC_PI_2) * gizmo.shape.rotation;
        prop_assert!(angle_between(&quarter.rotation, &expected) < 1e-9, "to the left as seen");
    }

    #[test]
    fn roundness_follows_the_pointer_along_the_diagonal(
        gizmo in any_gizmo(Mode::Roundness), which in 0_usize..2, wanted in 0.2..1.8_f64,
    ) {
        let handle = Handle::Exponent(which);
        let mut goal = gizmo.shape;
        goal.exponents[which] = wanted;
        let Some((to, dragged)) = drag_towards(&gizmo, handle, &goal) else { return Ok(()) };
        let at = gizmo.exponent_place(which, dragged.exponents[which]);
        let seen = gizmo.screen.pixel(&at).expect("in front");
        prop_assert!((seen - to).norm() < 0.2, "{seen} for {to}");
        // The place is one of the surface.
        let on_surface = dragged.radial_distance(&at).abs();
        prop_assert!(on_surface < 1e-4, "{on_surface}");
    }

    #[test]
    fn any_drag_gives_a_primitive_within_its_limits_and_back_again_gives_the_first(
        gizmo in any_gizmo(Mode::Scale), mode in prop::sample::select(&Mode::ALL[..]),
        x in -5e3..5e3, y in -5e3..5e3,
    ) {
        let gizmo = Gizmo { mode, ..gizmo };
        for part in gizmo.parts() {
            let from = Vector2::new(400.0, 300.0);
            let dragged = gizmo.drag(part.handle, from, Vector2::new(x, y));
            prop_assert!(dragged.is_valid(), "{:?}: {dragged:?}", part.handle);
            prop_assert!(dragged.semi_axes.min() >= LEAST_AXIS && dragged.semi_axes.max() <= MOST_AXIS);
            let same = gizmo.drag(part.handle, from, from);
            let near = |a: f64, b: f64| (a - b).abs() < 1e-3;
            prop_assert!((same.translation - gizmo.shape.translation).norm() < 1e-9);
            prop_assert!(angle_between(&same.rotation, &gizmo.shape.rotation) < 1e-6);
            prop_assert!((same.semi_axes - gizmo.shape.semi_axes).norm() < 1e-6);
            prop_assert!(near(same.taper[0], gizmo.shape.taper[0]) && near(same.taper[1], gizmo.shape.taper[1]));
        }
    }

    /// What is drawn can be taken hold of where it is drawn.
    #[test]
    fn handles_are_hit_where_they_are_seen(
        gizmo in any_gizmo(Mode::Move), mode in prop::sample::select(&Mode::ALL[..]),
    ) {
        let gizmo = Gizmo { mode, ..gizmo };
        for part in gizmo.parts() {
            let place = match &part.figure {
                Figure::Arrow(_, tip) => *tip,
                Figure::Square(corners) => corners.iter().sum::<Vector2<f64>>() / 4.0,
                Figure::Ring(points) => match points.iter().find(|(_, faces)| *faces) {
                    Some((p, _)) => *p,
                    None => continue,
                },
                Figure::Knob { at, .. } => *at,
                Figure::Circle(center, radius) if *radius < 10.0 => *center,
                Figure::Circle(center, radius) => center + Vector2::new(*radius, 0.0),
            };
            prop_assert!(part.figure.distance(place) < 1e-9, "{:?}", part.handle);
            prop_assert!(gizmo.hit(place).is_some());
        }
        prop_assert_eq!(gizmo.hit(Vector2::new(-500.0, -500.0)), None);
    }
}

/// Handles have the same size on the screen, near and far.
#[test]
fn arrows_keep_their_length_on_the_screen() {
    for distance in [0.5, 2.0, 30.0] {
        let camera = Camera { distance, yaw: 0.0, pitch: 0.0, ..Camera::default() };
        let gizmo = Gizmo::new(Superquadric::sphere(Point3::origin(), 0.2), Mode::Move, &camera, SIZE);
        let arrow = gizmo.parts().into_iter().find(|p| p.handle == Handle::MoveAxis(0)).expect("an arrow");
        let Figure::Arrow(from, to) = arrow.figure else { panic!("{arrow:?}") };
        assert!(((to - from).norm() - ARROW).abs() < 1e-6, "{distance}");
        let towards_eye = gizmo.parts().into_iter().find(|p| p.handle == Handle::MoveAxis(2));
        assert!(towards_eye.is_none(), "an arrow that points at the eye can't be dragged");
    }
}

#[test]
fn what_is_behind_the_camera_has_no_handles() {
    let camera = Camera { distance: 1.0, ..Camera::default() };
    let behind = camera.eye() - camera.forward();
    for mode in Mode::ALL {
        let gizmo = Gizmo::new(Superquadric::sphere(behind, 0.2), mode, &camera, SIZE);
        assert!(gizmo.parts().is_empty(), "{mode:?}");
    }
}
