//! Where in a text things are: ends of tables, lines, commas and comments.

use std::ops::Range;

use toml_edit::{InlineTable, Item, Table, Value};

/// The end of the last value that stands below the header of a table itself, if it has one.
pub(super) fn own_end(table: &Table) -> Option<usize> {
    let ends = table.iter().filter_map(|(_, item)| match item {
        Item::Value(value) => value.span().map(|span| span.end),
        Item::Table(table) if table.is_dotted() => own_end(table),
        _ => None,
    });
    ends.max()
}

/// The end of all that belongs to an item, the tables below it too.
pub(super) fn whole_end(item: &Item) -> Option<usize> {
    match item {
        Item::None => None,
        Item::Value(value) => value.span().map(|span| span.end),
        Item::Table(table) => {
            let header = table.span().map(|span| span.end);
            table.iter().filter_map(|(_, item)| whole_end(item)).chain(header).max()
        }
        Item::ArrayOfTables(tables) => tables.iter().filter_map(table_end).max(),
    }
}

/// [`whole_end`] of a table.
pub(super) fn table_end(table: &Table) -> Option<usize> {
    let header = table.span().map(|span| span.end);
    table.iter().filter_map(|(_, item)| whole_end(item)).chain(header).max()
}

/// The bytes of a table with a header and of those below it: each from its header to the end of its own values.
pub(super) fn pieces(table: &Table) -> Vec<Range<usize>> {
    let mut all = Vec::new();
    if let Some(header) = table.span().filter(|_| !table.is_dotted() && !table.is_implicit()) {
        all.push(header.start..own_end(table).unwrap_or(header.end));
    }
    for (_, item) in table.iter() {
        match item {
            Item::Table(below) => all.extend(pieces(below)),
            Item::ArrayOfTables(below) => all.extend(below.iter().flat_map(pieces)),
            _ => {}
        }
    }
    all.sort_by_key(|piece| piece.start);
    all
}

/// The keys of an inline table, from where each begins to the end of its value, those of `a.b = 1` by all their names.
pub(super) fn inline_members(text: &str, table: &InlineTable) -> Vec<(Vec<String>, Range<usize>)> {
    let mut all = Vec::new();
    for (name, value) in table.iter() {
        match value {
            Value::InlineTable(dotted) if dotted.is_dotted() => {
                let below = inline_members(text, dotted).into_iter();
                all.extend(below.map(|(names, span)| ([vec![name.into()], names].concat(), span)));
            }
            value => {
                let key = table.key(name).and_then(|key| key.span());
                if let (Some(key), Some(value)) = (key, value.span()) {
                    // The names before the last of a dotted key stand before it.
                    let begin = text[..key.start].rfind([',', '{', '\n']).map_or(0, |place| place + 1);
                    let space = text[begin..key.start].len() - text[begin..key.start].trim_start().len();
                    all.push((vec![name.into()], begin + space..value.end));
                }
            }
        }
    }
    all.sort_by_key(|(_, span)| span.start);
    all
}

/// The first byte of the line in which a byte is.
pub(super) fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |newline| newline + 1)
}

/// The newline at the end of the line in which a byte is, or the end of the text.
pub(super) fn line_end(text: &str, at: usize) -> usize {
    text[at..].find('\n').map_or(text.len(), |newline| at + newline)
}

/// The byte behind the line in which a byte is.
pub(super) fn next_line(text: &str, at: usize) -> usize {
    (line_end(text, at) + 1).min(text.len())
}

/// What stands before a byte in its line, if that is only space.
pub(super) fn indent(text: &str, at: usize) -> Option<&str> {
    let before = &text[line_start(text, at)..at];
    before.trim().is_empty().then_some(before)
}

/// The space at the beginning of a line.
pub(super) fn indent_of_line(text: &str, at: usize) -> &str {
    let line = &text[line_start(text, at)..];
    &line[..line.len() - line.trim_start_matches([' ', '\t']).len()]
}

/// The comma behind a value, space and comments passed over.
pub(super) fn comma_after(text: &str, mut at: usize) -> Option<usize> {
    loop {
        let rest = &text[at..];
        at += rest.len() - rest.trim_start().len();
        match text[at..].chars().next()? {
            ',' => return Some(at),
            '#' => at = line_end(text, at),
            _ => return None,
        }
    }
}

/// Whether nothing but a comment is left in the line.
pub(super) fn is_rest_free(text: &str, at: usize) -> bool {
    let rest = text[at..line_end(text, at)].trim();
    rest.is_empty() || rest.starts_with('#')
}

/// The lines of a part of a text that are comments.
pub(super) fn comment_lines(part: &str) -> String {
    part.split_inclusive('\n').filter(|line| line.trim_start().starts_with('#')).collect()
}
