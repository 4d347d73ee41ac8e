//! glTF: what places vertices, what stores them, and extensions.

use crate::formats::f32s;
use serde_json::{Value, json};
use superform::io::{Shape, ShapeGeometry, read, read_bytes};

/// A scene of one node with a mesh of one primitive, to be changed, and the
/// numbers that it is made of.
struct Scene {
    json: Value,
    bytes: Vec<u8>,
}

const CORNERS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

impl Scene {
    /// A triangle at the origin.
    fn triangle() -> Self {
        let mut scene = Self {
            json: json!({
                "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [],
                "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {}}]}],
            }),
            bytes: Vec::new(),
        };
        let position = scene.numbers("VEC3", 5126, 3, &f32s(&CORNERS));
        scene.primitive()["attributes"]["POSITION"] = position;
        scene
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    fn node(&mut self) -> &mut Value {
        &mut self.json["nodes"][0]
    }

    fn list(&mut self, name: &str) -> &mut Vec<Value> {
        self.json[name].as_array_mut().unwrap()
    }

    /// A view of some bytes.
    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()});
        self.list("bufferViews").push(view);
        self.list("bufferViews").len() - 1
    }

    /// An accessor of some numbers.
    fn numbers(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> Value {
        let view = self.view(bytes);
        self.accessor(json!({"bufferView": view, "type": kind, "componentType": component, "count": count}))
    }

    fn accessor(&mut self, accessor: Value) -> Value {
        self.list("accessors").push(accessor);
        (self.list("accessors").len() - 1).into()
    }

    fn requires(mut self, name: &str) -> Self {
        self.json["extensionsUsed"] = json!([name]);
        self.json["extensionsRequired"] = json!([name]);
        self
    }

    /// The file, with so many bytes of padding behind each part.
    fn glb(&self, padding: usize) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        let json = json.to_string().into_bytes();
        let mut parts = Vec::new();
        for (kind, part) in [(b"JSON", &json), (b"BIN\0", &self.bytes)] {
            parts.extend((part.len() as u32).to_le_bytes());
            parts.extend(kind);
            parts.extend(part);
            parts.extend(vec![0; padding]);
        }
        let length = (12 + parts.len() as u32).to_le_bytes();
        [b"glTF\x02\0\0\0", &length[..], &parts].concat()
    }

    fn shape(&self) -> Shape {
        let found = self.padded().and_then(|glb| read_bytes(&glb, "a.glb").ok());
        found.unwrap_or_else(|| panic!("{}", self.refusal()))
    }

    /// As the specification has it.
    fn padded(&self) -> Option<Vec<u8>> {
        let mut scene = Self { json: self.json.clone(), bytes: self.bytes.clone() };
        for blanks in 0..4 {
            scene.json["asset"]["generator"] = " ".repeat(blanks).into();
            let glb = scene.glb(0);
            if glb.len().is_multiple_of(4) {
                return Some(glb);
            }
        }
        None
    }

    fn refusal(&self) -> String {
        read_bytes(&self.padded().unwrap(), "a.glb")
            .map(|shape| format!("{shape:?}"))
            .unwrap_err()
            .to_string()
    }

    /// Corners of all triangles.
    fn corners(&self) -> Vec<[f64; 3]> {
        corners(&self.shape())
    }
}

fn corners(shape: &Shape) -> Vec<[f64; 3]> {
    let ShapeGeometry::Mesh(mesh) = &shape.geometry else { panic!("a cloud: {:?}", shape.notes) };
    let corner = |i: &u32| mesh.vertices[*i as usize];
    mesh.faces
        .iter()
        .flatten()
        .map(corner)
        .map(|p| [p.x, p.y, p.z].map(|v| (v * 1e6).round() / 1e6))
        .collect()
}

const FLAT: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn moved(corners: &[[f64; 3]], by: [f64; 3]) -> Vec<[f64; 3]> {
    corners.iter().map(|c| [c[0] + by[0], c[1] + by[1], c[2] + by[2]]).collect()
}

#[test]
fn instances_are_placed_by_any_of_their_attributes() {
    let instanced = |attributes: &[(&str, &str, u32, bool, Vec<u8>)]| {
        let mut scene = Scene::triangle().requires("EXT_mesh_gpu_instancing");
        let mut names = json!({});
        for (name, kind, component, normalized, bytes) in attributes {
            let accessor = scene.numbers(kind, *component, 2, bytes);
            scene.list("accessors").last_mut().unwrap()["normalized"] = json!(normalized);
            names[*name] = accessor;
        }
        scene.node()["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": names}});
        scene
    };
    let translation = || ("TRANSLATION", "VEC3", 5126, false, f32s(&[0.0, 0.0, 5.0, 7.0, 0.0, 0.0]));
    let scale = || ("SCALE", "VEC3", 5126, false, f32s(&[2.0, 2.0, 2.0, 1.0, 1.0, 1.0]));
    // Nothing, and a half turn around z: as floats, and as integers that stand for −1 to 1.
    let float = || ("ROTATION", "VEC4", 5126, false, f32s(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]));
    let byte = || ("ROTATION", "VEC4", 5120, true, vec![0, 0, 0, 127, 0, 0, 127, 0]);
    let short: Vec<u8> = [0i16, 0, 0, 32767, 0, 0, 32767, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let short = || ("ROTATION", "VEC4", 5122, true, short.clone());
    let turned = vec![[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    let doubled: Vec<[f64; 3]> = FLAT.iter().map(|c| c.map(|v| 2.0 * v)).collect();
    let both = |first: &[[f64; 3]], second: &[[f64; 3]]| [first, second].concat();
    let translated = both(&moved(&FLAT, [0.0, 0.0, 5.0]), &moved(&FLAT, [7.0, 0.0, 0.0]));
    assert_eq!(instanced(&[translation()]).corners(), translated);
    assert_eq!(instanced(&[scale()]).corners(), both(&doubled, &FLAT));
    for rotation in [float(), byte(), short()] {
        assert_eq!(instanced(&[rotation]).corners(), both(&FLAT, &turned));
    }
    let all = instanced(&[translation(), short(), scale()]).corners();
    let expected = both(&moved(&doubled, [0.0, 0.0, 5.0]), &moved(&turned, [7.0, 0.0, 0.0]));
    assert_eq!(all, expected);
    // Within the node, wherever that is.
    let mut below = instanced(&[translation()]);
    below.node()["translation"] = json!([1.0, 2.0, 3.0]);
    below.node()["scale"] = json!([2.0, 1.0, 1.0]);
    let wide: Vec<[f64; 3]> = translated.iter().map(|c| [2.0 * c[0], c[1], c[2]]).collect();
    assert_eq!(below.corners(), moved(&wide, [1.0, 2.0, 3.0]));
    // Attributes that place nothing make no copies.
    let ids = ("_ID", "SCALAR", 5126, false, f32s(&[0.0, 1.0]));
    assert_eq!(instanced(&[ids]).corners(), FLAT);
    let mut uneven = instanced(&[translation(), scale()]);
    uneven.list("accessors")[2]["count"] = json!(1);
    assert!(uneven.refusal().contains("instances differ in number"), "{}", uneven.refusal());
}

#[test]
fn morph_targets_stand_at_their_default_weights() {
    let lift = f32s(&[0.0, 0.0, 4.0].repeat(3));
    let morphed = |mesh: Value, node: Value| {
        let mut scene = Scene::triangle();
        let dense = scene.numbers("VEC3", 5126, 3, &lift);
        // The last vertex alone, in a sparse accessor without a base.
        let (at, by) = (scene.view(&[2]), scene.view(&f32s(&[10.0, 0.0, 0.0])));
        let sparse = scene.accessor(json!({
            "type": "VEC3", "componentType": 5126, "count": 3,
            "sparse": {"count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": by}},
        }));
        scene.primitive()["targets"] = json!([{"POSITION": dense}, {"NORMAL": 0}, {"POSITION": sparse}]);
        scene.json["meshes"][0]["weights"] = mesh;
        if !node.is_null() {
            scene.node()["weights"] = node;
        }
        scene
    };
    let none = json!([]);
    assert_eq!(morphed(none.clone(), Value::Null).corners(), FLAT);
    assert_eq!(morphed(json!([0.5]), Value::Null).corners(), moved(&FLAT, [0.0, 0.0, 2.0]));
    assert_eq!(morphed(json!([1, 0, 0]), json!([0, 0, 0])).corners(), FLAT, "the node's go first");
    let last = vec![FLAT[0], FLAT[1], [-5.0, 1.0, 0.0]];
    assert_eq!(morphed(none, json!([0, 1, -0.5])).corners(), last);
    let mut points = morphed(json!([1]), Value::Null);
    points.primitive()["mode"] = json!(0);
    let ShapeGeometry::Cloud(cloud) = points.shape().geometry else { panic!("a mesh") };
    assert!(cloud.points.iter().all(|p| p.z == 4.0));
    let mut short = morphed(json!([1]), Value::Null);
    short.list("accessors")[1]["count"] = json!(2);
    assert!(short.refusal().contains("a morph target moves 2 vertices of 3"), "{}", short.refusal());
}

#[test]
fn parts_are_found_with_any_padding() {
    // Blanks in the JSON part give it every length; its end and that of the
    // binary part may be padded as they should, otherwise, or not at all.
    for blanks in 0..4 {
        for padding in 0..4 {
            let mut scene = Scene::triangle();
            scene.json["asset"]["generator"] = " ".repeat(blanks).into();
            for odd in 0..2 {
                scene.bytes.resize(36 + odd, 0);
                let shape = read_bytes(&scene.glb(padding), "a.glb");
                let shape = shape.unwrap_or_else(|e| panic!("{blanks} blanks, {padding} bytes, {odd}: {e}"));
                assert_eq!(corners(&shape), FLAT);
            }
        }
    }
    // The padding of the last part is counted, but not there.
    let mut cut = Scene::triangle().glb(0);
    let at = cut.len() - 36 - 8;
    cut[at..at + 4].copy_from_slice(&39u32.to_le_bytes());
    assert_eq!(corners(&read_bytes(&cut, "a.glb").unwrap()), FLAT);
    cut.truncate(cut.len() - 4);
    assert!(read_bytes(&cut, "a.glb").unwrap_err().to_string().contains("truncated"));
}

#[test]
fn required_extensions_that_change_the_shape_are_refused_by_name() {
    for name in [
        "KHR_materials_unlit",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_texture_transform",
        "KHR_texture_basisu",
        "KHR_lights_punctual",
        "KHR_mesh_quantization",
        "EXT_texture_webp",
        "EXT_structural_metadata",
        "VRMC_vrm",
    ] {
        assert_eq!(Scene::triangle().requires(name).corners(), FLAT, "{name}");
    }
    for (name, words) in [
        ("VENDOR_unknown_geometry", "requires the extension “VENDOR_unknown_geometry”"),
        ("EXT_primitive_voxels", "requires the extension “EXT_primitive_voxels”"),
        ("KHR_draco_mesh_compression", "compressed (KHR_draco_mesh_compression)"),
        ("EXT_meshopt_compression", "compressed (EXT_meshopt_compression)"),
        ("KHR_gaussian_splatting_compression_spz", "compressed (KHR_gaussian_splatting_compression_spz)"),
    ] {
        let message = Scene::triangle().requires(name).refusal();
        assert!(message.contains(words) && message.contains("export it without"), "{message}");
    }
    // One that is used without need says what is there without it, if anything is.
    let mut optional = Scene::triangle();
    optional.primitive()["extensions"] = json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    assert_eq!(optional.corners(), FLAT);
    optional.list("accessors")[0].as_object_mut().unwrap().remove("bufferView");
    assert!(optional.refusal().contains("compressed (KHR_draco_mesh_compression)"), "{}", optional.refusal());
    let mut optional = Scene::triangle();
    optional.list("bufferViews")[0]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 0}});
    assert_eq!(optional.corners(), FLAT);
    optional.list("bufferViews")[0]["buffer"] = json!(1);
    let mut json = optional.json.clone();
    json["buffers"] = json!([{"byteLength": 36, "uri": "data:,"}, {"byteLength": 36}]);
    let message = read_bytes(json.to_string().as_bytes(), "a.gltf").unwrap_err().to_string();
    assert!(message.contains("compressed (EXT_meshopt_compression)"), "{message}");
    // What comes before version 2 looks otherwise.
    let old = br#"{"asset": {"version": "1.0"}, "meshes": {"a": {}}, "buffers": {}}"#;
    assert!(read_bytes(old, "a.gltf").unwrap_err().to_string().contains("it is glTF 1.0, but only glTF 2"));
}

#[test]
fn numbers_are_read_as_they_are_stored() {
    // Quantised positions, with and without a scale of their own.
    for (component, normalized, one, corners) in [
        (5121, false, 1.0, vec![0, 0, 0, 1, 0, 0, 0, 1, 0]),
        (5121, true, 255.0, vec![0, 0, 0, 255, 0, 0, 0, 255, 0]),
    ] {
        let mut scene = Scene::triangle().requires("KHR_mesh_quantization");
        // Rows of four bytes.
        let rows: Vec<u8> = corners.chunks(3).flat_map(|c: &[u8]| [c, &[0]].concat()).collect();
        let position = scene.numbers("VEC3", component, 3, &rows);
        scene.list("accessors")[1]["normalized"] = json!(normalized);
        scene.list("bufferViews")[1]["byteStride"] = json!(4);
        scene.primitive()["attributes"]["POSITION"] = position;
        assert_eq!(scene.corners(), FLAT, "{one}");
    }
    for (component, bytes) in [
        (5121, vec![0, 1, 2]),
        (5123, vec![0, 0, 1, 0, 2, 0]),
        (5125, vec![0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]),
    ] {
        let mut scene = Scene::triangle();
        scene.primitive()["indices"] = scene.numbers("SCALAR", component, 3, &bytes);
        assert_eq!(scene.corners(), FLAT, "{component}");
    }
    // Strips and fans keep their sides.
    let square = f32s(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    for (mode, order) in [(5, [0, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        let mut scene = Scene::triangle();
        scene.primitive()["attributes"]["POSITION"] = scene.numbers("VEC3", 5126, 4, &square);
        scene.primitive()["indices"] = scene.numbers("SCALAR", 5121, 4, &order);
        scene.primitive()["mode"] = json!(mode);
        let ShapeGeometry::Mesh(mesh) = scene.shape().geometry else { panic!("a cloud") };
        let up =
            mesh.faces.iter().map(|f| mesh.corners(f).unwrap()).map(|[a, b, c]| (b - a).cross(&(c - a)).z);
        assert_eq!(up.collect::<Vec<_>>(), [1.0, 1.0], "mode {mode}");
    }
    let mut lines = Scene::triangle();
    lines.primitive()["mode"] = json!(3);
    assert!(
        lines.refusal().contains("contains lines, but neither triangles nor points"),
        "{}",
        lines.refusal()
    );
    // A mirrored mesh is turned right side out.
    let mut mirrored = Scene::triangle();
    mirrored.node()["scale"] = json!([-1.0, 1.0, 1.0]);
    assert_eq!(mirrored.corners(), [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    // Colours in whole numbers that don't say what they stand for.
    let mut colored = Scene::triangle();
    colored.primitive()["attributes"]["COLOR_0"] =
        colored.numbers("VEC4", 5121, 3, &[255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255]);
    assert_eq!(colored.shape().attributes.colors, Some(vec![[255, 0, 0]; 3]));
    // Several scenes, hidden nodes.
    let mut scenes = Scene::triangle();
    scenes.json["scenes"] = json!([{"nodes": []}, {"nodes": [0, 1]}]);
    scenes.json["scene"] = json!(1);
    scenes.json["nodes"] =
        json!([{"mesh": 0}, {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}}]);
    assert_eq!(scenes.corners(), FLAT);
    let notes = scenes.shape().notes.join("; ");
    assert!(
        notes.contains("the file has 2 scenes") && notes.contains("1 node hidden in the file"),
        "{notes}"
    );
}

#[test]
fn buffers_are_found_wherever_they_are() {
    let scene = Scene::triangle();
    let folder = tempfile::tempdir().unwrap();
    for name in ["a b.bin", "100%.bin", "a%20c.bin", "bü.bin", "sub/d.bin"] {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, &scene.bytes).unwrap();
    }
    let with = |uri: &str| {
        let mut json = scene.json.clone();
        json["buffers"] =
            json!([{"byteLength": 36, "uri": uri}, {"byteLength": 9, "uri": "never needed.bin"}]);
        let path = folder.path().join("a.gltf");
        std::fs::write(&path, json.to_string()).unwrap();
        read(&path)
    };
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let percent: String = scene.bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
    for uri in [
        "a%20b.bin",
        "a b.bin",
        "100%.bin",
        "a%20c.bin",
        "b%C3%BC.bin",
        "sub/d.bin",
        "sub\\d.bin",
        &format!("data:application/octet-stream;base64,{base64}"),
        &format!("data:application/gltf-buffer;charset=utf-8;base64,{base64}"),
        &format!("data:;base64,{base64}"),
        &format!("DATA:application/x-odd;BASE64,{}", base64.replace('/', "%2F")),
        &format!("data:application/octet-stream,{percent}"),
    ] {
        assert_eq!(corners(&with(uri).unwrap_or_else(|e| panic!("{uri}: {e}"))), FLAT, "{uri}");
    }
    let message = with("gone.bin").unwrap_err().to_string();
    assert!(
        message.contains("a second file")
            && message.contains("gone.bin")
            && message.contains("file or folder not found")
    );
}
