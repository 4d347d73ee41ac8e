//! The parameters of the primitives, as JSON, NPZ and CSV.

use std::io::{self, Seek, Write};
use std::path::Path;

use nalgebra::{Point3, Rotation3};
use serde::{Deserialize, Serialize};

use super::atomic::unfit;
use super::cloud::{Text, file_label};
use super::formats::Format;
use super::npy::Npz;
use super::{Outcome, json};
use crate::geometry::palette::Colors;
use crate::inference::{Method, Params, Primitive};
use crate::io::WriteError;
use crate::io::read::primitives;

/// Primitives with what is known of where they come from.
#[derive(Debug, Clone, Copy)]
pub struct PrimitiveSet<'a> {
    pub primitives: &'a [Primitive],
    pub colors: &'a Colors,
    /// Name of the shape that they stand for.
    pub input: Option<&'a str>,
    /// Number of samples they were computed from.
    pub points: Option<usize>,
    /// The samples, and for each the id of its primitive.
    pub samples: Option<(&'a [Point3<f64>], &'a [u32])>,
    pub sampling_seed: Option<u64>,
    /// Seed of the run.
    pub seed: Option<u64>,
    pub params: Option<&'a Params>,
}

impl<'a> From<&Outcome<'a>> for PrimitiveSet<'a> {
    fn from(outcome: &Outcome<'a>) -> Self {
        let Outcome { shape, cloud, abstraction, colors, params, .. } = *outcome;
        Self {
            primitives: &abstraction.primitives,
            colors,
            input: Some(&shape.name),
            points: Some(cloud.points.len()),
            samples: Some((&cloud.points, &abstraction.labels)),
            sampling_seed: Some(outcome.sampling.seed),
            seed: Some(params.seed),
            params: Some(params),
        }
    }
}

/// One entry of `primitives.json`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct PrimitiveEntry {
    pub(in crate::io) id: u32,
    pub(in crate::io) eps: [f64; 2],
    pub(in crate::io) scale: [f64; 3],
    pub(in crate::io) rotation: [[f64; 3]; 3],
    pub(in crate::io) translation: [f64; 3],
    pub(in crate::io) taper: [f64; 2],
    pub(in crate::io) sigma: f64,
    pub(in crate::io) points: usize,
    pub(in crate::io) mean_distance: f64,
}

/// Rejects invalid primitives.
pub(super) fn checked(p: &Primitive) -> io::Result<&Primitive> {
    if p.shape.is_valid() && p.sigma.is_finite() && p.mean_distance.is_finite() {
        return Ok(p);
    }
    Err(unfit(format!("primitive {} has an invalid parameter", p.id)))
}

impl PrimitiveEntry {
    fn new(p: &Primitive) -> io::Result<Self> {
        checked(p)?;
        let rotation = p.shape.rotation.matrix();
        Ok(Self {
            id: p.id,
            eps: p.shape.exponents,
            scale: p.shape.semi_axes.into(),
            rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| rotation[(row, column)])),
            translation: p.shape.translation.into(),
            taper: p.shape.taper,
            sigma: p.sigma,
            points: p.points,
            mean_distance: p.mean_distance,
        })
    }
}

#[derive(Debug, Serialize)]
struct PrimitivesFile<'a> {
    format: &'static str,
    version: u32,
    program: &'static str,
    input: Option<&'a str>,
    units: &'static str,
    rotation: &'static str,
    seed: Option<u64>,
    points: Option<usize>,
    sampling_seed: Option<u64>,
    method: Option<Method>,
    params: Option<&'a Params>,
    primitives: Vec<PrimitiveEntry>,
}

impl PrimitiveSet<'_> {
    pub(super) fn json(&self, w: &mut impl Write) -> io::Result<()> {
        let file = PrimitivesFile {
            format: primitives::FORMAT,
            version: primitives::VERSION,
            program: concat!("superform ", env!("CARGO_PKG_VERSION")),
            input: self.input,
            units: "those of the input",
            rotation: "world from local, rows",
            seed: self.seed,
            points: self.points,
            sampling_seed: self.sampling_seed,
            method: self.params.and_then(Method::of),
            params: self.params,
            primitives: self.primitives.iter().map(PrimitiveEntry::new).collect::<Result<_, _>>()?,
        };
        json(w, &file)
    }

    /// 13 columns in the order of the paper's authors.
    pub(super) fn csv(&self, w: &mut impl Write) -> io::Result<()> {
        let ids: String = self.primitives.iter().map(|p| format!(" {}", p.id)).collect();
        write!(
            w,
            "# superform-primitives; lengths in units of the input, angles in radians; \
             Rz(yaw) Ry(pitch) Rx(roll) takes local to world\n\
             # ids{ids}\n\
             # {}\n",
            primitives::CSV_COLUMNS.join(",")
        )?;
        for primitive in self.primitives {
            let shape = &checked(primitive)?.shape;
            let numbers = shape
                .exponents
                .into_iter()
                .chain(shape.semi_axes.iter().copied())
                .chain(yaw_pitch_roll(&shape.rotation))
                .chain(shape.translation.iter().copied())
                .chain(shape.taper);
            for (k, number) in numbers.enumerate() {
                write!(w, "{}{}", if k > 0 { "," } else { "" }, Text(number))?;
            }
            writeln!(w)?;
        }
        Ok(())
    }

    /// A batch of one shape, by the names that superquadric tools in Python use.
    pub(super) fn npz(&self, w: &mut (impl Write + Seek)) -> io::Result<()> {
        let all = self.primitives.iter().map(checked).collect::<io::Result<Vec<_>>>()?;
        let count = all.len();
        let mut npz = Npz::new(w);
        npz.text("names", self.input.unwrap_or_default())?;
        if let Some((points, labels)) = self.samples {
            let place = |id: u32| all.iter().position(|p| p.id == id);
            let rows = labels.iter().flat_map(|&label| {
                let own = place(label);
                (0..count).map(move |k| if Some(k) == own { 1f32 } else { 0.0 }.to_le_bytes())
            });
            npz.doubles("pc", &[1, points.len(), 3], points.iter().flat_map(|p| p.iter()))?;
            npz.add("assign_matrix", "<f4", &[1, points.len(), count], rows)?;
        }
        let of =
            |values: fn(&Primitive) -> Vec<f64>| -> Vec<f64> { all.iter().flat_map(|p| values(p)).collect() };
        for (name, shape, values) in [
            ("scale", &[1, count, 3][..], of(|p| p.shape.semi_axes.iter().copied().collect())),
            // NumPy's order is by rows, nalgebra's by columns.
            (
                "rotation",
                &[1, count, 3, 3],
                of(|p| p.shape.rotation.matrix().transpose().iter().copied().collect()),
            ),
            ("translation", &[1, count, 3], of(|p| p.shape.translation.iter().copied().collect())),
            ("exponents", &[1, count, 2], of(|p| p.shape.exponents.to_vec())),
            ("exist", &[1, count, 1], of(|_| vec![1.0])),
            ("tapering", &[1, count, 2], of(|p| p.shape.taper.to_vec())),
            ("sigma", &[1, count], of(|p| vec![p.sigma])),
            ("mean_distance", &[1, count], of(|p| vec![p.mean_distance])),
        ] {
            npz.doubles(name, shape, &values)?;
        }
        let ids = all.iter().map(|p| file_label(p.id)).collect::<io::Result<Vec<_>>>()?;
        npz.add("ids", "<i4", &[1, count], ids.into_iter().map(i32::to_le_bytes))?;
        let points = all.iter().map(|p| (p.points as i64).to_le_bytes());
        npz.add("points", "<i8", &[1, count], points)?;
        npz.finish()
    }
}

/// The primitives as a text, for the clipboard: JSON or CSV.
///
/// # Errors
/// Where the format has no text, or a primitive has a parameter that is not
/// valid.
pub fn primitives_text(format: Format, set: &PrimitiveSet<'_>) -> Result<String, WriteError> {
    let mut text = Vec::new();
    match format {
        Format::PrimitivesJson => set.json(&mut text),
        Format::PrimitivesCsv => set.csv(&mut text),
        _ => Err(unfit(format!("{format} is not a text format; use JSON or CSV"))),
    }
    .and_then(|()| String::from_utf8(text).map_err(|e| unfit(e.to_string())))
    .map_err(|e| WriteError::Content { path: Path::new("the text").to_owned(), problem: e.to_string() })
}

/// Angles of R = Rz(yaw)·Ry(pitch)·Rx(roll), in radians: yaw and roll in
/// (−π, π], pitch in [−π/2, π/2]. The product is R to the last digits also where
/// pitch is ±π/2 and yaw is a matter of choice.
pub(super) fn yaw_pitch_roll(rotation: &Rotation3<f64>) -> [f64; 3] {
    let m = rotation.matrix();
    let yaw = m[(1, 0)].atan2(m[(0, 0)]);
    let pitch = (-m[(2, 0)]).atan2(m[(0, 0)].hypot(m[(1, 0)]));
    // Roll is what is left once the yaw is taken back.
    let (s, c) = yaw.sin_cos();
    let roll = (s * m[(0, 2)] - c * m[(1, 2)]).atan2(c * m[(1, 1)] - s * m[(0, 1)]);
    [yaw, pitch, roll]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn angles_give_the_rotation_back_also_where_they_are_not_unique() {
        let mut rotations = vec![Rotation3::identity(), Rotation3::from_euler_angles(PI, 0.0, PI)];
        for pitch in [-FRAC_PI_2, FRAC_PI_2, FRAC_PI_2 - 1e-9, 1e-12 - FRAC_PI_2, 0.3] {
            for (roll, yaw) in [(0.0, 0.0), (1.0, -2.0), (3.1, 2.9), (-0.4, 1e-9)] {
                rotations.push(Rotation3::from_euler_angles(roll, pitch, yaw));
                rotations.push(Rotation3::new(Vector3::new(roll, pitch, yaw)));
            }
        }
        for rotation in rotations {
            let [yaw, pitch, roll] = yaw_pitch_roll(&rotation);
            let back = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw)
                * Rotation3::from_axis_angle(&Vector3::y_axis(), pitch)
                * Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
            let off = (back.matrix() - rotation.matrix()).amax();
            assert!(off < 1e-15 * 4.0, "{off}: {yaw} {pitch} {roll}");
        }
    }
}
