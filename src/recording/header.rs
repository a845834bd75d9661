//! The lines of text before the data of a file.

use crate::error::Issue;

/// Hands the words of each line to `take`, with the number of the line, until it returns false, and returns how
/// many bytes those lines are.
///
/// # Errors
/// Those of `take`, and when the file ends before; `last` names the line that is missing then.
pub(super) fn lines(
    bytes: &[u8],
    last: &str,
    mut take: impl FnMut(usize, &[&str]) -> Result<bool, Issue>,
) -> Result<usize, Issue> {
    let mut at = 0;
    for number in 0.. {
        let length = bytes[at..].iter().position(|byte| *byte == b'\n');
        let length = length.ok_or_else(|| Issue::damaged(format!("ends before the line `{last}`")))?;
        let line = String::from_utf8_lossy(&bytes[at..at + length]);
        at += length + 1;
        if !take(number, &line.split_whitespace().collect::<Vec<_>>())? {
            break;
        }
    }
    Ok(at)
}
