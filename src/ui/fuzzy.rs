//! Fuzzy matching of names.

/// How well `query` fits `text`: each of its words has to occur, as letters of
/// the text in this order. Letters at the start of a word and letters that
/// follow one another count more, and a short text more than a long one. `None`
/// if it doesn't fit.
pub(super) fn score(query: &str, text: &str) -> Option<i32> {
    let text: Vec<char> = text.to_lowercase().chars().collect();
    let mut sum = 0;
    for word in query.split_whitespace() {
        sum += best(&word.to_lowercase().chars().collect::<Vec<_>>(), &text)?;
    }
    Some(if sum == 0 { 0 } else { sum - text.len() as i32 / 4 })
}

/// The best way to find the letters in the text.
///
/// By dynamic programming over the letters: `ends[i]` is the best sum of those
/// so far with the last of them at place i.
fn best(letters: &[char], text: &[char]) -> Option<i32> {
    let value = |i: usize| {
        let starts_word = i == 0 || !text[i - 1].is_alphanumeric();
        if i == 0 {
            14
        } else if starts_word {
            10
        } else {
            1
        }
    };
    let mut ends: Vec<Option<i32>> = Vec::new();
    for (k, letter) in letters.iter().enumerate() {
        let mut reached = vec![None; text.len()];
        // The best end so far that lies before i − 1.
        let mut before: Option<i32> = None;
        for i in 0..text.len() {
            if i >= 2 {
                before = before.max(ends.get(i - 2).copied().flatten());
            }
            if text[i] != *letter {
                continue;
            }
            reached[i] = if k == 0 {
                Some(value(i))
            } else {
                let adjacent = i.checked_sub(1).and_then(|j| ends[j]).map(|sum| sum + 9);
                let apart = before.map(|sum| sum + value(i) - 2);
                adjacent.max(apart)
            };
        }
        ends = reached;
    }
    ends.into_iter().flatten().max()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_have_to_occur_in_their_order() {
        assert!(score("stme", "Step merge").is_some());
        assert!(score("mest", "Step merge").is_none());
        assert!(score("merge step", "Step merge").is_some(), "words may come in any order");
        assert!(score("mm", "Step merge").is_none());
        assert_eq!(score("", "anything"), Some(0));
    }

    #[test]
    fn starts_of_words_and_short_names_win() {
        let better = [
            ("run", "Run", "Return"),
            ("sm", "Step merge", "Some"),
            ("log", "Log", "Clear log"),
            ("log", "Clear log", "Long drag"),
            ("top", "Top", "Stop"),
        ];
        for (query, good, worse) in better {
            assert!(score(query, good) > score(query, worse), "{query}: {good} before {worse}");
        }
    }
}
