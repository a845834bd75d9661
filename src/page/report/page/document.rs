//! The page in HTML: a head, the sections, and the script with its data.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::sections::Sections;

/// The contents of the page. Words are escaped here, in the sections and in drawings. The style, the patterns, the
/// script and its data are the program's own and unescaped.
pub(super) struct Document<'a> {
    pub(super) title: String,
    pub(super) note: Option<&'a str>,
    /// The study's name, and the day: printed on each sheet.
    pub(super) study: String,
    pub(super) day: String,
    pub(super) sections: Sections<'a>,
    pub(super) policy: String,
    pub(super) style: String,
    pub(super) patterns: &'static str,
    pub(super) script: String,
    pub(super) data: String,
    pub(super) numbers: String,
    pub(super) cells: String,
    pub(super) charts: String,
}

impl Document<'_> {
    /// The text of the file.
    pub(super) fn text(&self) -> String {
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                (self.head())
                body {
                    (PreEscaped(self.patterns))
                    header {
                        h1 { (self.title) }
                        @if let Some(summary) = &self.sections.summary { p.summary { (summary) } }
                        @if let Some(note) = self.note { p.warning { (note) } }
                        (self.sections.links())
                    }
                    main { (self.sections.view()) }
                    noscript {
                        p.warning { "Plots and the 3D view need JavaScript; all tables above are complete without." }
                    }
                    p #failure.warning role="alert" hidden {}
                    (self.scripts())
                }
            }
        };
        page.into_string()
    }

    fn head(&self) -> Markup {
        let (title, study, day) = (&self.title, css_string(&self.study), &self.day);
        let in_print = format!(
            "@page {{ @top-left {{ content: \"{study} · perirobot report\"; }} @top-right {{ content: \"{day}\"; }} \
             @bottom-right {{ content: counter(page) \" / \" counter(pages); }} }}"
        );
        html! {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(self.policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) " · perirobot report" }
                style { (PreEscaped(&self.style)) (PreEscaped(in_print)) }
            }
        }
    }

    /// The drawings of the script, and the script.
    fn scripts(&self) -> Markup {
        html! {
            script type="text/plain" id="data" { (PreEscaped(&self.data)) }
            script type="text/plain" id="numbers" { (PreEscaped(&self.numbers)) }
            script type="text/plain" id="charts" { (PreEscaped(&self.charts)) }
            script type="text/plain" id="cells" { (PreEscaped(&self.cells)) }
            script { (PreEscaped(&self.script)) }
        }
    }
}

/// Words in a string of a style sheet: all but letters and digits are written as escapes.
fn css_string(words: &str) -> String {
    let escape = |letter: char| match letter.is_ascii_alphanumeric() || letter == ' ' {
        true => letter.to_string(),
        false => format!("\\{:x} ", u32::from(letter)),
    };
    words.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn nothing_ends_a_string_of_a_style_sheet() {
        assert_eq!(super::css_string("my cell"), "my cell");
        assert_eq!(super::css_string("a\"</b>-ü"), "a\\22 \\3c \\2f b\\3e \\2d \\fc ");
    }
}
