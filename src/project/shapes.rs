//! Shapes and their samples as records.

use std::borrow::Cow;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::raw::Raw;
use crate::geometry::{NO_SAMPLE, SampleCloud, SampledPart, SamplingOptions, TriMesh};
use crate::io::{Attributes, PointCloud, Shape, ShapeGeometry, StoredPath};

/// A shape as it was read.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ShapeEntry<'a> {
    name: Cow<'a, str>,
    /// For people, and to tell where it came from: it is never read again.
    path: Option<Cow<'a, str>>,
    notes: Cow<'a, [String]>,
    geometry: GeometryEntry<'a>,
    /// Not in files of the first releases, which keep the colours of a cloud
    /// with its points.
    #[serde(default)]
    attributes: AttributesEntry<'a>,
    #[serde(default)]
    viewpoints: Cow<'a, [Point3<f64>]>,
}

#[derive(Debug, Default, Serialize, Deserialize)]
struct AttributesEntry<'a> {
    colors: Option<Raw<'a, [u8; 3]>>,
    normals: Option<Raw<'a, [f32; 3]>>,
    labels: Option<Raw<'a, i64>>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum GeometryEntry<'a> {
    Mesh {
        vertices: Raw<'a, Point3<f64>>,
        faces: Raw<'a, [u32; 3]>,
    },
    Cloud {
        points: Raw<'a, Point3<f64>>,
        #[serde(default)]
        colors: Option<Raw<'a, [u8; 3]>>,
    },
}

impl<'a> From<&'a Shape> for ShapeEntry<'a> {
    fn from(shape: &'a Shape) -> Self {
        Self {
            name: Cow::Borrowed(&shape.name),
            path: shape.path.as_deref().map(StoredPath::text),
            notes: Cow::Borrowed(&shape.notes),
            geometry: match &shape.geometry {
                ShapeGeometry::Mesh(mesh) => {
                    GeometryEntry::Mesh { vertices: Raw::of(&mesh.vertices), faces: Raw::of(&mesh.faces) }
                }
                ShapeGeometry::Cloud(cloud) => {
                    GeometryEntry::Cloud { points: Raw::of(&cloud.points), colors: None }
                }
            },
            viewpoints: Cow::Borrowed(&shape.viewpoints),
            attributes: AttributesEntry {
                colors: shape.attributes.colors.as_deref().map(Raw::of),
                normals: shape.attributes.normals.as_deref().map(Raw::of),
                labels: shape.attributes.labels.as_deref().map(Raw::of),
            },
        }
    }
}

impl ShapeEntry<'_> {
    /// The shape, if it is one.
    pub(super) fn checked(self) -> Result<Shape, &'static str> {
        let mut attributes = Attributes {
            colors: self.attributes.colors.map(Raw::into_vec),
            normals: self.attributes.normals.map(Raw::into_vec),
            labels: self.attributes.labels.map(Raw::into_vec),
        };
        let (geometry, count) = match self.geometry {
            GeometryEntry::Mesh { vertices, faces } => {
                let mesh = TriMesh { vertices: vertices.into_vec(), faces: faces.into_vec() };
                if mesh.faces.iter().flatten().any(|&i| i as usize >= mesh.vertices.len()) {
                    return Err("has a face that refers to missing vertices");
                }
                let count = mesh.vertices.len();
                (ShapeGeometry::Mesh(mesh), count)
            }
            GeometryEntry::Cloud { points, colors } => {
                let cloud = PointCloud { points: points.into_vec() };
                attributes.colors = attributes.colors.or(colors.map(Raw::into_vec));
                let count = cloud.points.len();
                (ShapeGeometry::Cloud(cloud), count)
            }
        };
        if !attributes.fit(count) {
            return Err("does not have one colour, normal or label per point");
        }
        Ok(Shape {
            name: self.name.into_owned(),
            path: self.path.map(|path| StoredPath::of(&path).0),
            content: None,
            geometry,
            attributes,
            viewpoints: are_places(&self.viewpoints)?,
            notes: self.notes.into_owned(),
        })
    }
}

/// Viewpoints, if they can be such.
fn are_places(viewpoints: &[Point3<f64>]) -> Result<Vec<Point3<f64>>, &'static str> {
    if viewpoints.iter().flat_map(|p| p.iter()).all(|c| c.is_finite()) {
        Ok(viewpoints.to_vec())
    } else {
        Err("has a viewpoint with non-finite coordinates")
    }
}

/// The samples of a shape.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct CloudEntry<'a> {
    points: Raw<'a, Point3<f64>>,
    sample_of_input: Option<Raw<'a, u32>>,
    part: SampledPart,
    #[serde(default)]
    viewpoints: Cow<'a, [Point3<f64>]>,
}

impl<'a> From<&'a SampleCloud> for CloudEntry<'a> {
    fn from(cloud: &'a SampleCloud) -> Self {
        Self {
            points: Raw::of(&cloud.points),
            sample_of_input: cloud.sample_of_input.as_deref().map(Raw::of),
            part: cloud.part,
            viewpoints: Cow::Borrowed(&cloud.viewpoints),
        }
    }
}

impl CloudEntry<'_> {
    /// The samples, if they can be such.
    pub(super) fn checked(self) -> Result<SampleCloud, &'static str> {
        let points = self.points.into_vec();
        if !points.iter().all(|p| p.iter().all(|c| c.is_finite())) {
            return Err("has a sample with non-finite coordinates");
        }
        let sample_of_input = self.sample_of_input.map(Raw::into_vec);
        let is_sample = |&i: &u32| i == NO_SAMPLE || (i as usize) < points.len();
        if !sample_of_input.iter().flatten().all(is_sample) {
            return Err("has an input point that refers to a missing sample");
        }
        Ok(SampleCloud {
            points,
            sample_of_input,
            part: self.part,
            viewpoints: are_places(&self.viewpoints)?,
        })
    }
}

/// A shape with its samples, by the numbers of their records.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct LoadedEntry {
    pub(super) generation: u64,
    pub(super) shape: u32,
    pub(super) cloud: u32,
    pub(super) sampling: SamplingOptions,
}

/// Whether the samples can be those of the shape.
pub(super) fn belong_together(shape: &Shape, cloud: &SampleCloud) -> bool {
    match &shape.geometry {
        ShapeGeometry::Mesh(_) => cloud.sample_of_input.is_none(),
        ShapeGeometry::Cloud(input) => {
            cloud.sample_of_input.as_ref().is_some_and(|map| map.len() == input.points.len())
        }
    }
}
