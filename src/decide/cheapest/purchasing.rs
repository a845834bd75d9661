//! The stages of a search for the cheapest set that passes: every candidate is cast once, then sets are searched.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Duration;

use perirobot_cover::cheapest::{Better, CheapestAnswer, FoundPurchase};
use perirobot_cover::layout::WantedCounts;
use perirobot_cover::{CandidateEvidence, Problem, SetLimits, SetRules, Worth};
use perirobot_march::Result;
use perirobot_march::backend::factory::ChosenBackends;
use perirobot_march::metrics::{Across, Score};
use perirobot_march::progress::Progress;
use perirobot_study::input::{
    ApproachScore, Counted, Disturb, Measure, Purchase, PurchaseFront, Requirement, Study, ThenScore,
};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use perirobot_study::world::place::Places;

use super::areas::Areas;
use super::number::{NumberQuestion, Subsets};
use super::purchase_search::PurchaseSearch;
use super::remaining::combination;
use super::report::{
    AimReport, ProvenWay, PurchasePoint, PurchaseReport, PurchasedSensor, PurchasedSet, ReasonReport,
};
use super::reporter::{BETWEEN_REPORTS, SearchReporter};
use super::terms::{PurchaseAim, Terms};
use super::verify::{ProofInput, PurchaseClaims, PurchaseVerified, verify};
use super::ways::{SceneWays, WayIn};
use crate::approach::Ground;
use crate::choose::{Casting, DisturbedPairs, PairTerms, candidates_of, odds_of, pose_name, rules_of};
use crate::view::watched::Watcher;

/// The most other sets of the same cost that are counted.
pub const MOST_TIES: usize = 9;

/// A search for the cheapest set.
pub struct Purchasing<'a> {
    pub(super) study: &'a Study,
    pub(super) purchase: &'a Purchase,
    pub(super) worlds: &'a [World],
    memory_bytes: u64,
    /// Sensor and candidate index of each candidate.
    pub(super) items: Vec<[usize; 2]>,
    /// The scenes with the space of moving bodies; empty if no requirement needs them.
    grounds: Vec<Ground<'a>>,
    /// The questions, in the order of the search.
    asked: Vec<(PurchaseAim, Terms)>,
    /// The regions of all counted scores.
    regions: Vec<usize>,
    /// Time between two progress reports.
    between_reports: Duration,
}

impl<'a> Purchasing<'a> {
    /// The question of a study.
    ///
    /// # Errors
    /// If approaches cannot be computed, as in [`Ground::new`].
    pub fn new(
        study: &'a Study,
        purchase: &'a Purchase,
        worlds: &'a [World],
        memory_bytes: u64,
    ) -> Result<Purchasing<'a>> {
        let mut questions = vec![(PurchaseAim::All, Terms::from_study(study))];
        questions.extend(purchase.disturb.map(|_| (PurchaseAim::Disturbed, Terms::from_study(study))));
        match purchase.front {
            Some(PurchaseFront::Speed) => {
                let speeds = study.stopping.iter().flat_map(|stopping| 0..stopping.speeds.len());
                questions
                    .extend(speeds.map(|speed| (PurchaseAim::Speed(speed), Terms::at_speed(study, speed))));
            }
            Some(PurchaseFront::Requirements) => {
                let all = Terms::from_study(study);
                let count = all.requirements.len();
                let without = |one: usize| (PurchaseAim::Without(one), all.only(&all.all_but(one)));
                questions.extend((0..count).map(without));
                questions.extend((1..count).rev().map(|least| (PurchaseAim::Number(least), all.clone())));
            }
            None => {}
        }
        let is_near =
            |(_, terms): &(PurchaseAim, Terms)| terms.requirements.iter().any(Requirement::is_of_nearness);
        let decides_near = matches!(purchase.then, Some(ThenScore::Nearness(_)));
        let grounds = match decides_near || questions.iter().any(is_near) {
            true => Ground::from_scenes(study, worlds, &[])?,
            false => Vec::new(),
        };
        let counted =
            questions.iter().flat_map(|(_, terms)| &terms.requirements).filter_map(Requirement::region);
        let regions: BTreeSet<usize> =
            counted.chain(counted_then(purchase).map(|then| then.region)).collect();
        let (items, regions) = (candidates_of(study), regions.into_iter().collect());
        let between_reports = BETWEEN_REPORTS;
        Ok(Purchasing {
            study,
            purchase,
            worlds,
            memory_bytes,
            items,
            grounds,
            asked: questions,
            regions,
            between_reports,
        })
    }

    /// Reads the evidence in a folder, and stores new evidence there; `restart` discards the old. Without a folder none
    /// is stored.
    ///
    /// # Errors
    /// Those of [`Casting::begin`].
    pub fn begin_casting(&self, folder: Option<&Path>, restart: bool) -> Result<Casting<'a>> {
        let regions: Vec<_> = self.regions.iter().map(|&region| (region, WantedCounts::ALL)).collect();
        let kept = folder.map(|folder| (folder, restart));
        let Purchase { representations, .. } = self.purchase;
        Casting::begin(self.study, &regions, representations, self.worlds, self.memory_bytes, kept)
    }

    /// The number of looks in [`Purchasing::look`].
    pub fn looks(&self) -> u64 {
        SceneWays::total(self.study, &self.grounds, self.items.len())
    }

    /// Computes what every candidate watches of the space of bodies.
    ///
    /// # Errors
    /// `Error::Stopped`.
    pub fn look(&self, progress: &dyn Progress) -> Result<Vec<SceneWays<'_>>> {
        let watcher = |&[sensor, candidate]: &[usize; 2]| Watcher {
            sensor,
            candidate,
            representation: self.purchase.representations[sensor],
        };
        let watchers: Vec<Watcher> = self.items.iter().map(watcher).collect();
        SceneWays::all(self.study, &self.grounds, &watchers, progress)
    }

    /// Searches for the cheapest set of each aim, and for the set that comes nearest if none passes all.
    ///
    /// # Errors
    /// If a backend fails while a set is judged; if evidence in a file cannot be read.
    pub fn search(
        &self,
        evidence: &[CandidateEvidence],
        ways: &[SceneWays],
        open: &dyn Fn() -> Result<ChosenBackends>,
        progress: &dyn Progress,
    ) -> Result<PurchaseReport> {
        let [rules, if_disturbed] = [self.purchase.disturb, None].map(|disturb| self.rules(disturb));
        let problems = self.regions.iter().zip(evidence);
        let problems: Vec<(usize, Problem)> =
            problems.map(|(&region, evidence)| (region, self.problem(evidence, &rules))).collect();
        let areas = self.asks_areas().then(|| Areas::new(ways, &self.items, self.purchase.at_most));
        let reporter = SearchReporter::new(self, progress, self.between_reports);
        let mut search = PurchaseSearch {
            purchasing: self,
            reporter: &reporter,
            rules: &rules,
            problems: &problems,
            ways,
            areas: areas.as_ref(),
            known: Vec::new(),
            all: Terms::from_study(self.study),
            answers: BTreeMap::new(),
            most_ties: MOST_TIES,
            open,
            progress,
        };
        let (mut points, mut is_cut) = (Vec::new(), false);
        for (aim, terms) in &self.asked {
            is_cut |= !points.is_empty() && progress.stops();
            if is_cut {
                break;
            }
            search.rules = if *aim == PurchaseAim::Disturbed { &if_disturbed } else { &rules };
            let all = 0..terms.requirements.len();
            let aim_report = AimReport::new(self.study, *aim);
            reporter.begin(&aim_report, terms);
            let (found, missed) = match *aim {
                PurchaseAim::All => (search.cheapest_of(&all.collect::<Vec<_>>())?, Vec::new()),
                PurchaseAim::Without(one) => (search.cheapest_of(&search.all.all_but(one))?, Vec::new()),
                PurchaseAim::Speed(_) | PurchaseAim::Disturbed => (search.cheapest(terms)?, Vec::new()),
                PurchaseAim::Number(least) => {
                    let then = self.purchase.then.as_ref().map(better);
                    NumberQuestion { count: all.len(), least, then }.answer(&mut search)?
                }
            };
            reporter.end(&found);
            let is_explained = !matches!(aim, PurchaseAim::Number(_));
            let reasons = if is_explained { search.reasons(terms, &found)? } else { Vec::new() };
            is_cut |= is_explained && found.is_proven && found.best.is_none() && reasons.is_empty();
            let name = |place: usize| terms.requirements[place].name.clone();
            search.most_ties = 0;
            let mut point = self.point(aim_report, terms, &found, reasons);
            point.missed = missed.into_iter().map(name).collect();
            if let (PurchaseAim::Disturbed, Some(best)) = (aim, &found.best) {
                point.disturbed = self.forbidden(&best.set, &rules);
            }
            points.push(point);
            if points.len() == 1 && !points[0].reasons.is_empty() {
                let nearest = self.nearest(&mut search, &points[0].reasons)?;
                is_cut |= nearest.is_none() && progress.stops();
                points.extend(nearest);
            }
        }
        evidence.iter().try_for_each(CandidateEvidence::was_read)?;
        let ways_in = search.known.iter().map(|way| self.proven_way(&ways[way.scene], way)).collect();
        let stopped = is_cut || points.iter().any(|point| !point.proven || !point.best_of_cost);
        Ok(PurchaseReport::new((self.study, self.purchase, self.worlds), points, ways_in, stopped))
    }

    /// Reads the answer in a folder.
    ///
    /// # Errors
    /// `Error::Input` that names what is wrong.
    pub fn read_claims(&self, folder: &Path) -> Result<PurchaseClaims> {
        PurchaseClaims::read(folder, self.proof_input(&[], &|| None))
    }

    /// Verifies an answer with all its files.
    ///
    /// # Errors
    /// `Error::Input` that names the wrong claim; `Error::Stopped`.
    pub fn verify(
        &self,
        claims: &PurchaseClaims,
        evidence: &[CandidateEvidence],
        open: &dyn Fn() -> Result<ChosenBackends>,
        progress: &dyn Progress,
    ) -> Result<PurchaseVerified> {
        verify(claims, self.proof_input(evidence, progress), open)
    }

    pub(super) fn proof_input<'p>(
        &'p self,
        evidence: &'p [CandidateEvidence],
        progress: &'p dyn Progress,
    ) -> ProofInput<'p> {
        let Purchasing { study, purchase, worlds, items, grounds, asked, regions, .. } = self;
        let disturbed = DisturbedPairs::none();
        ProofInput { study, purchase, worlds, items, grounds, asked, regions, disturbed, evidence, progress }
    }

    /// The cheapest set that meets all requirements except those that cannot be met, if any.
    fn nearest(
        &self,
        search: &mut PurchaseSearch,
        reasons: &[ReasonReport],
    ) -> Result<Option<PurchasePoint>> {
        let mut terms = Terms::from_study(self.study);
        let mut left_out: Vec<String> = Vec::new();
        let mut reasons = reasons.to_vec();
        while !reasons.is_empty() {
            left_out.extend(reasons.into_iter().map(|reason| reason.requirement));
            terms.requirements.retain(|one| !left_out.contains(&one.name));
            if terms.requirements.is_empty() {
                return Ok(None);
            }
            search.reporter.begin(&AimReport::Nearest(left_out.clone()), &terms);
            let found = search.cheapest(&terms)?;
            search.reporter.end(&found);
            reasons = search.reasons(&terms, &found)?;
            if found.best.is_some() {
                return Ok(Some(self.point(AimReport::Nearest(left_out), &terms, &found, Vec::new())));
            }
        }
        Ok(None)
    }

    pub(super) fn point(
        &self,
        aim: AimReport,
        terms: &Terms,
        found: &CheapestAnswer,
        reasons: Vec<ReasonReport>,
    ) -> PurchasePoint {
        let set = found.best.as_ref().map(|best| self.purchased_set(aim.title(), terms, best));
        PurchasePoint {
            aim,
            set,
            no_set_below: found.no_set_below.map(Cost::from_thousandths),
            proven: found.is_proven,
            best_of_cost: found.is_best_of_cost,
            compared: found.best.is_some().then_some(found.compared).filter(|_| !found.is_best_of_cost),
            ties: found.ties,
            tested: found.tested,
            disturbed: Vec::new(),
            reasons,
            missed: Vec::new(),
        }
    }

    /// A set in names of the study.
    pub(super) fn purchased_set(&self, name: String, terms: &Terms, best: &FoundPurchase) -> PurchasedSet {
        let combination = combination(self.study, self.purchase, &self.items, name.clone(), &best.set);
        let members = combination.members.iter().map(|member| [member.sensor, member.candidates[0]]);
        PurchasedSet {
            name,
            cost: Cost::from_thousandths(best.cost),
            score: best.worth.and_then(|worth| self.then_value(terms, worth)),
            sensors: members.map(|one| self.sensor(one)).collect(),
        }
    }

    /// The currency of all costs.
    pub(super) fn currency(&self) -> Option<String> {
        self.study.currency.clone()
    }

    /// The score that decides among sets of the same cost, as a number.
    fn then_value(&self, terms: &Terms, worth: Worth) -> Option<f64> {
        match (&self.purchase.then, worth) {
            (Some(ThenScore::Nearness(score)), Worth::Exact(squared)) => {
                terms.near_value(self.study, *score, u32::try_from(squared.numerator).ok())
            }
            _ => Some(worth.value()),
        }
    }

    /// The pairs of a set that a rule forbids, by name.
    fn forbidden(&self, set: &[usize], rules: &SetRules) -> Vec<[String; 2]> {
        let is_always = |item: usize| rules.always.contains(&item);
        let is_forbidden =
            |&(a, b): &(usize, usize)| a < b && !(is_always(a) && is_always(b)) && !rules.may_join(&[a], b);
        let mut set = set.to_vec();
        set.sort_unstable();
        let pairs = set.iter().flat_map(|&a| set.iter().map(move |&b| (a, b)));
        let name = |item: usize| pose_name(self.study, self.items[item]);
        pairs.filter(is_forbidden).map(|(a, b)| [name(a), name(b)]).collect()
    }

    fn sensor(&self, [sensor, candidate]: [usize; 2]) -> PurchasedSensor {
        let spec = &self.study.sensors[sensor];
        PurchasedSensor {
            sensor: spec.name.clone(),
            pose: spec.candidates[candidate].name.clone(),
            place: Places::new(self.study, &self.worlds[0]).words(sensor, candidate),
            cost: spec.terms.cost.unwrap_or_default(),
        }
    }

    fn proven_way(&self, ways: &SceneWays, way: &WayIn) -> ProvenWay {
        let passage = &ways.passages[way.passage];
        ProvenWay {
            scene: self.study.scenes[passage.scene].name.clone(),
            people: passage.company.name().into(),
            repeat: passage.repeat,
            body: passage.body.clone(),
            entry: passage.entry.clone(),
            places: way.places.clone(),
            nearest_m: f64::from(way.squared).sqrt() * self.study.voxel_size_m,
            noticed_by: way.noticed_by.iter().map(|&item| pose_name(self.study, self.items[item])).collect(),
        }
    }

    /// The same without pauses between progress reports.
    #[cfg(test)]
    pub(super) fn with_all_reports(self) -> Purchasing<'a> {
        Purchasing { between_reports: Duration::ZERO, ..self }
    }

    /// Sensor and candidate index of each candidate.
    #[cfg(test)]
    pub(super) fn items(&self) -> &[[usize; 2]] {
        &self.items
    }

    /// Whether a requirement limits an unnoticed area.
    fn asks_areas(&self) -> bool {
        let requirements = self.asked.iter().flat_map(|(_, terms)| &terms.requirements);
        let mut measures = requirements.map(|requirement| &requirement.measure);
        measures.any(|measure| {
            matches!(measure, Measure::Nearness(nearness) if nearness.score == ApproachScore::UnnoticedM2)
        })
    }

    /// The allowed pairs of candidates and their costs; with `disturb`, pairs that disturb each other are excluded.
    fn rules(&self, disturb: Option<Disturb>) -> SetRules {
        let Purchase { always, apart_m, .. } = self.purchase;
        let terms = PairTerms { apart_m: *apart_m, disturb };
        rules_of(self.study, &self.items, self.worlds, always, terms)
    }

    pub(super) fn limits(&self) -> SetLimits {
        let Purchase { at_most, budget, .. } = *self.purchase;
        SetLimits { at_most, budget: budget.map(Cost::thousandths) }
    }

    /// The evidence in a region, in terms of the solver.
    fn problem<'e>(&self, evidence: &'e CandidateEvidence, rules: &SetRules) -> Problem<'e> {
        let Purchase { fusion, representations, .. } = self.purchase;
        Problem {
            evidence,
            goal: (Score::F1, Across::Pooled),
            require: Vec::new(),
            limits: self.limits(),
            rules: rules.clone(),
            odds: odds_of(self.study, *fusion, representations, evidence),
        }
    }
}

/// The score of counts that decides among sets of the same cost, if any.
pub(super) fn counted_then(purchase: &Purchase) -> Option<&Counted> {
    match &purchase.then {
        Some(ThenScore::Counted(counted)) => Some(counted),
        _ => None,
    }
}

/// The better of two sets of the same cost.
fn better(then: &ThenScore) -> Better {
    match then {
        ThenScore::Counted(counted) => Better::from_score(counted.score),
        ThenScore::Nearness(_) => Better::More,
    }
}
