//! Reports to the page what a search tells.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use perirobot_decide::cheapest::purchase_progress_of;
use perirobot_decide::choose::progress_of;
use perirobot_march::progress::{Progress, PurchaseState, SearchState};
use perirobot_study::input::Study;
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use perirobot_study::world::place::Places;

use super::event::{FindEvent, FoundPoint, placed_in};

/// Listens to a search.
pub(super) struct FindListener<'a> {
    pub(super) emit: &'a (dyn Fn(FindEvent) + Sync),
    stop: &'a AtomicBool,
    stage: Mutex<Stage>,
    /// What was reported last of a search for the cheapest set.
    purchased: Mutex<Purchased>,
    /// Where a search for the best score gets names from.
    names: OnceLock<Names<'a>>,
}

/// The names of what a search for the best score calls by numbers.
struct Names<'a> {
    study: &'a Study,
    places: Places<'a>,
    /// Sensor and candidate of each number.
    items: Vec<[usize; 2]>,
    /// The most sensors that any set may have.
    at_most: usize,
    /// The searches within some limits, in the order in which they began.
    parts: Mutex<Vec<Part>>,
}

/// A search within some limits.
struct Part {
    /// How many sensors a set may have.
    at_most: usize,
    /// What it may cost, in thousandths.
    budget: Option<u64>,
    /// The set that was reported last.
    reported: Vec<usize>,
}

impl Names<'_> {
    /// The best set so far within some limits; none if there is none, or if it was reported already.
    fn new_point(&self, state: &SearchState) -> Option<FoundPoint> {
        let mut parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        let is_own = |part: &Part| (part.at_most, part.budget) == (state.at_most, state.budget);
        let number = parts.iter().position(is_own).unwrap_or(parts.len());
        if number == parts.len() {
            parts.push(Part { at_most: state.at_most, budget: state.budget, reported: Vec::new() });
        }
        if state.set.is_empty() || parts[number].reported == state.set {
            return None;
        }
        parts[number].reported.clone_from(&state.set);
        let sensors = state.set.iter().map(|&item| self.items[item]);
        let named = sensors.clone().map(|[sensor, candidate]| {
            let spec = &self.study.sensors[sensor];
            let pose = spec.candidates[candidate].name.clone();
            [spec.name.clone(), pose, self.places.words(sensor, candidate)]
        });
        let named: Vec<[String; 3]> = named.collect();
        let (placed, words) = placed_in(named.iter().map(|[sensor, pose, place]| [sensor, pose, place]));
        let mut costs = sensors.map(|[sensor, _]| self.study.sensors[sensor].terms.cost);
        let cost = costs.try_fold(Cost::ZERO, |sum, cost| Some(sum.plus(cost?)));
        Some(FoundPoint {
            part: Some(number),
            cost: cost.map(Cost::amount),
            score: state.best,
            words,
            placed,
            is_proven: false,
        })
    }

    /// Whether limits are those of the whole question: the most sensors with the first, largest budget.
    fn is_whole(&self, state: &SearchState) -> bool {
        let parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        let first = parts.iter().find(|part| part.at_most == self.at_most);
        first.is_some_and(|part| (part.at_most, part.budget) == (state.at_most, state.budget))
    }
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
        FindListener { emit, stop, stage, purchased: Mutex::default(), names: OnceLock::new() }
    }

    /// Names the candidates of a search for the best score, so that its sets are reported.
    pub(super) fn set_names(
        &self,
        (study, world): (&'a Study, &'a World),
        items: &[[usize; 2]],
        at_most: usize,
    ) {
        let places = Places::new(study, world);
        let names = || Names { study, places, items: items.to_vec(), at_most, parts: Mutex::default() };
        self.names.get_or_init(names);
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
        let Some(names) = self.names.get() else { return };
        if let Some(point) = names.new_point(state) {
            (self.emit)(FindEvent::Search(progress_of(state)));
            (self.emit)(FindEvent::Point(point));
        }
        // What no smaller set is above, a larger one may be.
        if state.bound.is_some() && names.is_whole(state) {
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
