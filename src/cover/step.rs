//! The best set within some limits: local search, improvement by two sensors at a time, then branch and bound.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use super::climb::{climb, climbs};
use super::gap::{Gap, GapSearch, WeighedCuts};
use super::mean::{MeanSearch, bounds_means};
use super::pairs::PairCounts;
use super::problem::{FoundSet, Problem};
use super::question::question;
use super::rules::SetLimits;
use super::search::{Ahead, Shortcuts, complete, search};
use super::worth::{Ratio, Worth};
use perirobot_march::metrics::Across;
use perirobot_march::progress::{Progress, SearchState};

/// What is known of all sets within some limits.
#[derive(Clone, Debug)]
pub struct FrontStep {
    /// The limits.
    pub limits: SetLimits,
    /// The best set that was found; none is worth more if that is proven.
    pub best: Option<FoundSet>,
    /// What no set is worth more than.
    pub bound: Bound,
}

impl FrontStep {
    /// What is known after this many seconds of search.
    fn state(&self, seconds: f64) -> SearchState {
        let state = self.limits.state(self.best.as_ref());
        let bound = state.best.and_then(|best| self.bound.upper_score(best));
        SearchState { bound, seconds: Some(seconds), ..state }
    }
}

/// What no set is worth more than.
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// The best set: all others were searched.
    Proven,
    /// A bound by cuts; the search was stopped. If a mean is asked for, one for each score.
    AtMost(Vec<Gap>),
    /// All sets were searched for one that is above this, in millionths; the search for a better one than the best was
    /// stopped.
    Searched(i128),
    /// Nothing is known.
    Unknown,
}

impl Bound {
    /// The score that no set is above, given the best set's.
    pub fn upper_score(&self, best: f64) -> Option<f64> {
        match self {
            Bound::Proven => Some(best),
            Bound::AtMost(gaps) => Some(gaps.iter().map(Gap::upper_bound).sum::<f64>() / gaps.len() as f64),
            Bound::Searched(above) => Some(*above as f64 / MILLION as f64),
            Bound::Unknown => None,
        }
    }
}

/// Every set that was judged, with its worth.
pub type KnownSets = BTreeMap<Vec<usize>, Worth>;

/// The time of branch and bound before a bound by cuts is computed.
const SHORT: Duration = Duration::from_secs(3);

/// Into how many parts a score is divided.
const MILLION: i128 = 1_000_000;
/// How near to the best score it is first searched whether any set is above, in millionths.
const NEARLY: i128 = 2000;

/// How many of the best results of climbing are improved by changing two sensors at a time.
const POLISHED: usize = 3;

/// The overlaps of all candidates, as far as a problem needs them, if they can be kept.
pub fn overlaps(problem: &Problem) -> Option<PairCounts> {
    let anything = Worth::Exact(Ratio { numerator: 1, denominator: 2 });
    PairCounts::new(problem.evidence, &question(problem, Some(anything)).all)
        .filter(|_| problem.is_searchable())
}

/// The search for the best set within some limits.
pub(super) struct StepSearch<'a> {
    problem: &'a Problem<'a>,
    kept: Option<&'a PairCounts>,
    progress: &'a dyn Progress,
    cuts: Option<WeighedCuts>,
    ahead: Ahead,
    seconds: f64,
    pub(super) step: FrontStep,
}

impl<'a> StepSearch<'a> {
    /// Searches so long that there is a good set and, unless it is proven, a bound. What is known is begun from,
    /// and what is found is added.
    pub(super) fn begun(
        problem: &'a Problem<'a>,
        limits: SetLimits,
        kept: Option<&'a PairCounts>,
        known: &mut KnownSets,
        progress: &'a dyn Progress,
    ) -> Self {
        let (begin, stop) = (Instant::now(), &|| progress.stops());
        progress.show_search(&limits.state(None));
        let mut ends = climbs(problem, limits, stop);
        ends.truncate(POLISHED);
        for found in ends {
            let found = match problem.is_searchable() {
                true => polish(problem, limits, kept, found, stop),
                false => found,
            };
            known.insert(found.set, found.worth);
        }
        let step = FrontStep { limits, best: best_known(problem, limits, known), bound: Bound::Unknown };
        let (cuts, ahead) = (None, Ahead::default());
        let mut search = StepSearch { problem, kept, progress, cuts, ahead, seconds: 0.0, step };
        search.tell("is to be beaten", begin.elapsed());
        if search.is_plainly_best() {
            search.step.bound = Bound::Proven;
        }
        // A long search may be stopped by the user, so a bound is computed before it goes on.
        let is_proven =
            search.step.bound == Bound::Proven || search.is_open() && search.go_on(known, Some(SHORT));
        if !is_proven && !progress.stops() {
            search.bound_by_cuts();
        }
        search.seconds += begin.elapsed().as_secs_f64();
        progress.show_search(&search.step.state(search.seconds));
        search
    }

    /// Whether no set can be better: none has a higher score, or climbing tried each single sensor.
    fn is_plainly_best(&self) -> bool {
        let StepSearch { problem, step, progress, .. } = self;
        let is_single = step.limits.at_most <= problem.rules.always.len() + 1;
        let is_tried = is_single && problem.evidence.is_filed() && !problem.adds_up() && !progress.stops();
        step.best.as_ref().is_some_and(|best| is_tried || best.worth.is_full())
    }

    /// Goes on until it is proven that no set is better, or it is stopped.
    pub(super) fn end(&mut self, known: &mut KnownSets) {
        let begin = Instant::now();
        self.refresh(known);
        self.progress.show_search(&self.step.limits.state(self.step.best.as_ref()));
        if self.come_near(known) {
            self.progress.show_search(&self.step.state(self.seconds + begin.elapsed().as_secs_f64()));
        }
        self.go_on(known, None);
        self.seconds += begin.elapsed().as_secs_f64();
        self.progress.show_search(&self.step.state(self.seconds));
    }

    /// What the best set is worth.
    pub(super) fn worth(&self) -> Option<Worth> {
        self.step.best.as_ref().map(|best| best.worth)
    }

    /// What the best set costs.
    pub(super) fn cost(&self) -> Option<u64> {
        self.step.best.as_ref().map(|best| self.problem.rules.cost_of(&best.set))
    }

    /// Whether branch and bound may prove anything that is not proven yet: of some means only that there is no set at all.
    pub(super) fn is_open(&self) -> bool {
        let is_searched = self.problem.goal.1 != Across::Mean || self.step.best.is_none();
        let is_searched = is_searched || bounds_means(self.problem);
        self.step.bound != Bound::Proven && is_searched && self.problem.is_searchable()
    }

    /// Takes the best of what is known by now.
    pub(super) fn refresh(&mut self, known: &KnownSets) {
        self.step.best = best_known(self.problem, self.step.limits, known);
    }

    /// Branch and bound, for a while; whether it is completed.
    fn go_on(&mut self, known: &mut KnownSets, longest: Option<Duration>) -> bool {
        let (begin, limits) = (Instant::now(), self.step.limits);
        let StepSearch { problem, kept, progress, cuts, ahead, step, .. } = self;
        let pause = || progress.stops() || longest.is_some_and(|longest| begin.elapsed() > longest);
        let mut improve = |found: FoundSet| {
            known.insert(found.set.clone(), found.worth);
            let further = polish(problem, limits, *kept, found, &|| progress.stops());
            known.insert(further.set.clone(), further.worth);
            progress.show_search(&limits.state(Some(&further)));
            further
        };
        let is_mean = problem.goal.1 == Across::Mean;
        let is_proven = match step.best.take() {
            Some(best) if is_mean => {
                let (best, is_proven) = best_mean(problem, limits, best, &pause, &mut improve);
                step.best = Some(best);
                is_proven
            }
            best => {
                // Of a mean any set will do: no inequality says which are better.
                let is_found = AtomicBool::new(false);
                let pause = || pause() || is_mean && is_found.load(Relaxed);
                let mut improve = |found: FoundSet| {
                    is_found.store(true, Relaxed);
                    improve(found)
                };
                let by = Shortcuts { overlaps: *kept, cuts: cuts.as_ref() };
                let (best, is_proven) = search(problem, limits, best, by, ahead, &pause, &mut improve);
                step.best = best;
                is_proven
            }
        };
        if is_proven {
            step.bound = Bound::Proven;
        }
        self.tell(if is_proven { "is proven" } else { "is not proven" }, begin.elapsed());
        is_proven
    }

    /// Looks for a set that is better by more than a little: that there is none takes far less than that none is better
    /// at all. Whether that was shown.
    fn come_near(&mut self, known: &mut KnownSets) -> bool {
        let begin = Instant::now();
        let StepSearch { problem, kept, progress, cuts, step, .. } = self;
        let (Some(best), Bound::AtMost(_)) = (&step.best, &step.bound) else { return false };
        let Worth::Exact(worth) = best.worth else { return false };
        let above = (worth.numerator * MILLION).div_euclid(worth.denominator) + NEARLY;
        // No score is above one.
        let is_near = |bound: f64| bound <= above as f64 / MILLION as f64;
        if above >= MILLION || step.bound.upper_score(0.0).is_none_or(is_near) {
            return false;
        }
        let by = Shortcuts { overlaps: *kept, cuts: cuts.as_ref() };
        let (found, is_searched) = find_above(problem, step.limits, above, by, &|| progress.stops());
        if let Some(found) = &found {
            known.insert(found.set.clone(), found.worth);
            step.best = Some(found.clone());
        }
        let is_shown = is_searched && found.is_none();
        if is_shown {
            step.bound = Bound::Searched(above);
        }
        self.tell(if is_shown { "is nearly proven" } else { "is to be beaten" }, begin.elapsed());
        is_shown
    }

    fn bound_by_cuts(&mut self) {
        let (begin, stop) = (Instant::now(), &|| self.progress.stops());
        let Some(best) = &self.step.best else { return };
        let (problem, limits) = (self.problem, self.step.limits);
        let found = match problem.goal.1 {
            Across::Mean => GapSearch::moment_bounds(problem, limits, &best.set, stop).map(|all| (all, None)),
            _ => GapSearch::new(problem, limits, stop)
                .run(best.worth)
                .map(|(gap, cuts)| (vec![gap], Some(cuts))),
        };
        let Some((gaps, cuts)) = found else { return };
        (self.step.bound, self.cuts) = (Bound::AtMost(gaps), cuts);
        self.tell("is bounded by cuts", begin.elapsed());
    }

    fn tell(&self, what: &str, time: Duration) {
        let (most, seconds) = (self.step.limits.at_most, time.as_secs_f64());
        let state = self.step.limits.state(self.step.best.as_ref());
        self.progress.show_search(&state);
        let worth = state.best.unwrap_or(f64::NAN);
        log::info!("choose: sets of at most {most}: {worth:.6} {what} after {seconds:.1} s");
    }
}

/// A set above a score in millionths, if one is found, and whether the search came to its end.
pub(super) fn find_above(
    problem: &Problem,
    limits: SetLimits,
    above: i128,
    by: Shortcuts,
    stop: &(dyn Fn() -> bool + Sync),
) -> (Option<FoundSet>, bool) {
    let worth = Worth::Exact(Ratio { numerator: above, denominator: MILLION });
    let is_found = AtomicBool::new(false);
    let mut first = |found: FoundSet| {
        is_found.store(true, Relaxed);
        found
    };
    let pause = || stop() || is_found.load(Relaxed);
    // Nobody has the set that is to be beaten.
    let bar = FoundSet { set: Vec::new(), worth };
    let (best, is_searched) =
        search(problem, limits, Some(bar), by, &mut Ahead::default(), &pause, &mut first);
    (best.filter(|_| is_found.load(Relaxed)), is_searched || is_found.load(Relaxed))
}

/// The best set by a mean of scores, and whether that is proven.
fn best_mean(
    problem: &Problem,
    limits: SetLimits,
    mut best: FoundSet,
    pause: &(dyn Fn() -> bool + Sync),
    improve: &mut dyn FnMut(FoundSet) -> FoundSet,
) -> (FoundSet, bool) {
    while bounds_means(problem) {
        match MeanSearch::new(problem, limits, &best, pause).better() {
            Some(found) => best = improve(found),
            None => return (best, !pause()),
        }
    }
    (best, false)
}

/// The best set within some limits, searched to the end.
pub fn best_within(
    problem: &Problem,
    limits: SetLimits,
    kept: Option<&PairCounts>,
    known: &mut KnownSets,
    progress: &dyn Progress,
) -> FrontStep {
    let mut search = StepSearch::begun(problem, limits, kept, known, progress);
    if search.is_open() {
        search.end(known);
    }
    search.step
}

/// The best of the known sets within some limits.
fn best_known(problem: &Problem, limits: SetLimits, known: &KnownSets) -> Option<FoundSet> {
    let fits = |set: &Vec<usize>| set.len() <= limits.at_most && limits.afford(problem.rules.cost_of(set));
    let better = |a: &FoundSet, b: &FoundSet| {
        let key = |found: &FoundSet| (found.worth, std::cmp::Reverse(problem.rules.cost_of(&found.set)));
        key(a).cmp(&key(b)).then(b.set.len().cmp(&a.set.len())).then(b.set.cmp(&a.set))
    };
    let all =
        known.iter().filter(|(set, _)| fits(set)).map(|(set, &worth)| FoundSet { set: set.clone(), worth });
    all.max_by(better)
}

/// Changes one or two sensors of a set as long as that helps.
pub fn polish(
    problem: &Problem,
    limits: SetLimits,
    kept: Option<&PairCounts>,
    mut best: FoundSet,
    stop: &(dyn Fn() -> bool + Sync),
) -> FoundSet {
    loop {
        best = climb(problem, limits, best.set.clone(), stop)
            .filter(|other| other.worth > best.worth)
            .unwrap_or(best);
        let places: Vec<usize> =
            (0..best.set.len()).filter(|&i| !problem.rules.always.contains(&best.set[i])).collect();
        // No inequality tells which pairs may have a higher mean.
        let places = if problem.goal.1 == Across::Mean { Vec::new() } else { places };
        let pairs = places.iter().flat_map(|&a| places.iter().filter(move |&&b| b > a).map(move |&b| [a, b]));
        let without = |out: [usize; 2]| -> Vec<usize> {
            (0..best.set.len()).filter(|i| !out.contains(i)).map(|i| best.set[i]).collect()
        };
        let better =
            pairs.into_iter().find_map(|out| complete(problem, limits, &without(out), &best, kept, stop));
        match better {
            Some(better) => best = better,
            None => return best,
        }
    }
}
