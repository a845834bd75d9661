//! Tells which encoding the text of a file has: UTF-8 is read, with or without a byte-order mark, and any other is named.

use perirobot_march::error::Issue;

/// What U+FEFF is in UTF-8; many programs of Windows put it before a text.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Takes the byte-order mark from the bytes of a file that begins with text.
///
/// # Errors
/// When the text is in UTF-16 or UTF-32.
pub(crate) fn strip_mark(mut bytes: Vec<u8>) -> Result<Vec<u8>, Issue> {
    if let Some(encoding) = wide_encoding(&bytes) {
        return Err(Issue::unsupported(format!("is {encoding} text")).with_advice(
            "save it as UTF-8 (PowerShell's > writes UTF-16: `| Out-File -Encoding utf8` does not)",
        ));
    }
    if bytes.starts_with(MARK) {
        bytes.drain(..MARK.len());
    }
    Ok(bytes)
}

/// The text of a file.
///
/// # Errors
/// When it is in another encoding than UTF-8.
pub(super) fn utf8(bytes: Vec<u8>) -> Result<String, Issue> {
    String::from_utf8(strip_mark(bytes)?).map_err(|e| {
        let (at, bytes) = (e.utf8_error().valid_up_to(), e.as_bytes());
        let line = 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count();
        Issue::says(format!("is not UTF-8 text: line {line} has the byte 0x{:02X}", bytes[at]))
            .with_advice("save it as UTF-8")
    })
}

/// The text of an XML file in UTF-8, or in UTF-16 by its mark or by the zero beside its first `<`.
///
/// # Errors
/// When it is in neither.
pub(super) fn utf8_or_utf16(bytes: Vec<u8>) -> Result<String, Issue> {
    let (unit, begin): (fn([u8; 2]) -> u16, usize) = match *bytes {
        [0xff, 0xfe, 0, 0, ..] => return utf8(bytes),
        [0xff, 0xfe, ..] => (u16::from_le_bytes, 2),
        [0xfe, 0xff, ..] => (u16::from_be_bytes, 2),
        [b'<', 0, ..] => (u16::from_le_bytes, 0),
        [0, b'<', ..] => (u16::from_be_bytes, 0),
        _ => return utf8(bytes),
    };
    let (units, rest) = bytes[begin..].as_chunks::<2>();
    let units: Vec<u16> = units.iter().copied().map(unit).collect();
    let text = String::from_utf16(&units).ok().filter(|_| rest.is_empty());
    text.ok_or_else(|| Issue::damaged("is not UTF-16 text all through").with_advice("export it again"))
}

/// The lines of a text, as Windows, Unix or an old Macintosh ends them.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split(if text.contains('\n') { '\n' } else { '\r' })
}

/// The encoding of a text whose characters have two or four bytes, by its mark, or by the zeros in its first two
/// characters.
fn wide_encoding(bytes: &[u8]) -> Option<&'static str> {
    let is_letter = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    match *bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] if is_letter(a) && is_letter(b) => Some("UTF-16"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn xml_may_be_utf16() {
        let text = "<MIB>Gehäuse 𝄞</MIB>";
        let wide = |text: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(bytes).collect()
        };
        let marked = format!("\u{feff}{text}");
        for bytes in [
            text.as_bytes().to_vec(),
            marked.as_bytes().to_vec(),
            wide(text, u16::to_le_bytes),
            wide(text, u16::to_be_bytes),
            wide(&marked, u16::to_le_bytes),
            wide(&marked, u16::to_be_bytes),
        ] {
            assert_eq!(utf8_or_utf16(bytes).unwrap(), text);
        }
        let mut cut = wide(&marked, u16::to_le_bytes);
        cut.pop();
        let lone = [0xff, 0xfe, 0x00, 0xd8, b'a', 0].to_vec();
        for (bytes, expected) in [
            (cut, "is not UTF-16 text all through"),
            (lone, "is not UTF-16 text all through"),
            (b"\xff\xfe\0\0<\0\0\0".to_vec(), "is UTF-32 text"),
            (b"<a>\xe4</a>".to_vec(), "is not UTF-8 text: line 1"),
        ] {
            let said = utf8_or_utf16(bytes).unwrap_err().to_string();
            assert!(said.starts_with(expected), "{said}");
        }
    }

    #[test]
    fn encodings_are_told_by_their_first_bytes() {
        let wide =
            |text: &str, bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<_>>();
        for (bytes, expected) in [
            (b"v 0 0 0".to_vec(), Ok("v 0 0 0")),
            (b"\xef\xbb\xbfsolid".to_vec(), Ok("solid")),
            (Vec::new(), Ok("")),
            (wide("\u{feff}solid", u16::to_le_bytes), Err("is UTF-16 text: save it as UTF-8")),
            (wide("\u{feff}solid", u16::to_be_bytes), Err("is UTF-16 text")),
            (wide("<sdf>", u16::to_le_bytes), Err("is UTF-16 text")),
            (wide("<sdf>", u16::to_be_bytes), Err("is UTF-16 text")),
            (b"\xff\xfe\0\0v\0\0\0".to_vec(), Err("is UTF-32 text")),
            (b"a\nGeh\xe4use".to_vec(), Err("is not UTF-8 text: line 2 has the byte 0xE4: save it as UTF-8")),
        ] {
            let read = utf8(bytes.clone()).map_err(|issue| issue.to_string());
            match (&read, expected) {
                (Ok(read), Ok(expected)) => assert_eq!(read, expected),
                (Err(read), Err(expected)) => assert!(read.contains(expected), "{read}"),
                _ => panic!("{bytes:?} is read as {read:?}"),
            }
        }
    }
}
