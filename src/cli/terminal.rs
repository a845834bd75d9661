//! All text for standard output and standard error passes through here and is escaped, since it may quote an untrusted
//! file.

use std::borrow::Cow;
use std::io::{ErrorKind, Write, stderr, stdout};

use perirobot_march::{Error, Result};
use perirobot_scene::shell;

/// Writes to standard output; a closed reader (`| head`) is not an error.
pub(super) fn print(text: &str) -> Result<()> {
    match stdout().write_all(harmless(text).as_bytes()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::device(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// Writes the next command, as the last line.
pub(super) fn print_next(words: &[impl AsRef<str>]) -> Result<()> {
    print(&format!("next: {}\n", shell::command(words)))
}

/// Writes a line on standard error at once; a failure is ignored.
pub(super) fn say(line: &str) {
    let _ = stderr().write_all(format!("{}\n", harmless(line)).as_bytes());
}

/// Escapes everything that controls a terminal: control characters except line feeds and tabs, and characters that
/// change the direction of writing.
pub(super) fn harmless(text: &str) -> Cow<'_, str> {
    if !text.contains(controls_terminal) {
        return text.into();
    }
    let escape = |c: char| if controls_terminal(c) { c.escape_unicode().to_string() } else { c.into() };
    text.chars().map(escape).collect()
}

fn controls_terminal(c: char) -> bool {
    let turns =
        matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && !matches!(c, '\n' | '\t'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
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
