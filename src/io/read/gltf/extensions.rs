//! Required extensions, and whether the shape can be read without them.

use crate::io::error::Fault;
use crate::io::read::text::quoted_up_to;

/// Starts of the names of extensions that leave vertices where they are, or
/// that are read.
const HARMLESS: [&str; 36] = [
    // Read.
    "EXT_mesh_gpu_instancing",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    // How surfaces look, and what lights them.
    "ADOBE_materials_",
    "CESIUM_primitive_outline",
    "EXT_lights_",
    "EXT_texture_",
    "FB_materials_",
    "GRIFFEL_bim_data",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_techniques_webgl",
    "KHR_texture_",
    "MSFT_packing_",
    "MSFT_texture_",
    "NV_materials_",
    "EXT_materials_",
    "MPEG_material_",
    "MPEG_texture_",
    // What is said or done beside the shape.
    "AGI_",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_xmp",
    "MSFT_audio_emitter",
    "MSFT_lod",
    "VRM",
];

/// Whether an extension packs vertices in a way that is not read.
pub(super) fn is_compression(name: &str) -> bool {
    name.contains("draco") || name.contains("meshopt") || name.contains("compression")
}

pub(super) fn compressed(name: &str) -> Fault {
    Fault::whole(format!(
        "its meshes are compressed ({name}), which is not supported; export it without compression"
    ))
}

/// Refuses what changes the shape, or may.
pub(super) fn check(required: &[String]) -> Result<(), Fault> {
    if let Some(name) = required.iter().find(|name| is_compression(name)) {
        return Err(compressed(name));
    }
    let unknown: Vec<String> = required
        .iter()
        .filter(|name| !HARMLESS.iter().any(|start| name.starts_with(start)))
        .map(|name| quoted_up_to(name, 64))
        .collect();
    let (it, them) = if unknown.len() == 1 { ("extension", "it") } else { ("extensions", "them") };
    if unknown.is_empty() {
        return Ok(());
    }
    Err(Fault::whole(format!(
        "it requires the {it} {}, which cannot be read; export it without {them}",
        unknown.join(", ")
    )))
}
