//! One pass of the Chinese Restaurant Process over all points, with births
//! and removals.

use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use rayon::prelude::*;

use crate::geometry::kernel::{self, Distance};
use crate::inference::data::abstraction::{Occurrence, UNASSIGNED};
use crate::inference::data::change::{Draw, Noise};
use crate::inference::data::model::Model;
use crate::inference::data::random_streams::{Purpose, stream};
use crate::inference::data::state::{Cluster, State};
use crate::inference::fit::moments::ellipsoid_of_moments;
use crate::inference::fit::points::START_SHRINK;
use crate::inference::params::{Params, SMALLEST_CLUSTER};

/// Points whose densities one thread works out at a time.
const ROWS: usize = 256;

/// N(d(θ, xᵢ); σ)·½ for each point from number `from` up to `to`: the
/// existing-cluster term of the paper's Gibbs step without its count. Underflow
/// to 0 far away is meant: there the new table wins.
fn density(model: &Model, cluster: &Cluster, (from, to): (usize, usize), buffers: &mut Buffers) {
    let Cluster { shape, sigma, .. } = cluster;
    let factor = 0.5 / (sigma * (2.0 * std::f64::consts::PI).sqrt());
    let Buffers { distances, densities } = buffers;
    kernel::distances_of_some(shape, &model.block, (from, to), Distance::Radial, distances);
    kernel::gaussian(distances, factor, *sigma, densities);
}

#[derive(Default)]
struct Buffers {
    distances: Vec<f32>,
    densities: Vec<f64>,
}

/// N(d; σ)·½ of all clusters, a row for each point: a draw reads one row.
struct Densities {
    rows: Vec<f64>,
    /// Clusters, and how many there is room for in a row.
    count: usize,
    room: usize,
}

impl Densities {
    fn new(model: &Model, clusters: &[Cluster]) -> Self {
        let mut new = Self { rows: Vec::new(), count: 0, room: clusters.len() + SPARE };
        new.rows.resize(model.points.len() * new.room, 0.0);
        new.add(model, clusters);
        new
    }

    fn row(&self, i: u32) -> &[f64] {
        let start = i as usize * self.room;
        &self.rows[start..start + self.count]
    }

    /// Adds clusters, for which there is room.
    fn add(&mut self, model: &Model, clusters: &[Cluster]) {
        let (count, room) = (self.count, self.room);
        self.rows.par_chunks_mut(room * ROWS).enumerate().for_each_init(
            Buffers::default,
            |buffers, (chunk, rows)| {
                let from = chunk * ROWS;
                let to = from + rows.len() / room;
                for (j, cluster) in clusters.iter().enumerate() {
                    density(model, cluster, (from, to), buffers);
                    for (row, density) in rows.chunks_mut(room).zip(&buffers.densities) {
                        row[count + j] = *density;
                    }
                }
            },
        );
        self.count += clusters.len();
    }

    /// Adds the last of all clusters.
    fn push(&mut self, model: &Model, clusters: &[Cluster]) {
        if self.count == self.room {
            *self = Self::new(model, clusters);
        } else {
            self.add(model, &clusters[self.count..]);
        }
    }
}

/// Clusters that can be born until the rows are laid out anew.
const SPARE: usize = 8;

/// The tables while points sit down one after another.
struct Tables<'a> {
    state: &'a mut State,
    density: Densities,
    count: Vec<f64>,
    weights: Vec<f64>,
}

impl<'a> Tables<'a> {
    fn new(state: &'a mut State) -> Self {
        let model = &state.model;
        let density = Densities::new(model, &state.clusters);
        let mut count = vec![0.0; state.clusters.len()];
        for &label in state.labels.iter().filter(|l| **l != UNASSIGNED) {
            count[label as usize] += 1.0;
        }
        // An empty table draws nobody.
        for (count, _) in count.iter_mut().zip(&state.clusters).filter(|(_, c)| c.locked) {
            *count = 0.0;
        }
        Self { state, density, count, weights: Vec::new() }
    }

    fn leave(&mut self, i: u32) {
        let label = std::mem::replace(&mut self.state.labels[i as usize], UNASSIGNED);
        if label != UNASSIGNED {
            self.count[label as usize] -= 1.0;
        }
    }

    fn join(&mut self, i: u32, cluster: u32) {
        self.state.labels[i as usize] = cluster;
        self.count[cluster as usize] += 1.0;
    }

    /// Draws a table for a point that has left its own: an existing one with
    /// weight n·N(d; σ)·½, a new one (`None`) with weight `new`.
    fn draw(&mut self, i: u32, new: f64, rng: &mut impl Rng) -> Option<u32> {
        self.weights.clear();
        let mut total = new;
        for (density, n) in self.density.row(i).iter().zip(&self.count) {
            let w = n * density;
            self.weights.push(w);
            total += w;
        }
        if total <= 0.0 {
            return None;
        }
        let mut u = rng.random::<f64>() * total;
        for (j, w) in (0u32..).zip(&self.weights) {
            u -= w;
            if u < 0.0 {
                return Some(j);
            }
        }
        None
    }
}

/// Points that chose a new table, joined as they come by the radius graph.
struct Waiting {
    parent: Vec<u32>,
    size: Vec<u32>,
    points: Vec<u32>,
}

impl Waiting {
    fn new(n: usize) -> Self {
        Self { parent: vec![UNASSIGNED; n], size: vec![0; n], points: Vec::new() }
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let up = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = up;
            i = up;
        }
        i
    }

    /// Adds a point; returns the size of its component.
    fn add(&mut self, i: u32, neighbors: &[u32]) -> usize {
        self.parent[i as usize] = i;
        self.size[i as usize] = 1;
        self.points.push(i);
        for &j in neighbors {
            if self.parent[j as usize] != UNASSIGNED {
                let (a, b) = (self.root(i), self.root(j));
                if a != b {
                    self.parent[b as usize] = a;
                    self.size[a as usize] += self.size[b as usize];
                }
            }
        }
        let root = self.root(i);
        self.size[root as usize] as usize
    }

    /// Empties the room: the component of `i`, and the others.
    fn take(&mut self, i: u32) -> (Vec<u32>, Vec<u32>) {
        let root = self.root(i);
        let points = std::mem::take(&mut self.points);
        let split = points.iter().copied().partition(|&p| self.root(p) == root);
        for p in points {
            self.parent[p as usize] = UNASSIGNED;
        }
        split
    }
}

/// Samples all labels: points leave and choose in random order, those that
/// choose a new table wait for company, and a connected company of more than
/// [`SMALLEST_CLUSTER`] is a birth. Whoever still waits at the end is
/// unassigned. Points that are pinned or belong to a locked cluster keep their
/// table, and no other point may join a locked one.
pub(crate) fn sweep(state: &mut State, params: &Params, occurrences: &mut Vec<Occurrence>) {
    let iteration = state.iteration;
    let mut rng = stream(params.seed, Purpose::Sweep, iteration, 0);
    let model = state.model.clone();
    let may_choose = |i: &u32| !state.frozen[*i as usize] && !state.is_held(*i);
    let mut order: Vec<u32> = (0..model.points.len() as u32).filter(may_choose).collect();
    order.shuffle(&mut rng);

    let mut waiting = Waiting::new(model.points.len());
    let mut tables = Tables::new(state);
    let mut next = 0;
    while next < order.len() {
        let i = order[next];
        next += 1;
        tables.leave(i);
        let new = (params.alpha + waiting.points.len() as f64) * params.p0;
        if let Some(j) = tables.draw(i, new, &mut rng) {
            tables.join(i, j);
            continue;
        }
        if waiting.add(i, model.graph.of(i)) <= SMALLEST_CLUSTER {
            continue;
        }
        let (company, rest) = waiting.take(i);
        order.extend(rest);
        let shape = ellipsoid_of_moments(&model.gather(&company), START_SHRINK, model.axis_floor());
        let noise = Noise::First(Draw::Cluster(params.seed, Purpose::Birth));
        let table = tables.state.open_table(shape, noise);
        tables.density.push(&model, &tables.state.clusters);
        tables.count.push(0.0);
        let id = tables.state.clusters[table].id;
        occurrences.push(Occurrence::Born { id, points: company.len() });
        for p in company {
            tables.join(p, table as u32);
        }
    }
    tidy(tables, &mut rng, occurrences);
}

/// Removes clusters whose largest connected component is too small, and lets
/// the points outside the largest component of the others choose again among
/// the clusters there are.
fn tidy(mut tables: Tables<'_>, rng: &mut impl Rng, occurrences: &mut Vec<Occurrence>) {
    let members = tables.state.members();
    let mut gone = vec![false; members.len()];
    let mut pool = Vec::new();
    for (j, points) in (0u32..).zip(&members) {
        if tables.state.clusters[j as usize].locked {
            continue;
        }
        let mut parts = tables.state.components(j, points).into_iter();
        match parts.next() {
            Some(largest) if largest.len() > SMALLEST_CLUSTER => pool.extend(parts.flatten()),
            _ if points.iter().any(|&i| tables.state.is_pinned(i)) => {}
            _ => {
                gone[j as usize] = true;
                occurrences.push(Occurrence::Died { id: tables.state.clusters[j as usize].id });
                pool.extend_from_slice(points);
            }
        }
    }
    pool.retain(|&i| {
        let state = &tables.state;
        !state.is_held(i) && (!state.frozen[i as usize] || gone[state.labels[i as usize] as usize])
    });
    for &i in &pool {
        tables.state.frozen[i as usize] = false;
        tables.leave(i);
    }
    for (j, _) in gone.iter().enumerate().filter(|g| *g.1) {
        tables.count[j] = 0.0;
    }
    for &i in &pool {
        if let Some(j) = tables.draw(i, 0.0, rng) {
            tables.join(i, j);
        }
    }
    tables.state.remove_clusters(&gone);
}
