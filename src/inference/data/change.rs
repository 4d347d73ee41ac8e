//! Changes of the clusters. Whatever a move, a merge, an edit or an import does
//! is one [`Change`], and [`State::apply`] alone writes it into the state.

use crate::geometry::Superquadric;
use crate::inference::data::abstraction::UNASSIGNED;
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::{Cluster, State};

/// Some clusters in the place of others.
#[derive(Debug, Default)]
pub(crate) struct Change {
    /// Indices of the clusters that go or are replaced; their points lose their
    /// label.
    pub(crate) removed: Vec<usize>,
    pub(crate) added: Vec<Successor>,
    /// Points that are frozen stay so, as in the authors' program, where they
    /// are frozen for ever.
    pub(crate) keeps_frozen: bool,
}

/// A cluster that a change adds.
#[derive(Debug)]
pub(crate) struct Successor {
    pub(crate) identity: Identity,
    pub(crate) shape: Superquadric,
    /// Its points: unassigned before, or of clusters that the change removes.
    pub(crate) members: Vec<u32>,
    pub(crate) noise: Noise,
}

/// Which cluster a successor is.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Identity {
    /// The removed cluster with this index: it keeps its place, id and lock.
    Same(usize),
    /// A cluster at the end of the list, with an id of which there is no other.
    Id(u32),
    /// A cluster at the end of the list, with an id that was never used.
    New,
}

/// Where σ of a cluster comes from.
#[derive(Debug)]
pub(crate) enum Noise {
    /// It stays, or is as small as can be where the cluster is new.
    Kept,
    Given(f64),
    /// Uniform in (0, 1], for a cluster without a history.
    First(Draw),
    /// From its conditional given Σ d² of the points, which is computed where
    /// it is not known.
    Conditional(Draw, Option<f64>),
}

/// The random stream of a draw: of a seed and a purpose, at the state's
/// iteration, and for the cluster.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Draw {
    /// By its id.
    Cluster(u64, Purpose),
    /// By the cluster's new revision.
    Revision(u64, Purpose),
    /// By a revision that it had in a configuration.
    Version(u64, Purpose, u64),
}

impl State {
    /// Makes a change and returns the ids of the clusters that it adds.
    pub(crate) fn apply(&mut self, change: Change) -> Vec<u32> {
        let mut gone = vec![false; self.clusters.len()];
        for &j in &change.removed {
            gone[j] = true;
        }
        for (label, frozen) in self.labels.iter_mut().zip(&mut self.frozen) {
            if *label != UNASSIGNED && gone[*label as usize] {
                (*label, *frozen) = (UNASSIGNED, *frozen && change.keeps_frozen);
            }
        }
        let mut ids = Vec::with_capacity(change.added.len());
        for Successor { identity, shape, members, noise } in change.added {
            let j = match identity {
                Identity::Same(j) => {
                    gone[j] = false;
                    j
                }
                Identity::Id(id) => {
                    self.next_id = self.next_id.max(id + 1);
                    self.push(id, shape)
                }
                Identity::New => {
                    let id = self.new_id();
                    self.push(id, shape)
                }
            };
            for &i in &members {
                debug_assert_eq!(
                    self.labels[i as usize], UNASSIGNED,
                    "point {i} belongs to a cluster that stays"
                );
                self.labels[i as usize] = j as u32;
                self.frozen[i as usize] &= change.keeps_frozen;
            }
            self.renew(j, shape, noise, &members);
            ids.push(self.clusters[j].id);
        }
        gone.resize(self.clusters.len(), false);
        self.remove_clusters(&gone);
        ids
    }

    /// Adds a cluster whose revision and σ are still to come.
    fn push(&mut self, id: u32, shape: Superquadric) -> usize {
        let sigma = self.model.sigma_floor();
        self.clusters.push(Cluster { id, revision: 0, shape, sigma, locked: false });
        self.clusters.len() - 1
    }

    /// Adds a cluster without points.
    pub(crate) fn open_table(&mut self, shape: Superquadric, noise: Noise) -> usize {
        let id = self.new_id();
        let j = self.push(id, shape);
        self.renew(j, shape, noise, &[]);
        j
    }

    /// Gives a cluster a shape, a new revision and σ.
    pub(crate) fn renew(&mut self, j: usize, shape: Superquadric, noise: Noise, members: &[u32]) {
        let revision = self.new_revision();
        let (iteration, id) = (self.iteration, self.clusters[j].id);
        let rng = |draw| match draw {
            Draw::Cluster(seed, purpose) => stream(seed, purpose, iteration, id),
            Draw::Revision(seed, purpose) => stream(seed, purpose, iteration, revision as u32),
            Draw::Version(seed, purpose, version) => stream(seed, purpose, iteration, version as u32),
        };
        let sigma = match noise {
            Noise::Kept => self.clusters[j].sigma,
            Noise::Given(sigma) => sigma,
            Noise::First(draw) => self.model.draw_first_sigma(&mut rng(draw)),
            Noise::Conditional(draw, sum_d2) => {
                let sum_d2 = sum_d2.unwrap_or_else(|| self.model.sum_d2(&shape, members));
                self.model.draw_sigma(sum_d2, members.len(), &mut rng(draw))
            }
        };
        let cluster = &mut self.clusters[j];
        (cluster.shape, cluster.sigma, cluster.revision) = (shape, sigma, revision);
    }
}
