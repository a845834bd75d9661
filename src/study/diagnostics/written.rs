//! A file as it is written, in which the places of wrong keys and values are found again.

use std::cell::OnceCell;
use std::convert::Infallible;
use std::fmt;
use std::ops::Range;

use serde::Deserializer;
use serde::de::{self, Visitor};
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue, ValueDeserializer};

use super::unreadable::{Step, Unread, Unreadable};

/// The first line of a text that was made from keys in memory. Users have never seen its lines, so errors name its keys
/// only.
pub const IN_MEMORY: &str = "# made in memory\n";

/// A file as it is written. It is read for its places once, when the first is looked for.
pub(crate) struct Written<'a> {
    text: &'a str,
    table: OnceCell<Option<Spanned<DeTable<'a>>>>,
}

impl<'a> Written<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Written { text, table: OnceCell::new() }
    }

    fn table(&self) -> Option<&Spanned<DeTable<'a>>> {
        let parse = || DeTable::parse(self.text).ok().filter(|_| !self.text.starts_with(IN_MEMORY));
        self.table.get_or_init(parse).as_ref()
    }

    /// The line on which the last key stands.
    pub(crate) fn line_of(&self, steps: &[Step]) -> Option<usize> {
        Some(line_at(self.text, place_of(self.table()?.get_ref(), steps)?))
    }

    /// An error in words below the line that it is about, as the `toml` crate shows those of syntax, and with
    /// what may be meant.
    pub(crate) fn show(&self, error: &Unreadable) -> String {
        let bytes = self.table().and_then(|table| bytes_of(table, error));
        let shown =
            bytes.map_or(error.to_string(), |bytes| narrow(&place_message(self.text, bytes, &error.message)));
        format!("{}{}", shown.trim_end(), error.suggestion())
    }
}

/// Finds the line on which the last of some keys stands.
pub(crate) type LineOf<'a> = &'a dyn Fn(&[Step]) -> Option<usize>;

/// An error in words, with the line of the file that it is about, where that is found at `within` or below,
/// and with what may be meant.
pub(crate) fn describe(error: &Unreadable, line_of: LineOf, within: &[Step]) -> String {
    let culprit = error.culprit();
    // What is missing stands on no line.
    let line = if culprit.is_empty() { None } else { line_of(&[within, &culprit].concat()) };
    let line = line.map_or(String::new(), |line| format!(" (line {line})"));
    format!("{error}{line}{}", error.suggestion())
}

/// The line of a byte, counted from 1.
pub(crate) fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|b| *b == b'\n').count()
}

/// The byte at which the last key begins.
pub(crate) fn place_of(table: &DeTable, steps: &[Step]) -> Option<usize> {
    Some(find(table, steps)?.0.span().start)
}

/// The bytes that an error is about: a key that is unknown, a value that is wrong, or a table that lacks a key.
fn bytes_of(table: &Spanned<DeTable>, error: &Unreadable) -> Option<Range<usize>> {
    match &error.kind {
        Unread::UnknownKey(..) => Some(find(table.get_ref(), &error.culprit())?.0.span()),
        _ if error.steps.is_empty() => Some(table.span()),
        _ => Some(find(table.get_ref(), &error.steps)?.1.span()),
    }
}

/// A message below the line in which some bytes begin. A value that stands in those bytes is refused with that
/// message, so that the `toml` crate draws the line and marks the bytes itself.
fn place_message(text: &str, bytes: Range<usize>, message: &str) -> String {
    struct Refusal<'a>(&'a str);

    impl Visitor<'_> for Refusal<'_> {
        type Value = Infallible;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("nothing")
        }

        fn visit_bool<E: de::Error>(self, _: bool) -> Result<Infallible, E> {
            Err(E::custom(self.0))
        }
    }

    let value = Spanned::new(bytes, DeValue::Boolean(true));
    let Err(mut refused) = ValueDeserializer::from(value).deserialize_bool(Refusal(message));
    refused.set_input(Some(text));
    refused.to_string()
}

/// Most characters of a line of the file that a message shows, and how many of them are before the marked ones.
const MOST_SHOWN: usize = 160;
const SHOWN_BEFORE: usize = 60;

/// A message of the `toml` crate with a part only of a line that is too long for a screen: the part around the marks
/// in the next line.
pub(crate) fn narrow(message: &str) -> String {
    let mut lines: Vec<String> = message.lines().map(String::from).collect();
    let is_marks = |line: &str| line.contains('^') && line.chars().all(|c| " |^".contains(c));
    let Some(at) = lines.iter().position(|line| is_marks(line)).filter(|at| *at > 0) else {
        return message.into();
    };
    // Both lines begin with a number or spaces, a bar and a space.
    let margin = lines[at].find('|').map_or(0, |bar| bar + 2);
    let count = lines[at - 1].chars().count();
    if count <= margin + MOST_SHOWN {
        return message.into();
    }
    let marks = lines[at].matches('^').count();
    let first = lines[at].find('^').map_or(0, |first| first - margin);
    let from = first.saturating_sub(SHOWN_BEFORE);
    let part = |line: &str, from: usize, most: usize| -> String {
        line.chars().skip(margin + from).take(most).collect()
    };
    let [before, after] =
        [from > 0, count > margin + from + MOST_SHOWN].map(|cut| if cut { "…" } else { "" });
    let head: String = lines[at - 1].chars().take(margin).collect();
    let shown = part(&lines[at - 1], from, MOST_SHOWN);
    let marked = "^".repeat(marks.min(MOST_SHOWN - (first - from)));
    let space = " ".repeat(first - from + before.chars().count());
    lines[at] = format!("{}{space}{marked}", &lines[at][..margin]);
    lines[at - 1] = format!("{head}{before}{shown}{after}");
    lines.join("\n")
}

/// The last key of some steps, and the value to which they lead.
fn find<'a, 'i>(
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
    use std::collections::BTreeMap;

    use serde::Deserialize;

    use super::super::reader::read;
    use super::*;
    use crate::keys::{AxisValues, exactly};

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

    #[test]
    fn the_line_is_that_of_the_entry_that_is_wrong() {
        let text = "[[sensor]]\n[[sensor.poses]]\nx = 1\n[[sensor.poses]]\nx = [1, \"2\"]\n";
        let steps = vec![Step::Key("poses".into()), Step::Entry(1), Step::Key("x".into()), Step::Entry(1)];
        let error = Unreadable { kind: Unread::Value, message: "no".into(), steps };
        let within = [Step::Key("sensor".into()), Step::Entry(0)];
        let written = Written::new(text);
        assert_eq!(describe(&error, &|steps| written.line_of(steps), &within), "no in `poses.x` (line 5)");
    }

    #[test]
    fn of_a_long_line_the_wrong_part_is_shown() {
        let long = format!("seed = [{}oops, {}]", "1, ".repeat(500_000), "2, ".repeat(500_000));
        let shown = narrow(&toml::from_str::<toml::Table>(&long).unwrap_err().to_string());
        let lines: Vec<&str> = shown.lines().collect();
        assert!(shown.len() < 1000 && lines[0].contains("line 1, column "), "{shown}");
        let marked = lines[3].chars().position(|c| c == '^').unwrap();
        assert_eq!(lines[2].chars().skip(marked).take(4).collect::<String>(), "oops", "{shown}");
        assert!(lines[2].starts_with("1 | …") && lines[2].ends_with('…'), "{shown}");
        let end = narrow("TOML\n  |\n1 | a\n  | ^\nno");
        assert_eq!(end, "TOML\n  |\n1 | a\n  | ^\nno");
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "it is only read")]
    struct SampleCell {
        seed: u32,
        fusion: Option<SampleWord>,
        grid: Option<SampleGrid>,
        #[serde(default)]
        body: Vec<SampleBody>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "it is only read")]
    struct SampleGrid {
        size_m: f64,
        outer: Option<SampleBody>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "it is only read")]
    struct SampleBody {
        name: String,
        #[serde(default, deserialize_with = "exactly")]
        position_m: [f64; 3],
        x_m: Option<AxisValues>,
        spots: Option<Vec<Spot>>,
        joints: Option<BTreeMap<String, f64>>,
        grid: Option<Box<SampleGrid>>,
    }

    #[derive(Debug, Deserialize)]
    #[expect(dead_code, reason = "it is only read")]
    struct Spot(#[serde(deserialize_with = "exactly")] [f64; 2]);

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum SampleWord {
        Caution,
        Odds,
    }

    #[test]
    fn errors_are_shown_where_the_crate_shows_them() {
        for text in [
            "",
            "\n\n",
            "sed = 1",
            "seed = 1\n\n  sed = 2\n",
            "seed = -1",
            "seed = \"five\"",
            "  seed = 1.5 # a comment",
            "seed = [1]",
            "seed = {}",
            "seed = 1\nfusion = \"cuation\"",
            "seed = 1\nfusion = 3",
            "seed = 1\nfusion = [\"odds\"]",
            "seed = 1\ngrid = 3",
            "seed = 1\ngrid = \"no\"",
            "seed = 1\ngrid = true",
            "seed = 1\ngrid = 1.5",
            "seed = 1\ngrid = {}",
            "seed = 1\n[grid]\n",
            "seed = 1\n[grid]",
            "seed = 1\n[grid]\nsize = 1\n",
            "seed = 1\ngrid.size = 1",
            "seed = 1\ngrid.size_m = \"1\"",
            "seed = 1\ngrid.outer.nam = \"a\"",
            "seed = 1\ngrid.outer.name = 1",
            "seed = 1\n[grid.outer]\nname = \"a\"\n",
            "seed = 1\n[grid]\nsize_m = 1\n[grid.outer]\n",
            "seed = 1\ngrid = { size_m = 1, outer = { name = \"a\", x = 2 } }",
            "seed = 1\nbody = 1",
            "seed = 1\nbody = [1]",
            "seed = 1\nbody = {}",
            "seed = 1\nbody = [{ name = \"a\" }, { nam = \"b\" }]",
            "seed = 1\nbody = [\n  { name = \"a\" },\n  { name = 2 },\n]",
            "seed = 1\n[[body]]\nname = \"a\"\n[[body]]\n",
            "seed = 1\n[[body]]\nname = \"a\"\n\n[[body]]\nname = \"b\"\nwrong = 1\n",
            "seed = 1\n[[body]]\nname = \"a\"\n[[body]]\nname = 1\n",
            "seed = 1\n[[body]]\nname = \"a\"\n[body.grid]\nsize_m = \"1\"\n",
            "seed = 1\n[[body]]\nname = \"a\"\n[body.grid]\n\n[[body]]\nname = \"b\"\n",
            "seed = 1\n[[body]]\nname = \"a\"\ngrid.outer.name = 1\n",
            "seed = 1\n[[body]]\nname = \"a\"\nposition_m = [1, 2]\n",
            "seed = 1\n[[body]]\nname = \"a\"\nposition_m = [1, 2, \"3\"]\n",
            "seed = 1\n[[body]]\nname = \"a\"\nposition_m = [\n  1,\n  2,\n  true, # no number\n]\n",
            "seed = 1\n[[body]]\nname = \"a\"\nposition_m = [\n  1,\n  2,\n]\n",
            "seed = 1\n[[body]]\nname = \"a\"\nx_m = \"1\"\n",
            "seed = 1\n[[body]]\nname = \"a\"\nx_m = { start = 1, stop = 2 }\n",
            "seed = 1\n[[body]]\nname = \"a\"\nx_m = { start = 1, stop = 2, setp = 1 }\n",
            "seed = 1\n[[body]]\nname = \"a\"\nx_m = { start = 1, stop = 2, step = \"1\" }\n",
            "seed = 1\n[[body]]\nname = \"a\"\nx_m = [1, [2]]\n",
            "seed = 1\n[[body]]\nname = \"a\"\nspots = [[0, 0], [0, 1, 2]]\n",
            "seed = 1\n[[body]]\nname = \"a\"\nspots = [[0, 0], [0, \"1\"]]\n",
            "seed = 1\n[[body]]\nname = \"a\"\nspots = [[0, 0], 1]\n",
            "seed = 1\n[[body]]\nname = \"a\"\njoints = { \"größe\" = 1, \"b c\" = \"x\" }\n",
            "seed = 1\n[[body]]\nname = \"a\"\njoints = [1]\n",
            "body = [{ name = \"Straße ∞ 🤖\", \"größe\" = 1 }]\nseed = 1",
            "body = [{ name = \"Straße ∞ 🤖\", x_m = \"ß\" }] # ∞\nseed = 1",
            "seed = 1\r\n[grid]\r\nsize = 1\r\n",
            "seed = \"1\"\r\n",
            "# ∞\r\nseed = 1\r\nbody = [\r\n  { name = \"a\" },\r\n  { name = 2 },\r\n]\r\n",
            "\u{feff}sed = 1",
        ] {
            let crates = toml::from_str::<SampleCell>(text).expect_err(text);
            let own = read::<SampleCell>(toml::from_str::<toml::Table>(text).unwrap()).expect_err(text);
            // The place is the crate's, the words are ours.
            let expected = crates.to_string().replace(crates.message(), &own.message);
            assert_eq!(
                Written::new(text).show(&own),
                expected.trim_end().to_owned() + &own.suggestion(),
                "{text}"
            );
        }
    }
}
