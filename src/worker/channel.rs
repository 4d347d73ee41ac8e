//! What goes through the channels between the owner and its threads.

use crate::inference::Cancel;

use super::protocol::{Command, Event};

/// A command with the flag that stops it.
#[derive(Debug)]
pub(super) struct NumberedCommand {
    pub(super) command: Command,
    pub(super) cancel: Cancel,
    pub(super) epoch: u64,
    /// The number of questions up to this order.
    pub(super) asked: u64,
}

/// An event with the number of what it tells of: an activity, of the last
/// question that it answers; anything else, of its epoch.
pub(super) type NumberedEvent = (u64, Event);

/// Called after each event.
pub(super) type Wake = dyn Fn() + Send + Sync;
