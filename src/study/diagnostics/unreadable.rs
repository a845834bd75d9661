//! Why a value of a file cannot be read: what is wrong, where, and which known word may be meant.

use std::fmt::{self, Display};

use serde::de::{self, Expected, Unexpected};

use perirobot_scene::spelling::nearest;

/// A step from a file's top towards one of its values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    /// To the value of this key.
    Key(String),
    /// To this entry of a list.
    Entry(usize),
}

/// Why a value cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unreadable {
    pub(crate) kind: Unread,
    /// In words, without the keys.
    pub(crate) message: String,
    /// The steps that lead to it, the outermost first.
    pub(crate) steps: Vec<Step>,
}

/// What is wrong with a value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Unread {
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
    fn new(kind: Unread, said: Unreadable) -> Self {
        Unreadable { kind, ..said }
    }

    /// The error of what a step leads to, as one of what the step is taken from.
    pub(crate) fn prefix(mut self, step: Step) -> Self {
        self.steps.insert(0, step);
        self
    }

    /// The keys that lead to it, the outermost first, without the numbers of entries.
    pub(crate) fn keys(&self) -> Vec<&str> {
        let keys = self.steps.iter().filter_map(|step| match step {
            Step::Key(key) => Some(key.as_str()),
            Step::Entry(_) => None,
        });
        keys.collect()
    }

    /// The steps to the key that the error is about: one that is unknown, or the one whose value is wrong or
    /// lacks something. None if that is the whole.
    pub(crate) fn culprit(&self) -> Vec<Step> {
        let mut steps = self.steps.clone();
        match &self.kind {
            Unread::UnknownKey(key, _) => steps.push(Step::Key(key.clone())),
            _ => while steps.pop_if(|last| matches!(last, Step::Entry(_))).is_some() {},
        }
        steps
    }

    /// What a word is nearest to among those that would be right, as the end of a message.
    pub(crate) fn suggestion(&self) -> String {
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
        Unreadable::new(Unread::Missing(field), Unreadable::custom(format_args!("missing field `{field}`")))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let said = format!("unknown field `{field}`, {}", expected_words(expected));
        Unreadable::new(Unread::UnknownKey(field.into(), expected), Unreadable::custom(said))
    }

    fn unknown_variant(word: &str, expected: &'static [&'static str]) -> Self {
        let said = format!("unknown variant `{word}`, {}", expected_words(expected));
        Unreadable::new(Unread::UnknownWord(word.into(), expected), Unreadable::custom(said))
    }

    fn invalid_type(found: Unexpected, wanted: &dyn Expected) -> Self {
        Unreadable::custom(format_args!("found {}, wanted {}", found_words(found), wanted_words(wanted)))
    }

    fn invalid_value(found: Unexpected, wanted: &dyn Expected) -> Self {
        Unreadable::invalid_type(found, wanted)
    }

    fn invalid_length(found: usize, wanted: &dyn Expected) -> Self {
        let entries = if found == 1 { "entry" } else { "entries" };
        Unreadable::custom(format_args!("found {found} {entries}, wanted {}", wanted_words(wanted)))
    }
}

/// The list as serde words it.
fn expected_words(expected: &[&str]) -> String {
    match expected {
        [] => "there are none".into(),
        _ => format!("expected {}", one_of(expected)),
    }
}

/// A choice among words.
pub(crate) fn one_of(words: &[&str]) -> String {
    match words {
        [one] => format!("`{one}`"),
        [one, other] => format!("`{one}` or `{other}`"),
        all => format!("one of `{}`", all.join("`, `")),
    }
}

/// A value as its file has it.
fn found_words(found: Unexpected) -> String {
    match found {
        Unexpected::Bool(is) => is.to_string(),
        Unexpected::Unsigned(number) => number.to_string(),
        Unexpected::Signed(number) => number.to_string(),
        // With its point: this is what tells it from a whole number.
        Unexpected::Float(number) => format!("{number:?}"),
        Unexpected::Str(text) => format!("{text:?}"),
        Unexpected::Seq => "a list".into(),
        Unexpected::Map => "a table".into(),
        other => other.to_string(),
    }
}

/// What would be right: serde's names of types of this language in the words of files.
fn wanted_words(wanted: &dyn Expected) -> String {
    let wanted = wanted.to_string();
    let whole = |low: i64, high: i64| format!("a whole number from {low} to {high}");
    match wanted.as_str() {
        "f32" | "f64" => "a number".into(),
        "u8" => whole(0, u8::MAX.into()),
        "u16" => whole(0, u16::MAX.into()),
        "u32" => whole(0, u32::MAX.into()),
        // A file holds no larger one.
        "u64" | "usize" => whole(0, i64::MAX),
        "i32" => whole(i32::MIN.into(), i32::MAX.into()),
        "i64" => whole(i64::MIN, i64::MAX),
        "a boolean" => "true or false".into(),
        "a string" => "text in quotes".into(),
        "a sequence" => "a list".into(),
        "a map" => "a table".into(),
        structure if structure.starts_with("struct ") => "a table".into(),
        list if list.starts_with("an array of ") => list.replace("an array", "a list"),
        _ => wanted,
    }
}
