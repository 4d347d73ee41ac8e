//! Numbers in binary formats.

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Scalar {
    /// Size in bytes.
    pub(in crate::io) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(in crate::io) fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    /// The number in the first bytes; NaN where there are too few.
    #[inline]
    pub(in crate::io) fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        let mut eight = [0; 8];
        let size = self.size();
        let Some(bytes) = bytes.get(..size) else { return f64::NAN };
        eight[..size].copy_from_slice(bytes);
        if big_endian {
            eight[..size].reverse();
        }
        let [a, b, c, d, ..] = eight;
        match self {
            Self::I8 => f64::from(a as i8),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::I64 => i64::from_le_bytes(eight) as f64,
            Self::U64 => u64::from_le_bytes(eight) as f64,
            Self::F16 => half(u16::from_le_bytes([a, b])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(eight),
        }
    }
}

/// A number of IEEE 754's half precision.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_those_of_ieee_754() {
        for (bits, value) in [
            (0x0000, 0.0),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 5.960464477539063e-8),
            (0x3555, 0.333251953125),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), value, "{bits:04x}");
        }
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn byte_orders_agree() {
        for scalar in [Scalar::I16, Scalar::U32, Scalar::I64, Scalar::F32, Scalar::F64] {
            let little = [0x80, 0x3f, 0x12, 0x40, 0x66, 0x05, 0xc0, 0xbf];
            let mut big = little[..scalar.size()].to_vec();
            big.reverse();
            assert_eq!(scalar.value(&little, false), scalar.value(&big, true), "{scalar:?}");
        }
        assert!(Scalar::F32.value(&[1, 2, 3], false).is_nan());
    }
}
