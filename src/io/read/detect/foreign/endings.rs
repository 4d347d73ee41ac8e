//! Recognises unsupported formats by file extension, if the content is not conclusive.

use super::advice::{
    CONVERT_CLOUD, CONVERT_MAP, CONVERT_MESH, CONVERT_SOLID, FROM_BLENDER, FROM_RECORDING, Known, NO_SHAPE,
    SAVE_ARRAY, SAVE_TABLE, SAVE_TENSOR,
};

/// Endings in lower case, with what they stand for.
const ENDINGS: [(&[&str], &str, &str); 46] = [
    (&["3mf"], "a 3MF model", CONVERT_MESH),
    (&["usd", "usda", "usdc"], "a USD scene", CONVERT_MESH),
    (&["usdz"], "a USDZ scene", CONVERT_MESH),
    (&["fbx"], "an FBX scene", CONVERT_MESH),
    (&["dae"], "a COLLADA scene", CONVERT_MESH),
    (&["3ds"], "a 3DS scene", CONVERT_MESH),
    (&["max"], "a 3ds Max scene", "export it from 3ds Max as OBJ or STL"),
    (&["ma", "mb"], "a Maya scene", "export it from Maya as OBJ, STL or glTF"),
    (&["c4d"], "a Cinema 4D scene", "export it from Cinema 4D as OBJ or STL"),
    (&["blend", "blend1"], "a Blender scene", FROM_BLENDER),
    (&["lwo", "lws"], "a LightWave object", CONVERT_MESH),
    (&["abc"], "an Alembic scene", CONVERT_MESH),
    (&["x3d", "x3db", "x3dv", "x3dz"], "an X3D scene", CONVERT_MESH),
    (&["wrl", "vrml", "wrz"], "a VRML scene", CONVERT_MESH),
    (&["vtk", "vtp", "vtu", "vti", "vts", "vtr", "vtm"], "a VTK file", CONVERT_MESH),
    (&["amf"], "an AMF model", CONVERT_MESH),
    (&["drc"], "a Draco-compressed mesh", "export it without compression"),
    (&["b3dm", "i3dm", "cmpt"], "a 3D Tiles tile", CONVERT_MESH),
    (&["mesh", "msh"], "a simulation mesh", CONVERT_MESH),
    (&["step", "stp", "stpz", "p21"], "a STEP model", CONVERT_SOLID),
    (&["iges", "igs"], "an IGES model", CONVERT_SOLID),
    (&["brep", "brp"], "a BREP model", CONVERT_SOLID),
    (&["sat", "sab"], "an ACIS model", CONVERT_SOLID),
    (&["x_t", "x_b"], "a Parasolid model", CONVERT_SOLID),
    (&["jt", "catpart", "catproduct", "ipt", "iam", "sldprt", "sldasm", "f3d"], "a CAD model", CONVERT_SOLID),
    (&["3dm"], "a Rhino model", "export it as a mesh (STL, OBJ) from Rhino"),
    (&["skp"], "a SketchUp model", "export it as a mesh (OBJ, STL) from SketchUp"),
    (&["scad"], "an OpenSCAD program", "export it as a mesh (STL) from OpenSCAD"),
    (&["fcstd"], "a FreeCAD document", CONVERT_SOLID),
    (&["dwg", "dxf"], "a CAD drawing", CONVERT_SOLID),
    (&["ifc", "ifczip", "ifcxml"], "an IFC building model", CONVERT_MESH),
    (&["e57"], "an E57 point cloud", CONVERT_CLOUD),
    (
        &["rcp", "rcs"],
        "a ReCap point cloud",
        "export it from ReCap as E57 and convert that with CloudCompare",
    ),
    (&["fls", "fws", "zfs", "ptx", "ptg", "pnts", "lvx", "lvx2"], "a scan", CONVERT_CLOUD),
    (&["pcap", "pcapng"], "a network capture (PCAP)", FROM_RECORDING),
    (&["bag", "db3"], "a ROS bag", FROM_RECORDING),
    (&["mcap"], "an MCAP recording", FROM_RECORDING),
    (
        &["splat", "ksplat", "spz", "sog"],
        "a Gaussian splat file",
        "convert it to PLY, for example with SuperSplat",
    ),
    (&["pt", "pth", "ckpt"], "a PyTorch file", SAVE_TENSOR),
    (&["h5", "hdf5", "mat", "pkl", "pickle", "safetensors", "tfrecord"], "an array file", SAVE_ARRAY),
    (&["npz"], "an NPZ archive without arrays", SAVE_ARRAY),
    (&["xls", "xlsx", "ods"], "a spreadsheet", SAVE_TABLE),
    (&["doc", "docx", "odt", "ppt", "pptx"], "a document", NO_SHAPE),
    (&["geojson", "topojson", "shp", "gpkg", "kml", "kmz"], "a map", CONVERT_MAP),
    (&["nii", "dcm", "nrrd", "vdb"], "a volume", "export its surface as STL, for example with 3D Slicer"),
    (&["mtl"], "a material library (MTL)", "open the OBJ file it belongs to"),
];

/// What files with this ending, in lower case, are.
pub(in crate::io::read::detect) fn by_ending(ending: &str) -> Option<Known> {
    ENDINGS.iter().find(|(endings, ..)| endings.contains(&ending)).map(|&(_, what, advice)| (what, advice))
}
