use nalgebra::{Point3, Rotation3, Vector3};

use super::*;
use crate::geometry::tessellate::{Resolution, tessellate};
use crate::geometry::{Superquadric, TriMesh};

/// Few enough for a quick test.
const QUICK: MetricOptions = MetricOptions { samples: 20_000, volume_points: 40_000, seed: 1 };

fn sphere(x: f64, radius: f64) -> Superquadric {
    Superquadric::sphere(Point3::new(x, 0.0, 0.0), radius)
}

fn box_at(center: [f64; 3], half: [f64; 3]) -> Superquadric {
    Superquadric {
        exponents: [1e-3; 2],
        semi_axes: half.into(),
        translation: center.into(),
        ..sphere(0.0, 1.0)
    }
}

fn mesh_of(shapes: &[Superquadric]) -> TriMesh {
    let mut mesh = TriMesh::default();
    for shape in shapes {
        let surface = tessellate(shape, Resolution { profile: 40, section: 40 });
        let offset = mesh.vertices.len() as u32;
        mesh.vertices.extend(surface.vertices);
        mesh.faces.extend(surface.faces.iter().map(|f| f.map(|i| i + offset)));
    }
    mesh
}

/// The surface of a box, two triangles a side.
fn box_mesh(center: [f64; 3], half: [f64; 3]) -> TriMesh {
    let corner = |i: usize| {
        Point3::from(std::array::from_fn::<f64, 3, _>(|k| {
            center[k] + if i >> k & 1 == 1 { half[k] } else { -half[k] }
        }))
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriMesh {
        vertices: (0..8).map(corner).collect(),
        faces: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

#[test]
fn concentric_spheres_are_a_radius_apart() {
    let reference = Reference::of_mesh(&mesh_of(&[sphere(0.0, 1.0)]), &QUICK).unwrap();
    assert!((reference.longest_edge() - 2.0).abs() < 1e-9);
    assert!(reference.notes().is_empty(), "{:?}", reference.notes());
    let found = evaluate(&[sphere(0.0, 0.8)], Some(0.25), &reference);
    // In units of the diameter 2; the other way, samples have gaps of 1e-2.
    assert!((found.accuracy.unwrap() - 0.1).abs() < 2e-4, "{found:?}");
    assert!((found.completeness.unwrap() - 0.1).abs() < 4e-4, "{found:?}");
    assert_eq!(found.chamfer_l1.unwrap(), 0.5 * (found.accuracy.unwrap() + found.completeness.unwrap()));
    let (iou, error) = (found.iou.unwrap(), found.iou_error.unwrap());
    assert!((iou - 0.512).abs() < 3.0 * error && error < 5e-3, "{iou} ± {error}");
    assert!((found.reference_volume.unwrap() - std::f64::consts::PI / 6.0).abs() < 4e-3);
    assert_eq!((found.primitives, found.unassigned_share, found.iou_outside), (1, Some(0.25), None));
}

#[test]
fn shifted_boxes_overlap_by_the_product_of_their_edges() {
    let half = [0.5, 0.3, 0.4];
    let reference = Reference::of_mesh(&box_mesh([0.0; 3], half), &QUICK).unwrap();
    for shift in [[0.0; 3], [0.25, 0.0, 0.0], [0.2, -0.3, 0.1], [3.0, 0.0, 0.0], [0.0, 40.0, 0.0]] {
        let found = evaluate(&[box_at(shift, half)], None, &reference);
        let share: f64 = (0..3).map(|k| (1.0 - shift[k].abs() / (2.0 * half[k])).max(0.0)).product();
        let expected = share / (2.0 - share);
        let error = found.iou_error.unwrap().max(1e-3);
        assert!((found.iou.unwrap() - expected).abs() < 3.0 * error, "{shift:?} {expected} {found:?}");
        // Far out there are fewer points than the box would need.
        let tolerance = if shift[1] > 1.0 { 0.1 } else { 0.02 };
        assert!((found.volume.unwrap() / 0.48 - 1.0).abs() < tolerance, "{shift:?} {found:?}");
    }
    // Along x the face of a box moves away; sides are as near as before.
    let found = evaluate(&[box_at([0.25, 0.0, 0.0], half)], None, &reference);
    let side = 2.0 * (2.0 * half[1] + 2.0 * half[2]);
    let end = 4.0 * half[1] * half[2];
    // The far end is 0.25 away, the near end as far from the other box's sides
    // as its nearest edge lets it.
    let near: f64 = mean_depth(half[1], half[2], 0.25);
    let beyond = 0.25 / 2.0;
    let expected = (side * 0.25 * beyond + end * 0.25 + end * near) / (side + 2.0 * end);
    assert!((found.accuracy.unwrap() - expected).abs() < 3e-3, "{expected} {found:?}");
}

/// Mean over a rectangle of half-edges (a, b) of min(limit, distance to rim).
fn mean_depth(a: f64, b: f64, limit: f64) -> f64 {
    let n = 400;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let x = a * (f64::from(i) + 0.5) / f64::from(n);
            let y = b * (f64::from(j) + 0.5) / f64::from(n);
            sum += x.min(y).min(limit);
        }
    }
    sum / f64::from(n * n)
}

#[test]
fn surfaces_inside_other_primitives_do_not_count() {
    let outer = sphere(0.0, 1.0);
    let reference = Reference::of_mesh(&mesh_of(&[outer]), &QUICK).unwrap();
    let alone = evaluate(&[outer], None, &reference);
    let with_core = evaluate(&[outer, sphere(0.1, 0.5)], None, &reference);
    assert_eq!(alone.buried_share, Some(0.0));
    assert!((with_core.buried_share.unwrap() - 0.2).abs() < 0.01, "{with_core:?}");
    assert!(with_core.accuracy.unwrap() < 1e-3 && alone.accuracy.unwrap() < 1e-3);
    assert_eq!(alone.iou, with_core.iou);
    // Of two that coincide both stay.
    assert_eq!(evaluate(&[outer, outer], None, &reference).buried_share, Some(0.0));
    // Two halves of a box that abut: the face between them is inside.
    let halves = [box_at([-0.5, 0.0, 0.0], [0.5; 3]), box_at([0.5, 0.0, 0.0], [0.5; 3])];
    let reference = Reference::of_mesh(&box_mesh([0.0; 3], [1.0, 0.5, 0.5]), &QUICK).unwrap();
    let found = evaluate(&halves, None, &reference);
    assert!((found.buried_share.unwrap() - 2.0 / 12.0).abs() < 0.01, "{found:?}");
    assert!(found.accuracy.unwrap() < 1e-3 && found.iou.unwrap() > 0.99, "{found:?}");
}

#[test]
fn units_and_offsets_change_nothing() {
    let shapes = [sphere(0.0, 0.9), sphere(1.2, 0.5)];
    let mesh = mesh_of(&[sphere(0.0, 1.0), sphere(1.0, 0.6)]);
    let found = evaluate(&shapes, None, &Reference::of_mesh(&mesh, &QUICK).unwrap());
    for (scale, offset) in [(1e-9, 0.0), (1e12, 0.0), (1.0, 5e6), (1e-3, 1e3)] {
        let offset = Vector3::repeat(offset);
        let mesh = TriMesh {
            vertices: mesh.vertices.iter().map(|p| p * scale + offset).collect(),
            faces: mesh.faces.clone(),
        };
        let shapes = shapes.map(|s| s.scaled(scale, &offset));
        let moved = evaluate(&shapes, None, &Reference::of_mesh(&mesh, &QUICK).unwrap());
        assert!((moved.chamfer_l1.unwrap() - found.chamfer_l1.unwrap()).abs() < 1e-5, "{moved:?}\n{found:?}");
        assert!((moved.iou.unwrap() - found.iou.unwrap()).abs() < 2e-3, "{moved:?}\n{found:?}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let shapes = [sphere(0.0, 0.9), sphere(1.2, 0.5), box_at([9.0, 0.0, 0.0], [0.1; 3])];
    let mut mesh = mesh_of(&[sphere(0.0, 1.0), sphere(1.0, 0.6)]);
    for face in mesh.faces.iter_mut().step_by(7) {
        face.swap(0, 1);
    }
    let on = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let reference = Reference::of_mesh(&mesh, &MetricOptions { seed, ..QUICK }).unwrap();
            (evaluate(&shapes, None, &reference), reference.notes().to_vec())
        })
    };
    let one = on(1, 3);
    assert_eq!(one, on(2, 3));
    assert_eq!(one, on(5, 3));
    assert_ne!(one.0, on(2, 4).0);
    assert_eq!(one.1.len(), 1, "{:?}", one.1);
}

#[test]
fn an_open_mesh_says_why_it_has_no_iou() {
    let whole = mesh_of(&[sphere(0.0, 1.0)]);
    let cut = |height: f64| {
        let low = |f: &&[u32; 3]| f.iter().all(|&i| whole.vertices[i as usize].z < height);
        let faces = whole.faces.iter().filter(low).copied().collect();
        Reference::of_mesh(&TriMesh { vertices: whole.vertices.clone(), faces }, &QUICK).unwrap()
    };
    let bowl = evaluate(&[sphere(0.0, 1.0)], None, &cut(0.0));
    assert!(bowl.iou.is_none() && bowl.iou_error.is_none());
    assert!(bowl.iou_missing.unwrap().contains("open or a thin shell"));
    assert!(bowl.chamfer_l1.is_some());
    // A small hole is no trouble.
    let pierced = cut(0.995);
    assert!(evaluate(&[sphere(0.0, 1.0)], None, &pierced).iou.unwrap() > 0.98);
    assert!(pierced.notes()[0].contains("not watertight"));
    let sheet = TriMesh {
        vertices: vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)],
        faces: vec![[0, 1, 2]],
    };
    let sheet = evaluate(&[sphere(0.0, 1.0)], None, &Reference::of_mesh(&sheet, &QUICK).unwrap());
    assert!(sheet.iou_missing.unwrap().contains("almost no volume"));
}

#[test]
fn a_cloud_has_distances_only() {
    let points: Vec<_> =
        mesh_of(&[sphere(0.0, 1.0)]).vertices.into_iter().chain([Point3::new(f64::NAN, 0.0, 0.0)]).collect();
    let reference = Reference::of_cloud(&points, &QUICK).unwrap();
    let found = evaluate(&[sphere(0.0, 1.1)], None, &reference);
    assert!((found.completeness.unwrap() - 0.05).abs() < 1e-3, "{found:?}");
    assert!(found.accuracy.unwrap() > 0.05 && found.accuracy.unwrap() < 0.06, "{found:?}");
    assert!(found.iou.is_none() && found.iou_missing.unwrap().contains("cloud"));
    assert!(reference.notes()[0].contains("spacing"));
    assert_eq!(Reference::of_cloud(&points[..1], &QUICK).unwrap_err(), ReferenceError::NoPoints);
    assert_eq!(Reference::of_mesh(&TriMesh::default(), &QUICK).unwrap_err(), ReferenceError::NoSurface);
}

#[test]
fn nothing_measures_as_nothing() {
    let reference = Reference::of_mesh(&box_mesh([0.0; 3], [1.0; 3]), &QUICK).unwrap();
    let found = evaluate(&[], Some(1.0), &reference);
    assert_eq!((found.chamfer_l1, found.accuracy, found.completeness), (None, None, None));
    assert_eq!((found.iou, found.primitives, found.buried_share), (Some(0.0), 0, None));
    // So does a shape that is none; it is counted all the same.
    let broken = Superquadric { taper: [f64::NAN, 0.0], ..sphere(0.0, 1.0) };
    let found = evaluate(&[broken], None, &reference);
    assert_eq!((found.chamfer_l1, found.iou, found.primitives), (None, Some(0.0), 1));
}

#[test]
fn hollows_can_be_filled() {
    // A hollow ball: the inner wall faces the cavity.
    let mut mesh = mesh_of(&[sphere(0.0, 1.0)]);
    let inner = mesh_of(&[sphere(0.0, 0.8)]);
    let offset = mesh.vertices.len() as u32;
    mesh.vertices.extend(inner.vertices);
    mesh.faces.extend(inner.faces.iter().map(|&[a, b, c]| [a + offset, c + offset, b + offset]));
    let reference = Reference::of_mesh(&mesh, &QUICK).unwrap().with_filled(|p| p.coords.norm() < 1.0);
    let found = evaluate(&[sphere(0.0, 1.0)], None, &reference);
    assert!((found.iou.unwrap() - 0.488).abs() < 0.01, "{found:?}");
    assert!(found.iou_outside.unwrap() > 0.985, "{found:?}");
}

#[test]
fn a_turned_tapered_primitive_measures_as_its_own_mesh() {
    let shape = Superquadric {
        exponents: [0.3, 0.7],
        semi_axes: Vector3::new(0.2, 0.5, 0.9),
        rotation: Rotation3::new(Vector3::new(0.4, -1.0, 2.0)),
        translation: Vector3::new(3.0, -1.0, 7.0),
        taper: [0.6, -0.4],
    };
    let reference = Reference::of_mesh(&mesh_of(&[shape]), &QUICK).unwrap();
    let found = evaluate(&[shape], None, &reference);
    assert!(found.accuracy.unwrap() < 1e-3 && found.iou.unwrap() > 0.98, "{found:?}");
    assert!((found.volume.unwrap() * reference.longest_edge().powi(3) / shape.volume() - 1.0).abs() < 0.02);
}

#[test]
fn options_out_of_their_limits_are_named() {
    assert!(MetricOptions::default().check().is_ok());
    let few = MetricOptions { samples: 5, ..QUICK };
    assert!(few.check().unwrap_err().contains("samples is 5"));
    let many = MetricOptions { volume_points: usize::MAX, ..QUICK };
    assert!(many.check().unwrap_err().contains("volume points"));
}

#[test]
fn an_estimate_differs_by_chance_alone() {
    let shapes = [sphere(0.0, 1.0), box_at([1.4, 0.0, 0.0], [0.8, 0.3, 0.2])];
    let reference = Reference::of_mesh(&mesh_of(&shapes), &QUICK).unwrap();
    for found in [&shapes[..], &shapes[..1], &[sphere(0.1, 0.9), box_at([1.3, 0.1, 0.0], [0.7, 0.3, 0.3])]] {
        let exact = evaluate(found, None, &reference).chamfer_l1.unwrap();
        let rough = estimate_chamfer(found, &reference, 3000).unwrap();
        assert!((rough / exact - 1.0).abs() < 0.05, "{rough} for {exact}");
    }
    assert_eq!(estimate_chamfer(&[], &reference, 3000), None);
}
