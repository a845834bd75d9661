//! A file as it is written, in which the places of wrong keys and values are found again.

use std::cell::OnceCell;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::unreadable::Unreadable;

/// A step from a file's top towards one of its values.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// To the value of this key.
    Key(String),
    /// To this entry of a list.
    Entry(usize),
}

/// A file as it is written. It is read for its places once, when the first is looked for.
pub(super) struct Written<'a> {
    text: &'a str,
    table: OnceCell<Option<DeTable<'a>>>,
}

impl Written<'_> {
    pub(super) fn new(text: &str) -> Written<'_> {
        Written { text, table: OnceCell::new() }
    }

    /// The line on which the last key stands.
    pub(super) fn line_of(&self, steps: &[Step]) -> Option<usize> {
        let read = || Some(DeTable::parse(self.text).ok()?.into_inner());
        Some(line_at(self.text, place_of(self.table.get_or_init(read).as_ref()?, steps)?))
    }
}

/// Finds the line on which the last of some keys stands.
pub(super) type LineOf<'a> = &'a dyn Fn(&[Step]) -> Option<usize>;

/// An error in words, with the line of the file that it is about, where that is found at `within` or below,
/// and with what may be meant.
pub(super) fn in_words(error: &Unreadable, line_of: LineOf, within: &[Step]) -> String {
    let culprit = error.culprit();
    // What is missing stands on no line.
    let line = if culprit.is_empty() { None } else { line_of(&[within, &culprit].concat()) };
    let line = line.map_or(String::new(), |line| format!(" (line {line})"));
    format!("{error}{line}{}", error.meant())
}

/// The line of a byte, counted from 1.
pub(super) fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|b| *b == b'\n').count()
}

/// The byte at which the last key begins.
pub(super) fn place_of(table: &DeTable, steps: &[Step]) -> Option<usize> {
    Some(found(table, steps)?.0.span().start)
}

/// The last key of some steps, and the value to which they lead.
fn found<'a, 'i>(
    table: &'a DeTable<'i>,
    steps: &[Step],
) -> Option<(&'a Spanned<DeString<'i>>, &'a Spanned<DeValue<'i>>)> {
    let (Step::Key(first), rest) = steps.split_first()? else { return None };
    let (mut key, mut value) = table.get_key_value(first.as_str())?;
    for step in rest {
        match (value.get_ref(), step) {
            (DeValue::Table(table), Step::Key(next)) => (key, value) = table.get_key_value(next.as_str())?,
            (DeValue::Array(list), Step::Entry(number)) => value = list.get(*number)?,
            _ => return None,
        }
    }
    Some((key, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "seed = 1\n[[sensor]]\nname = \"a\"\n[[sensor]]\nname = \"b\"\n\n[[sensor.poses]]\nx = 1\n\
                        [[sensor.poses]]\nlist = [\n  { wrong = 2 },\n]\n";

    #[test]
    fn a_key_is_found_by_its_tables() {
        let line = |steps: &[Step]| Written::new(FILE).line_of(steps);
        let (key, entry) = (|key: &str| Step::Key(key.into()), Step::Entry);
        assert_eq!(line(&[key("seed")]), Some(1));
        assert_eq!(line(&[key("sensor"), entry(0), key("name")]), Some(3));
        assert_eq!(line(&[key("sensor"), entry(1), key("name")]), Some(5));
        let list = [key("sensor"), entry(1), key("poses"), entry(1), key("list"), entry(0)];
        assert_eq!(line(&list), Some(10));
        assert_eq!(line(&[&list[..], &[key("wrong")]].concat()), Some(11));
        assert_eq!(line(&[key("sensor"), entry(2), key("name")]), None);
        assert_eq!(line(&[key("sensor"), key("name")]), None);
        assert_eq!(line(&[key("sed")]), None);
        assert_eq!(Written::new("no toml").line_of(&[key("no")]), None);
    }
}
