//! Primitives as bodies for simulators: URDF and MJCF, with their meshes.

use std::f64::consts::PI;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Vector3};

use super::meshes::stl_binary;
use super::options::ExportOptions;
use super::parts::{Part, Parts, closed};
use super::place::is_written_through;
use super::text::Text;
use super::writing::{Writing, content};
use crate::geometry::hull::convex_hull;
use crate::geometry::mesh::volume;
use crate::geometry::tessellate::{Resolution, Surface, tessellate};
use crate::geometry::{MassProperties, Superquadric};
use crate::io::error::WriteError;
use crate::io::primitives::{PrimitiveSet, checked, yaw_pitch_roll};

/// An exponent up to this counts as 0, one that is no farther from 1 as 1.
const EXPONENT: f64 = 0.1;
/// A taper up to this counts as none.
const TAPER: f64 = 0.05;
/// Semi-axes that differ by less than this part of them count as the same.
const AXES: f64 = 0.05;
/// A hull that is larger than the body by more than this fraction is noted.
const HULL: f64 = 1e-3;
/// What collisions are computed with: fine enough to hold 98 % of a sphere, and
/// few enough vertices for any simulator.
const COLLISION: Resolution = Resolution { profile: 6, section: 6 };
/// Simulators take no mesh with more than 200,000 faces.
const FINEST: usize = 96;
/// Beginning of the names of links and meshes; the primitive's id follows.
const LINK: &str = "primitive_";
/// MuJoCo takes no moving body whose mass or moment of inertia is not larger
/// (mjMINVAL), in SI units.
const LEAST: f64 = 1e-15;
/// Kilograms that no machine has: a thousand tonnes.
const HEAVIEST: f64 = 1e6;

/// A body that simulators know.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Exact {
    Ellipsoid(Vector3<f64>),
    /// Half of its edges.
    Box(Vector3<f64>),
    /// Along local z.
    Cylinder {
        radius: f64,
        half_length: f64,
    },
}

impl Exact {
    /// What the primitive is within the tolerances, if anything.
    fn of(shape: &Superquadric) -> Option<Self> {
        if shape.taper.iter().any(|k| k.abs() > TAPER) {
            return None;
        }
        let [e1, e2] = shape.exponents;
        let round = |e: f64| (e - 1.0).abs() <= EXPONENT;
        let a = shape.semi_axes;
        if round(e1) && round(e2) {
            return Some(Self::Ellipsoid(a));
        }
        if e1 > EXPONENT {
            return None;
        }
        if e2 <= EXPONENT {
            return Some(Self::Box(a));
        }
        let is_circular = (a.x - a.y).abs() <= AXES * a.x.max(a.y);
        (round(e2) && is_circular).then(|| Self::Cylinder { radius: (a.x * a.y).sqrt(), half_length: a.z })
    }

    /// The radius of an ellipsoid that is a sphere.
    fn sphere(axes: &Vector3<f64>) -> Option<f64> {
        (axes.max() - axes.min() <= AXES * axes.max()).then(|| axes.product().cbrt())
    }

    fn urdf(&self) -> Option<String> {
        match self {
            Self::Ellipsoid(axes) => Self::sphere(axes).map(|r| format!("<sphere radius=\"{}\"/>", Text(r))),
            Self::Box(half) => Some(format!("<box size=\"{}\"/>", list((2.0 * half).iter()))),
            Self::Cylinder { radius, half_length } => Some(format!(
                "<cylinder radius=\"{}\" length=\"{}\"/>",
                Text(*radius),
                Text(2.0 * half_length)
            )),
        }
    }

    fn mjcf(&self) -> String {
        match self {
            Self::Ellipsoid(axes) => match Self::sphere(axes) {
                Some(r) => format!("type=\"sphere\" size=\"{}\"", Text(r)),
                None => format!("type=\"ellipsoid\" size=\"{}\"", list(axes.iter())),
            },
            Self::Box(half) => format!("type=\"box\" size=\"{}\"", list(half.iter())),
            Self::Cylinder { radius, half_length } => {
                format!("type=\"cylinder\" size=\"{}\"", list([radius, half_length].into_iter()))
            }
        }
    }
}

/// A primitive as a body.
struct Body {
    name: String,
    color: [u8; 3],
    shape: Superquadric,
    mass: f64,
    /// Of density 1, in the primitive's frame.
    properties: MassProperties,
    density: f64,
    exact: Option<Exact>,
    /// Its surface and its convex hull, in the primitive's frame.
    visual: Parts,
    collision: Parts,
    /// Where the hull is larger than the body: by which part of it.
    excess: Option<f64>,
}

/// A robot model: the file, and its meshes in a folder next to it.
pub(super) struct Robot {
    name: String,
    /// Name of the folder of the meshes.
    folder: String,
    bodies: Vec<Body>,
    scale: f64,
    colors: bool,
}

/// Adds a model and its meshes to what is written; `format` is what messages call it.
pub(super) fn stage(
    writing: &mut Writing,
    path: &Path,
    (format, model): (&str, fn(&Robot) -> String),
    options: &ExportOptions,
    set: &PrimitiveSet<'_>,
) -> Result<(), WriteError> {
    if is_written_through(path) {
        let problem = format!(
            "{format} stores meshes in separate files, which cannot be written here; give a file name"
        );
        return Err(WriteError::Content { path: path.to_owned(), problem });
    }
    let robot = Robot::new(set, options, name(path)).map_err(content(path))?;
    let text = model(&robot);
    writing.files.stage(path, |w| w.write_all(text.as_bytes()))?;
    let folder = meshes_folder(path);
    writing.files.folder(&folder)?;
    for (name, mesh) in robot.meshes() {
        writing.files.stage(&folder.join(name), |w| stl_binary(w, mesh, false))?;
    }
    writing.notes.extend(robot.notes());
    Ok(())
}

/// The meshes beside a model that are there already, and may be written over.
pub(super) fn meshes_there(path: &Path) -> impl Iterator<Item = PathBuf> {
    let there = fs::read_dir(meshes_folder(path)).into_iter().flatten().flatten();
    there.filter(|entry| is_mesh(&entry.file_name())).map(|entry| entry.path())
}

/// What the model of a file is called: like the file, as far as simulators take
/// its letters.
fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.is_empty() { "superform".to_owned() } else { name }
}

/// The folder of its meshes.
fn meshes_folder(path: &Path) -> PathBuf {
    path.with_file_name(folder_name(&name(path)))
}

fn folder_name(name: &str) -> String {
    format!("{name}_meshes")
}

/// Whether a file of that folder may be one of its meshes.
fn is_mesh(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(LINK.as_bytes())
}

impl Robot {
    /// The model of primitives.
    fn new(set: &PrimitiveSet<'_>, options: &ExportOptions, name: String) -> io::Result<Self> {
        let fine = options.resolution.min(FINEST);
        let bodies = set.primitives.iter().map(|primitive| {
            let shape = checked(primitive)?.shape;
            let shape = Superquadric {
                semi_axes: options.scale * shape.semi_axes,
                translation: options.scale * shape.translation,
                ..shape
            };
            let local = Superquadric {
                rotation: nalgebra::Rotation3::identity(),
                translation: Vector3::zeros(),
                ..shape
            };
            let properties = shape.mass_properties();
            let coarse = tessellate(&local, COLLISION);
            let hull = convex_hull(&coarse.vertices);
            let hull = match hull {
                Some(faces) => Surface { faces, ..coarse },
                // So thin that it has no inside in double precision.
                None => closed(&local, COLLISION),
            };
            let larger = volume(&hull.vertices, &hull.faces) / properties.volume - 1.0;
            let exact = Exact::of(&shape).filter(|_| options.exact_shapes);
            Ok(Body {
                name: format!("{LINK}{}", primitive.id),
                color: set.colors.of(primitive.id),
                shape,
                mass: properties.volume * options.density,
                properties,
                density: options.density,
                exact,
                visual: single(closed(&local, Resolution { profile: fine, section: fine })),
                collision: single(hull),
                excess: (larger > HULL).then_some(larger),
            })
        });
        let bodies = bodies.collect::<io::Result<Vec<_>>>()?;
        Ok(Self { folder: folder_name(&name), name, bodies, scale: options.scale, colors: options.colors })
    }

    /// Names and content of the meshes.
    fn meshes(&self) -> impl Iterator<Item = (String, &Parts)> {
        self.bodies.iter().flat_map(|body| {
            [
                (format!("{}.stl", body.name), &body.visual),
                (format!("{}_collision.stl", body.name), &body.collision),
            ]
        })
    }

    /// What a person should know.
    fn notes(&self) -> Vec<String> {
        let larger = self.bodies.iter().filter(|body| body.exact.is_none());
        let larger = larger.filter_map(|body| {
            let percent = 100.0 * body.excess?;
            Some(format!(
                "{} is not convex; its collision mesh is the convex hull, {percent:.1} % larger",
                body.name
            ))
        });
        self.too_light().into_iter().chain(self.too_heavy()).chain(larger).collect()
    }

    /// What MuJoCo says no to.
    fn too_light(&self) -> Option<String> {
        let least = |body: &Body| body.inertia().min().min(body.mass);
        let light: Vec<&Body> = self.bodies.iter().filter(|body| least(body) <= LEAST).collect();
        let first = light.iter().min_by(|a, b| least(a).total_cmp(&least(b)))?;
        let others = match light.len() {
            1 => String::new(),
            n => format!(" (and {} more)", n - 1),
        };
        Some(format!(
            "{}{others} has a mass of {:.1e} kg and a smallest moment of inertia of {:.1e} kg m²; MuJoCo \
             rejects values not above {LEAST:e}. Write the model in a smaller unit of length, for example \
             in millimetres with a scale of {:?} instead of {:?}",
            first.name,
            first.mass,
            first.inertia().min(),
            1000.0 * self.scale,
            self.scale
        ))
    }

    /// What only an input has that is not in metres.
    fn too_heavy(&self) -> Option<String> {
        let mass: f64 = self.bodies.iter().map(|body| body.mass).sum();
        (mass > HEAVIEST).then(|| {
            format!(
                "the model has a mass of {mass:.1e} kg, with one unit of the input as {:?} m; if this is \
                 wrong, set the metres per unit, for example 0.001 for millimetres",
                self.scale
            )
        })
    }

    fn about(&self) -> String {
        let unit = match self.scale {
            1.0 => "in units of the input, interpreted as metres".to_owned(),
            scale => format!("in metres, {scale:?} per unit of the input"),
        };
        format!(
            "superform {}. Lengths {unit}; masses and inertias are those of the exact solids, which may \
             overlap. Collision meshes are convex hulls.",
            env!("CARGO_PKG_VERSION")
        )
    }

    /// A link a primitive, at its pose, all fixed to the link `base`.
    pub(super) fn urdf(&self) -> String {
        let mut text = String::new();
        // Writing to a string can't fail.
        let _ = write!(
            text,
            "<?xml version=\"1.0\"?>\n<!-- {} -->\n<robot name=\"{}\">\n  <link name=\"base\"/>\n",
            self.about(),
            self.name
        );
        for body in &self.bodies {
            let name = &body.name;
            let material = if self.colors {
                format!(
                    "\n      <material name=\"{name}\"><color rgba=\"{} 1\"/></material>",
                    color(body.color)
                )
            } else {
                String::new()
            };
            let mesh = |suffix: &str| format!("<mesh filename=\"{}/{name}{suffix}.stl\"/>", self.folder);
            let collision = body.exact.and_then(|exact| exact.urdf());
            let inertia = body.inertia();
            let [yaw, pitch, roll] = yaw_pitch_roll(&body.shape.rotation);
            let _ = write!(
                text,
                "{}  <link name=\"{name}\">\n    <inertial>\n      \
                 <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n      <mass value=\"{}\"/>\n      \
                 <inertia ixx=\"{}\" iyy=\"{}\" izz=\"{}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\n    </inertial>\n    \
                 <visual>\n      <geometry>{}</geometry>{material}\n    </visual>\n    \
                 <collision>\n      <geometry>{}</geometry>\n    </collision>\n  </link>\n  \
                 <joint name=\"{name}_joint\" type=\"fixed\">\n    <parent link=\"base\"/>\n    \
                 <child link=\"{name}\"/>\n    <origin xyz=\"{}\" rpy=\"{}\"/>\n  </joint>\n",
                body.remark("  "),
                list(body.properties.centroid.iter()),
                Text(body.mass),
                Text(inertia.x),
                Text(inertia.y),
                Text(inertia.z),
                mesh(""),
                collision.unwrap_or_else(|| mesh("_collision")),
                list(body.shape.translation.iter()),
                list([roll, pitch, yaw].iter()),
            );
        }
        text.push_str("</robot>\n");
        text
    }

    /// One free body, in it a body a primitive, at its pose.
    pub(super) fn mjcf(&self) -> String {
        let mut text = String::new();
        let _ = write!(
            text,
            "<!-- {} -->\n<mujoco model=\"{}\">\n  <compiler angle=\"radian\" meshdir=\"{}\"/>\n  \
             <default>\n    <default class=\"visual\">\n      \
             <geom type=\"mesh\" contype=\"0\" conaffinity=\"0\" group=\"2\"/>\n    </default>\n    \
             <default class=\"collision\">\n      <geom group=\"3\"/>\n    </default>\n  </default>\n  <asset>\n",
            self.about(),
            self.name,
            self.folder
        );
        for Body { name, .. } in &self.bodies {
            for suffix in ["", "_collision"] {
                let _ = writeln!(text, "    <mesh name=\"{name}{suffix}\" file=\"{name}{suffix}.stl\"/>");
            }
        }
        let _ = write!(
            text,
            "  </asset>\n  <worldbody>\n    <body name=\"{}\">\n      <freejoint/>\n",
            self.name
        );
        for body in &self.bodies {
            let name = &body.name;
            let frame = Isometry3::from_parts(
                body.shape.translation.into(),
                nalgebra::UnitQuaternion::from_rotation_matrix(&body.shape.rotation),
            );
            let q = frame.rotation.quaternion();
            let rgba = if self.colors { format!(" rgba=\"{} 1\"", color(body.color)) } else { String::new() };
            let collision = match body.exact {
                Some(exact) => exact.mjcf(),
                None => format!("type=\"mesh\" mesh=\"{name}_collision\""),
            };
            let _ = write!(
                text,
                "{}      <body name=\"{name}\" pos=\"{}\" quat=\"{}\">\n        \
                 <inertial pos=\"{}\" mass=\"{}\" diaginertia=\"{}\"/>\n        \
                 <geom class=\"visual\" name=\"{name}_visual\" mesh=\"{name}\"{rgba}/>\n        \
                 <geom class=\"collision\" name=\"{name}_collision\" {collision}/>\n      </body>\n",
                body.remark("      "),
                list(body.shape.translation.iter()),
                list([q.w, q.i, q.j, q.k].iter()),
                list(body.properties.centroid.iter()),
                Text(body.mass),
                list(body.inertia().iter()),
            );
        }
        text.push_str("    </body>\n  </worldbody>\n</mujoco>\n");
        text
    }
}

impl Body {
    /// Principal moments about the centroid, along the primitive's axes.
    fn inertia(&self) -> Vector3<f64> {
        self.properties.inertia * self.density
    }

    /// A comment on what collisions are computed with.
    fn remark(&self, indent: &str) -> String {
        match (self.exact, self.excess) {
            (None, Some(excess)) => format!(
                "{indent}<!-- not convex: the collision mesh is its convex hull, {:.1} % larger -->\n",
                100.0 * excess
            ),
            _ => String::new(),
        }
    }
}

/// Numbers with blanks between them.
fn list<'a>(numbers: impl Iterator<Item = &'a f64>) -> String {
    numbers.map(|n| Text(*n).to_string()).collect::<Vec<_>>().join(" ")
}

fn color(color: [u8; 3]) -> String {
    color.map(|c| format!("{:.3}", f64::from(c) / 255.0)).join(" ")
}

/// A surface as a mesh of one part.
fn single(surface: Surface) -> Parts {
    let part = Part { label: 0, name: String::new(), color: [0; 3], frame: Isometry3::identity() };
    Parts {
        part_of_face: vec![0; surface.faces.len()],
        vertices: surface.vertices,
        normals: None,
        faces: surface.faces,
        parts: vec![part],
    }
}

/// Bytes that a model takes, meshes and all.
pub(super) fn size(primitives: u64, options: &ExportOptions) -> u64 {
    let faces = |r: usize| (2 * (2 * r - 1) * 4 * r) as u64;
    let round = PI / 4.0; // A part of the hull's points lies within flat faces.
    let fine = options.resolution.next_multiple_of(2).min(FINEST);
    primitives * (50 * faces(fine) + (round * 50.0 * faces(COLLISION.profile) as f64) as u64 + 1800) + 1200
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    fn shape(eps: [f64; 2], axes: [f64; 3], taper: [f64; 2]) -> Superquadric {
        let sphere = Superquadric::sphere(Point3::origin(), 1.0);
        Superquadric { exponents: eps, semi_axes: Vector3::from(axes), taper, ..sphere }
    }

    #[test]
    fn bodies_that_simulators_know_are_told() {
        let of = |eps, axes| Exact::of(&shape(eps, axes, [0.0, 0.03])).map(|e| e.mjcf());
        assert_eq!(of([1.0, 0.95], [2.0; 3]).as_deref(), Some("type=\"sphere\" size=\"2\""));
        assert_eq!(of([1.0, 1.05], [2.0, 1.0, 2.0]).as_deref(), Some("type=\"ellipsoid\" size=\"2 1 2\""));
        assert_eq!(of([0.1, 0.05], [2.0, 1.0, 3.0]).as_deref(), Some("type=\"box\" size=\"2 1 3\""));
        assert_eq!(of([0.1, 1.0], [2.0, 2.0, 3.0]).as_deref(), Some("type=\"cylinder\" size=\"2 3\""));
        assert_eq!(of([0.1, 1.0], [2.0, 1.0, 3.0]), None);
        assert_eq!(of([0.3, 0.1], [2.0, 1.0, 3.0]), None);
        assert_eq!(Exact::of(&shape([1.0, 1.0], [1.0; 3], [0.06, 0.0])), None);
        let ellipsoid = Exact::of(&shape([1.0, 1.0], [1.0, 2.0, 1.0], [0.0; 2])).and_then(|e| e.urdf());
        assert_eq!(ellipsoid, None, "URDF has no ellipsoids");
    }
}
