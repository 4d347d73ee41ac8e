//! What to do about a format that is not read.

/// What a file is, and what to do.
pub(in crate::io::read::detect) type Known = (&'static str, &'static str);

pub(super) const CONVERT_MESH: &str =
    "convert it to OBJ, PLY, STL or glTF, for example with Blender or MeshLab";
pub(super) const CONVERT_CLOUD: &str =
    "convert it to PLY, PCD, LAS or XYZ text, for example with CloudCompare";
pub(super) const CONVERT_SOLID: &str = "export it as a mesh (STL, OBJ) from a CAD program";
pub(super) const CONVERT_MAP: &str = "convert it to XYZ text in metres, for example with QGIS";
pub(super) const FROM_BLENDER: &str = "export it from Blender as OBJ, PLY, STL or glTF";
pub(super) const FROM_RECORDING: &str = "export a cloud from it, for example as PCD";
pub(super) const UNPACK: &str = "extract it first and open the shape inside";
pub(super) const NO_SHAPE: &str = "give a mesh or a point cloud";
pub(super) const SAVE_ARRAY: &str = "save the points as an array (.npy, N×3) or as XYZ text";
pub(super) const SAVE_TENSOR: &str =
    "save its points as an array, for example with np.save(\"points.npy\", tensor.numpy())";
pub(super) const SAVE_TABLE: &str = "save the sheet with the points as CSV";
pub(super) const OPEN_MESHES: &str = "open one of the meshes it refers to";
pub(super) const COPY_AGAIN: &str = "copy or export it again";
