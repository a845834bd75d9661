//! Quotes words for a POSIX shell, for commands that are printed or written into scripts.

/// A word: plain where that is safe, else between single quotes.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./:@%+,-".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// A command of several words.
pub fn command(words: &[impl AsRef<str>]) -> String {
    words.iter().map(|word| quoted(word.as_ref())).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_must_be_is_quoted() {
        assert_eq!(
            command(&["perirobot", "--out", "a b/it's", "K=1", ""]),
            r"perirobot --out 'a b/it'\''s' 'K=1' ''"
        );
    }
}
