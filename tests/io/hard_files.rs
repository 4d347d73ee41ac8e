//! Every file of `data/hard`: what it is, how much is in it, and what is said
//! of it, or why it is refused. Counts are those of trimesh, plyfile, laspy and
//! pypcd4 where these can read the file.

use crate::common::shared_data;
use superform::io::{self, ShapeGeometry};

/// What becomes of a file.
enum Becomes {
    /// Vertices that faces use, faces, and a part of each note.
    Mesh(usize, usize, &'static [&'static str]),
    /// Points, how many of them are finite, and a part of each note.
    Cloud(usize, usize, &'static [&'static str]),
    /// Parts of the message.
    Refused(&'static [&'static str]),
}
use Becomes::{Cloud, Mesh, Refused};

const HARD: [(&str, Becomes); 63] = [
    ("all_faces_degenerate.obj", Cloud(9, 9, &["ignored 3 faces with zero area", "read as a point cloud"])),
    ("as_OutOfMemory.off", Refused(&["line ", "353535235358 vertices are declared", "truncated"])),
    ("as_Spider_ascii.stl", Mesh(722, 1312, &["ignored 56 faces with zero area"])),
    ("as_box_UTF16BE.obj", Mesh(8, 12, &[])),
    ("as_cube_binary_starts_with_nl.ply", Mesh(8, 12, &[])),
    ("as_malformed.obj", Mesh(8, 7, &["ignored 2 faces with missing vertices", "1 face with zero area"])),
    ("as_triangle_with_two_solids.stl", Mesh(6, 2, &[])),
    ("ascii.stl", Mesh(216, 428, &[])),
    ("binary_starts_with_solid.stl", Mesh(216, 428, &[])),
    ("collinear.xyz", Cloud(300, 300, &[])),
    ("coplanar_square.ply", Cloud(1500, 1500, &[])),
    ("crlf_ngons_slashes.obj", Mesh(216, 432, &[])),
    ("decimal_comma.xyz", Cloud(300, 300, &[])),
    ("degenerate_faces.obj", Mesh(216, 438, &["ignored 60 faces with zero area"])),
    ("duplicates_x20.ply", Cloud(4000, 4000, &[])),
    ("embedded.gltf", Mesh(216, 428, &[])),
    ("empty_file.ply", Refused(&["is empty"])),
    ("half_open_bottle.stl", Mesh(3635, 2120, &[])),
    ("header_crlf_extra_props.ply", Cloud(400, 400, &[])),
    ("header_on_one_line.off", Mesh(216, 428, &[])),
    ("huge_1e12.obj", Mesh(840, 428, &[])),
    ("index_out_of_range.obj", Mesh(216, 428, &["ignored 1 face with missing"])),
    ("laspy_simple.las", Cloud(1065, 1065, &[])),
    ("laspy_simple.laz", Cloud(1065, 1065, &[])),
    ("mixed_winding.off", Mesh(216, 428, &[])),
    ("nan_inf_chair.ply", Cloud(2000, 1898, &["102 points have a non-finite coordinate"])),
    ("nan_text.xyz", Cloud(8, 5, &["3 points have"])),
    ("nested_transforms.glb", Mesh(16, 24, &[])),
    ("noisy_chair_2pct.ply", Cloud(6000, 6000, &[])),
    ("nonmanifold_fan.off", Mesh(9, 7, &[])),
    ("o3d_bunnyData.pts", Cloud(30571, 30571, &[])),
    ("offset_utm_chair.xyz", Cloud(2000, 2000, &[])),
    ("organized_nan.pcd", Cloud(300, 257, &["43 points have"])),
    ("outliers_20pct_chair.ply", Cloud(7500, 7500, &[])),
    ("partial_front_view_chair.ply", Cloud(3000, 3000, &[])),
    ("pcl_milk.pcd", Cloud(12575, 12575, &[])),
    ("pcl_min_cut_segmentation_tutorial.pcd", Cloud(9311, 9311, &[])),
    ("pcl_person.pcd", Cloud(307_200, 242_749, &["64451 points have"])),
    ("points_mode.gltf", Cloud(216, 216, &[])),
    ("single_point.xyz", Cloud(1, 1, &[])),
    ("spaces and ünïcode стул.ply", Cloud(1500, 1500, &[])),
    ("table_on_floor.ply", Cloud(9000, 9000, &[])),
    ("text_renamed.stl", Refused(&["line 1", "in an STL mesh"])),
    ("tiny_1e-9.obj", Mesh(840, 428, &[])),
    ("tm_featuretype.STL", Mesh(2010, 3476, &[])),
    ("tm_multibody.stl", Mesh(20, 32, &[])),
    ("tm_nancolor.obj", Mesh(8, 12, &["1 colour is not finite"])),
    ("tm_negative_indices.obj", Mesh(8, 12, &[])),
    ("tm_obj_points.obj", Cloud(8, 8, &[])),
    ("tm_points_agisoft.xyz", Cloud(100, 100, &[])),
    ("tm_points_emptyface.ply", Cloud(1024, 1024, &[])),
    ("tm_polygonfaces.obj", Mesh(5, 3, &[])),
    ("tm_soup.stl", Mesh(300, 100, &[])),
    ("tm_stl_empty_bin.stl", Refused(&["no triangles", "export the shape again"])),
    ("tristrips.ply", Mesh(4, 2, &[])),
    ("truncated.glb", Refused(&["byte 12", "is truncated"])),
    ("truncated.ply", Refused(&["byte ", "vertex", "truncated"])),
    ("truncated.stl", Refused(&["byte 80", "declares 428 triangles", "room for at most 98"])),
    ("two_objects_far_apart.ply", Cloud(6000, 6000, &[])),
    ("two_points.xyz", Cloud(2, 2, &[])),
    ("uneven_density_man.ply", Cloud(4083, 4083, &[])),
    ("uniform_cube_noise.ply", Cloud(3000, 3000, &[])),
    ("unreferenced_far_vertex.obj", Mesh(216, 428, &[])),
];

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn every_hard_file_becomes_what_it_should() {
    let folder = shared_data();
    let folder = folder.join("hard");
    let mut wrong = Vec::new();
    for (name, becomes) in &HARD {
        let found = io::read(&folder.join(name));
        let said = match (&found, becomes) {
            (Err(e), Refused(parts)) => {
                let message = e.to_string();
                if parts.iter().all(|part| message.contains(part)) && message.contains(name) {
                    continue;
                }
                message
            }
            (Ok(shape), Mesh(_, _, notes) | Cloud(_, _, notes)) => {
                let are_told = notes.len() == shape.notes.len()
                    && notes.iter().zip(&shape.notes).all(|(part, note)| note.contains(part));
                let (said, is_so) = match (&shape.geometry, becomes) {
                    (ShapeGeometry::Mesh(mesh), Mesh(vertices, faces, _)) => {
                        let counts = (mesh.vertices.len(), mesh.faces.len());
                        let fit = shape.attributes.fit(counts.0);
                        (format!("a mesh of {counts:?}"), fit && counts == (*vertices, *faces))
                    }
                    (ShapeGeometry::Cloud(cloud), Cloud(points, finite, _)) => {
                        let is_finite =
                            cloud.points.iter().filter(|p| p.iter().all(|c| c.is_finite())).count();
                        let counts = (cloud.points.len(), is_finite);
                        let fit = shape.attributes.fit(counts.0);
                        (format!("a cloud of {counts:?}"), fit && counts == (*points, *finite))
                    }
                    (ShapeGeometry::Mesh(_), _) => ("a mesh".to_owned(), false),
                    (ShapeGeometry::Cloud(_), _) => ("a cloud".to_owned(), false),
                };
                if is_so && are_told {
                    continue;
                }
                format!("{said}, {:?}", shape.notes)
            }
            (Ok(_), Refused(_)) => "it was read".to_owned(),
            (Err(e), _) => e.to_string(),
        };
        wrong.push(format!("{name}: {said}"));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A file that is added there must be told here.
#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn no_hard_file_is_forgotten() {
    let folder = shared_data();
    for entry in std::fs::read_dir(folder.join("hard")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(HARD.iter().any(|(known, _)| *known == name), "{name}");
    }
}

/// The first point, colours and labels, as laspy and pypcd4 read them.
#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shapes in ../shared/data")]
fn clouds_have_the_places_and_colors_that_others_read() {
    let folder = shared_data();
    let shape = |name: &str| io::read(&folder.join(name)).unwrap_or_else(|e| panic!("{e}"));
    let first = |name: &str| {
        let ShapeGeometry::Cloud(cloud) = shape(name).geometry else { panic!("{name} is a mesh") };
        cloud.points[0]
    };
    for (name, place) in [
        ("hard/laspy_simple.las", [637_012.24, 849_028.31, 431.66]),
        ("hard/laspy_simple.laz", [637_012.24, 849_028.31, 431.66]),
        ("cloud/table_oak_10k.las", [0.1889, 0.5869, 0.3522]),
        (
            "hard/pcl_milk.pcd",
            [f64::from(0.185_441_6_f32), f64::from(-0.006_209_f32), f64::from(-0.706_432_6_f32)],
        ),
        ("hard/offset_utm_chair.xyz", [449999.8928, 5400000.4415, 119.9322]),
    ] {
        let found = first(name);
        assert!((0..3).all(|k| (found[k] - place[k]).abs() < 1e-6), "{name}: {found}");
    }
    let (las, laz) = (shape("hard/laspy_simple.las"), shape("hard/laspy_simple.laz"));
    assert_eq!(las.attributes, laz.attributes);
    let labels = las.attributes.labels.unwrap();
    assert!(labels.contains(&1) && labels.contains(&2) && labels.iter().all(|l| (1..=2).contains(l)));
    let colors = las.attributes.colors.unwrap();
    let largest = |c: usize| colors.iter().map(|rgb| rgb[c]).max();
    assert_eq!([0, 1, 2].map(largest), [Some(249), Some(239), Some(249)]);
    assert_eq!(
        shape("cloud/table_oak_10k.las").attributes,
        io::Attributes::default(),
        "no colours, no classes"
    );
    for (name, has) in [
        ("hard/pcl_milk.pcd", [true, false]),
        ("hard/organized_nan.pcd", [true, false]),
        ("hard/tm_nancolor.obj", [true, false]),
        ("hard/tm_points_agisoft.xyz", [true, false]),
        ("cloud/mailbox_mofx_6k.pts", [true, false]),
        ("cloud/bottle_yogurt_5k_normals.ply", [false, true]),
        ("cloud/rifle_sniper2_8k.csv", [false, false]),
    ] {
        let found = shape(name).attributes;
        assert_eq!([found.colors.is_some(), found.normals.is_some()], has, "{name}");
        assert_eq!(found.labels, None, "{name}");
    }
}
