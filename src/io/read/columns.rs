//! The meaning of columns, from their names or, without names, from their values, and the
//! conversion of their numbers.

use nalgebra::Point3;

use super::raw::Raw;
use super::text::counted;
use crate::io::shape::Attributes;

/// Which columns hold what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Roles {
    pub(super) position: [usize; 3],
    pub(super) normal: Option<[usize; 3]>,
    pub(super) color: Option<Color>,
    pub(super) label: Option<usize>,
    /// Whether the coordinates are degrees of longitude and latitude.
    pub(super) degrees: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Color {
    /// Red, green and blue.
    Channels([usize; 3]),
    /// The three in the lower bytes of a number: 0xRRGGBB.
    Packed(usize),
}

const POSITIONS: [[&str; 3]; 12] = [
    ["x", "y", "z"],
    ["px", "py", "pz"],
    ["x_m", "y_m", "z_m"],
    ["pos_x", "pos_y", "pos_z"],
    ["position_x", "position_y", "position_z"],
    ["x_coordinate", "y_coordinate", "z_coordinate"],
    ["coord_x", "coord_y", "coord_z"],
    ["points:0", "points:1", "points:2"],
    ["easting", "northing", "elevation"],
    ["easting", "northing", "height"],
    ["east", "north", "height"],
    ["east", "north", "elevation"],
];
const NORMALS: [[&str; 3]; 5] = [
    ["nx", "ny", "nz"],
    ["normal_x", "normal_y", "normal_z"],
    ["n_x", "n_y", "n_z"],
    ["normalx", "normaly", "normalz"],
    ["normals:0", "normals:1", "normals:2"],
];
const COLORS: [[&str; 3]; 5] = [
    ["red", "green", "blue"],
    ["r", "g", "b"],
    ["diffuse_red", "diffuse_green", "diffuse_blue"],
    ["color_r", "color_g", "color_b"],
    ["rgb:0", "rgb:1", "rgb:2"],
];
/// The first of these columns that exists contains the labels.
const LABELS: [&str; 17] = [
    "label",
    "labels",
    "class",
    "classification",
    "class_id",
    "cluster",
    "cluster_id",
    "segment",
    "segment_id",
    "segmentation",
    "part",
    "part_id",
    "primitive",
    "semantic",
    "category",
    "instance",
    "object_id",
];

/// Of degrees, and of what stands beside them, also in longer names (`gps_lat`).
const LONGITUDES: [&str; 4] = ["longitude", "lon", "lng", "long"];
const LATITUDES: [&str; 2] = ["latitude", "lat"];
const HEIGHTS: [&str; 9] = ["altitude", "alt", "elevation", "elev", "ele", "height", "z", "depth", "h"];
/// What is said of them.
pub(super) const DEGREES: &str = "latitude and longitude are in degrees, not lengths, so the \
     shape is distorted: project the points to metres first (for example to UTM, with QGIS, PDAL \
     or pyproj)";

/// Names of fields that hold three numbers, with those of their numbers.
const TRIPLES: [(&[&str], [&str; 3]); 3] = [
    (&["xyz", "point", "points", "position", "positions", "pos", "coord", "coords", "p"], POSITIONS[0]),
    (&["normal", "normals", "n"], NORMALS[0]),
    (&["rgb", "rgba", "color", "colors", "colour"], COLORS[0]),
];

/// The names of the numbers of a field that has `count` of them.
pub(in crate::io) fn names_of_parts(field: &str, count: usize) -> Vec<String> {
    if count == 1 {
        return vec![field.to_owned()];
    }
    let known = TRIPLES.iter().find(|(names, _)| names.contains(&field)).map(|(_, parts)| parts);
    let part = |i: usize| known.and_then(|parts| parts.get(i)).map(|part| (*part).to_owned());
    (0..count).map(|i| part(i).unwrap_or_else(|| format!("{field}[{i}]"))).collect()
}

/// A name without its adornments, as CloudCompare and others have them.
fn plain(name: &str) -> String {
    let name = name.trim_start_matches("scalar_");
    name.split(['(', '[']).next().unwrap_or_default().trim().replace([' ', '-', '.'], "_")
}

/// Where one of the words is a name, or a part of one.
fn find_word(names: &[String], words: &[&str]) -> Option<usize> {
    words.iter().find_map(|word| names.iter().position(|name| name.split('_').any(|part| part == *word)))
}

/// Whether lower-case names speak of degrees of longitude and latitude.
pub(super) fn name_degrees(names: &[impl AsRef<str>]) -> bool {
    let names: Vec<String> = names.iter().map(|n| plain(n.as_ref())).collect();
    find_word(&names, &LONGITUDES).is_some() && find_word(&names, &LATITUDES).is_some()
}

impl Roles {
    /// By lower-case names; `None` where they don't name three coordinates.
    pub(super) fn of(names: &[impl AsRef<str>]) -> Option<Self> {
        let names: Vec<String> = names.iter().map(|n| plain(n.as_ref())).collect();
        let at = |name: &str| names.iter().position(|n| n == name);
        let triple =
            |wanted: &[[&str; 3]]| wanted.iter().find_map(|[a, b, c]| Some([at(a)?, at(b)?, at(c)?]));
        let degrees = || {
            let find = |words: &[&str]| find_word(&names, words);
            Some([find(&LONGITUDES)?, find(&LATITUDES)?, find(&HEIGHTS)?])
        };
        let lengths = triple(&POSITIONS);
        let packed = || at("rgb").or_else(|| at("rgba")).map(Color::Packed);
        Some(Self {
            position: lengths.or_else(degrees)?,
            normal: triple(&NORMALS),
            color: triple(&COLORS).map(Color::Channels).or_else(packed),
            label: LABELS.iter().find_map(|name| at(name)),
            degrees: lengths.is_none(),
        })
    }
}

/// Collects points and what is said of them, row by row.
#[derive(Debug)]
pub(super) struct Gatherer {
    roles: Roles,
    points: Vec<Point3<f64>>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[f32; 3]>,
    labels: Vec<f64>,
}

impl Gatherer {
    /// For this many rows, which fit into the file.
    pub(super) fn new(roles: Roles, rows: usize) -> Self {
        let room = |is_there: bool| if is_there { rows } else { 0 };
        Self {
            roles,
            points: Vec::with_capacity(rows),
            normals: Vec::with_capacity(room(roles.normal.is_some())),
            colors: Vec::with_capacity(room(roles.color.is_some())),
            labels: Vec::with_capacity(room(roles.label.is_some())),
        }
    }

    /// Takes a row that has all columns. A packed colour is the number that
    /// its bits are.
    pub(super) fn push(&mut self, row: &[f64]) {
        let triple = |columns: [usize; 3]| columns.map(|i| row[i]);
        self.points.push(Point3::from(triple(self.roles.position)));
        if let Some(columns) = self.roles.normal {
            self.normals.push(triple(columns).map(|v| v as f32));
        }
        match self.roles.color {
            Some(Color::Channels(columns)) => self.colors.push(triple(columns).map(|v| v as f32)),
            Some(Color::Packed(column)) => {
                let bits = row[column] as u32;
                self.colors.push([16, 8, 0].map(|shift| (bits >> shift & 0xff) as f32));
            }
            None => {}
        }
        if let Some(column) = self.roles.label {
            self.labels.push(row[column]);
        }
    }

    /// Hands over; `whole_colors` where channels are whole numbers from 0 to
    /// 255 or 65535, not fractions of 1.
    pub(super) fn finish(self, whole_colors: bool, raw: &mut Raw) {
        if self.roles.degrees {
            raw.notes.push(DEGREES.to_owned());
        }
        let attributes = Attributes {
            colors: colors(&self.colors, whole_colors, &mut raw.notes),
            normals: normals(self.normals),
            labels: labels(&self.labels, &mut raw.notes),
        };
        raw.points = self.points;
        raw.attributes = attributes;
    }
}

/// Colours as bytes: from whole numbers to 255 or 65535, or else from 0 to 1
/// where none is above 1, or from −1 to 1. One that is no number is black, and
/// noted.
pub(super) fn colors(values: &[[f32; 3]], whole: bool, notes: &mut Vec<String>) -> Option<Vec<[u8; 3]>> {
    if values.is_empty() {
        return None;
    }
    let finite = || values.iter().flatten().copied().filter(|v| v.is_finite());
    let (least, largest) = (finite().fold(0.0, f32::min), finite().fold(0.0, f32::max));
    // What becomes of 1 and of 0; rounding may have led a little below 0.
    let (one, zero) = if !whole && largest <= 1.0 && (-1.0..-0.05).contains(&least) {
        (127.5, 127.5)
    } else if least < -1.0 || largest > 65535.0 {
        let range = format!("from {least} to {largest}");
        notes.push(format!("colours {range} have an unknown scale and were ignored"));
        return None;
    } else if largest <= 1.0 && !whole {
        (255.0, 0.0)
    } else if largest <= 255.0 {
        (1.0, 0.0)
    } else {
        (1.0 / 257.0, 0.0)
    };
    if zero > 0.0 {
        notes.push("some colours are below 0: read as −1 (black) to 1 (white)".to_owned());
    }
    let broken = values.iter().filter(|rgb| !rgb.iter().all(|v| v.is_finite())).count();
    if broken == values.len() {
        return None;
    }
    if broken > 0 {
        let colors = counted(broken, "colour is", "colours are");
        notes.push(format!("{colors} not finite and read as black"));
    }
    let byte = |v: f32| (v * one + zero).round().clamp(0.0, 255.0) as u8;
    // NaN becomes 0.
    Some(values.iter().map(|rgb| rgb.map(byte)).collect())
}

/// The bits of a packed colour that a text writes as a number: as a whole one, or
/// as the float that the bits are.
pub(super) fn packed_bits(value: f64) -> u32 {
    let is_whole = value.fract() == 0.0 && value.abs() <= f64::from(u32::MAX);
    // Negative where the first byte, of opacity, is taken for a sign.
    if is_whole { value as i64 as u32 } else { (value as f32).to_bits() }
}

/// Normals, unless all are zero, which some programs write if they have none.
pub(super) fn normals(values: Vec<[f32; 3]>) -> Option<Vec<[f32; 3]>> {
    values.iter().flatten().any(|v| v.is_finite() && *v != 0.0).then_some(values)
}

/// Labels, if all are whole numbers; −1 for no label.
pub(super) fn labels(values: &[f64], notes: &mut Vec<String>) -> Option<Vec<i64>> {
    // Above this, not all whole numbers are in double precision.
    const LARGEST: f64 = 9_007_199_254_740_992.0;
    if values.iter().all(|v| v.is_nan()) {
        return None;
    }
    let odd = values.iter().find(|v| v.is_infinite() || v.fract() != 0.0 && !v.is_nan() || v.abs() > LARGEST);
    if let Some(odd) = odd {
        notes.push(format!("labels were ignored: {odd} is not a whole number"));
        return None;
    }
    Some(values.iter().map(|v| if v.is_nan() { -1 } else { *v as i64 }).collect())
}

/// Unnamed columns after the coordinates.
#[derive(Debug)]
pub(super) struct Nameless<'a> {
    /// Row by row.
    pub(super) values: &'a [f64],
    pub(super) width: usize,
    /// Whether single columns come before colours, as in PTS.
    pub(super) scalars_first: bool,
}

impl Nameless<'_> {
    /// What they hold, if it is unmistakable: triples of whole numbers
    /// or of fractions are colours, those of length 1 normals, and a single
    /// column of a few small whole numbers labels.
    pub(super) fn attributes(&self, notes: &mut Vec<String>) -> Attributes {
        let width = self.width;
        if width == 0 || self.values.is_empty() {
            return Attributes::default();
        }
        let places = |first: usize| (first..width).step_by(3).filter(|at| at + 3 <= width);
        // Where three columns are left over, the single ones may stand on either side.
        let spare = width % 3;
        let sensible = |first: usize| {
            let trailing = spare - first;
            let is_label = trailing > 0 && self.are_labels(width - 1);
            2 * places(first).filter(|&at| self.kind(at).is_some()).count() + usize::from(is_label)
        };
        let mut first = spare;
        if !self.scalars_first {
            for other in (0..spare).rev() {
                if sensible(other) > sensible(first) {
                    first = other;
                }
            }
        }
        let mut found = Attributes::default();
        for at in places(first) {
            let triples = self.values.chunks_exact(width).map(|row| [row[at], row[at + 1], row[at + 2]]);
            let triples = triples.map(|t| t.map(|v| v as f32));
            match self.kind(at) {
                Some(Kind::Normals) if found.normals.is_none() => found.normals = Some(triples.collect()),
                Some(kind @ (Kind::Whole | Kind::Fractions)) if found.colors.is_none() => {
                    found.colors = colors(&triples.collect::<Vec<_>>(), kind == Kind::Whole, notes);
                }
                None if self.all(at, |v| (-1.0..=1.0).contains(&v)) && !self.all(at, |v| v >= 0.0) => {
                    notes.push(format!(
                        "columns {} to {} are between −1 and 1 but are not unit normals: ignored. Colours \
                         must range from 0 to 1 or from 0 to 255",
                        at + 4,
                        at + 6
                    ));
                }
                _ => {}
            }
        }
        let last = if first < spare { width - 1 } else { 0 };
        if spare > 0 && !self.scalars_first && self.are_labels(last) {
            let column: Vec<f64> = self.values.chunks_exact(width).map(|row| row[last]).collect();
            found.labels = labels(&column, notes);
            notes.push(format!(
                "column {} contains only a few distinct whole numbers: read as labels",
                last + 4
            ));
        }
        found
    }

    /// Whether a test holds for all numbers of three columns.
    fn all(&self, at: usize, test: fn(f64) -> bool) -> bool {
        self.values.chunks_exact(self.width).all(|row| row[at..at + 3].iter().all(|v| test(*v)))
    }

    fn kind(&self, at: usize) -> Option<Kind> {
        let triples = || self.values.chunks_exact(self.width).map(|row| [row[at], row[at + 1], row[at + 2]]);
        let all = |test: fn(f64) -> bool| self.all(at, test);
        let is_wide = |channel: usize| triples().any(|t| t[channel] > 255.0);
        let has_length_1 = |t: [f64; 3]| {
            let length = t.iter().map(|v| v * v).sum::<f64>().sqrt();
            length == 0.0 || (length - 1.0).abs() < 0.02
        };
        if triples().all(has_length_1) && !all(|v| v == 0.0) {
            Some(Kind::Normals)
        } else if all(|v| v.fract() == 0.0 && (0.0..=255.0).contains(&v)) {
            // Zeros and ones alone may mean anything.
            triples().flatten().any(|v| v > 1.0).then_some(Kind::Whole)
        } else if all(|v| v.fract() == 0.0 && (0.0..=65535.0).contains(&v)) {
            // Sixteen bits a channel. Counts and times would not need them in all three.
            (0..3).all(is_wide).then_some(Kind::Whole)
        } else {
            all(|v| (0.0..=1.0).contains(&v)).then_some(Kind::Fractions)
        }
    }

    /// Whether a column contains whole numbers without large gaps, each several times.
    fn are_labels(&self, at: usize) -> bool {
        const MOST: usize = 100;
        let column = || self.values.chunks_exact(self.width).map(|row| row[at]);
        if !column().all(|v| v.fract() == 0.0 && (-1.0..1e6).contains(&v)) {
            return false;
        }
        let mut seen: Vec<i64> = Vec::new();
        for v in column() {
            if let Err(place) = seen.binary_search(&(v as i64)) {
                seen.insert(place, v as i64);
                if seen.len() > MOST {
                    return false;
                }
            }
        }
        let (Some(low), Some(high)) = (seen.first(), seen.last()) else { return false };
        seen.len() > 1 && high - low < 4 * seen.len() as i64 && 4 * seen.len() <= column().count()
    }
}

/// What three columns hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Normals,
    /// Colours in whole numbers, to 255 or to 65535.
    Whole,
    /// Colours from 0 to 1.
    Fractions,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_roles() {
        let roles = |names: &str| Roles::of(&names.split(' ').collect::<Vec<_>>());
        let all = roles("z y x nx ny nz blue green red scalar_label").unwrap();
        assert_eq!(all.position, [2, 1, 0]);
        assert_eq!((all.normal, all.label), (Some([3, 4, 5]), Some(9)));
        assert_eq!(all.color, Some(Color::Channels([8, 7, 6])));
        assert_eq!(roles("x y z rgba").unwrap().color, Some(Color::Packed(3)));
        assert_eq!(roles("x[m] y[m] z[m] class label").unwrap().label, Some(4), "the surer name wins");
        assert_eq!(roles("x y class"), None);
        let geographic = roles("gps_lat alt gps_lon").unwrap();
        assert_eq!((geographic.position, geographic.degrees), ([2, 0, 1], true));
        assert!(
            !all.degrees && name_degrees(&["id", "lng", "lat"]) && !name_degrees(&["x", "flat", "along"])
        );
        assert_eq!(names_of_parts("xyz", 3), ["x", "y", "z"]);
        assert_eq!(names_of_parts("fpfh", 2), ["fpfh[0]", "fpfh[1]"]);
    }

    #[test]
    fn values_tell_what_has_no_name() {
        let rows: Vec<[f64; 7]> = (0..40)
            .map(|i| {
                let a = f64::from(i);
                [a.sin(), a.cos(), 0.0, f64::from(i % 200), 20.0, 30.0, f64::from(i % 4)]
            })
            .collect();
        let values = rows.concat();
        let mut notes = Vec::new();
        let all = Nameless { values: &values, width: 7, scalars_first: false }.attributes(&mut notes);
        assert_eq!(all.normals.unwrap()[0], [0.0, 1.0, 0.0]);
        assert_eq!(all.colors.unwrap()[39], [39, 20, 30]);
        assert_eq!(all.labels.unwrap()[39], 3);
        assert_eq!(notes, ["column 10 contains only a few distinct whole numbers: read as labels"]);
        // An intensity that is measured is no label.
        let single: Vec<f64> = (0..40).map(|i| f64::from(i * i % 97)).collect();
        let none = Nameless { values: &single, width: 1, scalars_first: false }.attributes(&mut notes);
        assert_eq!(none, Attributes::default());
    }

    #[test]
    fn scales_of_colors_are_told_from_the_largest() {
        let mut notes = Vec::new();
        assert_eq!(colors(&[[0.0, 0.5, 1.0]], false, &mut notes), Some(vec![[0, 128, 255]]));
        assert_eq!(colors(&[[0.0, 0.0, 1.0]], true, &mut notes), Some(vec![[0, 0, 1]]));
        assert_eq!(colors(&[[0.0, 257.0, 65535.0]], true, &mut notes), Some(vec![[0, 1, 255]]));
        assert!(notes.is_empty());
        assert_eq!(colors(&[[f32::NAN; 3], [9.0; 3]], true, &mut notes), Some(vec![[0; 3], [9; 3]]));
        assert!(notes[0].contains("1 colour is"), "{notes:?}");
        for values in [[1e6; 3], [-7.0, 0.0, 1.0]] {
            notes.clear();
            assert_eq!(colors(&[values], false, &mut notes), None);
            assert!(notes[0].contains("unknown scale"), "{notes:?}");
        }
        notes.clear();
        assert_eq!(colors(&[[-1.0, 0.0, 1.0]], false, &mut notes), Some(vec![[0, 128, 255]]));
        assert!(notes[0].contains("−1 (black) to 1 (white)"), "{notes:?}");
        assert_eq!(colors(&[[-0.001, 0.0, 1.0]], false, &mut notes), Some(vec![[0, 0, 255]]));
        assert_eq!(notes.len(), 1, "a rounding error below 0 is none of a scale");
        assert_eq!(labels(&[1.0, f64::NAN], &mut notes), Some(vec![1, -1]));
        assert_eq!(labels(&[1.5], &mut notes), None);
    }
}
