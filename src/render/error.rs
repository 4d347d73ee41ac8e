//! What can go wrong without a window.

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum OffscreenError {
    #[error("no graphics driver was found ({0}); install one (Mesa's lavapipe needs no graphics card)")]
    NoAdapter(String),
    #[error("the graphics driver {adapter} gave no device ({reason}); try another driver")]
    NoDevice { adapter: String, reason: String },
    #[error("a picture of {width} × {height} pixels can't be drawn: its sides must be 1 to {limit}")]
    Size { width: u32, height: u32, limit: u32 },
    #[error("the picture could not be read back from the graphics driver ({0}); try a smaller one")]
    Read(String),
}
