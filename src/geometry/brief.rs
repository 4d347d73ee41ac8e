//! How what holds many values is told in logs: by its size and a hash, which
//! says whether two of them are the same.

use std::fmt::{self, Write as _};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Deref;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// Lists of so many are told as a whole.
const FEW: usize = 6;

/// Stands for a list: `5500 #1c6e09af`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Brief {
    len: usize,
    hash: u32,
}

impl Brief {
    pub(crate) fn of<T: Hash>(values: impl IntoIterator<Item = T>) -> Self {
        let mut hasher = DefaultHasher::new();
        let len = values.into_iter().inspect(|value| value.hash(&mut hasher)).count();
        Self { len, hash: hasher.finish() as u32 }
    }

    pub(crate) fn of_points(points: &[Point3<f64>]) -> Self {
        Self::of(points.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)))
    }

    /// Of values that have no hash of their own, but are told in full.
    pub(crate) fn of_told<T: fmt::Debug>(values: &[T]) -> Self {
        let mut told = HashWriter(DefaultHasher::new());
        for value in values {
            // The writer never fails.
            let _ = write!(told, "{value:?},");
        }
        Self { len: values.len(), hash: told.0.finish() as u32 }
    }
}

impl fmt::Debug for Brief {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} #{:08x}", self.len, self.hash)
    }
}

/// Hashes what is written.
struct HashWriter(DefaultHasher);

impl fmt::Write for HashWriter {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}

/// A list, or a text, that may be long: as itself, but told briefly.
#[derive(Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Bulk<T>(T);

impl<T> Bulk<T> {
    pub fn into_inner(self) -> T {
        self.0
    }
}

impl<T> From<T> for Bulk<T> {
    fn from(content: T) -> Self {
        Self(content)
    }
}

impl<T> FromIterator<T> for Bulk<Vec<T>> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        Self(items.into_iter().collect())
    }
}

impl<T> Deref for Bulk<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: fmt::Debug> fmt::Debug for Bulk<Vec<T>> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.len() <= FEW { self.0.fmt(f) } else { Brief::of_told(&self.0).fmt(f) }
    }
}

impl fmt::Debug for Bulk<String> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Brief::of(self.bytes()).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_told_by_size_and_hash_and_short_ones_as_they_are() {
        let told = |values: Vec<u32>| format!("{:?}", Bulk::from(values));
        assert_eq!(told(vec![1, 2]), "[1, 2]");
        let (a, b) = (told((0..5000).collect()), told((1..5001).collect()));
        assert!(a.starts_with("5000 #") && a.len() < 20 && a != b, "{a} {b}");
        assert_eq!(a, told((0..5000).collect()));
        let points = |x: f64| format!("{:?}", Brief::of_points(&vec![Point3::new(x, 0.0, 0.0); 100]));
        assert_ne!(points(0.1), points(0.2));
    }
}
