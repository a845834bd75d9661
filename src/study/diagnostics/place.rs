//! Where in a file a check looks, and what its errors say: file, key, value, and what would be right.

use std::collections::HashSet;
use std::path::Path;

use glam::DVec3;

use perirobot_march::error::{Issue, Site, Words};
use perirobot_march::{Error, Result};
use perirobot_scene::shell::is_hidden;
use perirobot_scene::spelling::nearest;

/// The largest coordinate in a file; larger numbers are typing errors, infinities or NaN.
pub(crate) const FARTHEST_M: f64 = 1e6;

/// Most characters of a name; a default name of a combination is made of several.
const MOST_OF_NAME: usize = 1000;

/// Where in a file a check looks, so that every message names file, key, value and what would be right.
#[derive(Clone)]
pub(crate) struct Place<'a> {
    pub(crate) file: &'a Path,
    prefix: String,
}

impl<'a> Place<'a> {
    /// The whole of a file.
    pub(crate) fn new(file: &'a Path) -> Self {
        Place { file, prefix: String::new() }
    }

    /// A place inside this one.
    pub(crate) fn key(&self, key: &str) -> Self {
        Place { file: self.file, prefix: format!("{}{key}.", self.prefix) }
    }

    /// The folder that the file's own paths are relative to.
    pub(crate) fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    /// The error for a wrong value.
    pub(crate) fn wrong(&self, key: &str, value: impl std::fmt::Display, rule: &str) -> Error {
        let issue = Issue::value(key, value, rule);
        match self.prefix.trim_end_matches('.') {
            "" => issue,
            table => issue.with_place(Site::Table(table.into())),
        }
        .with_place(self.file)
        .into()
    }

    /// A name that is not one of those that are known; `what` says what it must be.
    pub(crate) fn unknown_name(&self, key: &str, name: &str, what: &str, known: &[&str]) -> Error {
        let near = nearest(name, known.iter().copied());
        let near = near.map_or(String::new(), |near| format!(" (did you mean {near:?}?)"));
        self.wrong(key, format!("{name:?}"), &format!("must be {what}: {known:?}{near}"))
    }

    /// The error for something that is missing or given twice.
    pub(crate) fn says(&self, what: impl Into<Words>) -> Error {
        self.wrap(Issue::says(what))
    }

    /// An error with this place around it, such as that of a file that is named here.
    pub(crate) fn wrap(&self, error: impl Into<Error>) -> Error {
        let error = error.into();
        match self.prefix.trim_end_matches('.') {
            "" => error,
            part => error.with_place(part),
        }
        .with_place(self.file)
    }

    pub(crate) fn number(
        &self,
        key: &str,
        value: f64,
        range: impl std::ops::RangeBounds<f64>,
        rule: &str,
    ) -> Result<f64> {
        if range.contains(&value) {
            Ok(value)
        } else {
            Err(self.wrong(key, value, &format!("must be {rule}")))
        }
    }

    pub(crate) fn vector(&self, key: &str, value: [f64; 3]) -> Result<DVec3> {
        self.vector_within(key, value, FARTHEST_M)
    }

    /// A place whose coordinates are at most so far from 0.
    pub(crate) fn vector_within(&self, key: &str, value: [f64; 3], farthest_m: f64) -> Result<DVec3> {
        if value.iter().all(|v| v.abs() <= farthest_m) {
            Ok(DVec3::from_array(value))
        } else {
            let rule = format!("must be three numbers from -{farthest_m} to {farthest_m}");
            Err(self.wrong(key, format!("{value:?}"), &rule))
        }
    }

    pub(crate) fn some<T>(&self, key: &str, entries: &[T], example: &str) -> Result<()> {
        if entries.is_empty() {
            return Err(self
                .wrap(Issue::missing(key))
                .with_advice(format!("add at least one, as in {example}")));
        }
        Ok(())
    }

    pub(crate) fn unique<'n>(&self, kind: &str, names: impl Iterator<Item = &'n str>) -> Result<()> {
        let kinds = match kind.strip_suffix('y') {
            Some(stem) => format!("{stem}ies"),
            None => format!("{kind}s"),
        };
        let mut seen = HashSet::new();
        for name in names {
            if name.is_empty() {
                return Err(self.says(format!("one of the {kinds} has an empty name")));
            }
            if name.chars().count() > MOST_OF_NAME {
                let begin: String = name.chars().take(40).collect();
                let what = format!("has more than {MOST_OF_NAME} characters: take a shorter one");
                return Err(self.wrap(
                    Issue::too_large(format!("its name {what}")).with_place(format!("{kind} {begin:?}…")),
                ));
            }
            if let Some(hidden) = name.chars().find(|c| is_hidden(*c)) {
                let hidden = hidden.escape_unicode();
                let what = format!("has control characters or others that are not seen ({hidden})");
                return Err(self
                    .says(format!("{kind} {name:?} {what}"))
                    .with_advice("name it with letters, digits and signs"));
            }
            if !seen.insert(name) {
                return Err(self
                    .says(format!("two {kinds} are named {name:?}"))
                    .with_advice("give each its own name"));
            }
        }
        Ok(())
    }
}

/// The one surface, shape or source that must be given among several keys.
pub(crate) fn only_one<T>(at: &Place, what: &str, choices: Vec<(&str, Option<T>)>) -> Result<T> {
    let known: Vec<&str> = choices.iter().map(|(key, _)| *key).collect();
    let mut given: Vec<(&str, T)> =
        choices.into_iter().filter_map(|(key, value)| Some((key, value?))).collect();
    match (given.pop(), given.pop()) {
        (Some((_, value)), None) => Ok(value),
        (None, _) => {
            Err(at.says(format!("no {what}")).with_advice(format!("give one of {}", known.join(", "))))
        }
        (Some((b, _)), Some((a, _))) => {
            Err(at.says(format!("both {a} and {b}")).with_advice(format!("give one {what}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_file_key_value_and_rule() {
        let at = Place::new(Path::new("study.toml"));
        let inside = at.key("sensor \"camera\"");
        let wrong = inside.number("fov", 190.0, 0.0..180.0, "below 180").unwrap_err();
        assert_eq!(wrong.to_string(), "study.toml: sensor \"camera\".fov = 190: must be below 180");
        assert_eq!(inside.says("no poses").to_string(), "study.toml: sensor \"camera\": no poses");
        assert_eq!(at.says("no scene").to_string(), "study.toml: no scene");
        for value in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300] {
            assert!(inside.vector("position_m", [0.0, value, 0.0]).is_err(), "{value}");
            assert!(inside.number("fov", value, -1.0..=1.0, "x").is_err(), "{value}");
        }
    }

    #[test]
    fn one_choice_is_one_choice() {
        let at = Place::new(Path::new("study.toml"));
        let choose =
            |a, b| only_one(&at, "shape", vec![("sphere", a), ("box", b)]).map_err(|e| e.to_string());
        assert_eq!(choose(Some(1), None), Ok(1));
        assert_eq!(choose(None, Some(2)), Ok(2));
        assert_eq!(choose(None, None).unwrap_err(), "study.toml: no shape: give one of sphere, box");
        assert_eq!(choose(Some(1), Some(2)).unwrap_err(), "study.toml: both sphere and box: give one shape");
    }
}
