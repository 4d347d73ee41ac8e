//! The energy that moves are judged by.

pub(crate) mod energy;
pub(crate) mod energy_cache;
