//! What speaks for a merge or against it, in words.

use crate::inference::{MergeReason, PaperFinding, TestQuantity};

/// What speaks for a merge or against it, as one sentence.
pub fn sentence(reason: &MergeReason) -> String {
    match reason {
        MergeReason::Energy { gain } if *gain > 0.0 => {
            format!("Merging lowers the energy by {gain:.4}, including the cost of the primitive it saves.")
        }
        MergeReason::Energy { gain } => {
            format!("Merging raises the energy by {:.4}, even after saving one primitive's cost.", -gain)
        }
        MergeReason::SwitchedOff => {
            "Merging is switched off in the parameters. You can still merge these two by hand.".to_owned()
        }
        MergeReason::Paper { finding, value, limit } => paper(*finding, *value, *limit),
        MergeReason::Sentence(text) => {
            let mut letters = text.chars();
            let first = letters.next().map(char::to_uppercase);
            let text: String = first.into_iter().flatten().chain(letters).collect();
            if text.ends_with('.') { text } else { format!("{text}.") }
        }
    }
}

fn paper(finding: PaperFinding, value: f64, limit: f64) -> String {
    match finding {
        PaperFinding::BoxTooEmpty => {
            format!("The two parts fill only {value:.2} of their common bounding box, less than {limit}.")
        }
        PaperFinding::UnionTooEmpty => {
            format!("The two primitives fill only {value:.2} of the union's volume, less than {limit}.")
        }
        PaperFinding::RelativeErrorNoWorse => {
            format!("The relative squared error {value:.1e} is no worse than before ({limit:.1e}).")
        }
        PaperFinding::RelativeErrorSmall => {
            format!("The relative squared error {value:.1e} is below {limit:.1e}.")
        }
        PaperFinding::MeanSquareSmall => {
            format!("The mean squared distance {value:.1e} is below {limit:.1e}.")
        }
        PaperFinding::MeanSquareLess => {
            format!("The mean squared distance {value:.1e} is smaller than before ({limit:.1e}).")
        }
        PaperFinding::ErrorsTooLarge => {
            format!(
                "The relative squared error {value:.1e} and the mean squared distance are both too large."
            )
        }
    }
}

/// How a number of the test is called, its unit (may be empty) and what it means.
pub fn quantity(quantity: TestQuantity) -> (&'static str, &'static str, &'static str) {
    const SPACINGS: &str = "mean spacings";
    match quantity {
        TestQuantity::ErrorBefore => (
            "Error before",
            SPACINGS,
            "Mean two-way distance between the point cloud and the primitives as they are",
        ),
        TestQuantity::ErrorAfter => {
            ("Error after", SPACINGS, "The same with one primitive in place of the two")
        }
        TestQuantity::CostSaved => {
            ("Cost saved", SPACINGS, "The error that one more primitive must save to be worthwhile")
        }
        TestQuantity::Gain => (
            "Gain",
            SPACINGS,
            "Error before plus cost saved, minus error after. The merge is recommended above 0",
        ),
        TestQuantity::BoxFill => (
            "Box fill",
            "",
            "Volume of the two parts' bounding boxes, relative to the box around both. At least 0.7 is required",
        ),
        TestQuantity::VolumeFill => (
            "Volume fill",
            "",
            "Volume of the two primitives, relative to the union's. At least 0.7 is required",
        ),
        TestQuantity::RelativeError => (
            "Relative error²",
            "",
            "Mean of (r/|q|)², the radial error relative to the distance from the centre. Good below 0.005, or \
             if no larger than the worse of the two alone",
        ),
        TestQuantity::MeanSquare => (
            "Mean d²",
            "normalised²",
            "Mean squared radial distance. Good below the limit (0.001 in the first merge pass, 0.01 later), or \
             if smaller than the worse of the two alone",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_whole_sentences_also_those_of_earlier_files() {
        let old: MergeReason = serde_json::from_str("\"it fits\"").unwrap();
        assert_eq!(sentence(&old), "It fits.");
        for gain in [0.01234, -0.5] {
            let reason = MergeReason::Energy { gain };
            let back: MergeReason = serde_json::from_str(&serde_json::to_string(&reason).unwrap()).unwrap();
            assert_eq!(back, reason);
            assert_eq!(reason.is_good(), gain > 0.0);
            assert_eq!(sentence(&reason).contains("lowers"), gain > 0.0);
            assert!(sentence(&reason).contains(&format!("{:.4}", gain.abs())));
        }
        let finding = PaperFinding::BoxTooEmpty;
        let reason = MergeReason::Paper { finding, value: 0.514, limit: 0.7 };
        assert!(!reason.is_good() && sentence(&reason).contains("0.51") && sentence(&reason).contains("0.7"));
    }
}
