//! Reports to the page what a search tells.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use perirobot_decide::cheapest::purchase_progress_of;
use perirobot_march::progress::{Progress, PurchaseState, SearchState};
use perirobot_study::sensor::Cost;

use super::event::{FindEvent, FoundPoint};

/// Listens to a search.
pub(super) struct FindListener<'a> {
    pub(super) emit: &'a (dyn Fn(FindEvent) + Sync),
    stop: &'a AtomicBool,
    stage: Mutex<Stage>,
    /// What was reported last of a search for the cheapest set.
    purchased: Mutex<Purchased>,
}

#[derive(Default)]
struct Purchased {
    /// No set costs less than this, in thousandths.
    bound: Option<u64>,
    point: Option<FoundPoint>,
}

/// A stage that is under way.
#[derive(Clone, Copy)]
struct Stage {
    words: &'static str,
    done: u64,
    total: u64,
}

/// How many reports of a stage are enough for a bar.
const REPORTS: u64 = 200;

impl<'a> FindListener<'a> {
    pub(super) fn new(emit: &'a (dyn Fn(FindEvent) + Sync), stop: &'a AtomicBool) -> FindListener<'a> {
        let stage = Mutex::new(Stage { words: "", done: 0, total: 0 });
        FindListener { emit, stop, stage, purchased: Mutex::default() }
    }

    pub(super) fn begin(&self, words: &'static str, total: u64) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = Stage { words, done: 0, total };
        (self.emit)(FindEvent::Stage { words, done: 0, total });
    }

    pub(super) fn end(&self, words: String, is_stopped: bool) {
        (self.emit)(if is_stopped { FindEvent::Stopped(words) } else { FindEvent::Done(words) });
    }
}

impl Progress for FindListener<'_> {
    fn stop_reason(&self) -> Option<String> {
        self.stop.load(Ordering::Relaxed).then(|| "stopped on the page".into())
    }

    fn advance(&self, more: u64) {
        let Stage { words, done, total } = {
            let mut stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
            stage.done += more;
            *stage
        };
        let each = (total / REPORTS).max(1);
        if done == total || done / each != done.saturating_sub(more) / each {
            (self.emit)(FindEvent::Stage { words, done, total });
        }
    }

    fn show_search(&self, state: &SearchState) {
        if state.bound.is_some() {
            (self.emit)(FindEvent::Bound { cost: None, score: state.bound });
        }
    }

    fn show_purchase(&self, state: &PurchaseState) {
        (self.emit)(FindEvent::Search(purchase_progress_of(state)));
        let mut known = self.purchased.lock().unwrap_or_else(PoisonError::into_inner);
        // The bound on the page is of all requirements.
        if let Some(bound) = state.no_set_below.filter(|_| state.part == 0)
            && known.bound != Some(bound)
        {
            known.bound = Some(bound);
            (self.emit)(FindEvent::Bound { cost: Some(Cost::from_thousandths(bound).amount()), score: None });
        }
        let point = FoundPoint::from_purchase(state).filter(|point| known.point.as_ref() != Some(point));
        if let Some(point) = point {
            known.point = Some(point.clone());
            (self.emit)(FindEvent::Point(point));
        }
    }
}
