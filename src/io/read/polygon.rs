//! Triangulates polygons: by a fan around the first corner where that covers exactly the polygon
//! (always for convex ones), otherwise by ear clipping in the polygon's plane. A fan across a notch
//! would close it.

use std::ops::Range;

use earcut::Earcut;
use nalgebra::{Point2, Point3, Vector3};
use rayon::prelude::*;

use crate::geometry::mesh::has_area;

/// What a fan may cover twice or beyond its polygon, as a part of its area:
/// corners of single precision that should lie on a line don't.
const ROUNDING: f64 = 1e-6;

/// How far corners may be off their plane, as a part of the polygon's size, so
/// that one that can't be seen in it is none that is lost.
const BENT: f64 = 1e-3;

/// A polygon of more corners stays a fan: what is set aside for cutting ears
/// has its limit.
const MOST_CORNERS: usize = 1 << 24;

/// The triangles, with every fan that does not fit its polygon triangulated
/// again. A fan is a range of triangles; ranges are disjoint and in order.
pub(super) fn cut(triangles: Vec<[u32; 3]>, fans: &[Range<usize>], points: &[Point3<f64>]) -> Vec<[u32; 3]> {
    let cuts: Vec<(Range<usize>, Vec<[u32; 3]>)> = fans
        .par_iter()
        .map_init(Earcut::new, |earcut, fan| {
            Some((fan.clone(), ears(&triangles[fan.clone()], points, earcut)?))
        })
        .flatten_iter()
        .collect();
    if cuts.is_empty() {
        return triangles;
    }
    let mut all = Vec::with_capacity(triangles.len());
    let mut done = 0;
    for (fan, ears) in cuts {
        all.extend_from_slice(&triangles[done..fan.start]);
        all.extend(ears);
        done = fan.end;
    }
    all.extend_from_slice(&triangles[done..]);
    all
}

/// The polygon of a fan by its ears, with the polygon's orientation; `None`
/// where the fan fits, or nothing better is to be had.
fn ears(fan: &[[u32; 3]], points: &[Point3<f64>], earcut: &mut Earcut<f64>) -> Option<Vec<[u32; 3]>> {
    let [[first, second, _], ..] = *fan else { return None };
    let from = |i: u32| points[i as usize] - points[first as usize];
    // Relative to a corner and in the polygon's own size, so that neither
    // places far out nor tiny or huge sizes matter.
    let mut size = 0.0f64;
    for &i in fan.iter().flatten() {
        let offset = from(i);
        if !offset.iter().all(|c| c.is_finite()) {
            return None;
        }
        size = size.max(offset.amax());
    }
    if size == 0.0 {
        return None;
    }
    // A power of two, which rounds nothing.
    let size = size.log2().floor().exp2();
    let place = |i: u32| from(i) / size;
    let twice_areas = || fan.iter().map(|&[_, a, b]| place(a).cross(&place(b)));
    let normal: Vector3<f64> = twice_areas().sum();
    let area = normal.norm();
    let normal = normal.try_normalize(0.0)?;
    let turned: f64 = twice_areas().map(|t| (-t.dot(&normal)).max(0.0)).sum();
    if turned <= ROUNDING * area || fan.len() + 2 > MOST_CORNERS {
        return None;
    }
    let is_plane = fan.iter().flatten().all(|&i| place(i).dot(&normal).abs() < BENT);
    // Seen along a coordinate, what lies on a line stays there to the last bit;
    // but a polygon that is bent can be seen along its normal only.
    let [u, v] = if is_plane {
        let axis = normal.iamax();
        let [u, v] = [1, 2].map(|next| Vector3::ith((axis + next) % 3, 1.0));
        if normal[axis] > 0.0 { [u, v] } else { [v, u] }
    } else {
        let u = Vector3::ith(normal.iamin(), 1.0).cross(&normal).normalize();
        [u, normal.cross(&u)]
    };
    let corners: Vec<u32> = [first, second].into_iter().chain(fan.iter().map(|t| t[2])).collect();
    let flat: Vec<Point2<f64>> =
        corners.iter().map(|&i| Point2::new(place(i).dot(&u), place(i).dot(&v))).collect();
    let mut found: Vec<usize> = Vec::new();
    earcut.earcut(flat.iter().map(|p| [p.x, p.y]), &[], &mut found);
    let ears = found.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
    // Corners on a line make ears of rounding.
    let mut ears: Vec<[usize; 3]> =
        ears.filter(|ear| has_area(&ear.map(|i| points[corners[i] as usize]))).collect();
    let is_whole = put_back(&mut ears, &flat);
    (!ears.is_empty() && (is_whole || is_plane))
        .then(|| ears.iter().map(|ear| ear.map(|i| corners[i])).collect())
}

/// Puts corners that were passed over, since they lie on a line, into the edge
/// where they lie: the polygon's neighbours have them, too, and would gape.
/// Whether all corners are there.
fn put_back(ears: &mut Vec<[usize; 3]>, flat: &[Point2<f64>]) -> bool {
    let n = flat.len();
    let mut is_there = vec![false; n];
    ears.iter().flatten().for_each(|&i| is_there[i] = true);
    if is_there.iter().all(|is_there| *is_there) {
        return true;
    }
    let mut waiting = std::mem::take(ears);
    while let Some([a, b, c]) = waiting.pop() {
        let split = [[a, b, c], [b, c, a], [c, a, b]].into_iter().find_map(|[i, j, k]| {
            let missing = || (i + 1..i + n).map(|d| d % n).take_while(|&d| d != j && !is_there[d]);
            // Else it is no edge of the polygon.
            let is_edge = (i + missing().count() + 1) % n == j;
            let is_between = |d: &usize| {
                let (from, to, edge) = (flat[*d] - flat[i], flat[*d] - flat[j], flat[j] - flat[i]);
                from.dot(&to) <= 0.0 && from.perp(&edge).abs() <= ROUNDING * edge.norm_squared()
            };
            missing().find(is_between).filter(|_| is_edge).map(|d| (d, [[i, d, k], [d, j, k]]))
        });
        match split {
            Some((d, halves)) => {
                is_there[d] = true;
                waiting.extend(halves);
            }
            None => ears.push([a, b, c]),
        }
    }
    is_there.iter().all(|is_there| *is_there)
}

#[cfg(test)]
mod tests;
