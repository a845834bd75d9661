//! Progress of a search: the cheapest set found, the bound, and the number of tested sets.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use perirobot_cover::cheapest::{CheapestAnswer, CheapestKnown, FoundPurchase};
use perirobot_march::progress::{Progress, PurchaseState, PurchasedMember, PurchasedState};
use perirobot_study::sensor::Cost;

use super::number::FamiliesKnown;
use super::purchasing::Purchasing;
use super::report::{AimReport, PurchasedSensor};
use super::terms::Terms;

/// Time between two reports of one part of a question.
pub(super) const BETWEEN_REPORTS: Duration = Duration::from_millis(100);

/// Reports the progress of a search, part by part of its question. Nothing is reported between the parts.
pub(super) struct SearchReporter<'s, 'a> {
    purchasing: &'s Purchasing<'a>,
    progress: &'s dyn Progress,
    between: Duration,
    part: RefCell<Option<Part>>,
    /// The number of parts begun.
    begun: Cell<usize>,
    /// Time of the last report.
    last: Cell<Option<Instant>>,
}

/// The progress of one part of a question.
struct Part {
    number: usize,
    title: String,
    terms: Terms,
    tested: u64,
    no_set_below: u64,
    best: Option<FoundPurchase>,
    /// Bounds besides those of the current search, if sets must meet a number of requirements.
    families: Option<FamiliesKnown>,
}

impl<'s, 'a> SearchReporter<'s, 'a> {
    pub(super) fn new(
        purchasing: &'s Purchasing<'a>,
        progress: &'s dyn Progress,
        between: Duration,
    ) -> SearchReporter<'s, 'a> {
        let (part, begun, last) = (RefCell::new(None), Cell::new(0), Cell::new(None));
        SearchReporter { purchasing, progress, between, part, begun, last }
    }

    /// Begins the next part.
    pub(super) fn begin(&self, aim: &AimReport, terms: &Terms) {
        let number = self.begun.replace(self.begun.get() + 1);
        let (title, terms) = (aim.title(), terms.clone());
        let (tested, no_set_below, best, families) = (0, 0, None, None);
        *self.part.borrow_mut() = Some(Part { number, title, terms, tested, no_set_below, best, families });
    }

    /// Records bounds besides those of the next search, whose sets need not meet enough requirements.
    pub(super) fn show_families(&self, known: FamiliesKnown) {
        if let Some(part) = &mut *self.part.borrow_mut() {
            part.best.clone_from(&known.best);
            part.families = Some(known);
        }
    }

    /// Records the progress of a search.
    pub(super) fn show(&self, known: CheapestKnown) {
        let mut part = self.part.borrow_mut();
        let Some(part) = &mut *part else { return };
        part.take(known);
        if self.last.get().is_none_or(|last| last.elapsed() >= self.between) {
            self.report(part, Some(part.no_set_below), false);
        }
    }

    /// Ends a part with its answer.
    pub(super) fn end(&self, found: &CheapestAnswer) {
        let Some(mut part) = self.part.take() else { return };
        part.best.clone_from(&found.best);
        part.tested = part.tested.max(found.tested);
        self.report(&part, found.no_set_below, found.is_proven);
    }

    fn report(&self, part: &Part, no_set_below: Option<u64>, is_proven: bool) {
        let best = part.best.as_ref().map(|best| {
            let set = self.purchasing.purchased_set(part.title.clone(), &part.terms, best);
            let member =
                |PurchasedSensor { sensor, pose, place, .. }| PurchasedMember { sensor, pose, place };
            let sensors = set.sensors.into_iter().map(member).collect();
            PurchasedState { cost: best.cost, score: set.score, sensors }
        });
        self.progress.show_purchase(&PurchaseState {
            part: part.number,
            title: part.title.clone(),
            tested: part.tested,
            no_set_below,
            best,
            currency: self.purchasing.currency(),
            is_proven,
        });
        self.last.set(Some(Instant::now()));
    }
}

impl Part {
    fn take(&mut self, CheapestKnown { best, no_set_below, tested }: CheapestKnown) {
        let (tested, bound) = match &self.families {
            Some(known) => (known.tested + tested, known.family.max(no_set_below).min(known.others)),
            None => {
                if let Some(best) = best.filter(|&best| self.best.as_ref() != Some(best)) {
                    self.best = Some(best.clone());
                }
                (tested, no_set_below)
            }
        };
        self.tested = self.tested.max(tested);
        self.no_set_below = self.no_set_below.max(bound);
    }
}

/// The progress of one part of a question, in words.
pub fn purchase_progress_of(state: &PurchaseState) -> String {
    let amount = |cost: u64| Cost::from_thousandths(cost).to_text(state.currency.as_deref());
    let none = if state.is_proven { "no set passes" } else { "none found yet" };
    let best = state.best.as_ref().map_or(none.into(), |best| format!("found {}", amount(best.cost)));
    let bound = state.no_set_below.map_or(String::new(), |bound| format!(", none below {}", amount(bound)));
    let tested = state.tested;
    let sets = if tested == 1 { "set" } else { "sets" };
    format!("{}: {best}{bound}; {tested} {sets} tested", state.title)
}
