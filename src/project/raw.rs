//! Long arrays as plain little-endian bytes, which are written and read as
//! fast as they are copied.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use nalgebra::Point3;
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// An element of a fixed size.
pub(super) trait Element: Clone {
    const SIZE: usize;
    fn put(&self, out: &mut Vec<u8>);
    /// From exactly `SIZE` bytes.
    fn get(bytes: &[u8]) -> Self;
}

impl Element for u8 {
    const SIZE: usize = 1;
    fn put(&self, out: &mut Vec<u8>) {
        out.push(*self);
    }
    fn get(bytes: &[u8]) -> Self {
        bytes[0]
    }
}

impl Element for u32 {
    const SIZE: usize = 4;
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> Self {
        Self::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
    }
}

impl Element for f32 {
    const SIZE: usize = 4;
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> Self {
        Self::from_bits(u32::get(bytes))
    }
}

impl Element for i64 {
    const SIZE: usize = 8;
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> Self {
        f64::get(bytes).to_bits() as Self
    }
}

impl Element for f64 {
    const SIZE: usize = 8;
    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }
    fn get(bytes: &[u8]) -> Self {
        let mut eight = [0; 8];
        eight.copy_from_slice(bytes);
        Self::from_le_bytes(eight)
    }
}

impl<T: Element> Element for [T; 3] {
    const SIZE: usize = 3 * T::SIZE;
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|part| part.put(out));
    }
    fn get(bytes: &[u8]) -> Self {
        [0, 1, 2].map(|i| T::get(&bytes[i * T::SIZE..(i + 1) * T::SIZE]))
    }
}

impl Element for Point3<f64> {
    const SIZE: usize = 24;
    fn put(&self, out: &mut Vec<u8>) {
        self.coords.iter().for_each(|c| c.put(out));
    }
    fn get(bytes: &[u8]) -> Self {
        Self::from(<[f64; 3]>::get(bytes))
    }
}

/// An array that is borrowed to be written, and owned once it was read.
#[derive(Debug, Clone)]
pub(super) struct Raw<'a, T: Element>(pub(super) Cow<'a, [T]>);

impl<'a, T: Element> Raw<'a, T> {
    pub(super) fn of(values: &'a [T]) -> Self {
        Self(Cow::Borrowed(values))
    }

    pub(super) fn into_vec(self) -> Vec<T> {
        self.0.into_owned()
    }
}

impl<T: Element> Serialize for Raw<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut bytes = Vec::with_capacity(self.0.len() * T::SIZE);
        self.0.iter().for_each(|value| value.put(&mut bytes));
        serializer.serialize_bytes(&bytes)
    }
}

impl<'de, T: Element> Deserialize<'de> for Raw<'_, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_bytes(Bytes(PhantomData)).map(|values| Self(Cow::Owned(values)))
    }
}

struct Bytes<T>(PhantomData<T>);

impl<T: Element> Visitor<'_> for Bytes<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "elements of {} bytes each", T::SIZE)
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<T>, E> {
        if bytes.len().is_multiple_of(T::SIZE) {
            Ok(bytes.chunks_exact(T::SIZE).map(T::get).collect())
        } else {
            Err(E::invalid_length(bytes.len(), &self))
        }
    }
}
