//! What is wrong with a study, and in which line of its text.

use std::path::Path;

use perirobot_march::Error;
use perirobot_march::error::{Site, What};
use serde::Serialize;
use toml_edit::{Document, Item, Value};

/// Something that is wrong with a study or its files.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Problem {
    /// The line of the study's text, counted from 1, if it is in the text and can be found.
    pub line: Option<usize>,
    /// What is wrong, and what would be right.
    pub words: String,
}

impl Problem {
    /// Of an error about a study with this text in this file.
    pub fn new(error: &Error, path: &Path, text: &str) -> Problem {
        Problem { line: line(error, path, text), words: error.to_string() }
    }
}

/// How the parser of TOML begins, before the line.
const PARSER_SAYS: &str = "TOML parse error at ";

/// The line that an error is about: as its parser says, else where the key or the table is that it names.
fn line(error: &Error, path: &Path, text: &str) -> Option<usize> {
    let issue = error.issue();
    let mut sites = issue.sites.iter();
    match sites.next()? {
        Site::File(file) if file == path => {}
        _ => return None,
    }
    let mut names: Vec<String> = Vec::new();
    for site in sites {
        match site {
            Site::Part(part) | Site::Table(part) | Site::Key(part) | Site::Subject(part) => {
                if let Some(line) = written_line(part) {
                    return Some(line);
                }
                names.extend(parts(part));
            }
            Site::File(_) | Site::Argument(..) => break,
        }
    }
    match &*issue.what {
        What::Value { key, .. } | What::Missing(key) => names.extend(parts(key)),
        What::Says(words) => {
            if let Some((_, place)) = words.to_string().split_once(PARSER_SAYS) {
                return written_line(place);
            }
        }
        _ => {}
    }
    if names.is_empty() {
        return None;
    }
    let document = Document::parse(text).ok()?;
    let begin = find(document.as_item(), &names)?;
    Some(1 + text.get(..begin)?.matches('\n').count())
}

/// The line that a parser names, as in `line 12, column 3`.
fn written_line(part: &str) -> Option<usize> {
    let digits = part.strip_prefix("line ")?;
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

/// The steps of a place such as `sensor "left cam".poses "wall".list[3]`; dots in names are kept.
fn parts(place: &str) -> Vec<String> {
    let (mut all, mut part, mut quoted) = (Vec::new(), String::new(), false);
    for letter in place.chars() {
        quoted ^= letter == '"';
        match letter {
            '.' if !quoted => all.push(std::mem::take(&mut part)),
            _ => part.push(letter),
        }
    }
    all.push(part);
    all.retain(|part| !part.is_empty());
    all
}

/// Where the deepest of some steps that can be followed begins in the text.
fn find(root: &Item, steps: &[String]) -> Option<usize> {
    let (mut item, mut begin) = (Place::Item(root), None);
    for step in steps {
        let Some(next) = follow(item, step) else { break };
        begin = next.begin().or(begin);
        item = next;
    }
    begin
}

/// A place in a document.
#[derive(Clone, Copy)]
enum Place<'a> {
    Item(&'a Item),
    Table(&'a toml_edit::Table),
    Value(&'a Value),
}

impl<'a> Place<'a> {
    fn begin(self) -> Option<usize> {
        let span = match self {
            Place::Item(item) => item.span(),
            Place::Table(table) => table.span(),
            Place::Value(value) => value.span(),
        };
        span.map(|span| span.start)
    }

    fn get(self, key: &str) -> Option<Place<'a>> {
        match self {
            Place::Item(item) => item.get(key).map(Place::Item),
            Place::Table(table) => table.get(key).map(Place::Item),
            Place::Value(value) => value.as_inline_table()?.get(key).map(Place::Value),
        }
    }

    /// The entries of a list.
    fn entries(self) -> Vec<Place<'a>> {
        match self {
            Place::Item(Item::ArrayOfTables(all)) => all.iter().map(Place::Table).collect(),
            Place::Item(Item::Value(Value::Array(all))) | Place::Value(Value::Array(all)) => {
                all.iter().map(Place::Value).collect()
            }
            _ => Vec::new(),
        }
    }

    fn text(self, key: &str) -> Option<&'a str> {
        match self.get(key)? {
            Place::Item(item) => item.as_str(),
            Place::Value(value) => value.as_str(),
            Place::Table(_) => None,
        }
    }
}

/// Follows a step: `sensor "camera"`, `list[3]` or `fov_deg`.
fn follow<'a>(at: Place<'a>, step: &str) -> Option<Place<'a>> {
    if let Some((key, name)) = step.split_once(' ') {
        let name = name.trim_matches('"');
        let entries = at.get(key)?.entries();
        return entries
            .into_iter()
            .find(|entry| ["name", "object", "file"].iter().any(|own| entry.text(own) == Some(name)));
    }
    match step.strip_suffix(']').and_then(|step| step.split_once('[')) {
        Some((key, number)) => at.get(key)?.entries().get(number.parse::<usize>().ok()?).copied(),
        None => at.get(step),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_march::error::Issue;

    const TEXT: &str = "[grid]\nvoxel_size_m = 0.1\n\n[[sensor]]\nname = \"a.b\"\ncost = 3\n\n[[sensor]]\nname = \"cam\"\n\
                        fov_deg = [1, 2]\n[[sensor.poses]]\nname = \"wall\"\nlist = [\n  { position_m = [0, 0, 0] },\n  \
                        { position_m = [9, 0, 0] },\n]\n";

    #[track_caller]
    fn assert_line(issue: Issue, expected: Option<usize>) {
        let path = Path::new("dir/study.toml");
        let problem = Problem::new(&issue.with_place(path).into(), path, TEXT);
        assert_eq!(problem.line, expected, "{}", problem.words);
    }

    #[test]
    fn the_line_of_a_problem_is_that_of_its_key() {
        assert_line(Issue::value("voxel_size_m", 0, "x").with_place(Site::Table("grid".into())), Some(2));
        assert_line(Issue::value("cost", -1, "x").with_place(Site::Table("sensor \"a.b\"".into())), Some(6));
        let cam = Site::Table("sensor \"cam\".poses \"wall\".list[1]".into());
        assert_line(Issue::value("position_m", 9, "x").with_place(cam.clone()), Some(15));
        assert_line(Issue::says("is odd").with_place(cam), Some(15));
        assert_line(Issue::missing("range_m").with_place(Site::Table("sensor \"cam\"".into())), Some(8));
        assert_line(Issue::says("is no TOML").with_place("line 4, column 2"), Some(4));
        assert_line(Issue::says("TOML parse error at line 5, column 8\n  |"), Some(5));
        assert_line(Issue::says("is odd"), None);
        assert_line(Issue::value("nothing", 1, "x").with_place(Site::Table("nowhere \"x\"".into())), None);
    }

    #[test]
    fn a_problem_of_another_file_has_no_line() {
        let issue = Issue::value("cost", -1, "x").with_place("object").with_place(Path::new("dir/cell.toml"));
        assert_eq!(Problem::new(&issue.into(), Path::new("dir/study.toml"), TEXT).line, None);
    }
}
