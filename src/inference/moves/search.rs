//! The end of a run. The sampler has found the parts; what remains is descent
//! on the energy (see [`crate::inference::objective::energy`]): points go to the nearest primitive,
//! primitives are fitted in both directions, and cuts, merges and removals are
//! made while they lower it. Locked primitives stay as they are and keep their
//! points; points that are nearest to them and held by no other join them at
//! last, since their surface explains these.

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::inference::control::Cancel;
use crate::inference::data::abstraction::{MergeReason, MergeReport, Occurrence};
use crate::inference::data::change::{Change, Draw, Identity, Noise, Successor};
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::State;
use crate::inference::fit::k_means::k_means;
use crate::inference::moves::configuration::{Configuration, Proposal, Version, components};
use crate::inference::moves::refit::{Refits, polish, refit};
use crate::inference::objective::energy;
use crate::inference::objective::energy::PrimitiveTerms;
use crate::inference::params::{MergeRule, Params};

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

/// A change that may be worth trying.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Move {
    Remove(usize),
    Merge(Vec<usize>),
    /// Into so many parts by k-means, with this number of the attempt.
    Cut(usize, u32, u32),
    /// Its points that are far from its surface, as a part of their own.
    Peel(usize),
}

impl Move {
    fn primitives(&self) -> &[usize] {
        match self {
            Self::Remove(j) | Self::Cut(j, ..) | Self::Peel(j) => std::slice::from_ref(j),
            Self::Merge(list) => list,
        }
    }
}

/// Refines the state until nothing lowers the energy any more, in at most
/// [`ROUNDS`] rounds. On a request to cancel the clusters are left as they are,
/// and the state is the caller's to drop.
pub(crate) fn refine(state: &mut State, params: &Params, cancel: &Cancel, occurrences: &mut Vec<Occurrence>) {
    if state.clusters.is_empty() {
        return;
    }
    let model = state.model.clone();
    let (mut configuration, mut versions) =
        (Configuration::of(&model, state, params, cancel), versions_of(state));
    configuration.assign();
    let mut tried = BTreeSet::new();
    let mut refits = Refits::default();
    let mut reports = Vec::new();
    for round in 0..ROUNDS {
        let before = refit(&mut configuration, &mut versions, state, &mut refits);
        if round + 1 == ROUNDS || cancel.is_requested() {
            break;
        }
        let moves = new_moves(&configuration, &versions, &mut tried);
        let proposals: Vec<(Move, Proposal)> = moves
            .into_par_iter()
            .filter_map(|proposed| {
                let proposal = propose(&configuration, &versions, &proposed, before)?;
                Some((proposed, proposal))
            })
            .collect();
        if !accept(&mut configuration, &mut versions, state, before, proposals, &mut reports) {
            break;
        }
        configuration.assign();
    }
    remove_empty(&mut configuration, &mut versions, &mut reports);
    polish(&mut configuration, &mut refits);
    if cancel.is_requested() {
        return;
    }
    occurrences.extend(reports);
    write_back(state, &configuration, &versions, params, occurrences);
}

pub(crate) fn versions_of(state: &State) -> Vec<Version> {
    state
        .clusters
        .iter()
        .enumerate()
        .map(|(j, c)| Version { place: Some(j), id: c.id, revision: c.revision })
        .collect()
}

/// Removes primitives that no point belongs to.
fn remove_empty(
    configuration: &mut Configuration<'_>,
    versions: &mut Vec<Version>,
    reports: &mut Vec<Occurrence>,
) {
    let kept: Vec<bool> = configuration
        .members
        .iter()
        .zip(&configuration.locked)
        .map(|(m, locked)| *locked || !m.is_empty())
        .collect();
    if kept.iter().all(|k| *k) {
        return;
    }
    let gone = versions.iter().zip(&kept).filter(|(_, k)| !**k);
    reports.extend(gone.map(|(name, _)| Occurrence::Died { id: name.id }));
    keep_marked(versions, &kept);
    keep_marked(&mut configuration.members, &kept);
    keep_marked(&mut configuration.locked, &kept);
    configuration.change_primitives(|primitives| keep_marked(primitives, &kept));
    configuration.assign();
}

/// Keeps what is marked.
fn keep_marked<T>(list: &mut Vec<T>, marks: &[bool]) {
    let mut marks = marks.iter();
    list.retain(|_| marks.next().copied().unwrap_or(true));
}

/// Changes that have not been tried of the same primitives before.
fn new_moves(
    configuration: &Configuration<'_>,
    versions: &[Version],
    tried: &mut BTreeSet<(Move, Vec<u64>)>,
) -> Vec<Move> {
    let price = configuration.price_of_one_more();
    let mut moves = Vec::new();
    for (j, own) in configuration.own_errors().into_iter().enumerate() {
        if configuration.locked[j] {
            continue;
        }
        if !configuration.is_tied(j) {
            moves.push(Move::Remove(j));
        }
        // A cut saves at most the primitive's own error.
        if own > price {
            moves.extend((0..CUTS).map(|attempt| Move::Cut(j, 2, attempt)));
            moves.push(Move::Peel(j));
        }
        // (The price falls as they get more.)
        let worth = |parts: &u32| own > 0.8 * f64::from(*parts - 1) * price;
        moves.extend(PARTS.into_iter().filter(worth).map(|parts| Move::Cut(j, parts, 0)));
    }
    let pairs = if configuration.params.merge == MergeRule::None {
        BTreeSet::new()
    } else {
        configuration.neighbors()
    };
    for &(a, b) in &pairs {
        moves.push(Move::Merge(vec![a, b]));
        // Three sectors of a disc are one, any two of them are none.
        let all_touch = |c: &usize| pairs.contains(&(a, *c)) && pairs.contains(&(b, *c));
        moves.extend(
            (b + 1..configuration.primitives().len()).filter(all_touch).map(|c| Move::Merge(vec![a, b, c])),
        );
    }
    if configuration.model.known.is_some() {
        // Faces of a body of which no two or three make a better one.
        let all = components(configuration.primitives().len(), &pairs);
        moves.extend(all.into_iter().filter(|list| list.len() > 3).map(Move::Merge));
    }
    // Indices change from round to round, revisions don't: they tell what has
    // been tried.
    moves.retain(|proposed| {
        let revisions = proposed.primitives().iter().map(|&j| versions[j].revision).collect();
        let kind = match proposed {
            Move::Remove(_) => Move::Remove(0),
            Move::Merge(_) => Move::Merge(Vec::new()),
            Move::Cut(_, parts, attempt) => Move::Cut(0, *parts, *attempt),
            Move::Peel(_) => Move::Peel(0),
        };
        // Whether a primitive can be spared depends on the others.
        matches!(proposed, Move::Remove(_)) || tried.insert((kind, revisions))
    });
    moves
}

fn propose(
    configuration: &Configuration<'_>,
    versions: &[Version],
    proposed: &Move,
    before: f64,
) -> Option<Proposal> {
    match *proposed {
        Move::Remove(j) => configuration.propose_removal(j, before),
        Move::Merge(ref list) => configuration.propose_merge(list, before),
        Move::Cut(j, parts, attempt) => {
            let points = configuration.model.gather(&configuration.members[j]);
            let which = parts << 8 | attempt;
            let mut rng = stream(configuration.params.seed, Purpose::Cut, which, versions[j].revision as u32);
            configuration.propose_cut(j, &k_means(&points, parts as usize, &mut rng), before)
        }
        Move::Peel(j) => configuration.propose_cut(j, &peel(configuration, j)?, before),
    }
}

/// Part 1 for the largest connected component of a primitive's far points, 0
/// for its others.
fn peel(configuration: &Configuration<'_>, j: usize) -> Option<Vec<u32>> {
    let points = &configuration.members[j];
    let distance = |i: u32| f64::from(configuration.primitives()[j].distances[i as usize]);
    let mut sorted: Vec<f64> = points.iter().map(|&i| distance(i)).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (times, spacings) = PEELED;
    let limit = (times * sorted.get(sorted.len() / 2)?).max(spacings * configuration.model.spacing);
    let far: Vec<u32> = points.iter().copied().filter(|&i| distance(i) > limit).collect();
    let components = configuration.model.graph.components(&far, |i| far.binary_search(&i).is_ok());
    let largest: BTreeSet<u32> = components.into_iter().next()?.into_iter().collect();
    Some(points.iter().map(|i| u32::from(largest.contains(i))).collect())
}

/// Makes the proposals that lower the energy, best first, each judged again
/// next to those made before it. Says whether there was one.
pub(crate) fn accept(
    configuration: &mut Configuration<'_>,
    versions: &mut Vec<Version>,
    state: &mut State,
    before: f64,
    mut proposals: Vec<(Move, Proposal)>,
    reports: &mut Vec<Occurrence>,
) -> bool {
    proposals.sort_by(|a, b| b.1.gain.total_cmp(&a.1.gain));
    let scale = energy::scale(configuration.model);
    let (mut removed, mut added): (Vec<usize>, Vec<PrimitiveTerms>) = (Vec::new(), Vec::new());
    let mut added_versions: Vec<Version> = Vec::new();
    let mut added_members: Vec<Vec<u32>> = Vec::new();
    let mut energy = before;
    for (proposed, proposal) in proposals {
        if proposal.removed.iter().any(|j| removed.contains(j)) {
            continue;
        }
        let (gone, come) = (removed.len(), added.len());
        removed.extend(&proposal.removed);
        added.extend(proposal.added);
        let now = configuration.energy_with(&removed, &added);
        let falls = now < energy;
        if !falls {
            removed.truncate(gone);
            added.truncate(come);
            continue;
        }
        let gain = (energy - now) / scale;
        // The largest keeps its id.
        let mut old: Vec<u32> = proposal.removed.iter().map(|&j| versions[j].id).collect();
        if let Some(k) = (0..old.len()).max_by_key(|&k| configuration.members[proposal.removed[k]].len()) {
            old.swap(0, k);
        }
        match &proposed {
            Move::Remove(_) => reports.extend(old.iter().map(|&id| Occurrence::Died { id })),
            Move::Merge(_) => reports.extend(old[1..].iter().map(|&other| {
                Occurrence::Merged(MergeReport {
                    merged: (old[0], other),
                    into: old[0],
                    reason: MergeReason::Energy { gain },
                })
            })),
            Move::Cut(..) | Move::Peel(_) => reports.push(Occurrence::Cut { id: old[0], gain }),
        }
        for k in 0..proposal.members.len() {
            let id = if k == 0 { old[0] } else { state.new_id() };
            if k > 0 {
                reports.push(Occurrence::Born { id, points: proposal.members[k].len() });
            }
            added_versions.push(Version { place: None, id, revision: state.new_revision() });
        }
        added_members.extend(proposal.members);
        energy = now;
    }
    if removed.is_empty() {
        return false;
    }
    let kept: Vec<bool> = (0..versions.len()).map(|j| !removed.contains(&j)).collect();
    keep_marked(versions, &kept);
    versions.extend(added_versions);
    keep_marked(&mut configuration.members, &kept);
    configuration.members.extend(added_members);
    keep_marked(&mut configuration.locked, &kept);
    configuration.locked.resize(versions.len(), false);
    configuration.change_primitives(|primitives| {
        keep_marked(primitives, &kept);
        primitives.extend(added);
    });
    true
}

/// Writes the configuration back. Primitives without points go; σ is drawn anew where
/// a primitive or its points have changed.
pub(crate) fn write_back(
    state: &mut State,
    configuration: &Configuration<'_>,
    versions: &[Version],
    params: &Params,
    occurrences: &mut Vec<Occurrence>,
) {
    let before = state.members();
    let mut change = Change::default();
    let mut is_unchanged = vec![false; state.clusters.len()];
    for (j, version) in versions.iter().enumerate() {
        let members = &configuration.members[j];
        if members.is_empty() && !configuration.locked[j] {
            occurrences.push(Occurrence::Died { id: version.id });
            continue;
        }
        let shape = configuration.primitives()[j].shape;
        let is_same = |k: &usize| state.clusters[*k].shape == shape && before[*k] == *members;
        if let Some(k) = version.place.filter(is_same) {
            is_unchanged[k] = true;
            continue;
        }
        let noise = if configuration.locked[j] {
            Noise::Kept
        } else {
            Noise::Conditional(Draw::Version(params.seed, Purpose::Refined, version.revision), None)
        };
        let identity = version.place.map_or(Identity::Id(version.id), Identity::Same);
        change.added.push(Successor { identity, shape, members: members.clone(), noise });
    }
    change.removed = (0..is_unchanged.len()).filter(|&k| !is_unchanged[k]).collect();
    state.apply(change);
}
