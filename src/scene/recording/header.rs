//! The lines of text before the data of a file.

use perirobot_march::error::Issue;

/// The longest line of a header; one of every field of a point with descriptors has some thousand bytes.
const LONGEST_LINE: usize = 1 << 16;

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
        let length = bytes[at..].iter().take(LONGEST_LINE + 1).position(|byte| *byte == b'\n');
        if length.is_none() && bytes.len() - at > LONGEST_LINE {
            return Err(Issue::too_large(format!("line {} has more than {LONGEST_LINE} bytes", number + 1))
                .with_advice(format!("is it text up to the line `{last}`?")));
        }
        let length = length.ok_or_else(|| Issue::damaged(format!("ends before the line `{last}`")))?;
        let line = String::from_utf8_lossy(&bytes[at..at + length]);
        at += length + 1;
        if !take(number, &line.split_whitespace().collect::<Vec<_>>())? {
            break;
        }
    }
    Ok(at)
}
