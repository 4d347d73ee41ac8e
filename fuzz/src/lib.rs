//! What every target checks.

use std::path::Path;

use superform::io::{ReadError, Shape, ShapeGeometry, parse_primitives, read_bytes, read_bytes_as};

/// Reads bytes in the format of an ending.
///
/// # Panics
/// Where the reader panics, or hands over what no shape may be.
pub fn one_format(ending: &str, bytes: &[u8]) {
    check(read_bytes_as(bytes, ending).expect("a known ending"), bytes.len());
}

/// Tells the format first; the first byte chooses the name.
///
/// # Panics
/// The same.
pub fn any_format(bytes: &[u8]) {
    const NAMES: [&str; 4] = ["a", "a.xyz", "a.obj", "a.stl"];
    let Some((first, rest)) = bytes.split_first() else { return };
    check(read_bytes(rest, NAMES[usize::from(*first) % NAMES.len()]), rest.len());
}

/// Reads primitives, in any of their formats.
///
/// # Panics
/// Where the reader panics, or a message is empty.
pub fn primitives(bytes: &[u8]) {
    match parse_primitives(bytes, Path::new("it"), None) {
        Ok(stored) => assert!(stored.primitives.iter().all(|p| p.shape.is_valid())),
        Err(e) => assert!(!e.to_string().is_empty()),
    }
}

/// Panics in the decoder of LAZ are caught by its reader: they must not end the
/// program as soon as they begin, only where they come through.
pub fn let_panics_be_caught() {
    std::panic::set_hook(Box::new(|_| {}));
}

fn check(read: Result<Shape, ReadError>, size: usize) {
    match read {
        Ok(shape) => {
            let points = match &shape.geometry {
                ShapeGeometry::Mesh(mesh) => {
                    assert!(!mesh.faces.is_empty());
                    assert!(mesh.faces.iter().flatten().all(|&i| (i as usize) < mesh.vertices.len()));
                    assert!(mesh.vertices.iter().all(|p| p.iter().all(|c| c.is_finite())));
                    mesh.vertices.len()
                }
                ShapeGeometry::Cloud(cloud) => {
                    assert!(cloud.points.iter().any(|p| p.iter().all(|c| c.is_finite())));
                    cloud.points.len()
                }
            };
            assert!(shape.attributes.fit(points));
            // Compressed points may be many; all others stand in the file.
            assert!(points <= (16 << 20) + 100 * size, "{points} points of {size} bytes");
        }
        Err(e) => assert!(!e.to_string().is_empty()),
    }
}
