//! Reads XML as tinyxml2 does, by which Gazebo and most of ROS read their files: prefixes need no declaration, comments
//! may hold two hyphens, a bare `&` stands for itself. A scan before parsing rewrites a text so that a strict parser
//! takes it, and refuses what would make that parser slow.
//!
//! No name has a namespace behind the scan: a prefix is a part of the name (`gz.policies`), but for the prefix of the root,
//! which is dropped. So namespaces cost nothing, however many a file declares.

use roxmltree::{Document, Error, Node};

use perirobot_march::error::Issue;

/// Most attributes of an element. Formats that are read here have ten; the parser compares each with each.
const MOST_ATTRIBUTES: usize = 256;

/// The children of a node that have this name.
pub(crate) fn children<'a, 'i>(node: Node<'a, 'i>, name: &str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// A text that was scanned. Its lines are those of the file.
pub(crate) struct Xml(String);

/// The constructs that are left out, by how they begin and end.
const LEFT_OUT: [[&str; 2]; 2] = [["<!--", "-->"], ["<?", "?>"]];
const CDATA: [&str; 2] = ["<![CDATA[", "]]>"];
const DOCTYPE: &str = "<!DOCTYPE";

impl Xml {
    /// Scans a text.
    ///
    /// # Errors
    /// When an element has too many attributes.
    pub(crate) fn scan(text: &str) -> Result<Xml, Issue> {
        let mut plain = String::with_capacity(text.len());
        let mut prefix = None;
        let mut rest = text;
        while let Some(at) = rest.find(['<', '&']) {
            plain.push_str(&rest[..at]);
            rest = &rest[at..];
            let length = match () {
                () if rest.starts_with('&') => push_reference(rest, &mut plain),
                () if rest.starts_with(CDATA[0]) => {
                    let length = rest.find(CDATA[1]).map_or(rest.len(), |end| end + CDATA[1].len());
                    plain.push_str(&rest[..length]);
                    length
                }
                () => match skipped_length(rest) {
                    // The parser refuses it.
                    Some(None) => break,
                    Some(Some(length)) => {
                        plain.extend(rest[..length].matches('\n'));
                        length
                    }
                    None => {
                        let element = Element::parse(rest);
                        let own = prefix.get_or_insert_with(|| element.prefix());
                        if element.write(own, &mut plain) > MOST_ATTRIBUTES {
                            let line = 1 + text[..text.len() - rest.len()].matches('\n').count();
                            return Err(Issue::says(format!(
                                "an element has more than {MOST_ATTRIBUTES} attributes"
                            ))
                            .with_place(format!("line {line}")));
                        }
                        element.text.len()
                    }
                },
            };
            rest = &rest[length..];
        }
        plain.push_str(rest);
        Ok(Xml(plain))
    }

    /// The elements.
    ///
    /// # Errors
    /// When the text is no XML.
    pub(crate) fn document(&self) -> Result<Document<'_>, Issue> {
        if self.0.trim().is_empty() {
            return Err(Issue::damaged("is empty").with_advice("export it again"));
        }
        Document::parse(&self.0).map_err(|e| match e {
            Error::DtdDetected => Issue::unsupported("has a DOCTYPE that declares entities")
                .with_advice("write their values in their places, and leave the DOCTYPE out"),
            e => Issue::damaged(format!("is no XML: {e}")),
        })
    }
}

/// The length of a comment, an instruction or a plain DOCTYPE at the beginning of a text; `None` of one without an end and of a
/// DOCTYPE that declares entities. Outer `None`: the text begins with something else.
fn skipped_length(text: &str) -> Option<Option<usize>> {
    if text.starts_with(DOCTYPE) {
        let end = text.find(['>', '[']).filter(|&end| text[end..].starts_with('>'));
        return Some(end.map(|end| end + 1));
    }
    let [begin, end] = LEFT_OUT.iter().find(|[begin, _]| text.starts_with(begin))?;
    Some(text[begin.len()..].find(end).map(|at| begin.len() + at + end.len()))
}

/// Writes a reference, or an ampersand that is none, and says how long it is in the text.
fn push_reference(text: &str, plain: &mut String) -> usize {
    /// No reference that a parser knows is longer: `&#x10FFFF;`.
    const LONGEST: usize = 12;
    let end = text.bytes().take(LONGEST).position(|byte| byte == b';');
    let name = end.map_or("", |end| &text[1..end]);
    let is_known = ["amp", "lt", "gt", "quot", "apos"].contains(&name)
        || name.strip_prefix("#x").is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_hexdigit()))
        || name.strip_prefix('#').is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()));
    match is_known {
        true => {
            let length = name.len() + 2;
            plain.push_str(&text[..length]);
            length
        }
        false => {
            plain.push_str("&amp;");
            1
        }
    }
}

/// The begin or the end of an element, as it is written: `<name key = "value">`.
struct Element<'t> {
    text: &'t str,
}

impl<'t> Element<'t> {
    /// The one at the beginning of a text, up to its `>`, or to the next `<` outside of quotes.
    fn parse(text: &'t str) -> Self {
        let mut quote = None;
        let mut length = text.len();
        for (at, byte) in text.bytes().enumerate().skip(1) {
            match (byte, quote) {
                (b'>', None) => {
                    length = at + 1;
                    break;
                }
                (b'<', None) => {
                    length = at;
                    break;
                }
                (byte, Some(open)) if byte == open => quote = None,
                (b'"' | b'\'', None) => quote = Some(byte),
                _ => {}
            }
        }
        Element { text: &text[..length] }
    }

    /// The prefix of its name, with the colon.
    fn prefix(&self) -> &'t str {
        let name = self.text.trim_start_matches(['<', '/']);
        let name = name.split(|c: char| c.is_whitespace() || c == '/' || c == '>').next().unwrap_or_default();
        name.split_once(':').map_or("", |(prefix, _)| &name[..prefix.len() + 1])
    }

    /// Writes it without namespaces, and returns how many attributes it has.
    fn write(&self, own_prefix: &str, plain: &mut String) -> usize {
        let begin = self.text.len() - self.text.trim_start_matches(['<', '/']).len();
        let (mut rest, mut quote, mut attributes) = (&self.text[begin..], None, 0);
        plain.push_str(&self.text[..begin]);
        if !own_prefix.is_empty() {
            rest = rest.strip_prefix(own_prefix).unwrap_or(rest);
        }
        while let Some(c) = rest.chars().next() {
            let mut length = c.len_utf8();
            match (c, quote) {
                (':', None) => plain.push('.'),
                ('&', Some(_)) => length = push_reference(rest, plain),
                ('<', Some(_)) => plain.push_str("&lt;"),
                // The declaration of the default namespace.
                ('x', None) if rest.starts_with("xmlns") => {
                    length = "xmlns".len();
                    plain.push_str("declared");
                }
                (c, _) => {
                    match (c, quote) {
                        ('"' | '\'', None) => quote = Some(c),
                        (c, Some(open)) if c == open => quote = None,
                        ('=', None) => attributes += 1,
                        _ => {}
                    }
                    plain.push(c);
                }
            }
            rest = &rest[length..];
        }
        attributes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is wrong with a text, or the names of its elements with what they hold.
    fn read(text: &str) -> Result<String, String> {
        let told = |issue: Issue| issue.to_string();
        let xml = Xml::scan(text).map_err(told)?;
        let document = xml.document().map_err(told)?;
        let elements = document.descendants().filter(|node| node.is_element()).map(|node| {
            let attributes = node.attributes().map(|a| format!(" {}={}", a.name(), a.value()));
            format!(
                "{}{}: {}",
                node.tag_name().name(),
                attributes.collect::<String>(),
                node.text().unwrap_or_default().trim()
            )
        });
        Ok(elements.collect::<Vec<_>>().join("; "))
    }

    fn element(attributes: usize) -> String {
        let attributes: String = (0..attributes).map(|i| format!(" a{i} = '>=\"'")).collect();
        format!("<robot>\n<!-- = -->\n<link{attributes}/></robot>")
    }

    #[test]
    fn an_element_has_few_attributes() {
        assert!(read(&element(256)).unwrap().starts_with("robot"));
        for crowded in [element(257), element(200_000), element(257).replace("'>=\"'", "\"'='\"")] {
            assert_eq!(read(&crowded).unwrap_err(), "line 3: an element has more than 256 attributes");
        }
        // Those of many elements, signs in a text, and in what is no element at all.
        let many = format!("<robot>{}{}</robot>", "<link a='1' b='2'/>".repeat(1000), "= ".repeat(1000));
        assert!(read(&many).is_ok());
        let signs = "< =".repeat(1000);
        assert!(read(&format!("<?a {signs}?><robot><!--{signs}--><![CDATA[{signs}]]></robot>")).is_ok());
        assert!(read("<robot a='").unwrap_err().starts_with("is no XML"));
        assert!(read("<").unwrap_err().starts_with("is no XML"));
        assert_eq!(read(" \n").unwrap_err(), "is empty: export it again");
    }

    #[test]
    fn a_text_is_read_as_the_readers_of_ros_and_gazebo_do() {
        for (text, expected) in [
            ("\n <?xml version='1.0'?>\n<sdf/>", "sdf: "),
            ("<!DOCTYPE sdf><sdf><!-- a -- b ---></sdf>", "sdf: "),
            ("<a><b>1 2 <!-- of --three-- -->3</b></a>", "a: ; b: 1 2 3"),
            ("<a><gz:pose x:y='1'>2</gz:pose><pose>3</pose></a>", "a: ; gz.pose x.y=1: 2; pose: 3"),
            ("<a xmlns='u' xmlns:g='v'><g:b/></a>", "a declared=u declared.g=v: ; g.b: "),
            ("<c:a xmlns:c='u'><c:b k='c:d'>e:f</c:b></c:a>", "a declared.c=u: ; b k=c:d: e:f"),
            ("<a k='M & N &lt; O &x; &#65;'>P & Q &amp; &#x42;</a>", "a k=M & N < O &x; A: P & Q & B"),
            ("<a k='1 < 2 > 0'/>", "a k=1 < 2 > 0: "),
            ("<a><![CDATA[<b> & --]]></a>", "a: <b> & --"),
        ] {
            assert_eq!(read(text).as_deref(), Ok(expected), "{text}");
        }
        for broken in ["<a><b></a>", "<a", "<!-- <a/>", "<a><![CDATA[</a>", "text"] {
            assert!(read(broken).unwrap_err().starts_with("is no XML"), "{broken}");
        }
        let entities = read("<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>").unwrap_err();
        assert!(entities.contains("leave the DOCTYPE out"), "{entities}");
        let wrong = read("<a>\n<!--\n\n-->\n<b>\n</a>").unwrap_err();
        assert!(wrong.contains("at 6:"), "lines stay as they are: {wrong}");
    }

    /// Each to the end of the text would take hours.
    #[test]
    fn what_has_no_end_is_looked_for_once() {
        for begin in ["<!--", "<?", "<!DOCTYPE ", "<!DOCTYPE[", "<![CDATA[", "<a b='", "<"] {
            let text = format!("<a>{}", begin.repeat(16 << 20 >> 2));
            assert!(read(&text).is_err(), "{begin}");
        }
    }

    #[test]
    fn namespaces_are_not_looked_up() {
        let declared: String = (0..200).map(|i| format!(" xmlns:n{i}='u'")).collect();
        let nested = format!("{}{}", format!("<a{declared}>").repeat(40), "<b/>".repeat(20_000));
        assert!(read(&format!("{nested}{}", "</a>".repeat(40))).is_ok());
    }
}
