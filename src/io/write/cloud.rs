//! The segmented cloud: every input point, in order, with the id of its primitive.

use std::io::{self, Seek, Write};
use std::path::Path;

use nalgebra::Point3;

use super::atomic::unfit;
use super::options::ExportOptions;
use super::outcome::Outcome;
use super::text::{Text, file_label, mean_place, rounding};
use super::writing::{Writing, content};
use crate::geometry::palette::UNASSIGNED_COLOR;
use crate::inference::UNASSIGNED;
use crate::io::error::WriteError;
use crate::io::npy::Npz;
use crate::io::shape::ShapeGeometry;

/// A format of clouds.
#[derive(Clone, Copy)]
pub(super) struct CloudFormat {
    pub(super) write: fn(&mut Writing, &Path, &SegmentedCloud<'_>, &ExportOptions) -> Result<(), WriteError>,
    /// About how many bytes that is.
    pub(super) size: fn(&CloudCounts, &ExportOptions) -> u64,
}

pub(super) const PLY: CloudFormat = CloudFormat {
    write: |writing, path, cloud, options| writing.files.stage(path, |w| cloud.ply(w, options.binary)),
    size: |n, options| match options.binary {
        true => n.points * (28 + 3 * n.colors + 12 * n.normals + 4 * n.labels + 3 * n.tints) + 400,
        false => n.text(),
    },
};
pub(super) const CSV: CloudFormat = CloudFormat {
    write: |writing, path, cloud, _| writing.files.stage(path, |w| cloud.csv(w)),
    size: |n, _| n.text(),
};
pub(super) const XYZ: CloudFormat = CloudFormat {
    write: |writing, path, cloud, _| writing.files.stage(path, |w| cloud.xyz(w)),
    size: |n, _| n.text(),
};
pub(super) const PCD: CloudFormat = CloudFormat {
    write: |writing, path, cloud, options| {
        if !options.doubles {
            writing.notes.extend(rounding(cloud.points.iter()).map_err(content(path))?);
        }
        writing.files.stage(path, |w| cloud.pcd(w, options))
    },
    size: |n, options| {
        let place = if options.doubles { 24 } else { 12 };
        match options.binary {
            true => n.points * (place + 4 + 4 * n.colors + 12 * n.normals + 4 * n.labels) + 300,
            false => n.text(),
        }
    },
};
pub(super) const NPZ: CloudFormat = CloudFormat {
    write: |writing, path, cloud, _| writing.files.stage(path, |w| cloud.npz(w)),
    // Coordinates hardly shrink, labels and colours to a small part.
    size: |n, _| n.points * (23 + n.normals * 11 + n.labels + n.tints) + 1500,
};

/// What the size of a cloud's file depends on.
#[derive(Debug)]
pub(super) struct CloudCounts {
    points: u64,
    /// Characters of a place.
    place: u64,
    /// 1 where each point has a colour, and a normal, a label and a colour of the
    /// input's; else 0.
    colors: u64,
    normals: u64,
    labels: u64,
    tints: u64,
}

impl CloudCounts {
    pub(super) fn of(outcome: &Outcome<'_>, options: &ExportOptions) -> Self {
        let (points, own) = match &outcome.shape.geometry {
            ShapeGeometry::Mesh(_) => (&outcome.cloud.points, None),
            ShapeGeometry::Cloud(input) => (&input.points, Some(&outcome.shape.attributes)),
        };
        let own = own.filter(|_| options.input_attributes);
        Self {
            points: points.len() as u64,
            place: mean_place(points),
            colors: options.colors.into(),
            normals: own.is_some_and(|a| a.normals.is_some()).into(),
            labels: own.is_some_and(|a| a.labels.is_some()).into(),
            tints: own.is_some_and(|a| a.colors.is_some()).into(),
        }
    }

    fn text(&self) -> u64 {
        let line = self.place + 3 + 12 * self.colors + 36 * self.normals + 4 * self.labels + 12 * self.tints;
        self.points * line + 300
    }
}

/// The columns of the cloud; all have one entry a point.
#[derive(Debug)]
pub(super) struct SegmentedCloud<'a> {
    points: &'a [Point3<f64>],
    /// Ids; −1 where a point belongs to no primitive.
    labels: Vec<i32>,
    colors: Option<Vec<[u8; 3]>>,
    normals: Option<&'a [[f32; 3]]>,
    input_labels: Option<&'a [i64]>,
    input_colors: Option<&'a [[u8; 3]]>,
    /// Of all primitives.
    ids: Vec<i32>,
}

impl<'a> SegmentedCloud<'a> {
    /// Of an input cloud all its points in input order, each with the label of the sample
    /// that stands for it; points that are not finite are as they were, with label −1. Of an
    /// input mesh the samples are the cloud.
    pub(super) fn new(outcome: &Outcome<'a>, options: &ExportOptions) -> io::Result<Self> {
        let Outcome { shape, cloud, abstraction, colors, .. } = *outcome;
        let (points, attributes) = match &shape.geometry {
            ShapeGeometry::Mesh(_) => (&cloud.points, None),
            ShapeGeometry::Cloud(input) => (&input.points, Some(&shape.attributes)),
        };
        let ids = cloud.labels_of_input(&abstraction.labels, UNASSIGNED);
        let attributes = attributes.filter(|_| options.input_attributes);
        if ids.len() != points.len() || attributes.is_some_and(|a| !a.fit(points.len())) {
            return Err(unfit("the labels belong to a different cloud"));
        }
        let color = |&id: &u32| if id == UNASSIGNED { UNASSIGNED_COLOR } else { colors.of(id) };
        let label = |&id: &u32| if id == UNASSIGNED { Ok(-1) } else { file_label(id) };
        Ok(Self {
            points,
            labels: ids.iter().map(label).collect::<io::Result<_>>()?,
            colors: options.colors.then(|| ids.iter().map(color).collect()),
            normals: attributes.and_then(|a| a.normals.as_deref()),
            input_labels: attributes.and_then(|a| a.labels.as_deref()),
            input_colors: attributes.and_then(|a| a.colors.as_deref()),
            ids: abstraction.primitives.iter().map(|p| file_label(p.id)).collect::<io::Result<_>>()?,
        })
    }

    /// The input's labels as 32-bit integers, where they all are such.
    fn short_input_labels(&self) -> Option<Vec<i32>> {
        self.input_labels?.iter().map(|&l| i32::try_from(l).ok()).collect()
    }

    /// For each point `x y z` (double, input units), `red green blue` (uchar, the colour
    /// of its primitive) and `label` (int, the primitive's id; −1 where the point belongs
    /// to none); then, where the input says so of its points, `nx ny nz` (float),
    /// `input_label` and `input_red input_green input_blue`.
    pub(super) fn ply(&self, w: &mut impl Write, binary: bool) -> io::Result<()> {
        begin_ply(w, binary, self.points.len())?;
        if self.colors.is_some() {
            w.write_all(b"property uchar red\nproperty uchar green\nproperty uchar blue\n")?;
        }
        w.write_all(b"property int label\n")?;
        if self.normals.is_some() {
            w.write_all(b"property float nx\nproperty float ny\nproperty float nz\n")?;
        }
        let short = self.short_input_labels();
        if self.input_labels.is_some() {
            // PLY has no integers of 64 bits; doubles hold those up to 2⁵³.
            let kind = if short.is_some() { "int" } else { "double" };
            writeln!(w, "property {kind} input_label")?;
        }
        if self.input_colors.is_some() {
            w.write_all(
                b"property uchar input_red\nproperty uchar input_green\nproperty uchar input_blue\n",
            )?;
        }
        w.write_all(b"end_header\n")?;
        if !binary {
            return self.rows(w, " ", &Order::PLY);
        }
        for (i, p) in self.points.iter().enumerate() {
            for c in p.iter() {
                w.write_all(&c.to_le_bytes())?;
            }
            if let Some(colors) = &self.colors {
                w.write_all(&colors[i])?;
            }
            w.write_all(&self.labels[i].to_le_bytes())?;
            for c in self.normals.iter().flat_map(|n| n[i]) {
                w.write_all(&c.to_le_bytes())?;
            }
            match (&short, self.input_labels) {
                (Some(labels), _) => w.write_all(&labels[i].to_le_bytes())?,
                (None, Some(labels)) => w.write_all(&(labels[i] as f64).to_le_bytes())?,
                (None, None) => {}
            }
            if let Some(colors) = self.input_colors {
                w.write_all(&colors[i])?;
            }
        }
        Ok(())
    }

    pub(super) fn csv(&self, w: &mut impl Write) -> io::Result<()> {
        writeln!(w, "{}", self.names(&Order::PLY).join(","))?;
        self.rows(w, ",", &Order::PLY)
    }

    pub(super) fn xyz(&self, w: &mut impl Write) -> io::Result<()> {
        writeln!(w, "# {}", self.names(&Order::LABEL_LAST).join(" "))?;
        self.rows(w, " ", &Order::LABEL_LAST)
    }

    pub(super) fn pcd(&self, w: &mut impl Write, options: &ExportOptions) -> io::Result<()> {
        let doubles = options.doubles;
        let place = if doubles { ('F', 8) } else { ('F', 4) };
        let mut fields = vec![("x", place), ("y", place), ("z", place)];
        if self.colors.is_some() {
            fields.push(("rgb", ('F', 4)));
        }
        fields.push(("label", ('I', 4)));
        if self.normals.is_some() {
            fields.extend(["normal_x", "normal_y", "normal_z"].map(|name| (name, ('F', 4))));
        }
        let short = self.short_input_labels();
        if self.input_labels.is_some() {
            fields.push(("input_label", if short.is_some() { ('I', 4) } else { ('F', 8) }));
        }
        let mut lists = ["FIELDS", "SIZE", "TYPE", "COUNT"].map(str::to_owned);
        for (name, (kind, bytes)) in fields {
            for (list, entry) in lists.iter_mut().zip([name, &bytes.to_string(), &kind.to_string(), "1"]) {
                list.push(' ');
                list.push_str(entry);
            }
        }
        let count = self.points.len();
        write!(
            w,
            "# .PCD v0.7 - superform {}; label: id of the primitive, -1 for none\nVERSION 0.7\n\
             {}\nWIDTH {count}\nHEIGHT 1\n\
             VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {}\n",
            env!("CARGO_PKG_VERSION"),
            lists.join("\n"),
            if options.binary { "binary" } else { "ascii" },
        )?;
        for (i, p) in self.points.iter().enumerate() {
            let packed = self.colors.as_ref().map(|colors| {
                let [r, g, b] = colors[i];
                f32::from_bits(u32::from_be_bytes([0, r, g, b]))
            });
            let wide = if short.is_some() { None } else { self.input_labels.map(|labels| labels[i] as f64) };
            let narrow = short.as_ref().map(|labels| labels[i]);
            if options.binary {
                for &c in p.iter() {
                    if doubles {
                        w.write_all(&c.to_le_bytes())?;
                    } else {
                        w.write_all(&(c as f32).to_le_bytes())?;
                    }
                }
                packed.map_or(Ok(()), |v| w.write_all(&v.to_le_bytes()))?;
                w.write_all(&self.labels[i].to_le_bytes())?;
                for c in self.normals.iter().flat_map(|n| n[i]) {
                    w.write_all(&c.to_le_bytes())?;
                }
                narrow.map_or(Ok(()), |v| w.write_all(&v.to_le_bytes()))?;
                wide.map_or(Ok(()), |v| w.write_all(&v.to_le_bytes()))?;
            } else {
                for (k, &c) in p.iter().enumerate() {
                    let blank = if k > 0 { " " } else { "" };
                    if doubles {
                        write!(w, "{blank}{}", Text(c))?;
                    } else {
                        write!(w, "{blank}{}", Text(c as f32))?;
                    }
                }
                packed.map_or(Ok(()), |v| write!(w, " {v:?}"))?;
                write!(w, " {}", self.labels[i])?;
                for c in self.normals.iter().flat_map(|n| n[i]) {
                    write!(w, " {}", Text(c))?;
                }
                narrow.map_or(Ok(()), |v| write!(w, " {v}"))?;
                wide.map_or(Ok(()), |v| write!(w, " {v:?}"))?;
                w.write_all(b"\n")?;
            }
        }
        Ok(())
    }

    pub(super) fn npz(&self, w: &mut (impl Write + Seek)) -> io::Result<()> {
        let count = self.points.len();
        let mut npz = Npz::new(w);
        npz.doubles("points", &[count, 3], self.points.iter().flat_map(|p| p.iter()))?;
        npz.add("labels", "<i4", &[count], self.labels.iter().map(|l| l.to_le_bytes()))?;
        npz.add("ids", "<i4", &[self.ids.len()], self.ids.iter().map(|l| l.to_le_bytes()))?;
        if let Some(colors) = &self.colors {
            npz.add("colors", "|u1", &[count, 3], colors.iter().copied())?;
        }
        if let Some(normals) = self.normals {
            npz.add("normals", "<f4", &[count, 3], normals.iter().flatten().map(|c| c.to_le_bytes()))?;
        }
        if let Some(labels) = self.input_labels {
            npz.add("input_labels", "<i8", &[count], labels.iter().map(|l| l.to_le_bytes()))?;
        }
        if let Some(colors) = self.input_colors {
            npz.add("input_colors", "|u1", &[count, 3], colors.iter().copied())?;
        }
        npz.finish()
    }

    fn has(&self, group: Group) -> bool {
        match group {
            Group::Place | Group::Label => true,
            Group::Color => self.colors.is_some(),
            Group::Normal => self.normals.is_some(),
            Group::InputLabel => self.input_labels.is_some(),
            Group::InputColor => self.input_colors.is_some(),
        }
    }

    fn names(&self, order: &Order) -> Vec<&'static str> {
        order.0.iter().filter(|group| self.has(**group)).flat_map(|group| group.names()).copied().collect()
    }

    /// All points as text, a line each.
    fn rows(&self, w: &mut impl Write, separator: &str, order: &Order) -> io::Result<()> {
        let groups: Vec<Group> = order.0.iter().copied().filter(|group| self.has(*group)).collect();
        (0..self.points.len()).try_for_each(|i| self.row(w, separator, &groups, i))
    }

    fn row(&self, w: &mut impl Write, separator: &str, groups: &[Group], i: usize) -> io::Result<()> {
        let s = separator;
        let bytes = |w: &mut dyn Write, [r, g, b]: [u8; 3]| write!(w, "{s}{r}{s}{g}{s}{b}");
        for group in groups {
            match group {
                Group::Place => {
                    let p = self.points[i];
                    write!(w, "{}{s}{}{s}{}", Text(p.x), Text(p.y), Text(p.z))?;
                }
                Group::Label => write!(w, "{s}{}", self.labels[i])?,
                Group::Color => self.colors.as_ref().map_or(Ok(()), |all| bytes(w, all[i]))?,
                Group::InputColor => self.input_colors.map_or(Ok(()), |all| bytes(w, all[i]))?,
                Group::InputLabel => self.input_labels.map_or(Ok(()), |all| write!(w, "{s}{}", all[i]))?,
                Group::Normal => {
                    for c in self.normals.iter().flat_map(|all| all[i]) {
                        write!(w, "{s}{}", Text(c))?;
                    }
                }
            }
        }
        w.write_all(b"\n")
    }
}

/// Columns that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Group {
    Place,
    Color,
    Label,
    Normal,
    InputLabel,
    InputColor,
}

impl Group {
    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Place => &["x", "y", "z"],
            Self::Color => &["red", "green", "blue"],
            Self::Label => &["label"],
            Self::Normal => &["nx", "ny", "nz"],
            Self::InputLabel => &["input_label"],
            Self::InputColor => &["input_red", "input_green", "input_blue"],
        }
    }
}

/// The order of the columns in a text.
struct Order([Group; 6]);

impl Order {
    const PLY: Self =
        Self([Group::Place, Group::Color, Group::Label, Group::Normal, Group::InputLabel, Group::InputColor]);
    const LABEL_LAST: Self =
        Self([Group::Place, Group::Normal, Group::Color, Group::InputColor, Group::InputLabel, Group::Label]);
}

/// The header of a PLY file up to the places of its points.
pub(super) fn begin_ply(w: &mut impl Write, binary: bool, points: usize) -> io::Result<()> {
    let form = if binary { "binary_little_endian" } else { "ascii" };
    write!(
        w,
        "ply\nformat {form} 1.0\ncomment superform {}\n\
         comment label: id of the primitive, -1 for none\nelement vertex {points}\n\
         property double x\nproperty double y\nproperty double z\n",
        env!("CARGO_PKG_VERSION"),
    )
}
