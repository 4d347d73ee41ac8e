//! glTF 2.0, as text and binary (GLB): the triangles of a scene in world coordinates, with vertex
//! colours and normals, or its points if it has no triangles. Morph targets are applied at their
//! default weights. Materials, textures, animations and skins are ignored.
//!
//! The JSON is parsed here rather than by a glTF library, because those compute in single
//! precision, keep indices without checking them against the buffers, and reject files for errors
//! in irrelevant parts.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use nalgebra::{Matrix4, Point3, Vector3};

use super::columns;
use super::raw::Raw;
use super::text::{counted, decode, shortened};
use crate::io::error::Fault;
use accessors::Data;
pub use beside::buffers_beside;
pub(crate) use buffers::percent_bytes;
use placing::{instances, local_transform, placed};
use schema::{Head, Primitive, Root};

mod accessors;
mod beside;
mod buffers;
mod extensions;
mod placing;
mod schema;

/// Vertices and triangles that a scene may have beyond those that its buffers
/// hold: each node gets its copy of its mesh, so that a small file can ask for
/// any number.
const MOST_COPIED: usize = 1 << 22;

/// Whether a text starts like a glTF file.
pub(super) fn is_gltf(start: &str, end: &[u8]) -> bool {
    let key = b"\"asset\"";
    start.trim_start().starts_with('{')
        && (start.contains("\"asset\"") || end.windows(key.len()).any(|w| w == key))
}

/// Reads a file's content; buffers in files of their own are looked for from
/// `folder` on, where there is one.
pub(super) fn parse(bytes: &[u8], folder: Option<&Path>) -> Result<Raw, Fault> {
    if bytes.starts_with(b"glTF") {
        let (json, blob) = buffers::chunks(bytes)?;
        let broken = |e| Fault::at_byte(20, format!("its JSON part cannot be parsed: {e}"));
        check(&serde_json::from_slice(json).map_err(broken)?)?;
        let root = serde_json::from_slice(json).map_err(broken)?;
        Scene::new(&root, blob, folder).read()
    } else {
        let text = decode(bytes);
        let broken = |e: serde_json::Error| {
            Fault::at_line(e.line(), format!("it is not the JSON of a glTF scene: {e}"))
        };
        check(&serde_json::from_str(&text).map_err(broken)?)?;
        let root = serde_json::from_str(&text).map_err(broken)?;
        Scene::new(&root, None, folder).read()
    }
}

/// Rejects unsupported files before the rest is parsed, which may have a different layout.
fn check(head: &Head) -> Result<(), Fault> {
    let version = &head.asset.version;
    let version = version.as_str().map_or_else(|| version.to_string(), str::to_owned);
    if version != "null" && !version.starts_with('2') {
        let problem = format!(
            "it is glTF {}, but only glTF 2 is supported; export the shape again",
            shortened(&version, 24)
        );
        return Err(Fault::whole(problem));
    }
    extensions::check(&head.extensions_required)
}

/// A scene that is being walked.
struct Scene<'a> {
    root: &'a Root,
    data: Data<'a>,
    raw: Raw,
    /// Points of the primitives that show points, with their colours.
    points: Vec<Point3<f64>>,
    colors: Vec<[u8; 3]>,
    /// Primitives of lines, nodes with a skin, and hidden ones.
    lines: usize,
    bent: usize,
    hidden: usize,
    /// Of the vertices of the triangles, as far as they have any.
    surface: SurfaceAttributes,
    /// Vertices or triangles that it may have.
    most: usize,
}

/// Colours and normals of the vertices of all triangles, with something in the
/// place of those that are missing.
#[derive(Default)]
struct SurfaceAttributes {
    colors: Vec<[u8; 3]>,
    has_colors: bool,
    normals: Vec<[f32; 3]>,
    lacks_normals: bool,
}

impl<'a> Scene<'a> {
    fn new(root: &'a Root, blob: Option<&'a [u8]>, folder: Option<&Path>) -> Self {
        let data = Data::new(root, blob, folder);
        // Indices of vertices are 32 bits wide.
        let most = data.bytes().saturating_add(MOST_COPIED).min(u32::MAX as usize);
        Self {
            root,
            data,
            raw: Raw::default(),
            points: Vec::new(),
            colors: Vec::new(),
            lines: 0,
            bent: 0,
            hidden: 0,
            surface: SurfaceAttributes::default(),
            most,
        }
    }

    fn read(mut self) -> Result<Raw, Fault> {
        let mut seen = HashSet::new();
        let mut waiting: Vec<(usize, Matrix4<f64>)> =
            self.roots()?.into_iter().rev().map(|i| (i, Matrix4::identity())).collect();
        if self.root.nodes.is_empty() {
            // Meshes without a scene stand where they are.
            for mesh in 0..self.root.meshes.len() {
                self.mesh(mesh, &Matrix4::identity(), None)?;
            }
        }
        while let Some((index, parent_world)) = waiting.pop() {
            let node = entry(&self.root.nodes, index, "node")?;
            if !seen.insert(index) {
                let problem = format!("node {index} has more than one parent; export the shape again");
                return Err(Fault::whole(problem));
            }
            if node.extensions.visibility.as_ref().is_some_and(|v| !v.visible) {
                self.hidden += 1;
                continue;
            }
            let world = parent_world * local_transform(node);
            if let Some(mesh) = node.mesh {
                self.bent += usize::from(node.skin.is_some());
                let weights = node.weights.as_deref();
                let instancing = node.extensions.instancing.as_ref();
                match instancing.map(|i| instances(i, &self.data)).transpose()?.flatten() {
                    Some(all) => {
                        for instance in all {
                            self.mesh(mesh, &(world * instance), weights)?;
                        }
                    }
                    None => self.mesh(mesh, &world, weights)?,
                }
            }
            waiting.extend(node.children.iter().rev().map(|&child| (child, world)));
        }
        self.finish()
    }

    /// The nodes at the top of the scene that is shown.
    fn roots(&self) -> Result<Vec<usize>, Fault> {
        if !self.root.scenes.is_empty() {
            return Ok(entry(&self.root.scenes, self.root.scene.unwrap_or(0), "scene")?.nodes.clone());
        }
        let children: HashSet<usize> = self.root.nodes.iter().flat_map(|n| &n.children).copied().collect();
        let roots: Vec<usize> = (0..self.root.nodes.len()).filter(|i| !children.contains(i)).collect();
        if roots.is_empty() && !children.is_empty() {
            return Err(Fault::whole("its nodes form a cycle; export the shape again"));
        }
        Ok(roots)
    }

    fn finish(mut self) -> Result<Raw, Fault> {
        let has_triangles = !self.raw.triangles.is_empty() || self.raw.faces_out_of_range > 0;
        if !has_triangles && self.points.is_empty() {
            // What was not needed may be why.
            self.data.check()?;
            return Err(Fault::whole(if self.lines > 0 {
                "its scene contains lines, but neither triangles nor points; export the surfaces as well"
            } else {
                "its scene contains neither triangles nor points; export the shape again"
            }));
        }
        if self.root.scenes.len() > 1 {
            let scenes = self.root.scenes.len();
            self.raw.notes.push(format!("the file has {scenes} scenes; only the default scene was read"));
        }
        for (n, what) in [
            (
                if has_triangles { self.points.len() } else { 0 },
                counted(self.points.len(), "point", "points"),
            ),
            (self.lines, counted(self.lines, "set of lines", "sets of lines")),
        ] {
            if n > 0 {
                self.raw.notes.push(format!("ignored {what} next to the surfaces"));
            }
        }
        if self.hidden > 0 {
            let nodes = counted(self.hidden, "node", "nodes");
            self.raw.notes.push(format!("ignored {nodes} hidden in the file"));
        }
        if self.bent > 0 {
            let meshes = counted(self.bent, "mesh is", "meshes are");
            self.raw.notes.push(format!("{meshes} in rest position: skins are not applied"));
        }
        if !has_triangles {
            self.raw.attributes.colors = (self.colors.len() == self.points.len()).then_some(self.colors);
            self.raw.points = self.points;
            return Ok(self.raw);
        }
        let surface = self.surface;
        self.raw.attributes.colors = surface.has_colors.then_some(surface.colors);
        self.raw.attributes.normals =
            Some(surface.normals).filter(|_| !surface.lacks_normals).and_then(columns::normals);
        Ok(self.raw)
    }

    fn check_size(&self, count: usize) -> Result<(), Fault> {
        let most = self.most;
        let problem =
            || format!("its scene repeats meshes to more than {most} vertices or faces; reduce it first");
        if count > most { Err(Fault::whole(problem())) } else { Ok(()) }
    }

    /// Shows a mesh, its morph targets at the weights of the node where that has
    /// some.
    fn mesh(&mut self, index: usize, world: &Matrix4<f64>, weights: Option<&[f64]>) -> Result<(), Fault> {
        let mesh = entry(&self.root.meshes, index, "mesh")?;
        let weights = weights.unwrap_or(&mesh.weights);
        // Primitives of one mesh often share their vertices.
        let mut first_of = HashMap::new();
        for primitive in &mesh.primitives {
            let Some(&position) = primitive.attributes.get("POSITION") else { continue };
            self.check_content(primitive, position)?;
            let moves = |name: &str| Moves::of(primitive, name, weights);
            match primitive.mode {
                0 => self.show_points(primitive, position, &moves("POSITION"), world)?,
                1..=3 => self.lines += 1,
                4..=6 => {
                    let sources = Sources {
                        position: (position, moves("POSITION")),
                        normal: primitive.attributes.get("NORMAL").map(|&a| (a, moves("NORMAL"))),
                        color: primitive.attributes.get("COLOR_0").copied(),
                    };
                    self.show_triangles(primitive, sources, world, &mut first_of)?;
                }
                mode => {
                    let problem = format!("mesh {index} has the unknown mode {mode}; export the shape again");
                    return Err(Fault::whole(problem));
                }
            }
        }
        Ok(())
    }

    /// Refuses vertices that are nowhere but in a compressed form.
    fn check_content(&self, primitive: &Primitive, position: usize) -> Result<(), Fault> {
        let about = entry(&self.root.accessors, position, "accessor")?;
        let packed = primitive.extensions.keys().find(|name| extensions::is_compression(name));
        match packed.filter(|_| about.buffer_view.is_none() && about.sparse.is_none()) {
            Some(name) => Err(extensions::compressed(name)),
            None => Ok(()),
        }
    }

    /// Positions or normals with what morph targets add to them.
    fn moved(&self, accessor: usize, moves: &Moves) -> Result<Vec<[f64; 3]>, Fault> {
        let mut vectors: Vec<[f64; 3]> = self.data.vectors(accessor)?;
        for &(target, weight) in &moves.0 {
            let by: Vec<[f64; 3]> = self.data.vectors(target)?;
            if by.len() != vectors.len() {
                let (n, vertices) = (by.len(), vectors.len());
                let problem =
                    format!("a morph target moves {n} vertices of {vertices}; export the shape again");
                return Err(Fault::whole(problem));
            }
            let weight = f64::from_bits(weight);
            for (vector, by) in vectors.iter_mut().zip(by) {
                vector.iter_mut().zip(by).for_each(|(v, by)| *v += weight * by);
            }
        }
        Ok(vectors)
    }

    fn show_points(
        &mut self,
        primitive: &Primitive,
        position: usize,
        moves: &Moves,
        world: &Matrix4<f64>,
    ) -> Result<(), Fault> {
        let vertices = self.moved(position, moves)?;
        let colors = match primitive.attributes.get("COLOR_0") {
            Some(&accessor) => self.data.colors(accessor)?,
            None => Vec::new(),
        };
        let order: Vec<usize> = match primitive.indices {
            Some(accessor) => self.data.indices(accessor)?,
            None => (0..vertices.len()).collect(),
        };
        self.check_size(self.points.len() + order.len())?;
        for i in order {
            let Some(vertex) = vertices.get(i) else { continue };
            self.points.push(placed(world, vertex));
            self.colors.extend(colors.get(i).map(|rgb| rgb.map(srgb_byte)));
        }
        Ok(())
    }

    /// Notes the colours and normals of as many vertices. What is wrong with
    /// them costs them, not the shape.
    fn surface_attributes(&mut self, sources: &Sources, count: usize, world: &Matrix4<f64>) {
        let fitting = |values: &Vec<[f64; 3]>| values.len() == count;
        let normals = sources.normal.as_ref().and_then(|(a, moves)| self.moved(*a, moves).ok());
        let colors = sources.color.and_then(|a| self.data.colors(a).ok());
        let (normals, colors) = (normals.filter(fitting), colors.filter(fitting));
        let surface = &mut self.surface;
        surface.has_colors |= colors.is_some();
        surface.lacks_normals |= normals.is_none();
        match colors {
            Some(colors) => surface.colors.extend(colors.iter().map(|rgb| rgb.map(srgb_byte))),
            None => surface.colors.resize(surface.colors.len() + count, [255; 3]),
        }
        // Normals stay upright on surfaces that are stretched.
        let upright = world.fixed_view::<3, 3>(0, 0).try_inverse().map(|m| m.transpose()).unwrap_or_default();
        let turned = |n: &[f64; 3]| {
            let n = (upright * Vector3::from(*n)).try_normalize(0.0).unwrap_or_default();
            [n.x as f32, n.y as f32, n.z as f32]
        };
        surface.normals.extend(normals.unwrap_or_default().iter().map(turned));
    }

    fn show_triangles(
        &mut self,
        primitive: &Primitive,
        sources: Sources,
        world: &Matrix4<f64>,
        first_of: &mut HashMap<Sources, (usize, usize)>,
    ) -> Result<(), Fault> {
        let (first, count) = match first_of.get(&sources) {
            Some(found) => *found,
            None => {
                let vertices = self.moved(sources.position.0, &sources.position.1)?;
                self.check_size(self.raw.points.len() + vertices.len())?;
                let range = (self.raw.points.len(), vertices.len());
                self.raw.points.extend(vertices.iter().map(|v| placed(world, v)));
                self.surface_attributes(&sources, vertices.len(), world);
                *first_of.entry(sources).or_insert(range)
            }
        };
        let corners = match primitive.indices {
            Some(accessor) => self.data.indices(accessor)?,
            None => (0..count).collect(),
        };
        self.check_size(self.raw.triangles.len() + corners.len())?;
        // A mirrored mesh is turned inside out, unless its triangles are turned, too.
        let is_mirrored = world.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let mut add = |a: usize, b: usize, c: usize| {
            if a.max(b).max(c) >= count {
                self.raw.faces_out_of_range += 1;
                return;
            }
            let (b, c) = if is_mirrored { (c, b) } else { (b, c) };
            // `check_size` keeps these well within range.
            self.raw.triangles.push([a, b, c].map(|i| (first + i) as u32));
        };
        match (primitive.mode, &corners[..]) {
            (4, _) => corners.chunks_exact(3).for_each(|t| add(t[0], t[1], t[2])),
            (5, _) => corners
                .windows(3)
                .enumerate()
                .for_each(|(i, t)| if i % 2 == 0 { add(t[0], t[1], t[2]) } else { add(t[1], t[0], t[2]) }),
            (_, [hub, rim @ ..]) => rim.windows(2).for_each(|t| add(*hub, t[0], t[1])),
            (_, []) => {}
        }
        Ok(())
    }
}

/// Where vertices come from: the accessors of positions, normals and colours.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Sources {
    position: (usize, Moves),
    normal: Option<(usize, Moves)>,
    color: Option<usize>,
}

/// Accessors of morph targets, with the bits of their weights.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Moves(Vec<(usize, u64)>);

impl Moves {
    /// Those of an attribute that do something.
    fn of(primitive: &Primitive, attribute: &str, weights: &[f64]) -> Self {
        let targets = primitive.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
        let of_attribute = |(target, weight): (&BTreeMap<String, usize>, &f64)| {
            target.get(attribute).map(|&accessor| (accessor, weight.to_bits()))
        };
        Self(targets.filter_map(of_attribute).collect())
    }
}

/// An entry of one of the file's lists.
fn entry<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T, Fault> {
    list.get(index).ok_or_else(|| {
        let number = list.len();
        Fault::whole(format!("it refers to {what} {index}, but has {number}; export the shape again"))
    })
}

/// glTF's colours are linear; pictures are not.
fn srgb_byte(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}
