//! Writes drawings as SVG.

use std::fmt::{Display, Write};

/// A drawing's elements, one after another.
#[derive(Clone, Debug, Default)]
pub struct Svg {
    text: String,
}

impl Svg {
    /// Adds an element without content.
    pub fn element(&mut self, name: &str, attributes: &[(&str, &dyn Display)]) {
        self.begin(name, attributes);
        self.text += "/>\n";
    }

    /// Adds an element with words in it; browsers show a `title` as a tooltip.
    pub fn add_titled(&mut self, name: &str, attributes: &[(&str, &dyn Display)], title: &str) {
        self.begin(name, attributes);
        let _ = writeln!(self.text, "><title>{}</title></{name}>", escape(title));
    }

    /// Adds words.
    pub fn words(&mut self, attributes: &[(&str, &dyn Display)], words: &str) {
        self.begin("text", attributes);
        let _ = writeln!(self.text, ">{}</text>", escape(words));
    }

    /// Adds elements unchanged.
    pub fn add(&mut self, elements: &str) {
        self.text += elements;
    }

    /// Only the elements.
    pub fn into_text(self) -> String {
        self.text
    }

    fn begin(&mut self, name: &str, attributes: &[(&str, &dyn Display)]) {
        let _ = write!(self.text, "<{name}");
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"{}\"", escape(&value.to_string()));
        }
    }

    /// The complete SVG, with the size of its box unless a page sets another.
    pub fn finish(self, class: &str, label: &str, [left, top, width, height]: [f64; 4]) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"{class}\" role=\"img\" aria-label=\"{}\" \
             viewBox=\"{left} {top} {width} {height}\" width=\"{width}\" height=\"{height}\">\n{}</svg>\n",
            escape(label),
            self.text
        )
    }
}

/// Escapes text for XML and removes characters that XML does not allow.
pub fn escape(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for letter in words.chars() {
        match letter {
            '&' => text += "&amp;",
            '<' => text += "&lt;",
            '>' => text += "&gt;",
            '"' => text += "&quot;",
            '\t' | '\n' | '\r' => text.push(' '),
            control if control.is_control() || ['\u{fffe}', '\u{ffff}'].contains(&control) => {}
            plain => text.push(plain),
        }
    }
    text
}

/// A length to a tenth of a unit, without trailing zeros.
pub fn tenth(units: f64) -> f64 {
    (units * 10.0).round() / 10.0 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_strangers_stay_words() {
        let mut svg = Svg::default();
        let nasty = "</text><script>\"&'\u{1}\u{ffff}\nend";
        svg.words(&[("class", &nasty), ("x", &tenth(-0.04))], nasty);
        svg.add_titled("circle", &[("r", &1)], nasty);
        let text = svg.finish("plan", nasty, [0.0, 0.0, 1.0, 2.0]);
        let document = roxmltree::Document::parse(&text).unwrap();
        let read = |name: &str| document.descendants().find(|node| node.has_tag_name(name)).unwrap();
        let svg = "http://www.w3.org/2000/svg";
        assert_eq!(read("svg").tag_name().namespace(), Some(svg));
        let shown = "</text><script>\"&' end";
        assert_eq!([read("text").text(), read("title").text()], [Some(shown); 2]);
        assert_eq!(read("text").attribute("x"), Some("0"));
        assert_eq!(read("svg").attribute("aria-label"), Some(shown));
    }
}
