//! Merging by energy: which unions are fitted, and in what order. One search
//! serves the passes of a run, a merge by hand and its proposal.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::inference::control::Cancel;
use crate::inference::data::abstraction::Occurrence;
use crate::inference::data::model::Model;
use crate::inference::data::state::State;
use crate::inference::moves::configuration::{Configuration, Proposal, RoughUnion, Version, groups};
use crate::inference::moves::search::{Move, accept, versions_of, write_back};
use crate::inference::params::Params;

/// Merges neighbours while that lowers the energy.
pub(crate) fn merge_all(
    state: &mut State,
    params: &Params,
    cancel: &Cancel,
    occurrences: &mut Vec<Occurrence>,
) {
    let model = state.model.clone();
    let mut search = MergeSearch::new(&model, state, params, cancel);
    let mut reports = Vec::new();
    while let Some(Round { before, proposals }) = search.round(|_| true) {
        let merges = proposals.into_iter().map(|(list, proposal)| (Move::Merge(list), proposal)).collect();
        accept(&mut search.configuration, &mut search.versions, state, before, merges, &mut reports);
    }
    if cancel.is_requested() {
        return;
    }
    occurrences.extend(reports);
    write_back(state, &search.configuration, &search.versions, params, occurrences);
}

/// The search for merges that lower the energy. In each round those unions that
/// look best at a rough fit are fitted, each primitive in one; where no pair is
/// left, larger groups.
pub(crate) struct MergeSearch<'a> {
    pub(crate) configuration: Configuration<'a>,
    versions: Vec<Version>,
    rough_unions: RoughUnions,
}

/// The unions of a round that lower the energy: the primitives by index, and
/// the one in their place.
pub(crate) struct Round {
    /// The energy before.
    pub(crate) before: f64,
    pub(crate) proposals: Vec<(Vec<usize>, Proposal)>,
}

/// Rough unions by the revisions of the parts; `None` once there is nothing
/// more to hope for.
type RoughUnions = BTreeMap<Vec<u64>, Option<RoughUnion>>;

impl<'a> MergeSearch<'a> {
    pub(crate) fn new(model: &'a Model, state: &State, params: &'a Params, cancel: &'a Cancel) -> Self {
        let configuration = Configuration::of(model, state, params, cancel);
        Self { configuration, versions: versions_of(state), rough_unions: RoughUnions::new() }
    }

    /// The next round among the unions that are `allowed`; `None` where none is
    /// worth a fit any more, or it was cancelled.
    pub(crate) fn round(&mut self, allowed: impl Fn(&[usize]) -> bool) -> Option<Round> {
        let before = self.configuration.energy();
        let pairs = self.configuration.neighbors();
        let mut lists: Vec<Vec<usize>> = pairs.iter().map(|&(a, b)| vec![a, b]).collect();
        lists.retain(|list| allowed(list));
        let mut hopeful = self.most_hopeful(before, lists);
        if hopeful.is_empty() {
            let mut lists = groups(self.versions.len(), &pairs);
            lists.retain(|list| allowed(list));
            hopeful = self.most_hopeful(before, lists);
        }
        if hopeful.is_empty() {
            return None;
        }
        let configuration = &self.configuration;
        let proposals = hopeful
            .into_par_iter()
            .filter_map(|(list, rough)| {
                let proposal = configuration.propose_union(&list, &rough, before)?;
                Some((list, proposal))
            })
            .collect();
        (!configuration.cancel.is_requested()).then_some(Round { before, proposals })
    }

    /// The best merge of the first round that has one.
    pub(crate) fn best(&mut self, allowed: impl Fn(&[usize]) -> bool) -> Option<(Vec<usize>, Proposal)> {
        while let Some(round) = self.round(&allowed) {
            let best = round.proposals.into_iter().max_by(|x, y| x.1.gain.total_cmp(&y.1.gain));
            if best.is_some() {
                return best;
            }
        }
        None
    }

    /// Those unions that look best at a rough fit, each primitive in one at
    /// most. They are not offered again.
    fn most_hopeful(&mut self, before: f64, lists: Vec<Vec<usize>>) -> Vec<(Vec<usize>, RoughUnion)> {
        let (configuration, versions) = (&self.configuration, &self.versions);
        let key = |list: &Vec<usize>| list.iter().map(|&j| versions[j].revision).collect::<Vec<u64>>();
        let unseen: Vec<&Vec<usize>> =
            lists.iter().filter(|list| !self.rough_unions.contains_key(&key(list))).collect();
        let seen: Vec<Option<RoughUnion>> =
            unseen.par_iter().map(|list| configuration.rough_union(list, before)).collect();
        self.rough_unions.extend(unseen.into_iter().map(key).zip(seen));
        let mut hopeful: Vec<(Vec<usize>, RoughUnion)> = lists
            .into_iter()
            .filter_map(|list| self.rough_unions[&key(&list)].map(|rough| (list, rough)))
            .collect();
        hopeful.sort_by(|x, y| x.1.rise.total_cmp(&y.1.rise).then(x.0.cmp(&y.0)));
        let mut taken = vec![false; versions.len()];
        hopeful.retain(|(list, _)| {
            let is_free = list.iter().all(|&j| !taken[j]);
            if is_free {
                list.iter().for_each(|&j| taken[j] = true);
            }
            is_free
        });
        self.rough_unions.extend(hopeful.iter().map(|(list, _)| (key(list), None)));
        hopeful
    }
}
