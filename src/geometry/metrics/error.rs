//! What can go wrong with a reference.

/// Why nothing can be measured against a shape.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    #[error("the reference has no faces with non-zero area; choose another mesh or a point cloud")]
    NoSurface,
    #[error("the reference has fewer than two distinct finite points; choose another cloud")]
    NoPoints,
}
