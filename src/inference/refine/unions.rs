//! The merge passes: which unions are fitted, and in what order.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::super::abstraction::Occurrence;
use super::super::params::Params;
use super::super::sampler::Cancel;
use super::super::state::State;
use super::layout::{Glimpse, Proposal};
use super::{Idea, Layout, Name, accept, names_of, take_over};

/// Merges neighbours while that lowers the energy. In each round those pairs
/// that look best at a first glance are fitted, each primitive once; where no
/// pair is left, larger groups.
pub(crate) fn merge_all(
    state: &mut State,
    params: &Params,
    cancel: &Cancel,
    occurrences: &mut Vec<Occurrence>,
) {
    let model = state.model.clone();
    let (mut layout, mut names) = (Layout::of(&model, state, params, cancel), names_of(state));
    let mut glimpses = Glimpses::new();
    let mut reports = Vec::new();
    loop {
        let before = layout.energy();
        let pairs = layout.neighbors();
        let lists = pairs.iter().map(|&(a, b)| vec![a, b]).collect();
        let mut hopeful = most_hopeful(&layout, &names, before, lists, &mut glimpses);
        if hopeful.is_empty() {
            hopeful = most_hopeful(&layout, &names, before, groups(names.len(), &pairs), &mut glimpses);
        }
        if hopeful.is_empty() {
            break;
        }
        let proposals: Vec<(Idea, Proposal)> = hopeful
            .into_par_iter()
            .filter_map(|(list, glimpse)| {
                let proposal = layout.propose_union(&list, &glimpse, before)?;
                Some((Idea::Merge(list), proposal))
            })
            .collect();
        if cancel.is_requested() {
            return;
        }
        accept(&mut layout, &mut names, state, before, proposals, &mut reports);
    }
    occurrences.extend(reports);
    take_over(state, &layout, &names, params, occurrences);
}

/// First looks at unions by the revisions of the parts; `None` once there is
/// nothing more to hope for.
type Glimpses = BTreeMap<Vec<u64>, Option<Glimpse>>;

/// Those unions that look best at first glance, each primitive in one at most.
/// They are not offered again.
fn most_hopeful(
    layout: &Layout<'_>,
    names: &[Name],
    before: f64,
    lists: Vec<Vec<usize>>,
    glimpses: &mut Glimpses,
) -> Vec<(Vec<usize>, Glimpse)> {
    let key = |list: &Vec<usize>| list.iter().map(|&j| names[j].revision).collect::<Vec<u64>>();
    let unseen: Vec<&Vec<usize>> = lists.iter().filter(|list| !glimpses.contains_key(&key(list))).collect();
    let seen: Vec<Option<Glimpse>> =
        unseen.par_iter().map(|list| layout.glance_at_union(list, before)).collect();
    glimpses.extend(unseen.into_iter().map(key).zip(seen));
    let mut hopeful: Vec<(Vec<usize>, Glimpse)> =
        lists.into_iter().filter_map(|list| glimpses[&key(&list)].map(|glimpse| (list, glimpse))).collect();
    hopeful.sort_by(|x, y| x.1.rise.total_cmp(&y.1.rise).then(x.0.cmp(&y.0)));
    let mut taken = vec![false; names.len()];
    hopeful.retain(|(list, _)| {
        let is_free = list.iter().all(|&j| !taken[j]);
        if is_free {
            list.iter().for_each(|&j| taken[j] = true);
        }
        is_free
    });
    glimpses.extend(hopeful.iter().map(|(list, _)| (key(list), None)));
    hopeful
}

/// Each primitive with all its neighbours, and all that are connected: of a
/// hollow body's two walls no two patches make a better one, all together do.
fn groups(count: usize, pairs: &BTreeSet<(usize, usize)>) -> Vec<Vec<usize>> {
    let mut near: Vec<BTreeSet<usize>> = (0..count).map(|j| BTreeSet::from([j])).collect();
    for &(a, b) in pairs {
        near[a].insert(b);
        near[b].insert(a);
    }
    let mut found: BTreeSet<Vec<usize>> =
        near.iter().map(|star| star.iter().copied().collect::<Vec<usize>>()).collect();
    let mut seen = vec![false; count];
    for first in 0..count {
        let mut component = Vec::new();
        let mut next = vec![first];
        while let Some(j) = next.pop() {
            if !std::mem::replace(&mut seen[j], true) {
                component.push(j);
                next.extend(&near[j]);
            }
        }
        component.sort_unstable();
        found.insert(component);
    }
    found.into_iter().filter(|list| list.len() > 2).collect()
}
