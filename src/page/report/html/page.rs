//! The page in HTML: a head, a section for each question, and what the script draws from.

mod answer;
mod blind;
mod compare;
mod front;
mod good;
mod instead;
mod money;
mod run;
mod tables;
mod whereabouts;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::facts::Facts;

/// What the page holds. Words are escaped here, those in drawings where they are drawn, the study's name in the style by
/// `facts`. The style, the patterns, the script and what it reads are this program's own and stand as they are.
pub(super) struct Page<'a> {
    pub(super) facts: Facts<'a>,
    pub(super) policy: String,
    pub(super) style: String,
    pub(super) patterns: &'static str,
    /// What is recommended at its worst moment, as an address that holds the picture.
    pub(super) picture: Option<String>,
    pub(super) script: String,
    pub(super) data: String,
    pub(super) numbers: String,
    pub(super) cells: String,
}

impl Page<'_> {
    /// The text of the file.
    pub(super) fn written(&self) -> String {
        let Page { facts, .. } = self;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                (self.head())
                body {
                    (PreEscaped(self.patterns))
                    header {
                        h1 { (facts.title) }
                        (self.links())
                    }
                    main {
                        (answer::section(facts))
                        (instead::section(facts))
                        (whereabouts::section(facts))
                        form #choice.controls aria-label="What is shown" {
                            (list("extent", "Scene"))
                            (list("region", "Region"))
                            (list("series", "Sensors · representation"))
                            (list("measure", "Score"))
                            label #member-label { "Positions of " select #member {} }
                        }
                        (blind::section(facts, self.picture.as_deref()))
                        (good::section(&facts.good, facts.answer.as_ref().map(|answer| answer.set.as_str())))
                        @if self.has_money() { (money::section(facts)) }
                        (compare::section(facts))
                        (run::section(facts))
                    }
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
        let Facts { title, study_in_css, day, .. } = &self.facts;
        let in_print = format!(
            "@page {{ @top-left {{ content: \"{study_in_css} · perirobot report\"; }} @top-right {{ content: \"{day}\"; }} \
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

    fn links(&self) -> Markup {
        html! {
            nav aria-label="Sections" {
                a href="#instead" { "Instead?" }
                a href="#where" { "Where exactly?" }
                a href="#blind" { "What stays blind?" }
                a href="#good" { "Good enough?" }
                @if self.has_money() { a href="#money" { "More money?" } }
                a href="#compare" { "All places" }
                a href="#run" { "What was run" }
            }
        }
    }

    /// Whether there is more than one way to spend.
    fn has_money(&self) -> bool {
        self.facts.front.is_some() || !self.facts.maxima.is_empty()
    }

    /// What the script draws, and the script.
    fn scripts(&self) -> Markup {
        html! {
            script type="text/plain" id="data" { (PreEscaped(&self.data)) }
            script type="text/plain" id="numbers" { (PreEscaped(&self.numbers)) }
            script type="text/plain" id="cells" { (PreEscaped(&self.cells)) }
            script { (PreEscaped(&self.script)) }
        }
    }
}

/// A list to choose from, which the script fills.
fn list(id: &str, of: &str) -> Markup {
    html! { label { (of) " " select id=(id) {} } }
}
