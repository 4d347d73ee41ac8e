//! The surface of a tapered superquadric as triangles, parameter lines and
//! sample points.
//!
//! The untapered surface is a product of two superellipses, the *profile*
//! (exponent ε1, from pole to pole) and the *section* (ε2, around the
//! equator):
//!
//! ```text
//! q = (ax·c₁·c₂, ay·c₁·s₂, az·s₁)          normal ∝ (m₁·m₂/ax, m₁·n₂/ay, n₁/az)
//! c^(2/ε) + s^(2/ε) = 1                     m = c^(2/ε − 1),  n = s^(2/ε − 1)
//! ```
//!
//! so that two short curves carry all powers. A curve is run through by the
//! slope ρ = s/c of its points, in logarithms, where no exponent overflows,
//! and cut into pieces of equal *arc length plus turning angle*: a box's edge,
//! where the normal turns within a narrow strip, gets as many vertices as its
//! faces do, and a flat cap keeps one normal.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point3, Vector3};

use super::Superquadric;

/// Slopes below this are as good as the end of the curve: at a sharp tip
/// (ε > 1) the normal would turn for ever on the way to it.
const SMALLEST_SLOPE: f64 = 1e-3;
/// Table entries of half a quadrant: even steps of the slope, then even steps
/// of the normal's angle in each of the planes.
const ARC_STEPS: usize = 8;

/// Signs of x and y in the four quadrants, counter-clockwise.
const SIGNS: [(f64, f64); 4] = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];

/// A point of the first quadrant of a superellipse with its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    c: f64,
    s: f64,
    /// Normal in the plane of semi-axes (1, 1): (c^(2/ε−1), s^(2/ε−1)).
    m: f64,
    n: f64,
}

impl Node {
    const START: Self = Self { c: 1.0, s: 0.0, m: 1.0, n: 0.0 };

    /// The point with s/c = `slope`, in [0, 1].
    #[inline]
    fn at(slope: f64, eps: f64) -> Self {
        if slope <= 0.0 {
            return Self::START;
        }
        // With e = ρ^(2/ε): c^(2/ε) = 1/(1 + e) and s^(2/ε) = e/(1 + e).
        let e = (2.0 / eps * slope.ln()).exp();
        let c = (-0.5 * eps * e.ln_1p()).exp();
        let s = slope * c;
        let weight = 1.0 / (1.0 + e);
        Self { c, s, m: weight / c, n: e * weight / s }
    }

    fn mirrored(self) -> Self {
        Self { c: self.s, s: self.c, m: self.n, n: self.m }
    }

    fn between(a: &Self, b: &Self, t: f64) -> Self {
        let mix = |x: f64, y: f64| x + (y - x) * t;
        Self { c: mix(a.c, b.c), s: mix(a.s, b.s), m: mix(a.m, b.m), n: mix(a.n, b.n) }
    }

    /// Length of the way to `other` in a plane of semi-axes `(a, b)`.
    fn distance(&self, other: &Self, (a, b): (f64, f64)) -> f64 {
        (a * (other.c - self.c)).hypot(b * (other.s - self.s))
    }

    /// Angle of the normal in a plane of semi-axes `(a, b)`.
    fn normal_angle(&self, (a, b): (f64, f64)) -> f64 {
        (self.n * a).atan2(self.m * b)
    }
}

/// Fills `out` with nodes from s = 0 to s = c, evenly by arc length plus
/// turning angle, on average over `planes` (pairs of semi-axes). `angle_steps`
/// is the resolution of the table that the turning is measured on.
fn half_quadrant<const PLANES: usize>(
    eps: f64,
    planes: &[(f64, f64); PLANES],
    angle_steps: usize,
    table: &mut Vec<(f64, Node, f64)>,
    out: &mut [Node],
) {
    table.clear();
    let mut push = |slope: f64| table.push((slope, Node::START, 0.0));
    (0..=ARC_STEPS).for_each(|k| push(k as f64 / ARC_STEPS as f64));
    let power = 2.0 / eps - 1.0;
    if power > 1e-3 {
        for &(a, b) in planes {
            // The normal's slope is (a/b)·ρ^power, and a/b at the end.
            let (last, log_ratio) = (a.atan2(b), (b / a).ln());
            for k in 1..angle_steps {
                let tangent = (last * k as f64 / angle_steps as f64).tan();
                push(((tangent.ln() + log_ratio) / power).exp().clamp(SMALLEST_SLOPE, 1.0));
            }
        }
    }
    table.sort_unstable_by(|x, y| x.0.total_cmp(&y.0));
    for entry in table.iter_mut() {
        entry.1 = Node::at(entry.0, eps);
    }

    // The table's third column becomes the measure run through up to there.
    for plane in planes {
        let whole = Node::START.distance(&table[table.len() - 1].1, *plane).max(f64::MIN_POSITIVE);
        // A tip may turn any amount on no length: no step counts for more than
        // two even ones.
        let largest = 2.0 * FRAC_PI_2 / (2 * angle_steps) as f64;
        let mut angle = 0.0;
        for k in 1..table.len() {
            let next = table[k].1.normal_angle(*plane);
            let turning = (next - angle).abs().min(largest) / (0.5 * FRAC_PI_2);
            angle = next;
            table[k].2 += table[k - 1].1.distance(&table[k].1, *plane) / whole + turning;
        }
    }
    let mut sum = 0.0;
    for entry in table.iter_mut() {
        sum += entry.2;
        entry.2 = sum;
    }

    let pieces = out.len() - 1;
    let mut k = 1;
    for (i, node) in out.iter_mut().enumerate() {
        if i == 0 {
            *node = Node::START;
        } else if i == pieces {
            *node = table[table.len() - 1].1;
        } else {
            let wanted = sum * i as f64 / pieces as f64;
            while table[k].2 < wanted && k + 1 < table.len() {
                k += 1;
            }
            let (low, high) = (&table[k - 1], &table[k]);
            let t = if high.2 > low.2 { ((wanted - low.2) / (high.2 - low.2)).clamp(0.0, 1.0) } else { 0.0 };
            *node = Node::at(low.0 + (high.0 - low.0) * t, eps);
        }
    }
}

/// Fills `out` (an odd number of nodes) with a quadrant from (1, 0) to (0, 1);
/// the diagonal s = c, where a box has its edge, is always among them.
fn quadrant<const PLANES: usize>(
    eps: f64,
    planes: &[(f64, f64); PLANES],
    angle_steps: usize,
    table: &mut Vec<(f64, Node, f64)>,
    out: &mut [Node],
) {
    let middle = out.len() / 2;
    half_quadrant(eps, planes, angle_steps, table, &mut out[..=middle]);
    let swapped = planes.map(|(a, b)| (b, a));
    let diagonal = out[middle];
    half_quadrant(eps, &swapped, angle_steps, table, &mut out[middle..]);
    out[middle..].reverse();
    out[middle..].iter_mut().for_each(|node| *node = node.mirrored());
    out[middle] = diagonal;
}

/// The whole section, counter-clockwise, from its first quadrant.
fn full_turn(first: &[Node]) -> Vec<Node> {
    let n = first.len() - 1;
    (0..4 * n)
        .map(|i| {
            let (quadrant, k) = (i / n, i % n);
            let node = if quadrant % 2 == 0 { first[k] } else { first[n - k] };
            let (x, y) = SIGNS[quadrant];
            Node { c: x * node.c, s: y * node.s, m: x * node.m, n: y * node.n }
        })
        .collect()
}

/// The profile from the south to the north pole, from its northern quadrant.
fn pole_to_pole(north: &[Node]) -> Vec<Node> {
    let south = north.iter().skip(1).rev().map(|node| Node { s: -node.s, n: -node.n, ..*node });
    south.chain(north.iter().copied()).collect()
}

/// Outward unit normal in local space of the point with profile node `p` and
/// section node `q`. The taper turns the untapered normal g by its inverse
/// transpose; times sx·sy that is (gx·sy, gy·sx, gz·sx·sy − (x·gx·kx·sy +
/// y·gy·ky·sx)/az), which needs no division and so no floor near an apex.
#[inline]
fn local_normal(shape: &Superquadric, p: &Node, q: &Node) -> Vector3<f64> {
    let a = &shape.semi_axes;
    let [kx, ky] = shape.taper;
    let sx = (kx * p.s + 1.0).max(0.0);
    let sy = (ky * p.s + 1.0).max(0.0);
    // In units of the semi-axes: x·gx = (c₁·m₁)·(c₂·m₂), free of both.
    let (gx, gy, gz) = (p.m * q.m / a.x, p.m * q.n / a.y, p.n / a.z);
    let (xgx, ygy) = (p.c * p.m * q.c * q.m, p.c * p.m * q.s * q.n);
    let n = Vector3::new(gx * sy, gy * sx, gz * sx * sy - (xgx * kx * sy + ygy * ky * sx) / a.z);
    let length = n.norm();
    if length > 0.0 && length.is_finite() { n / length } else { Vector3::new(0.0, 0.0, 1.0f64.copysign(p.s)) }
}

/// How finely a surface is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Resolution {
    /// Pieces of a quadrant of the profile; even, at least 2.
    pub profile: usize,
    /// Pieces of a quadrant of the section; even, at least 2.
    pub section: usize,
}

impl Default for Resolution {
    /// 64 × 32 pieces: smooth at the size of a window.
    fn default() -> Self {
        Self { profile: 16, section: 16 }
    }
}

impl Resolution {
    /// What the screen shows, and what a colour a vertex is given for.
    pub const SCREEN: Self = Self { profile: 16, section: 16 };

    fn even(self) -> (usize, usize) {
        ((self.profile.max(2) + 1) & !1, (self.section.max(2) + 1) & !1)
    }

    /// Number of vertices of every mesh of this resolution: all have the same
    /// faces, [`Resolution::faces`].
    pub fn vertices(self) -> usize {
        let (profile, section) = self.even();
        (2 * profile - 1) * 4 * section + 2
    }

    /// Number of faces of every mesh of this resolution.
    pub fn faces_len(self) -> usize {
        let (profile, section) = self.even();
        2 * (2 * profile - 1) * 4 * section
    }

    /// The triangles, counter-clockwise from outside: vertex 0 is the south
    /// pole, then come the rings from south to north, then the north pole.
    pub fn faces(self) -> Vec<[u32; 3]> {
        let (profile, section) = self.even();
        let (rings, around) = ((2 * profile - 1) as u32, 4 * section as u32);
        let at = |ring: u32, i: u32| 1 + ring * around + i % around;
        let north = 1 + rings * around;
        let mut faces = Vec::with_capacity(self.faces_len());
        for i in 0..around {
            faces.push([0, at(0, i + 1), at(0, i)]);
        }
        for ring in 0..rings - 1 {
            for i in 0..around {
                let [a, b] = [at(ring, i), at(ring, i + 1)];
                let [c, d] = [at(ring + 1, i), at(ring + 1, i + 1)];
                // The diagonal is mirrored with the quadrant, so that the mesh
                // has the body's symmetry.
                if (i / section as u32 + u32::from(2 * ring + 1 < rings)).is_multiple_of(2) {
                    faces.extend([[a, b, d], [a, d, c]]);
                } else {
                    faces.extend([[a, b, c], [b, d, c]]);
                }
            }
        }
        for i in 0..around {
            faces.push([at(rings - 1, i), at(rings - 1, i + 1), north]);
        }
        faces
    }
}

/// A closed surface with a normal a vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    pub vertices: Vec<Point3<f64>>,
    /// Outward unit normals, one a vertex.
    pub normals: Vec<Vector3<f64>>,
    /// Counter-clockwise from outside.
    pub faces: Vec<[u32; 3]>,
}

/// A line on the surface: points with their outward unit normals.
pub type SurfaceLine = Vec<(Point3<f64>, Vector3<f64>)>;

/// Semi-axes by which the profile is measured: the taper makes its sides longer
/// than the height.
fn profile_plane(a: f64, height: f64, taper: f64) -> (f64, f64) {
    (a, height.hypot(taper * a))
}

/// Profile (south to north) and section (full turn) of a shape.
fn curves(shape: &Superquadric, resolution: Resolution) -> (Vec<Node>, Vec<Node>) {
    let (profile, section) = resolution.even();
    let a = &shape.semi_axes;
    let mut table = Vec::new();
    let mut north = vec![Node::START; profile + 1];
    let planes = [profile_plane(a.x, a.z, shape.taper[0]), profile_plane(a.y, a.z, shape.taper[1])];
    quadrant(shape.exponents[0], &planes, 24, &mut table, &mut north);
    let mut first = vec![Node::START; section + 1];
    quadrant(shape.exponents[1], &[(a.x, a.y)], 24, &mut table, &mut first);
    (pole_to_pole(&north), full_turn(&first))
}

/// Vertices and normals of the surface; the faces depend on the resolution
/// only, [`Resolution::faces`].
pub fn surface_vertices(
    shape: &Superquadric,
    resolution: Resolution,
) -> impl Iterator<Item = (Point3<f64>, Vector3<f64>)> {
    let (profile, section) = curves(shape, resolution);
    let last = profile.len() - 1;
    let shape = *shape;
    profile.into_iter().enumerate().flat_map(move |(i, p)| {
        let pole = i == 0 || i == last;
        // A pole is one vertex.
        let around = if pole { vec![Node { c: 0.0, s: 0.0, m: 0.0, n: 0.0 }] } else { section.clone() };
        around.into_iter().map(move |q| surface_point(&shape, &p, &q))
    })
}

/// World point and normal of a pair of nodes.
#[inline]
fn surface_point(shape: &Superquadric, p: &Node, q: &Node) -> (Point3<f64>, Vector3<f64>) {
    let position = shape.world_from_normalized(&Vector3::new(p.c * q.c, p.c * q.s, p.s));
    (position, shape.rotation * local_normal(shape, p, q))
}

/// The surface as a closed triangle mesh.
pub fn tessellate(shape: &Superquadric, resolution: Resolution) -> Surface {
    let (vertices, normals) = surface_vertices(shape, resolution).unzip();
    Surface { vertices, normals, faces: resolution.faces() }
}

/// Parameter lines: `4 · section` meridians, then `2 · profile − 1` closed
/// parallels (the first point again at the end). Every other meridian ends at
/// the outermost parallels, so that the poles are not crowded. The edges of
/// box-like shapes are among the lines.
pub fn parameter_lines(shape: &Superquadric, lines: Resolution) -> Vec<SurfaceLine> {
    let (profile_lines, section_lines) = lines.even();
    // Four pieces between two lines keep the lines smooth.
    let fine = Resolution { profile: 4 * profile_lines, section: 4 * section_lines };
    let (profile, section) = curves(shape, fine);
    let meridians = section.iter().step_by(4).enumerate().map(|(k, q)| {
        let trim = 4 * (k % 2);
        let nodes = &profile[trim..profile.len() - trim];
        nodes.iter().map(|p| surface_point(shape, p, q)).collect::<SurfaceLine>()
    });
    let parallels = profile[1..profile.len() - 1].iter().skip(3).step_by(4).map(|p| {
        section.iter().chain(section.first()).map(|q| surface_point(shape, p, q)).collect::<SurfaceLine>()
    });
    meridians.chain(parallels).collect()
}

/// Pieces of a quadrant in [`AreaGrid`].
const PROFILE_PIECES: usize = 8;
const SECTION_PIECES: usize = 12;
/// Rows of the grid, from pole to pole.
const ROWS: usize = 2 * PROFILE_PIECES;

/// Areas of the cells of a coarse grid over a quarter of the surface (the
/// taper keeps the symmetry of x and y).
struct AreaGrid {
    /// Northern quadrant of the profile and first quadrant of the section.
    profile: [Node; PROFILE_PIECES + 1],
    section: [Node; SECTION_PIECES + 1],
    /// Area from the row's start up to the end of each column.
    columns: [[f64; SECTION_PIECES + 1]; ROWS],
    /// Area of the quarter from the south pole up to the start of each row.
    rows: [f64; ROWS + 1],
    /// Length of the profile from the south pole up to the start of each row.
    ways: [f64; ROWS + 1],
    /// Width of the section at the start of each row, to a factor.
    widths: [f64; ROWS + 1],
}

impl AreaGrid {
    fn new(shape: &Superquadric) -> Self {
        let a = &shape.semi_axes;
        let mut table = Vec::with_capacity(ARC_STEPS + 1 + 8);
        let mut profile = [Node::START; PROFILE_PIECES + 1];
        let taper = 0.5 * (shape.taper[0].abs() + shape.taper[1].abs());
        let plane = profile_plane(0.5 * (a.x + a.y), a.z, taper);
        quadrant(shape.exponents[0], &[plane], 6, &mut table, &mut profile);
        let mut section = [Node::START; SECTION_PIECES + 1];
        quadrant(shape.exponents[1], &[(a.x, a.y)], 6, &mut table, &mut section);

        let mut grid = Self {
            profile,
            section,
            columns: [[0.0; SECTION_PIECES + 1]; ROWS],
            rows: [0.0; ROWS + 1],
            ways: [0.0; ROWS + 1],
            widths: [0.0; ROWS + 1],
        };
        // x and y of the section at the lower and the upper edge of a row.
        let ring = |p: &Node| {
            let wx = a.x * p.c * (shape.taper[0] * p.s + 1.0).max(0.0);
            let wy = a.y * p.c * (shape.taper[1] * p.s + 1.0).max(0.0);
            (wx, wy, a.z * p.s)
        };
        let mut low = ring(&grid.profile_node(0));
        for row in 0..ROWS {
            let high = ring(&grid.profile_node(row + 1));
            let dz = high.2 - low.2;
            let mut sum = 0.0;
            for k in 0..SECTION_PIECES {
                let (p, q) = (&grid.section[k], &grid.section[k + 1]);
                // Half the cross product of the diagonals.
                let d = Vector3::new(high.0 * q.c - low.0 * p.c, high.1 * q.s - low.1 * p.s, dz);
                let e = Vector3::new(high.0 * p.c - low.0 * q.c, high.1 * p.s - low.1 * q.s, dz);
                sum += 0.5 * d.cross(&e).norm();
                grid.columns[row][k + 1] = sum;
            }
            grid.rows[row + 1] = grid.rows[row] + sum;
            let length = (0.5 * (high.0 + high.1 - low.0 - low.1)).hypot(dz);
            grid.ways[row + 1] = grid.ways[row] + length;
            grid.widths[row + 1] = high.0 + high.1;
            low = high;
        }
        grid
    }

    /// The k-th node of the profile from the south pole.
    #[inline]
    fn profile_node(&self, k: usize) -> Node {
        if k >= PROFILE_PIECES {
            self.profile[k - PROFILE_PIECES]
        } else {
            let node = self.profile[PROFILE_PIECES - k];
            Node { s: -node.s, n: -node.n, ..node }
        }
    }

    /// Area of the quarter from the south pole up to the part `t` of the way
    /// through a row, whose width changes evenly on the way.
    fn area_below(&self, row: usize, t: f64) -> f64 {
        let (w0, w1) = (self.widths[row], self.widths[row + 1]);
        let part = if w0 + w1 > 0.0 { t * (2.0 * w0 + (w1 - w0) * t) / (w0 + w1) } else { t };
        self.rows[row] + part * (self.rows[row + 1] - self.rows[row])
    }

    /// The point of the section after the part `turn`, in [0, 1), of the area
    /// of a whole row.
    #[inline]
    fn section_node(&self, row: usize, turn: f64) -> Node {
        let quadrant = (4.0 * turn) as usize & 3;
        let mut part = (4.0 * turn).fract();
        if quadrant % 2 == 1 {
            part = 1.0 - part;
        }
        let columns = &self.columns[row];
        let area = part * columns[SECTION_PIECES];
        let k = columns[1..SECTION_PIECES].iter().take_while(|&&end| end < area).count();
        let width = columns[k + 1] - columns[k];
        let t = if width > 0.0 { ((area - columns[k]) / width).clamp(0.0, 1.0) } else { part };
        let node = Node::between(&self.section[k], &self.section[k + 1], t);
        let (x, y) = SIGNS[quadrant];
        Node { c: x * node.c, s: y * node.s, m: x * node.m, n: y * node.n }
    }
}

/// Surface area, within 1 %; 0 for a shape that is not valid.
pub fn surface_area(shape: &Superquadric) -> f64 {
    if !shape.is_valid() {
        return 0.0;
    }
    let area = 4.0 * AreaGrid::new(shape).rows[ROWS];
    if area.is_finite() { area } else { 0.0 }
}

/// About evenly spaced points (area-proportional) on the surface with their
/// outward unit normals: about area / spacing² of them, at least 1 and at most
/// `max`. The same arguments give the same points. Empty for a shape that is
/// not valid or has no area.
pub fn surface_samples(shape: &Superquadric, spacing: f64, max: usize) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let mut samples = Vec::new();
    surface_samples_into(shape, spacing, max, &mut samples);
    samples
}

/// [`surface_samples`] into a vector whose memory is used again.
///
/// The surface is cut into bands about `spacing` wide between the poles; each
/// holds its share of the points, spread evenly by area along the band, and
/// the bands are turned against each other by the golden ratio.
pub fn surface_samples_into(
    shape: &Superquadric,
    spacing: f64,
    max: usize,
    samples: &mut Vec<(Point3<f64>, Vector3<f64>)>,
) {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    samples.clear();
    if !shape.is_valid() || max == 0 {
        return;
    }
    let grid = AreaGrid::new(shape);
    let quarter = grid.rows[ROWS];
    let area = 4.0 * quarter;
    if !(area > 0.0 && area.is_finite()) {
        return;
    }
    let wanted = area / (spacing * spacing);
    let count = if wanted < max as f64 { (wanted.round() as usize).max(1) } else { max };
    let spacing = (area / count as f64).sqrt();

    let (way, ways) = (grid.ways[ROWS], &grid.ways);
    let bands = ((way / spacing).round() as usize).clamp(1, count);

    samples.reserve(count);
    let (mut row, mut phase) = (0, 0.5);
    // Row and place within it after a part of the way from pole to pole.
    let mut walk = |part: f64| {
        let end = way * part;
        while row + 1 < ROWS && ways[row + 1] < end {
            row += 1;
        }
        let length = ways[row + 1] - ways[row];
        (row, if length > 0.0 { ((end - ways[row]) / length).clamp(0.0, 1.0) } else { 0.5 })
    };
    for band in 0..bands {
        let (middle, t) = walk((band as f64 + 0.5) / bands as f64);
        let profile = Node::between(&grid.profile_node(middle), &grid.profile_node(middle + 1), t);
        let (last, t) = walk((band + 1) as f64 / bands as f64);
        let area_below = grid.area_below(last, t);
        let until = if band + 1 == bands { count as f64 } else { count as f64 * area_below / quarter };
        let here = (until.round() as usize).saturating_sub(samples.len());
        for k in 0..here {
            let section = grid.section_node(middle, (k as f64 + phase) / here as f64);
            samples.push(surface_point(shape, &profile, &section));
        }
        phase = (phase + GOLDEN).fract();
    }
}
