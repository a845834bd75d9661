//! The stages of a search for the cheapest set that passes: every candidate is cast once, then sets are searched.

use perirobot_cover::cheapest::{CheapestAnswer, CheapestProblem, Share, cheapest};
use perirobot_cover::layout::WantedCounts;
use perirobot_cover::{CandidateEvidence, Problem, Ratio, SetLimits, SetRules};
use perirobot_march::Result;
use perirobot_march::backend::factory::{BackendFactory, ChosenBackends};
use perirobot_march::metrics::{Across, Score};
use perirobot_march::progress::Progress;
use perirobot_study::sensor::Cost;
use perirobot_study::study::{Purchase, PurchaseFront, Requirement, Study};
use perirobot_study::world::World;
use perirobot_sweep::sweep::Failover;

use super::passing::PassingTest;
use super::remaining::Remaining;
use super::terms::{Terms, bounding, dead_in, is_counted};
use super::ways::{SceneWays, WayIn};
use crate::approach::Ground;
use crate::choose::{Casting, odds_of, rules_of};
use crate::view::watched::Watcher;

/// A search for the cheapest set.
pub struct Purchasing<'a> {
    study: &'a Study,
    purchase: &'a Purchase,
    worlds: &'a [World],
    memory_bytes: u64,
    /// Sensor and candidate of each candidate.
    items: Vec<[usize; 2]>,
    /// The scenes as bodies move through them; none where nothing is required of that.
    grounds: Vec<Ground<'a>>,
    /// What is asked for, in the order in which it is searched.
    asked: Vec<(PurchaseAim, Terms)>,
    /// The regions in which anything is counted.
    regions: Vec<usize>,
}

/// What a set is to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PurchaseAim {
    /// All requirements.
    All,
    /// All requirements, so that the robot may run at the speed of this number.
    Speed(usize),
    /// All requirements but the one of this number.
    Without(usize),
}

/// The cheapest set for one aim.
#[derive(Clone, Debug)]
pub struct PurchaseAnswer {
    /// What it is to pass.
    pub aim: PurchaseAim,
    /// What was found.
    pub found: CheapestAnswer,
}

impl<'a> Purchasing<'a> {
    /// What a study asks for.
    ///
    /// # Errors
    /// When it cannot be asked how near bodies come, as in [`Ground::new`].
    pub fn new(
        study: &'a Study,
        purchase: &'a Purchase,
        worlds: &'a [World],
        memory_bytes: u64,
    ) -> Result<Purchasing<'a>> {
        let items = study.sensors.iter().enumerate();
        let items: Vec<[usize; 2]> =
            items.flat_map(|(sensor, spec)| (0..spec.candidates.len()).map(move |c| [sensor, c])).collect();
        let mut asked = vec![(PurchaseAim::All, Terms::from_study(study))];
        match purchase.front {
            Some(PurchaseFront::Speed) => {
                let speeds = study.stopping.iter().flat_map(|stopping| 0..stopping.speeds.len());
                asked.extend(speeds.map(|speed| (PurchaseAim::Speed(speed), Terms::at_speed(study, speed))));
            }
            Some(PurchaseFront::Requirements) => {
                let all = Terms::from_study(study);
                let each = 0..all.requirements.len();
                asked.extend(each.map(|one| (PurchaseAim::Without(one), all.without(&[one]))));
            }
            None => {}
        }
        let is_near =
            |(_, terms): &(PurchaseAim, Terms)| terms.requirements.iter().any(Requirement::is_of_nearness);
        let grounds = match asked.iter().any(is_near) {
            true => Ground::from_scenes(study, worlds, &[])?,
            false => Vec::new(),
        };
        let mut regions: Vec<usize> = asked.iter().flat_map(|(_, terms)| terms.regions()).collect();
        regions.extend(purchase.then.map(|then| then.region));
        regions.sort_unstable();
        regions.dedup();
        Ok(Purchasing { study, purchase, worlds, memory_bytes, items, grounds, asked, regions })
    }

    /// Casts every candidate.
    ///
    /// # Errors
    /// When the backend fails; when the evidence takes more memory than it may; `Error::Stopped`.
    pub fn cast(
        &self,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Vec<CandidateEvidence>> {
        let mut all = Vec::new();
        for &region in &self.regions {
            let mut casting = Casting::new(
                self.study,
                self.worlds,
                (region, &self.purchase.representations),
                WantedCounts::ALL,
                self.memory_bytes,
                None,
            )?;
            casting.run_on(&mut Failover::new(backends, progress))?;
            all.push(casting.evidence());
        }
        Ok(all)
    }

    /// How many looks of [`Purchasing::look`] there are.
    pub fn looks(&self) -> u64 {
        SceneWays::total(self.study, &self.grounds, self.items.len())
    }

    /// Looks from every candidate at where bodies come near.
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

    /// Searches for the cheapest set of each aim.
    ///
    /// # Errors
    /// When a backend fails that judges what no bound tells; when evidence in a file cannot be read.
    pub fn search(
        &self,
        evidence: &[CandidateEvidence],
        ways: &[SceneWays],
        open: &dyn Fn() -> Result<ChosenBackends>,
        progress: &dyn Progress,
    ) -> Result<Vec<PurchaseAnswer>> {
        let rules = self.rules();
        let problems = self.regions.iter().zip(evidence);
        let problems: Vec<(usize, Problem)> =
            problems.map(|(&region, evidence)| (region, self.problem(evidence, &rules))).collect();
        let mut known = Vec::new();
        let mut answers = Vec::new();
        for (aim, terms) in &self.asked {
            let found = self.cheapest(terms, (&rules, &problems), (ways, &mut known), open, progress)?;
            answers.push(PurchaseAnswer { aim: *aim, found });
            if progress.stops() {
                break;
            }
        }
        evidence.iter().try_for_each(CandidateEvidence::was_read)?;
        Ok(answers)
    }

    /// Sensor and candidate of each candidate.
    #[cfg(test)]
    pub(super) fn items(&self) -> &[[usize; 2]] {
        &self.items
    }

    /// Which candidates a set may have together, and what they cost.
    pub(super) fn rules(&self) -> SetRules {
        let Purchase { always, apart_m, .. } = self.purchase;
        rules_of(self.study, &self.items, self.worlds, always, *apart_m)
    }

    pub(super) fn limits(&self) -> SetLimits {
        let Purchase { at_most, budget, .. } = *self.purchase;
        SetLimits { at_most, budget: budget.map(Cost::thousandths) }
    }

    /// What candidates say in a region, as the solver has it.
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

    fn cheapest(
        &self,
        terms: &Terms,
        (rules, problems): (&SetRules, &[(usize, Problem)]),
        (ways, known): (&[SceneWays], &mut Vec<WayIn>),
        open: &dyn Fn() -> Result<ChosenBackends>,
        progress: &dyn Progress,
    ) -> Result<CheapestAnswer> {
        let asked = (self.study, self.purchase, self.worlds);
        let remaining = Remaining::new(asked, terms, &self.items, open, progress);
        let scale = (self.items.len(), self.study.voxel_size_m);
        let mut test = PassingTest::new(terms, problems, (ways, known), scale, remaining);
        if test.too_near_at_entry().is_some() {
            return Ok(CheapestAnswer::NONE);
        }
        let shares = terms.requirements.iter().flat_map(|one| shares(one, problems)).collect();
        let then = self.purchase.then.and_then(|then| {
            let (_, problem) = problems.iter().find(|(region, _)| *region == then.region)?;
            let limit = Ratio::from_f64(0.0);
            Some(Share { evidence: problem.evidence, score: then.score, over: then.over, limit, dead: 0 })
        });
        let problem = CheapestProblem { rules, limits: self.limits(), shares, then };
        let mut demands = test.known_demands();
        cheapest(&problem, &mut demands, &mut test, progress)
    }
}

/// What a requirement says of counts, as the solver has it: of scores that sums of what sensors say decide, nothing.
fn shares<'e>(requirement: &Requirement, problems: &[(usize, Problem<'e>)]) -> Vec<Share<'e>> {
    let Some((counted, limit)) = bounding(requirement) else { return Vec::new() };
    let Some((_, problem)) = problems.iter().find(|(region, _)| *region == counted.region) else {
        return Vec::new();
    };
    if problem.asking(counted.score, counted.over).adds_up() {
        return Vec::new();
    }
    let limit = limit.ratio();
    let under = requirement.under.iter().filter(|&&condition| is_counted(requirement, condition));
    let share =
        |dead| Share { evidence: problem.evidence, score: counted.score, over: counted.over, limit, dead };
    under.filter_map(|&condition| dead_in(condition)).map(share).collect()
}
