//! The sections of the page, a module for each question, with the section's facts and its view.

mod blind;
mod compare;
mod first_screen;
mod good;
mod help;
mod instead;
mod money;
mod run;
mod signed;
mod summary;
mod whereabouts;

use maud::{Markup, html};

use super::{Findings, ReportedSweep};
use blind::Blind;
use compare::Compare;
use first_screen::FirstScreen;
use good::Good;
use help::Help;
use instead::Instead;
use money::Money;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use run::Run;
use signed::Signed;
use summary::summary;
use whereabouts::Whereabouts;

/// All sections: words, drawings and tables that need no script; the contents of a printed report.
pub(super) struct Sections<'a> {
    /// The recommended choice, in a line; `None` if there is none.
    pub(super) summary: Option<String>,
    first_screen: Option<FirstScreen>,
    help: Option<Help>,
    instead: Instead<'a>,
    whereabouts: Whereabouts<'a>,
    blind: Blind<'a>,
    good: Good,
    money: Option<Money<'a>>,
    compare: Compare,
    run: Run,
    signed: Signed,
}

impl<'a> Sections<'a> {
    /// The sections; `picture` is the address of the recommended choice at its worst moment.
    pub(super) fn new(findings: &Findings<'a>, picture: Option<String>) -> Result<Sections<'a>> {
        let money = Money::new(findings)?;
        let (first_screen, good) = (FirstScreen::from_recommended(findings)?, Good::new(findings)?);
        Ok(Sections {
            signed: Signed::new(&findings.sweep, first_screen.as_ref().map(|first| first.set.as_str())),
            summary: first_screen.as_ref().map(|first| summary(findings, first, &good)),
            first_screen,
            help: Help::from_findings(findings)?,
            instead: Instead::new(findings)?,
            whereabouts: Whereabouts::new(findings),
            blind: Blind::new(findings, picture),
            good,
            compare: Compare::new(findings, money.as_ref().is_some_and(Money::has_maxima)),
            run: Run::new(&findings.sweep),
            money,
        })
    }

    /// Links to them.
    pub(super) fn links(&self) -> Markup {
        html! {
            nav aria-label="Sections" {
                @if self.help.is_some() { a href="#help" { "Improve?" } }
                a href="#instead" { "Instead?" }
                a href="#where" { "Where exactly?" }
                a href="#blind" { "What stays blind?" }
                a href="#good" { "Good enough?" }
                @if self.money.is_some() { a href="#money" { "More money?" } }
                a href="#compare" { "All places" }
                a href="#run" { "What was run" }
                a href="#signed" { "Signatures" }
            }
        }
    }

    /// Charts of scores that are not shown initially.
    pub(super) fn other_charts(&self) -> Markup {
        html! {
            @if let Some(money) = &self.money { (money.other_charts()) }
            (self.compare.other_charts())
        }
    }

    /// All sections, in order.
    pub(super) fn view(&self) -> Markup {
        let set = self.first_screen.as_ref().map(|first| first.set.as_str());
        let plans = self.first_screen.as_ref().map_or(&[][..], |first| &first.plans[..]);
        html! {
            @match &self.first_screen {
                Some(first) => (first.view(&self.good)),
                None => (first_screen::render_empty()),
            }
            @if let Some(help) = &self.help { (help.view()) }
            (self.instead.view())
            (self.whereabouts.view())
            form #choice.controls aria-label="What is shown" {
                (list("extent", "Scene"))
                (list("region", "Region"))
                (list("series", "Sensors · representation"))
                (list("measure", "Score"))
                label #member-label { "Positions of " select #member {} }
            }
            (self.blind.view(plans))
            (self.good.view(set))
            @if let Some(money) = &self.money { (money.view()) }
            (self.compare.view())
            (self.run.view())
            (self.signed.view())
        }
    }
}

/// A selection list, filled by the script.
fn list(id: &str, of: &str) -> Markup {
    html! { label { (of) " " select id=(id) {} } }
}

/// The scores in each region.
fn scores_in_regions(sweep: &ReportedSweep) -> impl Iterator<Item = (usize, Score)> {
    let regions = 0..sweep.results.regions.len();
    regions.flat_map(|region| Score::ALL.map(|score| (region, score)))
}

/// The title of the table of a score in a region.
fn score_in_region(sweep: &ReportedSweep, (region, score): (usize, Score)) -> String {
    format!("{} in region {}", score.title(), sweep.results.regions[region])
}
