//! Parses XML, but refuses beforehand what would make the parser slow.

use roxmltree::Document;

use crate::error::Issue;

/// Most attributes of an element. Formats that are read here have ten; the parser compares each with each.
const MOST_ATTRIBUTES: usize = 256;

/// Parses a text.
pub(super) fn parse(text: &str) -> Result<Document<'_>, Issue> {
    if let Some(at) = crowded_element(text) {
        let line = 1 + text[..at].matches('\n').count();
        return Err(Issue::says(format!("an element has more than {MOST_ATTRIBUTES} attributes"))
            .at(format!("line {line}")));
    }
    Document::parse(text).map_err(|e| Issue::damaged(format!("is no XML: {e}")))
}

/// The constructs that are no elements, by how they begin and end.
const NO_ELEMENTS: [[&str; 2]; 3] = [["<!--", "-->"], ["<![CDATA[", "]]>"], ["<?", "?>"]];

/// Where the first element begins that has too many attributes.
fn crowded_element(text: &str) -> Option<usize> {
    let mut at = 0;
    while let Some(next) = text[at..].find('<') {
        at += next;
        let rest = &text[at..];
        let length = match NO_ELEMENTS.iter().find(|[begin, _]| rest.starts_with(begin)) {
            // A construct without an end is left to the parser, which refuses it.
            Some([_, end]) => rest.find(end)?,
            None if attributes(rest) > MOST_ATTRIBUTES => return Some(at),
            None => 1,
        };
        at += length;
    }
    None
}

/// How many attributes the element at the beginning of a text has: signs of equality outside of quotes.
fn attributes(text: &str) -> usize {
    let (mut quote, mut count) = (None, 0);
    for byte in text.bytes().skip(1) {
        match (byte, quote) {
            // No value may hold the beginning of an element.
            (b'<', _) | (b'>', None) => break,
            (byte, Some(open)) if byte == open => quote = None,
            (b'"' | b'\'', None) => quote = Some(byte),
            (b'=', None) => count += 1,
            _ => {}
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(attributes: usize) -> String {
        let attributes: String = (0..attributes).map(|i| format!(" a{i} = '>=\"'")).collect();
        format!("<robot>\n<!-- = -->\n<link{attributes}/></robot>")
    }

    #[test]
    fn an_element_has_few_attributes() {
        assert_eq!(parse(&element(256)).unwrap().root_element().tag_name().name(), "robot");
        for crowded in [element(257), element(200_000), element(257).replace("'>=\"'", "\"'='\"")] {
            assert_eq!(
                parse(&crowded).unwrap_err().to_string(),
                "line 3: an element has more than 256 attributes"
            );
        }
        // Those of many elements, signs in a text, and in what is no element at all.
        let many = format!("<robot>{}{}</robot>", "<link a='1' b='2'/>".repeat(1000), "= ".repeat(1000));
        assert!(parse(&many).is_ok());
        let signs = "< =".repeat(1000);
        assert!(parse(&format!("<?a {signs}?><robot><!--{signs}--><![CDATA[{signs}]]></robot>")).is_ok());
        assert!(parse("<robot a='").unwrap_err().to_string().starts_with("is no XML"));
        assert!(parse("<").unwrap_err().to_string().starts_with("is no XML"));
    }
}
