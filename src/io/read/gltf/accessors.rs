//! Accessors of a glTF file, with every range checked.

use std::borrow::Cow;
use std::path::Path;

use super::schema::{Accessor, Root, entry};
use super::{buffers, extensions};
use crate::io::error::Fault;
use crate::io::read::text::shortened;

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Result<Self, Fault> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => {
                return Err(Fault::whole(format!("unknown number type {other}")));
            }
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number in the first bytes, of which there are enough.
    fn value(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Self::I8, [a, ..]) => f64::from(i8::from_le_bytes([*a])),
            (Self::U8, [a, ..]) => f64::from(*a),
            (Self::I16, [a, b, ..]) => f64::from(i16::from_le_bytes([*a, *b])),
            (Self::U16, [a, b, ..]) => f64::from(u16::from_le_bytes([*a, *b])),
            (Self::U32, [a, b, c, d, ..]) => f64::from(u32::from_le_bytes([*a, *b, *c, *d])),
            (Self::F32, [a, b, c, d, ..]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            _ => f64::NAN,
        }
    }

    /// What 1 is stored as, where integers stand for −1 to 1.
    fn one(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32767.0,
            Self::U16 => 65535.0,
            Self::U32 => f64::from(u32::MAX),
            Self::F32 => 1.0,
        }
    }
}

/// The buffers of a file, and the way to the numbers in them.
pub(super) struct Data<'a> {
    root: &'a Root,
    /// Those that can't be had matter only where they are needed.
    buffers: Vec<Result<Cow<'a, [u8]>, Fault>>,
}

/// Layout of the numbers.
struct Place {
    view: usize,
    offset: usize,
    count: usize,
    component: Component,
    /// Numbers an element.
    width: usize,
}

impl<'a> Data<'a> {
    pub(super) fn new(root: &'a Root, blob: Option<&'a [u8]>, folder: Option<&Path>) -> Self {
        let buffers =
            root.buffers.iter().enumerate().map(|(i, buffer)| buffers::load(i, buffer, blob, folder));
        Self { root, buffers: buffers.collect() }
    }

    /// Whether all buffers could be had.
    pub(super) fn check(&self) -> Result<(), Fault> {
        self.buffers.iter().try_for_each(|buffer| buffer.as_ref().map(drop).map_err(Clone::clone))
    }

    /// Bytes of all buffers.
    pub(super) fn bytes(&self) -> usize {
        self.buffers.iter().flatten().map(|b| b.len()).sum()
    }

    /// Vectors of at least `N` numbers: the first of them.
    pub(super) fn vectors<const N: usize>(&self, accessor: usize) -> Result<Vec<[f64; N]>, Fault> {
        let about = entry(&self.root.accessors, accessor, "accessor")?;
        let width = match about.kind.as_str() {
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 0,
        };
        if width < N {
            let other = shortened(&about.kind, 24);
            let problem = format!("accessor {accessor} contains {other} instead of VEC{N}");
            return Err(Fault::whole(problem));
        }
        self.numbers(accessor, about, width)
    }

    /// Colours from 0 to 1. Whole numbers stand for that, though some files
    /// don't say so.
    pub(super) fn colors(&self, accessor: usize) -> Result<Vec<[f64; 3]>, Fault> {
        let mut colors = self.vectors(accessor)?;
        let about = entry(&self.root.accessors, accessor, "accessor")?;
        if !about.normalized {
            let one = Component::of(about.component_type)?.one();
            colors.iter_mut().flatten().for_each(|v| *v /= one);
        }
        Ok(colors)
    }

    /// Indices of vertices.
    pub(super) fn indices(&self, accessor: usize) -> Result<Vec<usize>, Fault> {
        let about = entry(&self.root.accessors, accessor, "accessor")?;
        if about.kind != "SCALAR" || about.component_type == 5126 {
            let problem = format!("accessor {accessor} should contain indices, but does not");
            return Err(Fault::whole(problem));
        }
        let numbers: Vec<[f64; 1]> = self.numbers(accessor, about, 1)?;
        // What is below 0 is no vertex.
        Ok(numbers.into_iter().map(|[i]| if i < 0.0 { usize::MAX } else { i as usize }).collect())
    }

    /// The first `N` numbers of every element, of which each has `width`.
    fn numbers<const N: usize>(
        &self,
        index: usize,
        about: &Accessor,
        width: usize,
    ) -> Result<Vec<[f64; N]>, Fault> {
        let component = Component::of(about.component_type)?;
        let mut numbers = match about.buffer_view {
            Some(view) => {
                self.dense(&Place { view, offset: about.byte_offset, count: about.count, component, width })?
            }
            None => {
                // A file could ask for any number of zeros.
                if about.count > self.bytes() {
                    let count = about.count;
                    let problem = format!("accessor {index} declares {count} elements that are missing");
                    return Err(Fault::whole(problem));
                }
                vec![[0.0; N]; about.count]
            }
        };
        if let Some(sparse) = &about.sparse {
            let count = sparse.count;
            let at: Vec<[f64; 1]> = self.dense(&Place {
                view: sparse.indices.buffer_view,
                offset: sparse.indices.byte_offset,
                count,
                component: Component::of(sparse.indices.component_type)?,
                width: 1,
            })?;
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
            let values: Vec<[f64; N]> = self.dense(&Place { view, offset, count, component, width })?;
            for ([i], value) in at.into_iter().zip(values) {
                if let Some(slot) = numbers.get_mut(i as usize) {
                    *slot = value;
                }
            }
        }
        if about.normalized {
            let one = component.one();
            numbers.iter_mut().flatten().for_each(|v| *v = (*v / one).max(-1.0));
        }
        Ok(numbers)
    }

    /// Numbers as they lie in a view.
    fn dense<const N: usize>(&self, place: &Place) -> Result<Vec<[f64; N]>, Fault> {
        let &Place { view, offset, count, component, width } = place;
        let about = entry(&self.root.buffer_views, view, "buffer view")?;
        let buffer = entry(&self.buffers, about.buffer, "buffer")?.as_ref().map_err(|fault| {
            let packed = about.extensions.keys().find(|name| extensions::is_compression(name));
            packed.map_or_else(|| fault.clone(), |name| extensions::compressed(name))
        })?;
        let bytes = buffer.get(about.byte_offset..).and_then(|rest| rest.get(..about.byte_length));
        let bytes = bytes.and_then(|view| view.get(offset..)).ok_or_else(|| {
            let (end, there) = (about.byte_offset.saturating_add(about.byte_length), buffer.len());
            Fault::whole(format!(
                "buffer {} should have at least {end} bytes, but has {there}; the file may be truncated",
                about.buffer
            ))
        })?;
        let element = component.size() * width;
        let stride = about.byte_stride.filter(|s| *s > 0).unwrap_or(element);
        // Elements may overlap but not be read any number of times.
        let room = if bytes.len() < element { 0 } else { (bytes.len() - element) / stride + 1 };
        if count > room || stride < component.size() {
            return Err(Fault::whole(format!(
                "buffer view {view} has room for {room} elements, but {count} are declared; the file may be \
                 truncated"
            )));
        }
        let number = |i: usize, k: usize| component.value(&bytes[i * stride + k * component.size()..]);
        Ok((0..count).map(|i| std::array::from_fn(|k| number(i, k))).collect())
    }
}
