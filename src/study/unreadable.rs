//! Why a value of a file cannot be read: what is wrong, where, and which known word may be meant.

use std::fmt::{self, Display};

use serde::de;

use super::written::Step;
use crate::spelling::nearest;

/// Why a value cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Unreadable {
    pub(super) kind: Unread,
    /// In words, without the keys.
    pub(super) message: String,
    /// The steps that lead to it, the outermost first.
    pub(super) steps: Vec<Step>,
}

/// What is wrong with a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unread {
    /// A table lacks this key.
    Missing(&'static str),
    /// A table has a key that is none of these.
    UnknownKey(String, &'static [&'static str]),
    /// A word is none of these.
    UnknownWord(String, &'static [&'static str]),
    /// It is of another type, or out of range.
    Value,
}

impl Unreadable {
    fn of(kind: Unread, said: Unreadable) -> Self {
        Unreadable { kind, ..said }
    }

    /// The error of what a step leads to, as one of what the step is taken from.
    pub(super) fn after(mut self, step: Step) -> Self {
        self.steps.insert(0, step);
        self
    }

    /// The keys that lead to it, the outermost first, without the numbers of entries.
    pub(super) fn keys(&self) -> Vec<&str> {
        let keys = self.steps.iter().filter_map(|step| match step {
            Step::Key(key) => Some(key.as_str()),
            Step::Entry(_) => None,
        });
        keys.collect()
    }

    /// The steps to the key that the error is about: one that is unknown, or the one whose value is wrong or
    /// lacks something. None if that is the whole.
    pub(super) fn culprit(&self) -> Vec<Step> {
        let mut steps = self.steps.clone();
        match &self.kind {
            Unread::UnknownKey(key, _) => steps.push(Step::Key(key.clone())),
            _ => while steps.pop_if(|last| matches!(last, Step::Entry(_))).is_some() {},
        }
        steps
    }

    /// What a word is nearest to among those that would be right, as the end of a message.
    pub(super) fn meant(&self) -> String {
        let near = match &self.kind {
            Unread::UnknownKey(written, expected) | Unread::UnknownWord(written, expected) => {
                nearest(written, expected.iter().copied())
            }
            Unread::Missing(_) | Unread::Value => None,
        };
        near.map_or(String::new(), |near| format!("; did you mean `{near}`?"))
    }
}

impl Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.message)?;
        let keys = self.keys();
        if keys.is_empty() { Ok(()) } else { write!(f, " in `{}`", keys.join(".")) }
    }
}

impl std::error::Error for Unreadable {}

impl de::Error for Unreadable {
    fn custom<M: Display>(message: M) -> Self {
        Unreadable { kind: Unread::Value, message: message.to_string(), steps: Vec::new() }
    }

    fn missing_field(field: &'static str) -> Self {
        Unreadable::of(Unread::Missing(field), Unreadable::custom(format_args!("missing field `{field}`")))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let said = format!("unknown field `{field}`, {}", one_of(expected));
        Unreadable::of(Unread::UnknownKey(field.into(), expected), Unreadable::custom(said))
    }

    fn unknown_variant(word: &str, expected: &'static [&'static str]) -> Self {
        let said = format!("unknown variant `{word}`, {}", one_of(expected));
        Unreadable::of(Unread::UnknownWord(word.into(), expected), Unreadable::custom(said))
    }
}

/// The list as serde words it.
fn one_of(expected: &[&str]) -> String {
    match expected {
        [] => "there are none".into(),
        [one] => format!("expected `{one}`"),
        [one, other] => format!("expected `{one}` or `{other}`"),
        all => format!("expected one of `{}`", all.join("`, `")),
    }
}
