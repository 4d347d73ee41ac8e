//! The curves over the timeline.

/// A value of every state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    Clusters,
    MeanError,
    LogJoint,
    Chamfer,
}

impl Curve {
    pub const ALL: [Self; 4] = [Self::Clusters, Self::MeanError, Self::LogJoint, Self::Chamfer];

    pub fn text(self) -> &'static str {
        match self {
            Self::Clusters => "Primitives K",
            Self::MeanError => "Mean error",
            Self::LogJoint => "Log joint",
            Self::Chamfer => "Chamfer-L1",
        }
    }

    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Clusters => "Number of primitives, K in the paper",
            Self::MeanError => {
                "Mean distance of the assigned samples to their primitive, in the file's units"
            }
            Self::LogJoint => {
                "Log of the joint density of points and labels given the primitives, log p(X, z | θ), in \
                 nats. The sampler tends to increase it. Comparable only between states of the same shape \
                 and samples"
            }
            Self::Chamfer => {
                "Mean of accuracy and completeness: how far apart primitives and input are, in units of the \
                 longest edge of the input's bounding box. The line is a rough estimate computed in idle \
                 time; dots are measured"
            }
        }
    }
}

/// The shown curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Curves([bool; Curve::ALL.len()]);

impl Default for Curves {
    fn default() -> Self {
        Self(Curve::ALL.map(|curve| curve != Curve::LogJoint))
    }
}

impl Curves {
    pub fn shows(self, curve: Curve) -> bool {
        self.0[curve as usize]
    }

    pub fn set(&mut self, curve: Curve, shown: bool) {
        self.0[curve as usize] = shown;
    }

    /// The shown curves, in order.
    pub fn shown(self) -> impl Iterator<Item = Curve> {
        Curve::ALL.into_iter().filter(move |&curve| self.shows(curve))
    }
}
