//! Colours of primitives and their points: one palette for screen and files.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

/// The colour of points that belong to no primitive.
pub const UNASSIGNED_COLOR: [u8; 3] = [138, 138, 138];

/// As many colours as ids may need, which grow with every birth. The first six
/// are Okabe and Ito's; each further one is the colour farthest from all before
/// it and from [`UNASSIGNED_COLOR`] in Oklab, the nearest of four distances
/// counting: for usual sight, protanopia, deuteranopia and tritanopia (Machado
/// et al. 2009). None is so dark or so pale that it drowns in a dark or a light
/// background.
#[rustfmt::skip]
const COLORS: [[u8; 3]; 120] = [
    [0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0],
    [144, 8, 56], [80, 248, 192], [0, 0, 232], [224, 224, 0], [88, 64, 120], [184, 80, 248],
    [152, 192, 144], [152, 216, 248], [160, 72, 40], [136, 88, 120], [80, 40, 176], [208, 32, 200],
    [224, 200, 104], [0, 208, 200], [248, 72, 104], [128, 144, 232], [224, 128, 32], [200, 16, 96],
    [184, 56, 160], [72, 160, 192], [72, 120, 216], [88, 56, 248], [40, 232, 144], [120, 48, 88],
    [152, 128, 72], [96, 192, 96], [40, 112, 64], [160, 16, 0], [152, 0, 144], [240, 168, 184],
    [208, 144, 152], [160, 192, 248], [248, 96, 200], [136, 24, 200], [160, 104, 136], [128, 232, 224],
    [192, 208, 0], [184, 80, 0], [80, 72, 160], [144, 64, 136], [160, 240, 128], [104, 88, 224],
    [248, 144, 96], [104, 168, 128], [160, 112, 176], [152, 0, 112], [200, 192, 72], [136, 160, 48],
    [160, 80, 184], [0, 128, 248], [216, 144, 224], [224, 176, 216], [184, 120, 104], [216, 0, 72],
    [184, 136, 208], [240, 144, 176], [112, 248, 80], [88, 80, 8], [112, 96, 160], [112, 48, 224],
    [152, 152, 248], [248, 200, 160], [120, 128, 224], [80, 184, 120], [32, 80, 184], [192, 160, 248],
    [144, 88, 72], [184, 88, 96], [216, 64, 208], [184, 192, 120], [200, 88, 160], [128, 136, 0],
    [152, 224, 176], [136, 56, 80], [152, 184, 40], [224, 88, 80], [48, 8, 248], [192, 48, 120],
    [160, 40, 104], [168, 32, 48], [152, 72, 96], [152, 128, 248], [208, 136, 80], [112, 224, 112],
    [120, 72, 48], [80, 0, 200], [0, 136, 136], [224, 128, 176], [128, 200, 224], [144, 104, 40],
    [96, 64, 144], [120, 224, 200], [208, 208, 136], [128, 96, 144], [104, 80, 248], [48, 120, 192],
    [240, 56, 224], [112, 8, 160], [80, 128, 64], [248, 192, 248], [48, 136, 176], [136, 32, 128],
    [144, 24, 160], [152, 16, 184], [248, 160, 160], [240, 96, 152], [136, 0, 104], [240, 128, 136],
    [104, 16, 216], [176, 168, 72], [184, 128, 184], [144, 168, 216], [16, 96, 72], [168, 32, 208],
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
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Colors(BTreeMap<u32, u32>);

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

    /// Oklab coordinates of an sRGB colour.
    fn oklab(rgb: [u8; 3]) -> [f64; 3] {
        let [r, g, b] = rgb.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let l = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b).cbrt();
        let m = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b).cbrt();
        let s = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b).cbrt();
        [
            0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
        ]
    }

    #[test]
    fn colors_can_be_told_apart_and_from_grey() {
        let mut all = COLORS.to_vec();
        all.push(UNASSIGNED_COLOR);
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                let (a, b) = (oklab(*a), oklab(*b));
                let distance = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
                // 0.02 is about one just noticeable difference.
                let least = if i < 40 { 0.06 } else { 0.03 };
                assert!(distance > least, "{distance}");
            }
        }
    }

    #[test]
    fn colors_stand_out_on_dark_and_light_ground() {
        for c in COLORS {
            let lightness = oklab(c)[0];
            assert!((0.35..0.9).contains(&lightness), "{c:?} has lightness {lightness}");
        }
    }
}
