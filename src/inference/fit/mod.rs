//! Fits of one primitive to points.

pub(crate) mod area;
pub(crate) mod k_means;
pub(crate) mod levenberg_marquardt;
pub(crate) mod moments;
pub(crate) mod points;
pub(crate) mod symmetric;
