//! The end of a run. The sampler has found the parts; what remains is descent
//! on the energy (see [`super::energy`]): points go to the nearest primitive,
//! primitives are fitted in both directions, and cuts, merges and removals are
//! made while they lower it. Locked primitives stay as they are and keep their
//! points; points that are nearest to them and held by no other join them at
//! last, since their surface explains these.

mod layout;
mod refits;
mod unions;

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::abstraction::{MergeReport, Occurrence, UNASSIGNED};
use super::energy::{self, Piece};
use super::fit::sum_squared_radial;
use super::kmeans::kmeans;
use super::params::{MergeRule, Params};
use super::sampler::Cancel;
use super::state::{Cluster, State};
use super::streams::{Purpose, stream};
pub(crate) use layout::Layout;
use layout::Proposal;
use refits::{Refits, polish, refit};
pub(crate) use unions::merge_all;

/// Rounds of fits and changes at most.
const ROUNDS: usize = 8;
/// Random cuts in two that are tried of each primitive.
const CUTS: u32 = 2;
/// Cuts into more parts, for primitives that span a ring or a frame: no cut in
/// two makes those better.
const PARTS: [u32; 4] = [3, 4, 6, 8];
/// A point this many times as far as the median of its primitive's, and this
/// many mean spacings, may belong to a part of its own.
const PEELED: (f64, f64) = (2.0, 0.5);
/// A fit that gains less than this share of the price of a primitive does not
/// make changes worth trying again.
const NOTABLE: f64 = 0.05;

/// A change that may be worth trying.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Idea {
    Remove(usize),
    Merge(Vec<usize>),
    /// Into so many parts by k-means, with this number of the attempt.
    Cut(usize, u32, u32),
    /// Its points that are far from its surface, as a part of their own.
    Peel(usize),
}

impl Idea {
    fn pieces(&self) -> &[usize] {
        match self {
            Self::Remove(j) | Self::Cut(j, ..) | Self::Peel(j) => std::slice::from_ref(j),
            Self::Merge(list) => list,
        }
    }
}

/// Identity of a piece, parallel to the layout's.
#[derive(Debug, Clone, Copy)]
struct Name {
    id: u32,
    revision: u64,
}

/// Refines the state until nothing lowers the energy any more, in at most
/// [`ROUNDS`] rounds. On a request to cancel the clusters are left as they are,
/// and the state is the caller's to drop.
pub(crate) fn refine(state: &mut State, params: &Params, cancel: &Cancel, occurrences: &mut Vec<Occurrence>) {
    if state.clusters.is_empty() {
        return;
    }
    let model = state.model.clone();
    let (mut layout, mut names) = (Layout::of(&model, state, params, cancel), names_of(state));
    layout.assign();
    let mut tried = BTreeSet::new();
    let mut refits = Refits::default();
    let mut reports = Vec::new();
    for round in 0..ROUNDS {
        let before = refit(&mut layout, &mut names, state, &mut refits);
        if round + 1 == ROUNDS || cancel.is_requested() {
            break;
        }
        let ideas = new_ideas(&layout, &names, &mut tried);
        let proposals: Vec<(Idea, Proposal)> = ideas
            .into_par_iter()
            .filter_map(|idea| {
                let proposal = propose(&layout, &names, &idea, before)?;
                Some((idea, proposal))
            })
            .collect();
        if !accept(&mut layout, &mut names, state, before, proposals, &mut reports) {
            break;
        }
        layout.assign();
    }
    spare_the_empty(&mut layout, &mut names, &mut reports);
    polish(&mut layout, &mut refits);
    if cancel.is_requested() {
        return;
    }
    occurrences.extend(reports);
    take_over(state, &layout, &names, params, occurrences);
}

fn names_of(state: &State) -> Vec<Name> {
    state.clusters.iter().map(|c| Name { id: c.id, revision: c.revision }).collect()
}

/// Removes primitives that no point belongs to.
fn spare_the_empty(layout: &mut Layout<'_>, names: &mut Vec<Name>, reports: &mut Vec<Occurrence>) {
    let kept: Vec<bool> =
        layout.members.iter().zip(&layout.locked).map(|(m, locked)| *locked || !m.is_empty()).collect();
    if kept.iter().all(|k| *k) {
        return;
    }
    let gone = names.iter().zip(&kept).filter(|(_, k)| !**k);
    reports.extend(gone.map(|(name, _)| Occurrence::Died { id: name.id }));
    keep_marked(names, &kept);
    keep_marked(&mut layout.members, &kept);
    keep_marked(&mut layout.locked, &kept);
    layout.change_pieces(|pieces| keep_marked(pieces, &kept));
    layout.assign();
}

/// Keeps what is marked.
fn keep_marked<T>(list: &mut Vec<T>, marks: &[bool]) {
    let mut marks = marks.iter();
    list.retain(|_| marks.next().copied().unwrap_or(true));
}

/// Changes that have not been tried of the same primitives before.
fn new_ideas(layout: &Layout<'_>, names: &[Name], tried: &mut BTreeSet<(Idea, Vec<u64>)>) -> Vec<Idea> {
    let price = layout.price_of_one_more();
    let mut ideas = Vec::new();
    for (j, own) in layout.own_errors().into_iter().enumerate() {
        if layout.locked[j] {
            continue;
        }
        if !layout.is_tied(j) {
            ideas.push(Idea::Remove(j));
        }
        // A cut saves at most the primitive's own error.
        if own > price {
            ideas.extend((0..CUTS).map(|attempt| Idea::Cut(j, 2, attempt)));
            ideas.push(Idea::Peel(j));
        }
        // (The price falls as they get more.)
        let worth = |parts: &u32| own > 0.8 * f64::from(*parts - 1) * price;
        ideas.extend(PARTS.into_iter().filter(worth).map(|parts| Idea::Cut(j, parts, 0)));
    }
    let pairs = if layout.params.merge == MergeRule::None { BTreeSet::new() } else { layout.neighbors() };
    for &(a, b) in &pairs {
        ideas.push(Idea::Merge(vec![a, b]));
        // Three sectors of a disc are one, any two of them are none.
        let all_touch = |c: &usize| pairs.contains(&(a, *c)) && pairs.contains(&(b, *c));
        ideas.extend((b + 1..layout.pieces().len()).filter(all_touch).map(|c| Idea::Merge(vec![a, b, c])));
    }
    // Indices change from round to round, revisions don't: they tell what has
    // been tried.
    ideas.retain(|idea| {
        let revisions = idea.pieces().iter().map(|&j| names[j].revision).collect();
        let kind = match idea {
            Idea::Remove(_) => Idea::Remove(0),
            Idea::Merge(_) => Idea::Merge(Vec::new()),
            Idea::Cut(_, parts, attempt) => Idea::Cut(0, *parts, *attempt),
            Idea::Peel(_) => Idea::Peel(0),
        };
        // Whether a primitive can be spared depends on the others.
        matches!(idea, Idea::Remove(_)) || tried.insert((kind, revisions))
    });
    ideas
}

fn propose(layout: &Layout<'_>, names: &[Name], idea: &Idea, before: f64) -> Option<Proposal> {
    match *idea {
        Idea::Remove(j) => layout.propose_removal(j, before),
        Idea::Merge(ref list) => layout.propose_merge(list, before),
        Idea::Cut(j, parts, attempt) => {
            let points = layout.model.gather(&layout.members[j]);
            let which = parts << 8 | attempt;
            let mut rng = stream(layout.params.seed, Purpose::Cut, which, names[j].revision as u32);
            layout.propose_cut(j, &kmeans(&points, parts as usize, &mut rng), before)
        }
        Idea::Peel(j) => layout.propose_cut(j, &peel(layout, j)?, before),
    }
}

/// Part 1 for the largest connected component of a primitive's far points, 0
/// for its others.
fn peel(layout: &Layout<'_>, j: usize) -> Option<Vec<u32>> {
    let points = &layout.members[j];
    let distance = |i: u32| f64::from(layout.pieces()[j].distances[i as usize]);
    let mut sorted: Vec<f64> = points.iter().map(|&i| distance(i)).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (times, spacings) = PEELED;
    let limit = (times * sorted.get(sorted.len() / 2)?).max(spacings * layout.model.spacing);
    let far: Vec<u32> = points.iter().copied().filter(|&i| distance(i) > limit).collect();
    let components = layout.model.graph.components(&far, |i| far.binary_search(&i).is_ok());
    let largest: BTreeSet<u32> = components.into_iter().next()?.into_iter().collect();
    Some(points.iter().map(|i| u32::from(largest.contains(i))).collect())
}

/// Makes the proposals that lower the energy, best first, each judged again
/// next to those made before it. Says whether there was one.
fn accept(
    layout: &mut Layout<'_>,
    names: &mut Vec<Name>,
    state: &mut State,
    before: f64,
    mut proposals: Vec<(Idea, Proposal)>,
    reports: &mut Vec<Occurrence>,
) -> bool {
    proposals.sort_by(|a, b| b.1.gain.total_cmp(&a.1.gain));
    let scale = energy::scale(layout.model);
    let (mut removed, mut added): (Vec<usize>, Vec<Piece>) = (Vec::new(), Vec::new());
    let mut added_names: Vec<Name> = Vec::new();
    let mut added_members: Vec<Vec<u32>> = Vec::new();
    let mut energy = before;
    for (idea, proposal) in proposals {
        if proposal.removed.iter().any(|j| removed.contains(j)) {
            continue;
        }
        let (gone, come) = (removed.len(), added.len());
        removed.extend(&proposal.removed);
        added.extend(proposal.added);
        let now = layout.energy_with(&removed, &added);
        let falls = now < energy;
        if !falls {
            removed.truncate(gone);
            added.truncate(come);
            continue;
        }
        let gain = (energy - now) / scale;
        // The largest keeps its id.
        let mut old: Vec<u32> = proposal.removed.iter().map(|&j| names[j].id).collect();
        if let Some(k) = (0..old.len()).max_by_key(|&k| layout.members[proposal.removed[k]].len()) {
            old.swap(0, k);
        }
        match &idea {
            Idea::Remove(_) => reports.extend(old.iter().map(|&id| Occurrence::Died { id })),
            Idea::Merge(_) => reports.extend(old[1..].iter().map(|&other| {
                Occurrence::Merged(MergeReport {
                    merged: (old[0], other),
                    into: old[0],
                    reason: merge_reason(gain),
                })
            })),
            Idea::Cut(..) | Idea::Peel(_) => reports.push(Occurrence::Cut { id: old[0], gain }),
        }
        for k in 0..proposal.members.len() {
            let id = if k == 0 { old[0] } else { state.new_id() };
            if k > 0 {
                reports.push(Occurrence::Born { id, points: proposal.members[k].len() });
            }
            added_names.push(Name { id, revision: state.new_revision() });
        }
        added_members.extend(proposal.members);
        energy = now;
    }
    if removed.is_empty() {
        return false;
    }
    let kept: Vec<bool> = (0..names.len()).map(|j| !removed.contains(&j)).collect();
    keep_marked(names, &kept);
    names.extend(added_names);
    keep_marked(&mut layout.members, &kept);
    layout.members.extend(added_members);
    keep_marked(&mut layout.locked, &kept);
    layout.locked.resize(names.len(), false);
    layout.change_pieces(|pieces| {
        keep_marked(pieces, &kept);
        pieces.extend(added);
    });
    true
}

/// Why a merge is made, for people: what it saves in all.
pub(crate) fn merge_reason(gain: f64) -> String {
    format!("one primitive in their place saves {gain:.4} mean spacings of error, its price counted")
}

/// Writes the layout back. Primitives without points go; σ is drawn anew where
/// a primitive or its points have changed.
fn take_over(
    state: &mut State,
    layout: &Layout<'_>,
    names: &[Name],
    params: &Params,
    occurrences: &mut Vec<Occurrence>,
) {
    let old = std::mem::take(&mut state.clusters);
    let labels = std::mem::replace(&mut state.labels, vec![UNASSIGNED; layout.model.points.len()]);
    let mut sizes = vec![0; old.len()];
    for &l in labels.iter().filter(|l| **l != UNASSIGNED) {
        sizes[l as usize] += 1;
    }
    for (j, name) in names.iter().enumerate() {
        let points = &layout.members[j];
        if points.is_empty() && !layout.locked[j] {
            occurrences.push(Occurrence::Died { id: name.id });
            continue;
        }
        let shape = layout.pieces()[j].shape;
        for &i in points {
            state.labels[i as usize] = state.clusters.len() as u32;
        }
        let before = old.iter().position(|c| c.id == name.id);
        let same = before.filter(|&k| {
            old[k].shape == shape
                && sizes[k] == points.len()
                && points.iter().all(|&i| labels[i as usize] == k as u32)
        });
        let cluster = match (same, before) {
            (Some(k), _) => old[k].clone(),
            // Points have come to it.
            (None, Some(k)) if old[k].locked => Cluster { revision: state.new_revision(), ..old[k].clone() },
            _ => {
                for &i in points {
                    state.frozen[i as usize] = false;
                }
                let sum_d2 = sum_squared_radial(&shape, &layout.model.gather(points));
                let mut rng = stream(params.seed, Purpose::Refined, state.iteration, name.revision as u32);
                let sigma = layout.model.draw_sigma(sum_d2, points.len(), &mut rng);
                Cluster { id: name.id, revision: state.new_revision(), shape, sigma, locked: false }
            }
        };
        state.clusters.push(cluster);
    }
}
