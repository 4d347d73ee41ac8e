//! Light or dark.

use crate::render::SceneTheme;

/// Colours of what is not data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theme {
    #[default]
    Dark,
    Light,
}

impl Theme {
    pub(super) fn scene(self) -> SceneTheme {
        match self {
            Self::Dark => SceneTheme::dark(),
            Self::Light => SceneTheme::light(),
        }
    }

    /// Of text, and of what goes with it.
    pub(super) fn ink(self) -> [u8; 3] {
        match self {
            Self::Dark => [222, 227, 234],
            Self::Light => [32, 38, 46],
        }
    }

    /// Of text that is less important.
    pub(super) fn weak(self) -> [u8; 3] {
        match self {
            Self::Dark => [148, 156, 168],
            Self::Light => [94, 102, 114],
        }
    }

    /// Of text about what went wrong.
    pub(super) fn error(self) -> [u8; 3] {
        match self {
            Self::Dark => [240, 108, 96],
            Self::Light => [190, 44, 36],
        }
    }
}
