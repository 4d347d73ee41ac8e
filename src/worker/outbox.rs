//! Messages on their way to a thread that may be busy.

use std::collections::VecDeque;
use std::sync::mpsc::{SyncSender, TrySendError};

/// A bounded channel whose sender never blocks: what the channel has no room
/// for waits here, in order.
#[derive(Debug)]
pub(crate) struct Outbox<T> {
    /// `None` once the channel is closed.
    channel: Option<SyncSender<T>>,
    waiting: VecDeque<T>,
}

impl<T> Outbox<T> {
    pub(crate) fn new(channel: SyncSender<T>) -> Self {
        Self { channel: Some(channel), waiting: VecDeque::new() }
    }

    /// Adds a message that goes out at the next [`Outbox::flush`].
    pub(crate) fn push(&mut self, message: T) {
        self.waiting.push_back(message);
    }

    /// The messages that wait for room, oldest first.
    pub(crate) fn waiting(&mut self) -> &mut VecDeque<T> {
        &mut self.waiting
    }

    /// Sends what there is room for. Answers whether somebody is there to
    /// receive it; otherwise what waited is dropped.
    pub(crate) fn flush(&mut self) -> bool {
        let Some(channel) = &self.channel else { return true };
        while let Some(message) = self.waiting.pop_front() {
            match channel.try_send(message) {
                Ok(()) => {}
                Err(TrySendError::Full(message)) => {
                    self.waiting.push_front(message);
                    return true;
                }
                Err(TrySendError::Disconnected(_)) => {
                    self.waiting.clear();
                    return false;
                }
            }
        }
        true
    }

    /// Closes the channel: who receives gets what was sent, and then the end.
    pub(crate) fn close(&mut self) {
        self.channel = None;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use super::*;

    #[test]
    fn what_finds_no_room_waits_in_order() {
        let (sender, receiver) = sync_channel(2);
        let mut outbox = Outbox::new(sender);
        (0..5).for_each(|i| outbox.push(i));
        assert!(outbox.flush());
        assert_eq!(receiver.try_iter().collect::<Vec<_>>(), [0, 1]);
        assert!(outbox.flush());
        outbox.close();
        assert_eq!(receiver.iter().collect::<Vec<_>>(), [2, 3]);
        assert_eq!(*outbox.waiting(), [4]);
    }

    #[test]
    fn without_a_receiver_nothing_waits() {
        let (sender, receiver) = sync_channel(1);
        let mut outbox = Outbox::new(sender);
        drop(receiver);
        outbox.push(1);
        assert!(!outbox.flush() && outbox.waiting().is_empty());
    }
}
