//! Splits the text of a STEP file (ISO 10303-21) into its entities, with the places of their words in the text, so that
//! a file can be changed at one place and stay the same elsewhere. A text that is no valid STEP file gives fewer
//! entities and no error: its converter reports what is wrong.

use std::ops::Range;

/// A word of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Token<'a> {
    /// The number of an entity: `#12`.
    Reference(u64),
    /// A string without its quotes, as written.
    Text(&'a [u8]),
    /// One of `( ) , ; =`.
    Sign(u8),
    /// Anything else: keywords, numbers, enumerations, `$`, `*`.
    Word(&'a [u8]),
}

/// A word and its place.
pub(super) type Placed<'a> = (Token<'a>, Range<usize>);

/// The words of a text from a place on.
struct Tokens<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Tokens<'a> {
    /// The place behind the next such bytes, or the end of the text.
    fn end_after(&self, from: usize, bytes: &[u8]) -> usize {
        let rest = self.text.get(from..).unwrap_or_default();
        rest.windows(bytes.len())
            .position(|w| w == bytes)
            .map_or(self.text.len(), |at| from + at + bytes.len())
    }

    /// The place behind the bytes of a kind.
    fn end_while(&self, from: usize, is_inside: impl Fn(u8) -> bool) -> usize {
        let rest = self.text.get(from..).unwrap_or_default();
        from + rest.iter().position(|byte| !is_inside(*byte)).unwrap_or(rest.len())
    }

    /// The place behind a string that begins at a place; two quotes in it are one that it contains.
    fn end_of_string(&self, from: usize) -> usize {
        let mut end = self.end_after(from + 1, b"'");
        while self.text.get(end) == Some(&b'\'') {
            end = self.end_after(end + 1, b"'");
        }
        end
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = Placed<'a>;

    fn next(&mut self) -> Option<Placed<'a>> {
        loop {
            self.at = self.end_while(self.at, |byte| byte.is_ascii_whitespace() || byte.is_ascii_control());
            match self.text.get(self.at..)? {
                [b'/', b'*', ..] => self.at = self.end_after(self.at + 2, b"*/"),
                [] => return None,
                _ => break,
            }
        }
        let from = self.at;
        let token = match self.text[from] {
            b'\'' => {
                self.at = self.end_of_string(from);
                Token::Text(self.text.get(from + 1..self.at - 1).unwrap_or_default())
            }
            b'#' => {
                self.at = self.end_while(from + 1, |byte| byte.is_ascii_digit());
                let digits = str::from_utf8(&self.text[from + 1..self.at]).unwrap_or_default();
                digits.parse().map_or(Token::Word(&self.text[from..self.at]), Token::Reference)
            }
            sign @ (b'(' | b')' | b',' | b';' | b'=') => {
                self.at = from + 1;
                Token::Sign(sign)
            }
            _ => {
                let is_inside = |byte: u8| !byte.is_ascii_whitespace() && !b"(),;='#/".contains(&byte);
                self.at = self.end_while(from + 1, is_inside);
                Token::Word(&self.text[from..self.at])
            }
        };
        Some((token, from..self.at))
    }
}

/// Calls a function for each entity of a file, in its order: its number, and the words between `=` and `;`.
pub(super) fn for_each_entity<'a>(text: &'a [u8], mut call: impl FnMut(u64, &[Placed<'a>])) {
    let mut statement = Vec::new();
    for token in (Tokens { text, at: 0 }) {
        if token.0 != Token::Sign(b';') {
            statement.push(token);
            continue;
        }
        if let [(Token::Reference(number), _), (Token::Sign(b'='), _), body @ ..] = &statement[..] {
            call(*number, body);
        }
        statement.clear();
    }
}

/// The records of an entity, each a keyword and the words between its brackets: one, or several of `( A() B() )`.
pub(super) fn records<'a, 'b>(body: &'b [Placed<'a>]) -> Vec<(&'a [u8], &'b [Placed<'a>])> {
    let mut rest = match body {
        [(Token::Sign(b'('), _), inside @ .., (Token::Sign(b')'), _)] => inside,
        _ => body,
    };
    let mut records = Vec::new();
    while let [(Token::Word(keyword), _), (Token::Sign(b'('), _), behind @ ..] = rest {
        let end = end_of_list(behind);
        records.push((*keyword, &behind[..end]));
        rest = behind.get(end + 1..).unwrap_or_default();
    }
    records
}

/// How many words a list has whose opening bracket is before them.
fn end_of_list(words: &[Placed]) -> usize {
    let mut depth = 1;
    let closes = words.iter().position(|(token, _)| {
        match token {
            Token::Sign(b'(') => depth += 1,
            Token::Sign(b')') => depth -= 1,
            _ => {}
        }
        depth == 0
    });
    closes.unwrap_or(words.len())
}

/// The arguments of a record, each of one or more words.
pub(super) fn arguments<'a, 'b>(record: &'b [Placed<'a>]) -> Vec<&'b [Placed<'a>]> {
    let mut depth = 0_usize;
    let split = record.split(|(token, _)| {
        match token {
            Token::Sign(b'(') => depth += 1,
            Token::Sign(b')') => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0 && *token == Token::Sign(b',')
    });
    split.collect()
}

/// The numbers of entities among words.
pub(super) fn references(words: &[Placed]) -> impl Iterator<Item = u64> {
    words.iter().filter_map(|(token, _)| match token {
        Token::Reference(number) => Some(*number),
        _ => None,
    })
}

/// The text that a string stands for: `''` is a quote, and letters beyond ASCII are `\X\E9`, `\X2\00E9\X0\`,
/// `\X4\0001F600\X0\` or `\S\i`, or the bytes of UTF-8.
pub(super) fn decode(written: &[u8]) -> String {
    let written = String::from_utf8_lossy(written).replace("''", "'");
    let mut rest = &*written;
    let mut text = String::new();
    while let Some((plain, escape)) = rest.split_once('\\') {
        text.push_str(plain);
        let (letters, behind) = escaped(escape).unwrap_or_else(|| ("\\".into(), escape));
        text.push_str(&letters);
        rest = behind;
    }
    text + rest
}

/// The letters of an escape, given the text behind its backslash, and what is behind the escape.
fn escaped(escape: &str) -> Option<(String, &str)> {
    if let Some(behind) = escape.strip_prefix('\\') {
        return Some(("\\".into(), behind));
    }
    let (kind, behind) = escape.split_once('\\')?;
    match kind {
        "X" => {
            let letter = char::from(u8::from_str_radix(behind.get(..2)?, 16).ok()?);
            Some((letter.into(), &behind[2..]))
        }
        "S" => {
            let letter = behind.chars().next().filter(char::is_ascii)?;
            Some((char::from(letter as u8 | 0x80).into(), &behind[1..]))
        }
        "X2" | "X4" => {
            let (digits, behind) = behind.split_once("\\X0\\")?;
            let width = if kind == "X2" { 4 } else { 8 };
            let numbers = digits.as_bytes().chunks(width).map(|digits| {
                (digits.len() == width).then(|| u32::from_str_radix(str::from_utf8(digits).ok()?, 16).ok())?
            });
            let numbers = numbers.collect::<Option<Vec<u32>>>()?;
            let letters = match kind {
                "X2" => String::from_utf16_lossy(&numbers.iter().map(|n| *n as u16).collect::<Vec<_>>()),
                _ => numbers
                    .iter()
                    .map(|n| char::from_u32(*n).unwrap_or(char::REPLACEMENT_CHARACTER))
                    .collect(),
            };
            Some((letters, behind))
        }
        // The alphabet of `\S\`: `\PA\` is ISO 8859-1, which is assumed.
        _ if kind.len() == 2 && kind.starts_with('P') => Some((String::new(), behind)),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
