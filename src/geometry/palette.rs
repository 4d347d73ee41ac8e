//! Colours of primitives and their points: one palette for screen and files.
//!
//! How it was chosen: among the sRGB colours on a grid of 8 whose relative
//! luminance lies in [0.06, 0.5], so that they stand out on a dark and on a
//! light background, and whose Oklab chroma is above 0.05, so that none passes
//! for [`UNASSIGNED_COLOR`]. The distance of two colours is the least of their
//! four distances in Oklab for usual sight, protanopia, deuteranopia and
//! tritanopia (Machado et al. 2009, severity 1; tritanopia, which is very rare,
//! counts 1.25 times, usual sight 0.85 times). The first [`SAFE`] maximise the least
//! distance: chosen greedily, then exchanged one by one until none gains. They
//! are in the order in which each is farthest from all before it, the last four
//! counting more, so that ids that follow one another differ most. The others
//! follow greedily.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use super::brief::Brief;

/// The colour of points that belong to no primitive.
pub const UNASSIGNED_COLOR: [u8; 3] = [138, 138, 138];

/// Ids below this have colours that also colour-blind eyes tell apart.
pub const SAFE: u32 = 32;

/// As many colours as ids may need, which grow with every birth.
#[rustfmt::skip]
const COLORS: [[u8; 3]; 120] = [
    [32, 128, 208], [200, 184, 0], [144, 8, 24], [24, 0, 232], [152, 176, 255], [232, 88, 48],
    [112, 32, 128], [136, 112, 255], [88, 104, 0], [240, 160, 184], [192, 16, 136], [56, 72, 255],
    [0, 80, 56], [128, 160, 112], [200, 72, 208], [200, 32, 8], [104, 200, 216], [48, 104, 128],
    [216, 144, 32], [136, 56, 192], [112, 152, 255], [152, 104, 96], [168, 176, 136], [136, 40, 88],
    [104, 144, 64], [104, 0, 176], [160, 112, 168], [160, 200, 112], [136, 80, 88], [200, 144, 176],
    [120, 96, 168], [168, 136, 208], [96, 184, 88], [120, 56, 160], [72, 96, 56], [144, 168, 216],
    [96, 64, 224], [32, 88, 112], [200, 120, 176], [120, 104, 64], [120, 48, 56], [224, 104, 240],
    [192, 48, 168], [96, 168, 144], [56, 32, 200], [120, 192, 168], [168, 120, 104], [112, 104, 232],
    [168, 16, 112], [240, 144, 80], [144, 112, 136], [72, 72, 16], [216, 80, 184], [96, 144, 232],
    [255, 88, 152], [80, 56, 144], [152, 128, 8], [136, 80, 192], [255, 8, 88], [144, 200, 152],
    [72, 88, 136], [192, 8, 96], [136, 192, 240], [72, 112, 144], [216, 144, 200], [64, 136, 64],
    [224, 168, 208], [136, 112, 224], [216, 160, 112], [192, 88, 120], [64, 184, 40], [152, 0, 112],
    [176, 96, 40], [104, 88, 224], [8, 192, 120], [136, 0, 96], [216, 184, 88], [104, 48, 184],
    [144, 72, 64], [0, 168, 232], [56, 96, 255], [0, 40, 255], [152, 128, 200], [128, 168, 192],
    [152, 80, 0], [88, 152, 160], [152, 80, 112], [160, 0, 0], [96, 48, 208], [80, 96, 152],
    [240, 160, 232], [200, 112, 128], [104, 128, 184], [56, 80, 160], [136, 64, 80], [255, 144, 255],
    [136, 96, 192], [255, 112, 88], [0, 72, 128], [112, 152, 48], [200, 32, 208], [192, 128, 255],
    [96, 64, 144], [120, 80, 40], [176, 56, 152], [104, 56, 72], [104, 72, 176], [72, 48, 160],
    [240, 56, 160], [240, 128, 224], [0, 144, 112], [72, 208, 0], [160, 112, 88], [136, 192, 192],
    [200, 8, 120], [224, 112, 88], [64, 160, 80], [248, 120, 120], [0, 152, 184], [160, 88, 48],
];

/// The sRGB colour of the primitive with this id, the same in every picture
/// and file. The smaller two ids, the better their colours can be told apart;
/// ids 120 apart share one.
pub fn color_of(id: u32) -> [u8; 3] {
    COLORS[id as usize % COLORS.len()]
}

/// Which colour of the palette each primitive of a run has. Ids begin anew in
/// every run; where one run takes the place of another, what stands for the
/// same part keeps its colour.
#[derive(Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Colors(BTreeMap<u32, u32>);

impl fmt::Debug for Colors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Colors").field(&Brief::of(&self.0)).finish()
    }
}

impl Colors {
    /// The ids of `kept` get those places in the palette, all `others` the first
    /// that are still free.
    pub fn new(kept: BTreeMap<u32, u32>, others: impl IntoIterator<Item = u32>) -> Self {
        let taken: BTreeSet<u32> = kept.values().copied().collect();
        let mut free = (0..).filter(|place| !taken.contains(place));
        let mut places = kept;
        for id in others {
            if let Entry::Vacant(new) = places.entry(id)
                && let Some(place) = free.next()
            {
                new.insert(place);
            }
        }
        Self(places)
    }

    /// The place in the palette; that of the id itself, where it was given none.
    pub fn place(&self, id: u32) -> u32 {
        self.0.get(&id).copied().unwrap_or(id)
    }

    /// The sRGB colour.
    pub fn of(&self, id: u32) -> [u8; 3] {
        color_of(self.place(id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kept_keep_and_nobody_shares() {
        let colors = Colors::new([(7, 2), (9, 0)].into(), [3, 7, 8, 4]);
        assert_eq!([7, 9, 3, 8, 4].map(|id| colors.place(id)), [2, 0, 1, 3, 4]);
        assert_eq!(Colors::default().of(5), color_of(5));
    }

    /// Usual sight, protanopia, deuteranopia, tritanopia: what linear sRGB is
    /// seen as (Machado, Oliveira and Fernandes 2009, severity 1).
    const SIGHTS: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    ];

    fn linear(rgb: [u8; 3]) -> [f64; 3] {
        rgb.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    }

    /// Relative luminance.
    fn luminance(rgb: [u8; 3]) -> f64 {
        let [r, g, b] = linear(rgb);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// Oklab coordinates of an sRGB colour as it is seen.
    fn oklab(rgb: [u8; 3], sight: &[[f64; 3]; 3]) -> [f64; 3] {
        let of = linear(rgb);
        let [r, g, b] = sight.map(|row| (0..3).map(|k| row[k] * of[k]).sum::<f64>().clamp(0.0, 1.0));
        let l = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b).cbrt();
        let m = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b).cbrt();
        let s = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b).cbrt();
        [
            0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
        ]
    }

    fn distance(a: [u8; 3], b: [u8; 3], sight: &[[f64; 3]; 3]) -> f64 {
        let (a, b) = (oklab(a, sight), oklab(b, sight));
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// The least distance among the first colours and grey.
    fn least(first: u32, sight: &[[f64; 3]; 3]) -> f64 {
        let mut all: Vec<_> = (0..first).map(color_of).collect();
        all.push(UNASSIGNED_COLOR);
        let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| distance(all[i], all[j], sight)).fold(f64::INFINITY, f64::min)
    }

    /// 0.02 is about one just noticeable difference.
    #[test]
    fn colors_can_be_told_apart_by_every_eye() {
        for (first, floors) in [
            (12, [0.100, 0.060, 0.060, 0.060]),
            (SAFE, [0.070, 0.060, 0.060, 0.049]),
            (COLORS.len() as u32, [0.030, 0.024, 0.024, 0.019]),
        ] {
            for (sight, floor) in SIGHTS.iter().zip(floors) {
                let least = least(first, sight);
                assert!(least > floor, "{least} among the first {first}, {floor} was promised");
            }
        }
    }

    #[test]
    fn ids_that_follow_one_another_differ_most() {
        for sight in &SIGHTS {
            for id in 1..SAFE {
                let apart = distance(color_of(id - 1), color_of(id), sight);
                assert!(apart > 0.13, "{} and {id}: {apart}", id - 1);
            }
        }
    }

    #[test]
    fn colors_stand_out_on_dark_and_light_ground() {
        for color in COLORS {
            let luminance = luminance(color);
            assert!((0.06..0.5).contains(&luminance), "{color:?} has luminance {luminance}");
            let [_, a, b] = oklab(color, &SIGHTS[0]);
            assert!(a.hypot(b) > 0.05, "{color:?} is nearly grey");
        }
    }
}
