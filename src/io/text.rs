//! What the text formats share: encodings, numbers, lines.

use std::borrow::Cow;

/// The text of a file. A byte-order mark tells UTF-8 and UTF-16; bytes that
/// are not valid (Latin-1 in a comment, say) become replacement characters.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
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

/// A number as programs write it: also `nan`, `inf` and the forms of older
/// C libraries (`1.#QNAN`, `-nan(ind)`, `1.#INF`).
pub(super) fn number(token: &str) -> Option<f64> {
    if let Ok(value) = token.parse() {
        return Some(value);
    }
    let lower = token.to_ascii_lowercase();
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
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text);
    let mut number = 0;
    std::iter::from_fn(move || {
        let now = rest?;
        number += 1;
        match now.find(['\n', '\r']) {
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

/// A token for a message: short, and quoted.
pub(super) fn quoted(token: &str) -> String {
    let mut shown: String = token.chars().take(24).collect();
    if shown.len() < token.len() {
        shown.push('…');
    }
    format!("“{}”", shown.escape_debug().to_string().replace("\\u{fffd}", "\u{fffd}"))
}

/// "1 face", "3 faces".
pub(super) fn counted(n: usize, one: &str, many: &str) -> String {
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
        for (token, value) in
            [("1.5", 1.5), ("-2e-3", -2e-3), ("+7", 7.0), (".5", 0.5), ("-1.#INF", f64::NEG_INFINITY)]
        {
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
    fn byte_order_marks_tell_the_encoding() {
        assert_eq!(decode(b"\xef\xbb\xbfv 1"), "v 1");
        assert_eq!(decode(b"\xff\xfev\0 \0"), "v ");
        assert_eq!(decode(b"\xfe\xff\0v\0 "), "v ");
        assert_eq!(decode(b"# caf\xe9"), "# caf\u{fffd}");
    }
}
