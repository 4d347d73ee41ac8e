//! Which values a file holds already, so that each is written once.

use std::any::Any;
use std::collections::HashMap;
use std::io::{self, Write};
use std::sync::{Arc, Weak};

use super::container::{Kind, write_record};

/// Keeps the place of a shared value from being used again, but not the value.
type Pin = Weak<dyn Any + Send + Sync>;

/// A record that was written.
#[derive(Debug)]
struct Slot {
    bytes: u64,
    /// Numbers of the records that it refers to.
    refers: Vec<u32>,
    /// The last round in which it belonged to the session.
    round: u32,
}

/// The records of one file.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    slots: Vec<Slot>,
    round: u32,
    /// By the place of the value in memory.
    shared: HashMap<usize, (u32, Pin)>,
    /// By the content of the record.
    small: HashMap<(Kind, Vec<u8>), u32>,
    /// Bytes of the records that belong to the session, and of all.
    pub(super) reachable: u64,
    pub(super) written: u64,
}

impl Ledger {
    /// The record of a shared value, where it has one.
    pub(super) fn find<T>(&self, value: &Arc<T>) -> Option<u32> {
        self.shared.get(&Arc::as_ptr(value).addr()).map(|(number, _)| *number)
    }

    /// Notes which record is that of the value.
    pub(super) fn note<T: Any + Send + Sync>(&mut self, value: &Arc<T>, number: u32) {
        let place = Arc::as_ptr(value).addr();
        let value: Arc<dyn Any + Send + Sync> = Arc::<T>::clone(value);
        self.shared.insert(place, (number, Arc::downgrade(&value)));
    }

    /// Writes a record; its number.
    pub(super) fn write(
        &mut self,
        out: &mut dyn Write,
        kind: Kind,
        content: &[u8],
        refers: Vec<u32>,
    ) -> io::Result<u32> {
        let number = u32::try_from(self.slots.len()).map_err(io::Error::other)?;
        let bytes = write_record(out, kind, content)?;
        self.written += bytes;
        self.slots.push(Slot { bytes, refers, round: self.round });
        Ok(number)
    }

    /// Writes a record, unless one of the same content is there.
    pub(super) fn write_once(
        &mut self,
        out: &mut dyn Write,
        kind: Kind,
        content: Vec<u8>,
        refers: Vec<u32>,
    ) -> io::Result<u32> {
        let key = (kind, content);
        if let Some(number) = self.small.get(&key) {
            return Ok(*number);
        }
        let number = self.write(out, kind, &key.1, refers)?;
        self.small.insert(key, number);
        Ok(number)
    }

    /// Forgets what the session, as the record `head` has it, does not need.
    pub(super) fn settle(&mut self, head: u32) {
        self.round += 1;
        self.reachable = 0;
        self.reach(head);
        let (slots, round) = (&self.slots, self.round);
        let is_needed = |number: &u32| slots.get(*number as usize).is_some_and(|slot| slot.round == round);
        self.shared.retain(|_, (number, _)| is_needed(number));
        self.small.retain(|_, number| is_needed(number));
    }

    /// References go from a head to documents, branches, states: they are not deep.
    fn reach(&mut self, number: u32) {
        let round = self.round;
        let Some(slot) = self.slots.get_mut(number as usize).filter(|slot| slot.round != round) else {
            return;
        };
        slot.round = round;
        self.reachable += slot.bytes;
        let refers = std::mem::take(&mut slot.refers);
        refers.iter().for_each(|&next| self.reach(next));
        self.slots[number as usize].refers = refers;
    }
}
