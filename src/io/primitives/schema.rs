//! Names by which files of primitives say what they hold.

/// Name and version of the JSON format, as they stand in the file.
pub(in crate::io) const FORMAT: &str = "superform-primitives";
pub(super) const VERSION: u32 = 1;

/// Names of the columns. Rz(yaw)·Ry(pitch)·Rx(roll) takes local to world.
pub(in crate::io) const COLUMNS: [&str; 13] =
    ["e1", "e2", "ax", "ay", "az", "yaw", "pitch", "roll", "tx", "ty", "tz", "kx", "ky"];

/// Names of the arrays in an NPZ file, each with an entry a primitive where it says
/// no more.
pub(in crate::io) mod arrays {
    /// Of the shapes.
    pub(in crate::io) const NAMES: &str = "names";
    /// The points that the primitives were made from.
    pub(in crate::io) const CLOUD: &str = "pc";
    /// For each point how much it belongs to each primitive.
    pub(in crate::io) const ASSIGNMENT: &str = "assign_matrix";
    pub(in crate::io) const SCALE: &str = "scale";
    pub(in crate::io) const ROTATION: &str = "rotation";
    pub(in crate::io) const TRANSLATION: &str = "translation";
    pub(in crate::io) const EXPONENTS: &str = "exponents";
    pub(in crate::io) const EXIST: &str = "exist";
    pub(in crate::io) const TAPERING: &str = "tapering";
    pub(in crate::io) const SIGMA: &str = "sigma";
    pub(in crate::io) const MEAN_DISTANCE: &str = "mean_distance";
    pub(in crate::io) const IDS: &str = "ids";
    pub(in crate::io) const POINTS: &str = "points";
}
