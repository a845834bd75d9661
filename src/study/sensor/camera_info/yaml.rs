//! The first document of a YAML file as a table, whose values are then read as those of a study are. A parser finds
//! the words; here they become values. How deep these lie, and how much is copied for aliases, is bounded, since an
//! alias may stand for what has aliases itself.

use std::collections::BTreeMap;

use saphyr_parser::{Event, Marker, Parser, ScalarStyle, Span, StrInput};
use toml::{Table, Value};

use crate::error::Issue;

/// So many lists and tables may lie in each other.
const DEEPEST: usize = 64;
/// So many values and letters may be copied for anchors and aliases. This bounds how deep aliases in aliases lie, too.
const MOST_COPIED: usize = 10_000;

/// The first document that is not empty, if there is one. What comes after it is not looked at.
pub(super) fn first(text: &str) -> Result<Option<Table>, Issue> {
    let mut reader = Reader { events: Parser::new_from_str(text), named: BTreeMap::new(), left: MOST_COPIED };
    loop {
        match reader.next()? {
            (Event::StreamEnd, _) => return Ok(None),
            (Event::StreamStart | Event::DocumentStart(_) | Event::DocumentEnd, _) => {}
            (event, at) => match reader.value(event, at, 0)? {
                None => {}
                Some(Value::Table(table)) => return Ok(Some(table)),
                Some(_) => return Err(wrong(at.start, "is not a table of keys")),
            },
        }
    }
}

struct Reader<'t> {
    events: Parser<'t, StrInput<'t>>,
    /// What aliases may stand for.
    named: BTreeMap<usize, Option<Value>>,
    /// So many values and letters may still be copied.
    left: usize,
}

impl<'t> Reader<'t> {
    fn next(&mut self) -> Result<(Event<'t>, Span), Issue> {
        let ends = Issue::damaged("ends early");
        self.events.next_event().ok_or(ends)?.map_err(|e| wrong(*e.marker(), e.info()))
    }

    /// What starts with this event; None for an empty value.
    fn value(&mut self, event: Event<'t>, at: Span, deep: usize) -> Result<Option<Value>, Issue> {
        let (value, name) = match event {
            Event::Scalar(text, style, name, _) => (scalar(&text, style), name),
            Event::SequenceStart(..) | Event::MappingStart(..) if deep == DEEPEST => {
                return Err(wrong(
                    at.start,
                    &format!("more than {DEEPEST} lists and tables lie in each other"),
                ));
            }
            Event::SequenceStart(name, _) => (Some(Value::Array(self.list(deep + 1)?)), name),
            Event::MappingStart(name, _) => (Some(Value::Table(self.table(deep + 1)?)), name),
            Event::Alias(name) => {
                let unknown = || wrong(at.start, "an alias must stand for a whole value before it");
                let value = self.named.get(&name).ok_or_else(unknown)?;
                self.left = rest(self.left, value, at)?;
                return Ok(value.clone());
            }
            _ => return Err(wrong(at.start, "a value is missing")),
        };
        // Zero stands for no name.
        if name > 0 {
            self.left = rest(self.left, &value, at)?;
            self.named.insert(name, value.clone());
        }
        Ok(value)
    }

    fn list(&mut self, deep: usize) -> Result<Vec<Value>, Issue> {
        let mut list = Vec::new();
        loop {
            match self.next()? {
                (Event::SequenceEnd, _) => return Ok(list),
                (event, at) => {
                    // A list keeps the places of its entries; an empty word is no number.
                    list.push(self.value(event, at, deep)?.unwrap_or_else(|| "".into()));
                }
            }
        }
    }

    /// Keys without a value are left out; `<<: { }` stands for what is between its braces.
    fn table(&mut self, deep: usize) -> Result<Table, Issue> {
        let mut table = Table::new();
        let mut merged = Vec::new();
        loop {
            let (key, style, at) = match self.next()? {
                (Event::MappingEnd, _) => break,
                (Event::Scalar(key, style, ..), at) => (key, style, at),
                (_, at) => return Err(wrong(at.start, "a key must be plain text")),
            };
            let (event, begin) = self.next()?;
            let value = self.value(event, begin, deep)?;
            if key == "<<" && style == ScalarStyle::Plain {
                let others = match value {
                    Some(Value::Array(list)) => list,
                    one => one.into_iter().collect(),
                };
                for other in others {
                    let Value::Table(other) = other else {
                        return Err(wrong(begin.start, "only tables can be merged into this one"));
                    };
                    merged.push(other);
                }
            } else if let Some(value) = value
                && table.insert(key.to_string(), value).is_some()
            {
                return Err(wrong(at.start, &format!("the key {key:?} is there twice")));
            }
        }
        for (key, value) in merged.into_iter().flatten() {
            table.entry(key).or_insert(value);
        }
        Ok(table)
    }
}

/// What is left of so many after a copy of the value.
fn rest(left: usize, value: &Option<Value>, at: Span) -> Result<usize, Issue> {
    let many =
        || wrong(at.start, &format!("anchors and aliases repeat more than {MOST_COPIED} values and letters"));
    left.checked_sub(value.as_ref().map_or(1, size)).ok_or_else(many)
}

/// A single value; None for an empty one. A number that is not finite stays a word, which is refused where a
/// number is wanted.
fn scalar(text: &str, style: ScalarStyle) -> Option<Value> {
    if style != ScalarStyle::Plain {
        return Some(text.into());
    }
    let number = || text.parse().ok().map(Value::Integer);
    let fraction = || text.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::Float);
    match text {
        "" | "~" | "null" | "Null" | "NULL" => None,
        _ => number().or_else(fraction).or_else(|| Some(text.into())),
    }
}

/// How many values and letters there are in it, with itself.
fn size(value: &Value) -> usize {
    match value {
        Value::Array(list) => 1 + list.iter().map(size).sum::<usize>(),
        Value::Table(table) => 1 + table.iter().map(|(key, value)| key.len() + size(value)).sum::<usize>(),
        Value::String(text) => 1 + text.len(),
        _ => 1,
    }
}

fn wrong(at: Marker, what: &str) -> Issue {
    Issue::damaged(what).at(format!("line {}, column {}", at.line(), at.col() + 1))
}
