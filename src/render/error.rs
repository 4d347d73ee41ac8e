//! What can go wrong without a window.

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum OffscreenError {
    #[error("no graphics driver found ({0}); install one (Mesa's lavapipe works without a graphics card)")]
    NoAdapter(String),
    #[error("cannot open a device with the graphics driver {adapter} ({reason}); try another driver")]
    NoDevice { adapter: String, reason: String },
    #[error(
        "cannot render a picture of {width} × {height} pixels: width and height must be between 1 and {limit}"
    )]
    Size { width: u32, height: u32, limit: u32 },
    #[error("cannot read the picture back from the graphics driver ({0}); try a smaller size")]
    Read(String),
}
