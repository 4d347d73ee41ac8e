//! Transforms of nodes and their meshes' vertices.

use nalgebra::{Matrix4, Point3, Quaternion, UnitQuaternion, Vector3};

use super::accessors::Data;
use super::schema::{Instancing, Node};
use crate::io::error::Fault;

/// From a node's coordinates to those of its parent.
pub(super) fn local_transform(node: &Node) -> Matrix4<f64> {
    if let Some(columns) = &node.matrix {
        return Matrix4::from_column_slice(columns);
    }
    transform(
        node.translation.unwrap_or([0.0; 3]),
        node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
        node.scale.unwrap_or([1.0; 3]),
    )
}

fn transform(translation: [f64; 3], [x, y, z, w]: [f64; 4], scale: [f64; 3]) -> Matrix4<f64> {
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0).unwrap_or_default();
    Matrix4::new_translation(&Vector3::from(translation))
        * rotation.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&Vector3::from(scale))
}

/// The transforms of the instances of a node's mesh, within the node; `None`
/// where no attribute places them.
pub(super) fn instances(
    instancing: &Instancing,
    data: &Data<'_>,
) -> Result<Option<impl Iterator<Item = Matrix4<f64>> + use<>>, Fault> {
    let accessor = |name: &str| instancing.attributes.get(name).copied();
    let translations = accessor("TRANSLATION").map(|a| data.vectors(a)).transpose()?;
    let rotations = accessor("ROTATION").map(|a| data.vectors(a)).transpose()?;
    let scales = accessor("SCALE").map(|a| data.vectors(a)).transpose()?;
    let counts = [
        translations.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
    ];
    let mut counts = counts.into_iter().flatten();
    let Some(count) = counts.next() else { return Ok(None) };
    if counts.any(|other| other != count) {
        let problem = "the attributes of its instances differ in number; export the shape again";
        return Err(Fault::whole(problem));
    }
    let place = move |i: usize| {
        transform(
            translations.as_ref().map_or([0.0; 3], |all| all[i]),
            rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[i]),
            scales.as_ref().map_or([1.0; 3], |all| all[i]),
        )
    };
    Ok(Some((0..count).map(place)))
}

pub(super) fn placed(world: &Matrix4<f64>, vertex: &[f64; 3]) -> Point3<f64> {
    Point3::from(world.fixed_view::<3, 3>(0, 0) * Vector3::from(*vertex) + world.fixed_view::<3, 1>(0, 3))
}
