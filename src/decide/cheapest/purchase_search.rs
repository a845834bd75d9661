//! The search for the cheapest set that passes some terms: the solver proposes sets, and requirements without a bound
//! are judged.

use std::collections::BTreeMap;

use perirobot_cover::cheapest::{
    CheapestAnswer, CheapestProblem, SetTest, Share, TestAnswer, TieRule, TieScore, cheapest,
};
use perirobot_cover::{Problem, SetRules};
use perirobot_march::Result;
use perirobot_march::backend::factory::ChosenBackends;
use perirobot_march::metrics::{Ratio, Score};
use perirobot_march::progress::Progress;
use perirobot_study::input::{Counted, Limit, Requirement, ThenScore};

use super::areas::Areas;
use super::number::{FamiliesKnown, Subsets};
use super::passing::PassingTest;
use super::purchasing::Purchasing;
use super::reasons::{self, Obstacle};
use super::remaining::Remaining;
use super::report::ReasonReport;
use super::reporter::SearchReporter;
use super::terms::{Terms, bounding, dead_in};
use super::ways::{SceneWays, WayIn};

/// A search for sets that pass several terms, one after the other; known ways in are kept.
pub(super) struct PurchaseSearch<'s, 'a> {
    pub(super) purchasing: &'s Purchasing<'a>,
    pub(super) reporter: &'s SearchReporter<'s, 'a>,
    pub(super) rules: &'s SetRules,
    pub(super) problems: &'s [(usize, Problem<'s>)],
    pub(super) ways: &'s [SceneWays<'s>],
    pub(super) areas: Option<&'s Areas>,
    pub(super) known: Vec<WayIn>,
    /// The study's requirements.
    pub(super) all: Terms,
    /// Proven bounds for subsets of the requirements, by their places.
    pub(super) answers: BTreeMap<Vec<usize>, CheapestAnswer>,
    /// The most other sets of the same cost that are counted.
    pub(super) most_ties: usize,
    pub(super) open: &'s dyn Fn() -> Result<ChosenBackends>,
    pub(super) progress: &'s dyn Progress,
}

impl PurchaseSearch<'_, '_> {
    pub(super) fn cheapest(&mut self, terms: &Terms) -> Result<CheapestAnswer> {
        let (problems, Purchasing { purchase, .. }) = (self.problems, self.purchasing);
        let shares = terms.requirements.iter().flat_map(|one| shares(one, problems)).collect();
        let then = match &purchase.then {
            Some(ThenScore::Counted(Counted { score, region, over })) => {
                let known = problems.iter().find(|(known, _)| known == region);
                let (score, over) = (*score, *over);
                known.map(|(_, problem)| TieRule::Score(TieScore { problem, score, over }))
            }
            Some(ThenScore::Nearness(_)) => Some(TieRule::Tested),
            None => None,
        };
        let limits = self.purchasing.limits();
        let (progress, reporter, rules) = (self.progress, self.reporter, self.rules);
        let (areas, most_ties) = (self.areas, self.most_ties);
        let mut test = self.test(terms);
        if test.too_near_at_entry().is_some() {
            return Ok(CheapestAnswer::NONE);
        }
        let mut demands = test.known_demands();
        let largest = test.largest_areas();
        let coverages = areas.iter().flat_map(|areas| largest.iter().filter_map(|one| areas.coverage(one)));
        let problem =
            CheapestProblem { rules, limits, shares, coverages: coverages.collect(), then, most_ties };
        cheapest(&problem, &mut demands, &mut test, progress, &|known| reporter.show(known))
    }

    fn test<'t>(&'t mut self, terms: &'t Terms) -> PassingTest<'t, 't> {
        let Purchasing { study, purchase, worlds, items, .. } = self.purchasing;
        let remaining = Remaining::new((study, purchase, worlds), terms, items, self.open, self.progress);
        let scale = (items.len(), study.voxel_size_m);
        PassingTest::new(terms, self.problems, (self.ways, &mut self.known), scale, remaining)
    }

    /// Why no set passes, if that is proven; empty if the search was stopped.
    pub(super) fn reasons(&mut self, terms: &Terms, found: &CheapestAnswer) -> Result<Vec<ReasonReport>> {
        if found.best.is_some() || !found.is_proven {
            return Ok(Vec::new());
        }
        let mut is_possible = |terms: &Terms| {
            let found = self.cheapest(terms)?;
            Ok(found.best.is_some() || !found.is_proven)
        };
        let places = reasons::fewest(terms, &mut is_possible)?;
        if self.progress.stops() {
            return Ok(Vec::new());
        }
        let study = self.purchasing.study;
        if let [place] = places[..] {
            let alone = terms.only(&[place]);
            let requirement = &terms.requirements[place];
            let candidates = (study, &*self.purchasing.items);
            let test = self.test(&alone);
            let obstacle = Obstacle::new(requirement, &test, candidates);
            let why = obstacle.words(study, terms.stopping.as_ref(), requirement);
            return Ok(reasons::reports(terms, &places, &|_| why.clone()));
        }
        Ok(reasons::reports(terms, &places, &|one| reasons::describe_demand(study, one)))
    }
}

impl Subsets for PurchaseSearch<'_, '_> {
    fn cheapest_of(&mut self, places: &[usize]) -> Result<CheapestAnswer> {
        let mut places = places.to_vec();
        places.sort_unstable();
        if let Some(known) = self.answers.get(&places) {
            return Ok(CheapestAnswer { tested: 0, ..known.clone() });
        }
        let found = self.cheapest(&self.all.only(&places))?;
        if found.is_proven && found.is_best_of_cost {
            self.answers.insert(places, found.clone());
        }
        Ok(found)
    }

    fn missed_by(&mut self, set: &[usize]) -> Result<Vec<usize>> {
        let mut missed = Vec::new();
        for place in 0..self.all.requirements.len() {
            let alone = self.all.only(&[place]);
            if self.test(&alone).test(set)? != TestAnswer::Passes {
                missed.push(place);
            }
        }
        Ok(missed)
    }

    fn show(&mut self, known: FamiliesKnown) {
        self.reporter.show_families(known);
    }
}

/// A requirement on counts, in terms of the solver.
fn shares<'e>(requirement: &Requirement, problems: &'e [(usize, Problem<'e>)]) -> Vec<Share<'e>> {
    let (counted, limit, more_dead) = match (bounding(requirement), requirement.counted_score()) {
        (Some((counted, limit)), _) => (*counted, limit.ratio(), 0),
        (None, Some(counted)) => match seen_once_without_any(counted, requirement.limit) {
            Some((counted, limit)) => (counted, limit, 1),
            None => return Vec::new(),
        },
        (None, None) => return Vec::new(),
    };
    let Some((_, problem)) = problems.iter().find(|(region, _)| *region == counted.region) else {
        return Vec::new();
    };
    let share =
        |dead| Share { problem, score: counted.score, over: counted.over, limit, dead: dead + more_dead };
    requirement.under.iter().filter_map(|&condition| dead_in(condition)).map(share).collect()
}

/// A voxel seen by two sensors is still seen if one of them fails: so a share seen twice bounds the unknown share
/// without any one member.
fn seen_once_without_any(counted: &Counted, limit: Limit) -> Option<(Counted, Ratio)> {
    let Limit::AtLeast(least) = limit else { return None };
    let Ratio { numerator, denominator } = least;
    let unknown = Ratio { numerator: denominator - numerator, denominator };
    (counted.score == Score::SeenTwice).then_some((Counted { score: Score::Unknown, ..*counted }, unknown))
}
