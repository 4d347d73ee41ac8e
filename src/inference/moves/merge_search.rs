//! The merge passes: which unions are fitted, and in what order.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use crate::inference::control::Cancel;
use crate::inference::data::abstraction::Occurrence;
use crate::inference::data::state::State;
use crate::inference::moves::configuration::{Configuration, Proposal, RoughUnion, Version};
use crate::inference::moves::search::{Move, accept, versions_of, write_back};
use crate::inference::params::Params;

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
    let (mut configuration, mut versions) =
        (Configuration::of(&model, state, params, cancel), versions_of(state));
    let mut rough_unions = RoughUnions::new();
    let mut reports = Vec::new();
    loop {
        let before = configuration.energy();
        let pairs = configuration.neighbors();
        let lists = pairs.iter().map(|&(a, b)| vec![a, b]).collect();
        let mut hopeful = most_hopeful(&configuration, &versions, before, lists, &mut rough_unions);
        if hopeful.is_empty() {
            hopeful = most_hopeful(
                &configuration,
                &versions,
                before,
                groups(versions.len(), &pairs),
                &mut rough_unions,
            );
        }
        if hopeful.is_empty() {
            break;
        }
        let proposals: Vec<(Move, Proposal)> = hopeful
            .into_par_iter()
            .filter_map(|(list, rough)| {
                let proposal = configuration.propose_union(&list, &rough, before)?;
                Some((Move::Merge(list), proposal))
            })
            .collect();
        if cancel.is_requested() {
            return;
        }
        accept(&mut configuration, &mut versions, state, before, proposals, &mut reports);
    }
    occurrences.extend(reports);
    write_back(state, &configuration, &versions, params, occurrences);
}

/// First looks at unions by the revisions of the parts; `None` once there is
/// nothing more to hope for.
type RoughUnions = BTreeMap<Vec<u64>, Option<RoughUnion>>;

/// Those unions that look best at first glance, each primitive in one at most.
/// They are not offered again.
fn most_hopeful(
    configuration: &Configuration<'_>,
    versions: &[Version],
    before: f64,
    lists: Vec<Vec<usize>>,
    rough_unions: &mut RoughUnions,
) -> Vec<(Vec<usize>, RoughUnion)> {
    let key = |list: &Vec<usize>| list.iter().map(|&j| versions[j].revision).collect::<Vec<u64>>();
    let unseen: Vec<&Vec<usize>> =
        lists.iter().filter(|list| !rough_unions.contains_key(&key(list))).collect();
    let seen: Vec<Option<RoughUnion>> =
        unseen.par_iter().map(|list| configuration.rough_union(list, before)).collect();
    rough_unions.extend(unseen.into_iter().map(key).zip(seen));
    let mut hopeful: Vec<(Vec<usize>, RoughUnion)> =
        lists.into_iter().filter_map(|list| rough_unions[&key(&list)].map(|rough| (list, rough))).collect();
    hopeful.sort_by(|x, y| x.1.rise.total_cmp(&y.1.rise).then(x.0.cmp(&y.0)));
    let mut taken = vec![false; versions.len()];
    hopeful.retain(|(list, _)| {
        let is_free = list.iter().all(|&j| !taken[j]);
        if is_free {
            list.iter().for_each(|&j| taken[j] = true);
        }
        is_free
    });
    rough_unions.extend(hopeful.iter().map(|(list, _)| (key(list), None)));
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
