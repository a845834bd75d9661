//! An answer verified by other code than the search's. It uses only the question (`terms`) and the evidence of each
//! candidate, and, of judge, how a value is compared with a limit.
//!
//! # Practice
//! `claims` compares the question, the aims and the sets with the study. Each set is judged by the plain oracle
//! (`judged`). Each way in is followed again (`ways`). A plain search looks for cheaper sets (`plain`), with
//! counts that use no vector instructions (`counted`). It also checks the reasons if no set passes, and their text is
//! made again (`reasons`). `tables` sweeps and judges the sets again. A search that would take too long is reported as
//! open. The number of tested sets is not checked.

mod claims;
mod counted;
mod judged;
mod plain;
mod reasons;
mod tables;
mod ways;

use self::claims::AskedPoint;
use self::counted::{Bar, value};
use self::judged::{Verdict, asking_nearest, judge, restricted_study};
use self::plain::{PlainSearch, SearchEnd};
use self::reasons::verify_words;
use self::tables::verify_tables;
use self::ways::NearFacts;
use super::purchasing::MOST_TIES;
use super::remaining::OpenBackends;
use super::report::{AimReport, FILE, PurchasePoint, PurchaseReport, PurchasedSet};
use super::terms::{PurchaseAim, Terms};
use crate::approach::Ground;
use crate::choose::{AllowedSets, DisturbedPairs, pose_name};
pub use claims::PurchaseClaims;
use perirobot_cover::CandidateEvidence;
use perirobot_march::backend::factory::{BackendChoice, BackendKind, ChosenBackends};
use perirobot_march::metrics::{Across, Confusion, Ratio, Score};
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Counted, Limit, Purchase, Study, ThenScore};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;

/// The most groups of requirements searched for one claim.
const MOST_SEARCHES: usize = 2_000;

/// Counts of checked claims.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PurchaseVerified {
    /// Sets judged again.
    pub sets: usize,
    /// Ways in followed again.
    pub ways: usize,
    /// Claims that no set passes, or no better one, searched again.
    pub proven: usize,
    /// Claims of that kind that were not verified, since the plain search would take too long.
    pub open: usize,
    /// Whether the search was stopped, so that answers or proofs may be missing.
    pub stopped: bool,
}

/// The inputs of an answer.
#[derive(Clone, Copy)]
pub(crate) struct ProofInput<'a> {
    pub(super) study: &'a Study,
    pub(super) purchase: &'a Purchase,
    pub(super) worlds: &'a [World],
    /// Sensor and candidate index of each candidate.
    pub(super) items: &'a [[usize; 2]],
    pub(super) grounds: &'a [Ground<'a>],
    /// The questions, in the order of the answer.
    pub(super) asked: &'a [(PurchaseAim, Terms)],
    /// The regions of all counted scores, with their evidence.
    pub(super) regions: &'a [usize],
    /// Pairs of candidates that are excluded, since they disturb each other.
    pub(super) disturbed: &'a DisturbedPairs,
    pub(super) evidence: &'a [CandidateEvidence],
    pub(super) progress: &'a dyn Progress,
}

/// Checks an answer and all its tables; `open` opens the backends that judge sets of the plain search.
///
/// # Errors
/// `Error::Input` that names the wrong claim; `Error::Stopped`.
pub(super) fn verify(
    claims: &PurchaseClaims,
    input: ProofInput,
    open: OpenBackends,
) -> Result<PurchaseVerified> {
    let verified = verify_points(claims, input, open)?;
    verify_tables(&claims.folder, &claims.report, input)?;
    Ok(verified)
}

/// Checks an answer without its tables.
pub(super) fn verify_points(
    claims: &PurchaseClaims,
    input: ProofInput,
    open: OpenBackends,
) -> Result<PurchaseVerified> {
    let PurchaseClaims { folder, report, asked, disturbed } = claims;
    let input = ProofInput { disturbed, ..input };
    let path = folder.join(FILE.name);
    let facts = NearFacts::new(input, &report.ways_in).map_err(|error| error.with_place(&path))?;
    let mut verified =
        PurchaseVerified { ways: facts.ways.len(), stopped: report.stopped, ..PurchaseVerified::default() };
    for (number, (point, AskedPoint { terms, least, set })) in report.points.iter().zip(asked).enumerate() {
        let place = format!("points[{number}].");
        let (least, input) = (*least, input.for_aim(&point.aim));
        let mut check =
            PointCheck { input, open, facts: &facts, place, terms, least, verified: &mut verified };
        check.run(point, set.as_deref()).map_err(|error| error.with_place(&path))?;
        input.progress.advance(1);
    }
    if !report.stopped && is_another_nearer(report) {
        let mut terms = asked[0].terms.clone();
        let is_reason = |name: &String| report.points[0].reasons.iter().any(|one| one.requirement == *name);
        terms.requirements.retain(|one| !is_reason(&one.name));
        let (place, terms, verified) = (String::new(), &terms, &mut verified);
        let mut check = PointCheck { input, open, facts: &facts, place, terms, least: None, verified };
        if !terms.requirements.is_empty() {
            let what = "do not have the set that comes nearest: this one passes all but the reasons";
            check.none_passes(terms, None, ("points", what)).map_err(|error| error.with_place(&path))?;
        }
    }
    Ok(verified)
}

/// Whether no set passes all, and the answer lacks the set that passes all but the reasons.
fn is_another_nearer(report: &PurchaseReport) -> bool {
    let reasons = report.points[0].reasons.len();
    let is_nearest =
        |point: &PurchasePoint| matches!(&point.aim, AimReport::Nearest(names) if names.len() == reasons);
    reasons > 0 && !report.points.iter().any(is_nearest)
}

/// Opens the plain oracle.
fn open_oracle() -> Result<ChosenBackends> {
    let oracle = BackendChoice { kind: BackendKind::Oracle, ..BackendChoice::default() };
    ChosenBackends::open(&oracle).map(|(backends, _)| backends)
}

/// A check of one point.
struct PointCheck<'c, 'a> {
    input: ProofInput<'a>,
    open: OpenBackends<'c>,
    facts: &'c NearFacts<'a>,
    /// The path of the point in the file.
    place: String,
    terms: &'c Terms,
    /// The number of requirements that suffice; `None` for all.
    least: Option<usize>,
    verified: &'c mut PurchaseVerified,
}

impl PointCheck<'_, '_> {
    fn run(&mut self, point: &PurchasePoint, set: Option<&[usize]>) -> Result<()> {
        if let (Some(claimed), Some(set)) = (&point.set, set) {
            let verdict = self.judge_set((claimed, &point.missed), set)?;
            self.verified.sets += 1;
            if point.best_of_cost {
                self.none_is_better(claimed.cost, &verdict)?;
            }
        }
        match point.no_set_below {
            Some(below) => {
                if let Some(most) = below.thousandths().checked_sub(1) {
                    self.none_passes(self.terms, Some(most), ("no_set_below", "this set passes"))?;
                }
            }
            None if self.least.is_some() => {
                self.none_passes(self.terms, None, ("set", "this one meets as many"))?;
            }
            None => self.check_reasons(point)?,
        }
        match (&point.set, point.ties) {
            (Some(claimed), Some(ties)) => self.count_ties(claimed.cost, ties),
            _ => Ok(()),
        }
    }

    /// Judges a set with the oracle.
    fn judge_set(
        &self,
        (claimed, claimed_missed): (&PurchasedSet, &[String]),
        set: &[usize],
    ) -> Result<Verdict> {
        let ProofInput { study, purchase, .. } = self.input;
        let Terms { requirements, stopping } = self.terms;
        let mut restricted = restricted_study(study, requirements.clone(), stopping.clone());
        if matches!(purchase.then, Some(ThenScore::Nearness(_))) {
            restricted = asking_nearest(restricted);
        }
        let verdict = judge(self.input, &restricted, set, &open_oracle)?;
        let most_missed = self.least.map_or(0, |least| requirements.len() - least);
        if let Some(missed) = verdict.misses_more_than(most_missed) {
            return Err(self.wrong("set", format!("does not pass: {missed}")));
        }
        if verdict.missed_names != claimed_missed {
            let what = format!("is {claimed_missed:?}, but judged again it is {:?}", verdict.missed_names);
            return Err(self.wrong("missed", what));
        }
        let score = match purchase.then {
            Some(ThenScore::Counted(Counted { score, over, region })) => {
                value(score, over, &verdict.counts[region])
            }
            Some(ThenScore::Nearness(score)) => self.terms.near_value(study, score, verdict.nearest),
            None => None,
        };
        let or_none = |score: Option<f64>| score.map_or("none".into(), |score| score.to_string());
        if claimed.score != score {
            let what = format!("is {}, but counted again it is {}", or_none(claimed.score), or_none(score));
            return Err(self.wrong("set.score", what));
        }
        Ok(verdict)
    }

    /// Checks that no set passes some terms for at most `most`.
    fn none_passes(&mut self, terms: &Terms, most: Option<u64>, what: (&str, &str)) -> Result<()> {
        let end = self.run_search(terms, &|terms| self.search(terms, most).run())?;
        self.record_end(end, what)
    }

    /// Searches for a set that passes some terms; if a number of requirements suffices, for each group of that size,
    /// without those of which a part is already known to be impossible.
    fn run_search(&self, terms: &Terms, search: &dyn Fn(&Terms) -> Result<SearchEnd>) -> Result<SearchEnd> {
        let Some(least) = self.least else { return search(terms) };
        let count = terms.requirements.len();
        let mut open: Vec<Vec<usize>> = (0..count).map(|place| vec![place]).collect();
        let mut searches = 0;
        while let Some(places) = open.pop() {
            let next = places.last().map_or(0, |last| last + 1);
            if places.len() + (count - next) < least {
                continue;
            }
            searches += 1;
            if searches > MOST_SEARCHES {
                return Ok(SearchEnd::Open);
            }
            match search(&terms.only(&places))? {
                SearchEnd::NonePasses => {}
                SearchEnd::Open => return Ok(SearchEnd::Open),
                SearchEnd::Passes(set) if places.len() >= least => return Ok(SearchEnd::Passes(set)),
                SearchEnd::Passes(_) => {
                    open.extend((next..count).map(|more| [&places[..], &[more]].concat()))
                }
            }
        }
        Ok(SearchEnd::NonePasses)
    }

    fn wrong(&self, key: &str, what: String) -> Error {
        Error::input(format!("{}{key}", self.place), what)
    }

    fn search(&self, terms: &Terms, most: Option<u64>) -> PlainSearch<'_> {
        PlainSearch::new((self.input, self.open), self.facts, terms, most)
    }

    /// Checks that no set of the same cost is better by the deciding score.
    fn none_is_better(&mut self, cost: Cost, verdict: &Verdict) -> Result<()> {
        let Some(then) = self.input.purchase.then else { return Ok(()) };
        let most = Some(cost.thousandths());
        let end = self.run_search(self.terms, &|terms| {
            let search = self.search(terms, most);
            match then {
                ThenScore::Nearness(_) => match verdict.nearest {
                    // No body fits through an entry, for any set.
                    None => Ok(SearchEnd::NonePasses),
                    Some(squared) => search.beating_nearest(self.facts, terms, squared).run(),
                },
                ThenScore::Counted(counted) => self.better_by_counts(search, terms, counted, verdict),
            }
        })?;
        self.record_end(end, ("best_of_cost", "this set passes, costs no more and is better"))
    }

    /// Searches for a set that is better by a score of counts.
    fn better_by_counts(
        &self,
        search: PlainSearch,
        terms: &Terms,
        counted: Counted,
        verdict: &Verdict,
    ) -> Result<SearchEnd> {
        let Counted { score, over, region } = counted;
        let counts = &verdict.counts[region];
        let exact = exact_score(score, over, counts);
        if score == Score::SeenTwice {
            let seen = match (exact, value(score, over, counts)) {
                (Some(exact), _) => Ok(exact),
                (None, Some(mean)) => Err(mean),
                // The region has no voxel, for any set.
                (None, None) => return Ok(SearchEnd::NonePasses),
            };
            return search.beating_overlap(terms, counted, seen).run();
        }
        let bar = match (over, exact) {
            (Across::Mean, _) => value(score, over, counts).map_or(Bar::HasValue, Bar::BeatsMean),
            (_, Some(ratio)) if score.less_is_better() => Bar::Beats(Limit::AtMost(ratio)),
            (_, Some(ratio)) => Bar::Beats(Limit::AtLeast(ratio)),
            (_, None) => Bar::HasValue,
        };
        let reach = self.input.reach((score, over, region), bar, 0);
        let reach =
            reach.ok_or_else(|| self.wrong("best_of_cost", "nothing was cast in the region".into()))?;
        search.beating(terms, reach).run()
    }

    /// Checks the number of other sets of the same cost, as far as they are counted.
    fn count_ties(&mut self, cost: Cost, ties: usize) -> Result<()> {
        let wanted = (ties + 2).min(MOST_TIES + 1);
        let search = self.search(self.terms, Some(cost.thousandths())).at_least(wanted);
        let (found, is_open) = search.find()?;
        let others = found.len().saturating_sub(1).min(MOST_TIES);
        if others > ties || (others < ties && !is_open) {
            return Err(self.wrong("ties", format!("is {ties}, but counted again it is {others}")));
        }
        if is_open {
            self.verified.open += 1
        } else {
            self.verified.proven += 1
        }
        Ok(())
    }

    /// Checks that no set meets all reasons, and that each of them is necessary.
    fn check_reasons(&mut self, point: &PurchasePoint) -> Result<()> {
        if point.reasons.is_empty() {
            return self.none_passes(self.terms, None, ("set", "this one passes"));
        }
        verify_words((self.input, &self.place), self.facts, self.terms, &point.reasons)?;
        let is_named = |name: &str| point.reasons.iter().any(|reason| reason.requirement == name);
        let mut named = self.terms.clone();
        named.requirements.retain(|one| is_named(&one.name));
        self.none_passes(&named, None, ("reasons", "this set meets all of these"))?;
        // Requirements at different robot speeds have the same names.
        let is_unique = named.requirements.len() == point.reasons.len();
        for (number, reason) in
            point.reasons.iter().enumerate().filter(|_| is_unique && point.reasons.len() > 1)
        {
            let mut fewer = named.clone();
            fewer.requirements.retain(|one| one.name != reason.requirement);
            match self.search(&fewer, None).run()? {
                SearchEnd::Passes(_) => self.verified.proven += 1,
                SearchEnd::Open => self.verified.open += 1,
                SearchEnd::NonePasses => {
                    return Err(self.wrong(
                        &format!("reasons[{number}]"),
                        "is not needed: the others cannot be met".into(),
                    ));
                }
            }
        }
        Ok(())
    }

    fn record_end(&mut self, end: SearchEnd, (place, what): (&str, &str)) -> Result<()> {
        match end {
            SearchEnd::NonePasses => self.verified.proven += 1,
            SearchEnd::Open => self.verified.open += 1,
            SearchEnd::Passes(set) => {
                let name = |&item: &usize| pose_name(self.input.study, self.input.items[item]);
                let names: Vec<String> = set.iter().map(name).collect();
                return Err(self.wrong(place, format!("{what}: {}", names.join(";"))));
            }
        }
        Ok(())
    }
}

impl<'a> ProofInput<'a> {
    /// The same for an aim: the allowed pairs of candidates.
    fn for_aim(self, aim: &AimReport) -> ProofInput<'a> {
        match aim {
            AimReport::Disturbed => ProofInput { disturbed: DisturbedPairs::none(), ..self },
            _ => self,
        }
    }

    fn allowed(self) -> AllowedSets<'a> {
        let ProofInput { study, purchase, worlds, disturbed, .. } = self;
        let Purchase { at_most, budget, ref always, apart_m, .. } = *purchase;
        AllowedSets { study, worlds, at_most, budget, always, apart_m, disturbed }
    }
}

/// A score as a fraction, unless it is a mean or has no value.
fn exact_score(score: Score, over: Across, counts: &[Confusion]) -> Option<Ratio> {
    let each = || counts.iter().filter_map(|counts| Ratio::from_score(score, counts));
    match over {
        Across::Mean => None,
        Across::Worst if score.less_is_better() => each().max(),
        Across::Worst => each().min(),
        Across::Pooled => {
            Ratio::from_score(score, &counts.iter().fold(Confusion::default(), |all, one| all.plus(one)))
        }
    }
}
