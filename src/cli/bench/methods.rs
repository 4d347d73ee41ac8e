//! The methods that can be compared: one row each.

use crate::inference::{MergeRule, Params};

/// A method by its name.
#[derive(Debug)]
pub(super) struct Method {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    /// Its parameters, before those of the command line.
    pub(super) params: fn() -> Params,
}

/// All methods, in the order of the table.
pub(super) const METHODS: &[Method] = &[
    Method { name: "default", about: "what gives the best results", params: Params::default },
    Method { name: "paper", about: "the steps of the paper and its authors' program", params: Params::paper },
    Method {
        name: "without-merge",
        about: "the paper's steps, primitives left unmerged",
        params: || Params { merge: MergeRule::None, ..Params::paper() },
    },
];

/// The method of that name.
pub(super) fn by_name(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|m| m.name == name)
}
