//! What a run knows and changes: the model of the cloud, the state, and the
//! result in input units.

pub(crate) mod abstraction;
pub(crate) mod change;
pub(crate) mod known_space;
pub(crate) mod label_uncertainty;
pub(crate) mod limits;
pub(crate) mod model;
pub(crate) mod normalization;
pub(crate) mod random_streams;
pub(crate) mod restaurant;
pub(crate) mod state;
pub(crate) mod surface_distance;
