//! Describes what is wrong as a value: where, what, and what would be right.

use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::words::{Argument, NameOf, Words};

/// What is wrong, where, and what would be right. A function that does not know the file says what is wrong,
/// and its callers add the places around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Issue {
    /// Where it is, the outermost place first.
    pub sites: Vec<Site>,
    /// What is wrong.
    pub what: Box<What>,
    /// What would be right.
    pub wanted: Option<Words>,
    /// What helps otherwise.
    pub cures: Vec<Words>,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A key has a value that cannot be right.
    Value {
        /// The key.
        key: String,
        /// Its value, as it is written.
        value: String,
    },
    /// Something that must be given is missing.
    Missing(String),
    /// The name of the place is none of those known.
    Unknown {
        /// All names that would be right.
        known: Vec<String>,
    },
    /// A file ends too early, or contradicts itself.
    Damaged(Words),
    /// The file is valid, but uses a feature that is not read here.
    Unsupported(Words),
    /// More than can be worked on.
    TooLarge(Words),
    /// The system does not let the place be read, written, made, …
    Io {
        /// What could not be done.
        doing: Words,
        /// Why, as the system sorts it.
        kind: ErrorKind,
        /// Why, in the system's words.
        source: String,
    },
    /// Anything else, as a sentence whose subject is the place.
    Says(Words),
}

/// Where an issue is.
#[derive(Clone, Debug, PartialEq)]
pub enum Site {
    /// In a file or a folder.
    File(PathBuf),
    /// In an argument, with the value that was given.
    Argument(Argument, String),
    /// In this part of it: an object, a line.
    Part(String),
    /// In this table of keys.
    Table(String),
    /// In what the value of this key names.
    Key(String),
    /// The subject of the sentence that follows.
    Subject(String),
}

impl Issue {
    /// Anything that is wrong, as a sentence.
    pub fn says(what: impl Into<Words>) -> Issue {
        Issue::new(What::Says(what.into()))
    }

    /// A wrong value of a key, and the rule that it breaks.
    pub fn value(key: impl Into<String>, value: impl fmt::Display, wanted: impl Into<Words>) -> Issue {
        Issue::new(What::Value { key: key.into(), value: value.to_string() }).with_advice(wanted)
    }

    /// Something that must be given is missing.
    pub fn missing(key: impl Into<String>) -> Issue {
        Issue::new(What::Missing(key.into()))
    }

    /// A name that is none of those known.
    pub fn unknown(known: &[impl AsRef<str>]) -> Issue {
        Issue::new(What::Unknown { known: known.iter().map(|name| name.as_ref().into()).collect() })
    }

    /// A file that ends too early, or contradicts itself.
    pub fn damaged(what: impl Into<Words>) -> Issue {
        Issue::new(What::Damaged(what.into()))
    }

    /// A valid file that uses a feature that is not read here.
    pub fn unsupported(what: impl Into<Words>) -> Issue {
        Issue::new(What::Unsupported(what.into()))
    }

    /// Something that this program was built without.
    pub fn left_out(what: impl Into<Words>, feature: &str) -> Issue {
        Issue::says(
            what.into() + format!(" is not in this program, which was built without the feature {feature:?}"),
        )
        .with_advice("build it with cargo's defaults")
    }

    /// More than can be worked on.
    pub fn too_large(what: impl Into<Words>) -> Issue {
        Issue::new(What::TooLarge(what.into()))
    }

    /// An operation that the system refused.
    pub fn io(doing: impl Into<Words>, source: &std::io::Error) -> Issue {
        let (doing, kind) = (doing.into(), source.kind());
        Issue::new(What::Io { doing, kind, source: source.to_string() })
    }

    fn new(what: What) -> Issue {
        Issue { sites: Vec::new(), what: Box::new(what), wanted: None, cures: Vec::new() }
    }

    /// The same, with the place around it.
    #[must_use]
    pub fn with_place(mut self, place: impl Into<Site>) -> Issue {
        self.sites.insert(0, place.into());
        self
    }

    /// The same, with what would be right.
    #[must_use]
    pub fn with_advice(mut self, wanted: impl Into<Words>) -> Issue {
        self.wanted = Some(wanted.into());
        self
    }

    /// The same, with what helps otherwise.
    #[must_use]
    pub fn cure(mut self, cure: impl Into<Words>) -> Issue {
        self.cures.push(cure.into());
        self
    }

    /// The whole as one text, its arguments written by `name_of`.
    pub fn to_text(&self, name_of: NameOf) -> String {
        let mut text = String::new();
        for (i, place) in self.sites.iter().enumerate() {
            let joined = match (place, self.sites.get(i + 1)) {
                (Site::Table(_), Some(_)) => ".",
                (Site::Table(_), None) if matches!(*self.what, What::Value { .. }) => ".",
                (Site::Key(_), _) => " = ",
                (Site::Subject(_), _) => " ",
                _ => ": ",
            };
            text += &(place.to_text(name_of) + joined);
        }
        text += &match &*self.what {
            What::Value { key, value } => format!("{key} = {value}"),
            What::Missing(key) => format!("no {key}"),
            What::Unknown { known } => format!("does not exist; there are {}", known.join(", ")),
            What::Io { doing, source, .. } => format!("{}: {source}", doing.to_text(name_of)),
            What::Damaged(what) | What::Unsupported(what) | What::TooLarge(what) | What::Says(what) => {
                what.to_text(name_of)
            }
        };
        let before = if matches!(*self.what, What::Io { .. }) { ". " } else { ": " };
        let wanted = self.wanted.iter().map(|wanted| format!("{before}{}", wanted.to_text(name_of)));
        let cures = self.cures.iter().map(|cure| format!("; {}", cure.to_text(name_of)));
        text.extend(wanted.chain(cures));
        shorten_lines(text)
    }
}

/// Most characters of a line of a message, and how many of its end are kept of a longer one.
const MOST_OF_LINE: usize = 2000;
const KEPT_OF_END: usize = 500;

/// A text without the middle of lines that are too long to read: what is quoted may be of any length.
fn shorten_lines(text: String) -> String {
    // No text of so few bytes has a line of more characters.
    if text.len() <= MOST_OF_LINE {
        return text;
    }
    let line = |line: &str| {
        let count = line.chars().count();
        if count <= MOST_OF_LINE {
            return line.to_string();
        }
        let begin: String = line.chars().take(MOST_OF_LINE - KEPT_OF_END).collect();
        let end: String = line.chars().skip(count - KEPT_OF_END).collect();
        format!("{begin} … ({} characters left out) … {end}", count - MOST_OF_LINE)
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

impl fmt::Display for Issue {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.to_text(&|argument| argument.0.into()))
    }
}

impl std::error::Error for Issue {}

impl Site {
    fn to_text(&self, name_of: NameOf) -> String {
        match self {
            Site::File(path) => path.display().to_string(),
            Site::Argument(argument, value) if value.is_empty() => name_of(*argument),
            Site::Argument(argument, value) => format!("{} {value}", name_of(*argument)),
            Site::Part(name) | Site::Table(name) | Site::Key(name) | Site::Subject(name) => name.clone(),
        }
    }
}

impl From<&Path> for Site {
    fn from(path: &Path) -> Site {
        Site::File(path.into())
    }
}

impl From<&PathBuf> for Site {
    fn from(path: &PathBuf) -> Site {
        Site::File(path.into())
    }
}

impl From<PathBuf> for Site {
    fn from(path: PathBuf) -> Site {
        Site::File(path)
    }
}

impl From<String> for Site {
    fn from(name: String) -> Site {
        Site::Part(name)
    }
}

impl From<&str> for Site {
    fn from(name: &str) -> Site {
        Site::Part(name.into())
    }
}

impl From<Argument> for Site {
    fn from(argument: Argument) -> Site {
        Site::Argument(argument, String::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_reads_as_a_sentence() {
        let file = || Site::from(Path::new("study.toml"));
        let camera = || Site::Table("sensor \"camera\"".into());
        let wrong = Issue::value("fov", 190, "must be below 180");
        for (issue, expected) in [
            (
                wrong.clone().with_place(camera()).with_place(file()),
                "study.toml: sensor \"camera\".fov = 190: must be below 180",
            ),
            (wrong.with_place("line 3"), "line 3: fov = 190: must be below 180"),
            (Issue::missing("poses").with_place(camera()), "sensor \"camera\": no poses"),
            (
                Issue::says("is empty")
                    .with_place(file())
                    .with_place(Site::Key("mesh".into()))
                    .with_place(camera()),
                "sensor \"camera\".mesh = study.toml: is empty",
            ),
            (Issue::says("is tilted").with_place(Site::Subject("pose 3".into())), "pose 3 is tilted"),
            (
                Issue::unknown(&["a", "b"]).with_place(Site::Argument(Argument("region"), "c".into())),
                "region c: does not exist; there are a, b",
            ),
            (
                Issue::damaged("is cut off").with_advice("take a whole one").cure("sweep again"),
                "is cut off: take a whole one; sweep again",
            ),
        ] {
            assert_eq!(issue.to_string(), expected);
        }
    }

    #[test]
    fn long_lines_lose_their_middle() {
        let said = |length: usize| {
            let name = "ä".repeat(length);
            Issue::says(format!("{name}\nis wrong")).with_place("study.toml").to_string()
        };
        assert_eq!(
            said(MOST_OF_LINE - 12),
            format!("study.toml: {}\nis wrong", "ä".repeat(MOST_OF_LINE - 12))
        );
        let cut = said(1_000_000);
        assert!(cut.starts_with("study.toml: ää") && cut.ends_with("ä\nis wrong"), "{cut}");
        assert!(cut.contains("ä … (998012 characters left out) … ä"), "{cut}");
        assert!(cut.chars().count() < MOST_OF_LINE + 60);
    }

    #[test]
    fn a_front_writes_settings_its_own_way() {
        let words = Words::from("use `") + Argument("backend").with_value("cpu") + "`";
        let issue = Issue::says("does not fit").with_place(Argument("voxel size")).with_advice(words);
        assert_eq!(issue.to_string(), "voxel size: does not fit: use `backend cpu`");
        let flag = |argument: Argument| format!("--{}", argument.0.replace(' ', "-"));
        assert_eq!(issue.to_text(&flag), "--voxel-size: does not fit: use `--backend cpu`");
    }
}
