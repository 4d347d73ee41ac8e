//! Encodings, numbers and lines, shared by the text formats.

use std::borrow::Cow;

/// The text of a file. A byte-order mark tells UTF-8 and UTF-16; bytes that
/// are not valid (Latin-1 in a comment, say) become replacement characters.
pub(in crate::io) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let utf16 = |unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|b| unit([b[0], b[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    match bytes {
        [0xff, 0xfe, ..] => utf16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => utf16(u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest),
        _ => String::from_utf8_lossy(bytes),
    }
}

/// A number as programs write it: also `nan`, `inf`, the forms of older C
/// libraries (`1.#QNAN`, `-nan(ind)`, `1.#INF`) and those of Fortran (`1.5D+00`).
pub(in crate::io) fn number(token: &str) -> Option<f64> {
    if let Some(value) = plain_number(token.as_bytes()).or_else(|| token.parse().ok()) {
        return Some(value);
    }
    let lower = token.to_ascii_lowercase();
    // Fortran's exponents of double precision.
    if let Some(value) = lower.contains('d').then(|| lower.replace('d', "e")).and_then(|t| t.parse().ok()) {
        return Some(value);
    }
    let (sign, rest) = match lower.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, lower.as_str()),
    };
    if rest.starts_with("1.#inf") {
        Some(sign * f64::INFINITY)
    } else if rest.starts_with("nan(") || rest.starts_with("1.#") {
        Some(f64::NAN)
    } else {
        None
    }
}

/// Lines with their numbers from 1, at `\n`, `\r\n` and a lone `\r`.
pub(in crate::io) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text);
    let mut number = 0;
    std::iter::from_fn(move || {
        let now = rest?;
        number += 1;
        match now.bytes().position(|b| matches!(b, b'\n' | b'\r')) {
            Some(at) => {
                let after = &now[at..];
                rest = Some(after.strip_prefix("\r\n").unwrap_or(&after[1..]));
                Some((number, &now[..at]))
            }
            None => {
                rest = None;
                Some((number, now))
            }
        }
    })
}

/// A decimal number of few digits, as most are; `None` for all others, be they
/// numbers or not. What it gives is what [`str::parse`] gives, in half the time.
pub(in crate::io) fn plain_number(token: &[u8]) -> Option<f64> {
    /// Powers of ten that are exact.
    const TENS: [f64; 19] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17,
        1e18,
    ];
    let (is_negative, digits) = match token {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, token),
    };
    let (mut mantissa, mut count, mut fraction) = (0u64, 0, 0);
    let mut in_fraction = false;
    for &b in digits {
        match b {
            b'0'..=b'9' => {
                // No overflow: more than 18 digits are refused below.
                mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(b - b'0'));
                count += 1;
                fraction += usize::from(in_fraction);
            }
            b'.' if !in_fraction => in_fraction = true,
            _ => return None,
        }
    }
    // Both numbers are exact, so that their quotient is rounded once.
    if !(1..=18).contains(&count) || mantissa > 1 << 53 {
        return None;
    }
    let value = mantissa as f64 / TENS.get(fraction)?;
    Some(if is_negative { -value } else { value })
}

/// Bytes of text that one thread parses at once.
pub(in crate::io) const PIECE: usize = 1 << 18;

/// The text in pieces of about `size` bytes, each of which ends with a line.
pub(in crate::io) fn pieces(text: &str, size: usize) -> Vec<&str> {
    let mut pieces = Vec::with_capacity(text.len() / size.max(1) + 1);
    let mut rest = text;
    while !rest.is_empty() {
        let bytes = rest.as_bytes();
        let from = size.min(bytes.len());
        let end = bytes[from..].iter().position(|b| matches!(b, b'\n' | b'\r'));
        let end = end.map_or(bytes.len(), |at| {
            let at = from + at;
            // `\r\n` is one ending.
            at + if bytes[at..].starts_with(b"\r\n") { 2 } else { 1 }
        });
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
    }
    pieces
}

/// A token for a message: short, and quoted.
pub(in crate::io) fn quoted(token: &str) -> String {
    quoted_up_to(token, 24)
}

/// The same, with this many characters at most.
pub(in crate::io) fn quoted_up_to(token: &str, most: usize) -> String {
    format!("“{}”", shortened(token, most))
}

/// The first characters of a text, those that a terminal would obey escaped.
pub(in crate::io) fn shortened(text: &str, most: usize) -> String {
    let mut shown: String = text.chars().take(most).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    shown.escape_debug().to_string().replace("\\u{fffd}", "\u{fffd}")
}

/// "1 face", "3 faces".
pub(in crate::io) fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways() {
        let all: Vec<_> = lines("a\nb\r\nc\rd\n\ne").collect();
        assert_eq!(all, [(1, "a"), (2, "b"), (3, "c"), (4, "d"), (5, ""), (6, "e")]);
    }

    #[test]
    fn numbers_of_many_dialects() {
        for (token, value) in [
            ("1.5", 1.5),
            ("-2e-3", -2e-3),
            ("+7", 7.0),
            (".5", 0.5),
            ("-1.#INF", f64::NEG_INFINITY),
            ("-1.5D+01", -15.0),
        ] {
            assert_eq!(number(token), Some(value));
        }
        for token in ["nan", "NaN", "-nan", "1.#QNAN", "-1.#IND", "nan(ind)"] {
            assert!(number(token).is_some_and(f64::is_nan), "{token}");
        }
        for token in ["", "x", "1,5", "0x10", "1.5f", "--1"] {
            assert_eq!(number(token), None, "{token}");
        }
    }

    #[test]
    fn plain_numbers_are_what_the_standard_library_reads() {
        let tokens = [
            "0",
            "-0",
            "1.",
            ".5",
            "-.25",
            "+7",
            "0.1",
            "3.14159265358979",
            "123456789012345678",
            "0.3000000001",
            "9007199254740992",
            "9007199254740993",
            "0.000000000000000001",
            "-1234.5678",
            "00012.50",
        ];
        for token in tokens {
            let expected: f64 = token.parse().unwrap();
            let found = plain_number(token.as_bytes());
            assert!(found.is_none_or(|v| v.to_bits() == expected.to_bits()), "{token}: {found:?}");
            assert!(found.is_some() || token.len() > 15, "{token}");
        }
        for token in ["", "-", ".", "+.", "1e5", "nan", "1.2.3", "1-2", "0x1", "1,5", "12345678901234567890"]
        {
            assert_eq!(plain_number(token.as_bytes()), None, "{token}");
        }
    }

    #[test]
    fn pieces_end_with_a_line_and_lose_nothing() {
        let text = "ab\r\nc\rdé\n\n\nlong line without an end";
        for size in 0..text.len() + 2 {
            let all = pieces(text, size);
            assert_eq!(all.concat(), text);
            let in_pieces: Vec<&str> =
                all.iter().flat_map(|piece| lines(piece).map(|(_, l)| l).filter(|l| !l.is_empty())).collect();
            let whole: Vec<&str> = lines(text).map(|(_, l)| l).filter(|l| !l.is_empty()).collect();
            assert_eq!(in_pieces, whole, "size {size}");
            assert!(all.iter().rev().skip(1).all(|p| p.ends_with(['\n', '\r'])));
        }
    }

    #[test]
    fn byte_order_marks_tell_the_encoding() {
        assert_eq!(decode(b"\xef\xbb\xbfv 1"), "v 1");
        assert_eq!(decode(b"\xff\xfev\0 \0"), "v ");
        assert_eq!(decode(b"\xfe\xff\0v\0 "), "v ");
        assert_eq!(decode(b"# caf\xe9"), "# caf\u{fffd}");
    }
}
