//! Keys and words of a file that are spelt wrong: on which line they stand, and which known word they
//! resemble.

use std::cell::OnceCell;

use toml::de::{DeTable, DeValue};

use super::reader::{Unread, Unreadable};
use crate::spelling::nearest;

/// A step from a file's top towards one of its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step<'a> {
    /// To the value of this key.
    Key(&'a str),
    /// To this entry of a list.
    Entry(usize),
}

/// A file as it is written, in which wrong keys are found again. It is read for that once, when the first is
/// looked for.
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
    let culprit = culprit(error);
    let steps: Vec<Step> = within.iter().copied().chain(culprit.iter().map(|key| Step::Key(key))).collect();
    // What is missing stands on no line.
    let line = if culprit.is_empty() { None } else { line_of(&steps) };
    let line = line.map_or(String::new(), |line| format!(" (line {line})"));
    format!("{error}{line}{}", meant(error))
}

/// What a word is nearest to among those that would be right, as the end of a message.
pub(super) fn meant(error: &Unreadable) -> String {
    let near = match &error.kind {
        Unread::UnknownKey(written, expected) | Unread::UnknownWord(written, expected) => {
            nearest(written, expected.iter().copied())
        }
        Unread::Missing(_) | Unread::Value => None,
    };
    near.map_or(String::new(), |near| format!("; did you mean `{near}`?"))
}

/// The keys that an error is about, from the outermost table inwards.
pub(super) fn culprit(error: &Unreadable) -> Vec<String> {
    let unknown = match &error.kind {
        Unread::UnknownKey(key, _) => Some(key),
        _ => None,
    };
    error.keys.iter().chain(unknown).cloned().collect()
}

/// The line of a byte, counted from 1.
pub(super) fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|b| *b == b'\n').count()
}

/// The byte at which the last key begins; of lists without a number, in the first entry that has it.
pub(super) fn place_of(table: &DeTable, steps: &[Step]) -> Option<usize> {
    let (Step::Key(key), rest) = (steps.first()?, &steps[1..]) else { return None };
    let (name, value) = table.get_key_value(*key)?;
    match rest.iter().any(|step| matches!(step, Step::Key(_))) {
        true => in_value(value.get_ref(), rest),
        false => Some(name.span().start),
    }
}

fn in_value(value: &DeValue, steps: &[Step]) -> Option<usize> {
    match (value, steps.first()?) {
        (DeValue::Table(table), Step::Key(_)) => place_of(table, steps),
        (DeValue::Array(list), Step::Entry(number)) => in_value(list.get(*number)?.get_ref(), &steps[1..]),
        (DeValue::Array(list), Step::Key(_)) => {
            list.iter().find_map(|entry| in_value(entry.get_ref(), steps))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "seed = 1\n[[sensor]]\nname = \"a\"\n[[sensor]]\nname = \"b\"\n\n[[sensor.poses]]\nx = 1\n\
                        [[sensor.poses]]\nlist = [\n  { wrong = 2 },\n]\n";

    #[test]
    fn a_key_is_found_by_its_tables() {
        let line = |steps: &[Step]| Written::new(FILE).line_of(steps);
        use Step::{Entry, Key};
        assert_eq!(line(&[Key("seed")]), Some(1));
        assert_eq!(line(&[Key("sensor"), Entry(0), Key("name")]), Some(3));
        assert_eq!(line(&[Key("sensor"), Entry(1), Key("name")]), Some(5));
        assert_eq!(line(&[Key("sensor"), Entry(1), Key("poses"), Key("list"), Key("wrong")]), Some(11));
        assert_eq!(line(&[Key("sensor"), Entry(1), Key("poses"), Entry(1), Key("list"), Entry(0)]), Some(10));
        assert_eq!(line(&[Key("sensor"), Entry(2), Key("name")]), None);
        assert_eq!(line(&[Key("sed")]), None);
        assert_eq!(Written::new("no toml").line_of(&[Key("no")]), None);
    }
}
