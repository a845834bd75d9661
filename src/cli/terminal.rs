//! All text for standard output and standard error passes here, since it may quote a stranger's file.

use std::borrow::Cow;
use std::io::{ErrorKind, Write, stderr, stdout};

use perirobot_march::{Error, Result};
use perirobot_scene::shell;

/// Writes to standard output; it is no error if the reader has gone (`| head`).
pub(super) fn print(text: &str) -> Result<()> {
    match stdout().write_all(harmless(text).as_bytes()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::device(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// Writes the command that comes next, as the last line.
pub(super) fn print_next(words: &[impl AsRef<str>]) -> Result<()> {
    print(&format!("next: {}\n", shell::command(words)))
}

/// Writes a line on standard error at once; a failure is ignored.
pub(super) fn say(line: &str) {
    let _ = stderr().write_all(format!("{}\n", harmless(line)).as_bytes());
}

/// Text in which everything that would control a terminal is escaped: control characters except line feeds
/// and tabs, and characters that change the direction of writing.
pub(super) fn harmless(text: &str) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return text.into();
    }
    let spelt = |c: char| if is_obeyed(c) { c.escape_unicode().to_string() } else { c.into() };
    text.chars().map(spelt).collect()
}

fn is_obeyed(c: char) -> bool {
    let turns =
        matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && !matches!(c, '\n' | '\t'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_terminals_obey_is_spelt_out() {
        for (text, expected) in [
            ("wände\n\tF1 – 0.5 · 机器人", "wände\n\tF1 – 0.5 · 机器人"),
            ("\u{1b}[2J", "\\u{1b}[2J"),
            ("\rerror\u{7}\u{9b}31m", "\\u{d}error\\u{7}\\u{9b}31m"),
            ("a\u{202e}b\u{2066}c\u{2028}d", "a\\u{202e}b\\u{2066}c\\u{2028}d"),
        ] {
            assert_eq!(harmless(text), expected);
        }
    }
}
