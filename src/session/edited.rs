//! Effects of edits on the rest of the session: messages and selection.

use std::sync::Arc;

use super::Session;
use super::action::Level;
use crate::geometry::cloud::grouped;
use crate::inference::Occurrence;

impl Session {
    /// Updates the selection after an edit.
    pub(super) fn follow_selection(&mut self, occurrences: &[Occurrence]) {
        for occurrence in occurrences {
            match occurrence {
                Occurrence::Merged(report) => {
                    self.replace_selected(&[report.merged.0, report.merged.1], report.into);
                }
                Occurrence::Joined { ids, into } => self.replace_selected(ids, *into),
                Occurrence::Halved { id, into } if self.selection.contains(id) => {
                    self.selection.insert(*into);
                }
                // The points are what was selected before.
                Occurrence::Created { id, .. } => {
                    self.selection = [*id].into();
                    self.selected_points = Arc::default();
                }
                _ => {}
            }
        }
    }

    fn replace_selected(&mut self, ids: &[u32], into: u32) {
        for id in ids {
            if *id != into && self.selection.remove(id) {
                self.selection.insert(into);
            }
        }
    }

    /// Adds messages about edits.
    pub(super) fn tell_edits(&mut self, occurrences: &[Occurrence]) {
        for text in occurrences.iter().filter_map(sentence) {
            self.messages.push(Level::Note, text, "");
        }
    }
}

/// The message about an edit; none for steps of the sampler or changes that are
/// immediately visible.
fn sentence(occurrence: &Occurrence) -> Option<String> {
    let points = |n: usize| if n == 1 { "1 point".to_owned() } else { format!("{} points", grouped(n)) };
    Some(match occurrence {
        Occurrence::Refitted { id } => format!("Primitive {id} refitted to its points"),
        Occurrence::Locked { id } => {
            format!("Primitive {id} locked: the sampler will not change it or its points")
        }
        Occurrence::Unlocked { id } => format!("Primitive {id} unlocked"),
        Occurrence::Joined { ids, into } => {
            let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
            let (last, first) = ids.split_last()?;
            format!("Primitives {} and {last} merged into {into}", first.join(", "))
        }
        Occurrence::Halved { id, into } => format!("Primitive {id} split into {id} and {into}"),
        Occurrence::Deleted { id, points: n } => {
            format!("Primitive {id} deleted; {} now unassigned", points(*n))
        }
        Occurrence::Created { id, points: n } => format!("Primitive {id} created from {}", points(*n)),
        Occurrence::Pinned { id, points: n } => format!("{} pinned to primitive {id}", points(*n)),
        Occurrence::Released { points: n } => format!("{} unpinned", points(*n)),
        Occurrence::Taken { primitives: n } => {
            format!("{n} {} imported", if *n == 1 { "primitive" } else { "primitives" })
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_told_in_words() {
        let told = |occurrence: Occurrence| sentence(&occurrence).unwrap_or_default();
        assert_eq!(told(Occurrence::Created { id: 17, points: 41 }), "Primitive 17 created from 41 points");
        assert_eq!(
            told(Occurrence::Joined { ids: vec![3, 5, 9], into: 5 }),
            "Primitives 3, 5 and 9 merged into 5"
        );
        assert_eq!(
            told(Occurrence::Deleted { id: 2, points: 1200 }),
            "Primitive 2 deleted; 1,200 points now unassigned"
        );
        assert_eq!(told(Occurrence::Died { id: 3 }), "");
    }
}
