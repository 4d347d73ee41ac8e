//! What can go wrong with a reference.

/// Why nothing can be measured against a shape.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    #[error("the reference has no face with an area; choose another mesh or its cloud")]
    NoSurface,
    #[error("the reference has no two distinct finite points; choose another cloud")]
    NoPoints,
}
