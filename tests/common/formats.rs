//! Small files of the binary formats, built in memory.
#![allow(dead_code)] // Each test file uses its part.

use std::io::{Cursor, Write};

use superform::io::{Shape, ShapeGeometry, read_bytes};

/// What is read of a content, which must be a cloud: its points, and all of it.
pub(crate) fn cloud_of(name: &str, bytes: impl AsRef<[u8]>) -> (Vec<[f64; 3]>, Shape) {
    let shape = read_bytes(bytes.as_ref(), name).unwrap_or_else(|e| panic!("{e}"));
    let ShapeGeometry::Cloud(cloud) = &shape.geometry else { panic!("{name} is a mesh") };
    (cloud.points.iter().map(|p| [p.x, p.y, p.z]).collect(), shape)
}

/// The message of a refusal.
pub(crate) fn refusal(name: &str, bytes: impl AsRef<[u8]>) -> String {
    match read_bytes(bytes.as_ref(), name) {
        Err(e) => e.to_string(),
        Ok(shape) => panic!("{name} was read: {shape:?}"),
    }
}

/// A NumPy array of version 1.
pub(crate) fn npy(descr: &str, fortran: bool, shape: &str, body: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let mut header = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': ({shape}), }}");
    while (header.len() + 11) % 16 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut file = b"\x93NUMPY\x01\0".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.bytes());
    file.extend(body);
    file
}

pub(crate) fn npz(arrays: &[(&str, Vec<u8>)], packed: bool) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let method = if packed { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
    for (name, array) in arrays {
        let options = zip::write::SimpleFileOptions::default().compression_method(method);
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(array).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

pub(crate) fn f32s(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(crate) fn f64s(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A header of PCD's version 0.7 for fields of one number each.
pub(crate) fn pcd(fields: &str, sizes: &str, types: &str, points: usize, data: &str) -> Vec<u8> {
    format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\nWIDTH {points}\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
    )
    .into_bytes()
}

/// The same, with a body compressed by LZF, field after field.
pub(crate) fn pcd_packed(header: Vec<u8>, body: &[u8]) -> Vec<u8> {
    let packed = lzf::compress(body).unwrap();
    let mut file = header;
    file.extend((packed.len() as u32).to_le_bytes());
    file.extend((body.len() as u32).to_le_bytes());
    file.extend(packed);
    file
}

/// A scan of points, each with a class and a colour, in a point format.
pub(crate) fn las(format: u8, compressed: bool, points: &[([f64; 3], u8, [u16; 3])]) -> Vec<u8> {
    let mut builder = las::Builder::from((1, 4));
    builder.point_format = las::point::Format::new(format).unwrap();
    builder.point_format.is_compressed = compressed;
    for (axis, offset) in [
        (&mut builder.transforms.x, 500_000.0),
        (&mut builder.transforms.y, 5_400_000.0),
        (&mut builder.transforms.z, 0.0),
    ] {
        *axis = las::Transform { scale: 0.001, offset };
    }
    let has_color = builder.point_format.has_color;
    let has_time = builder.point_format.has_gps_time;
    let mut writer = las::Writer::new(Cursor::new(Vec::new()), builder.into_header().unwrap()).unwrap();
    for ([x, y, z], class, [red, green, blue]) in points {
        let point = las::Point {
            x: *x,
            y: *y,
            z: *z,
            classification: las::point::Classification::new(*class).unwrap(),
            color: has_color.then(|| las::Color::new(*red, *green, *blue)),
            gps_time: has_time.then_some(1.5),
            ..las::Point::default()
        };
        writer.write_point(point).unwrap();
    }
    writer.close().unwrap();
    writer.into_inner().unwrap().into_inner()
}
