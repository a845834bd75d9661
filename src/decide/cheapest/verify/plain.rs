//! A plain search for a set that passes within some cost.
//!
//! # Theory
//! A passing set contains enough of the candidates that notice each way in. For the way with the fewest choices, all
//! sets with the first of these are tried, then those with the second and without the first, and so on; if all ways are
//! noticed, all candidates are tried in order. A branch ends if a way needs more candidates than are left, if ways
//! without a common candidate cost too much, or if scores of counts are out of reach (`counted`). The remaining sets are
//! counted, and finally judged.

use super::ProofInput;
use super::counted::{Bar, Reach, Tally, is_of_labels, value};
use super::judged::{Verdict, asking_nearest, judge, restricted_study};
use super::ways::NearFacts;
use crate::cheapest::remaining::OpenBackends;
use crate::cheapest::terms::{Terms, dead_in};
use crate::choose::{odds_of, thousandths};
use crate::judge::Value;
use perirobot_march::Result;
use perirobot_march::metrics::{Across, Ratio, Score};
use perirobot_study::input::{Counted, Limit, Measure, Requirement, Study};
use perirobot_study::sensor::Cost;

/// The most sets per search.
const MOST_SETS: u64 = 2_000_000;

/// The most judged sets per search.
const MOST_JUDGED: u64 = 2_000;

/// How a search ended.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum SearchEnd {
    /// No set passes.
    NonePasses,
    /// This set passes.
    Passes(Vec<usize>),
    /// There are too many sets.
    Open,
}

/// Candidates of which a set needs `count`.
struct Need {
    among: Vec<bool>,
    least: usize,
}

/// A search for a set that passes some terms.
pub(super) struct PlainSearch<'s> {
    input: ProofInput<'s>,
    open: OpenBackends<'s>,
    /// Whether a body is already too near at its entry.
    is_hopeless: bool,
    needs: Vec<Need>,
    reaches: Vec<Reach<'s>>,
    /// The bound that the deciding score must beat.
    then: Option<Beaten<'s>>,
    /// The number of wanted sets.
    wanted: usize,
    /// The requirements that must be judged.
    judged: Option<Study>,
    /// The cost of each candidate, and the budget, in thousandths.
    costs: Vec<u64>,
    most_cost: Option<u64>,
    /// For each candidate the others allowed in a set with it.
    together: Vec<Vec<bool>>,
    looked_at: u64,
    judgements: u64,
    found: Vec<Vec<usize>>,
    is_open: bool,
}

/// The bound that a set must beat.
enum Beaten<'s> {
    /// A score of counts, decided by unions or, under log-odds, by judge.
    Score(Reach<'s>),
    /// The share seen by at least two sensors; it bounds the unknown share without any one member.
    Overlap { unknown: Option<Reach<'s>>, counted: Counted, seen: Ratio },
    /// The same as a mean.
    MeanOverlap(Counted, f64),
    /// The closest distance of bodies, squared in voxels.
    Nearest(u32),
}

/// The unmet demands of ways in.
struct Unmet {
    /// The smallest group of candidates of a way that may join.
    first: Vec<usize>,
    /// Lower bounds of the additional cost and number.
    cost: u64,
    members: usize,
}

impl<'s> PlainSearch<'s> {
    /// A search for sets that pass some terms and cost at most `most`.
    pub(super) fn new(
        (input, open): (ProofInput<'s>, OpenBackends<'s>),
        facts: &NearFacts,
        terms: &Terms,
        most_cost: Option<u64>,
    ) -> PlainSearch<'s> {
        let ProofInput { study, purchase, items, .. } = input;
        let need = |way| {
            let least = facts.needed(input, terms, way)?;
            Some(Need { among: way.noticed_by.clone(), least })
        };
        let (mut reaches, mut judged) = (Vec::new(), Vec::new());
        for requirement in &terms.requirements {
            let mut others = Requirement { under: Vec::new(), ..requirement.clone() };
            for &condition in &requirement.under {
                let reach = match (&requirement.measure, dead_in(condition)) {
                    (Measure::Counted(counted), Some(dead)) => {
                        let bar = Bar::Keeps(requirement.limit);
                        input.reach((counted.score, counted.over, counted.region), bar, dead)
                    }
                    _ => None,
                };
                if reach.as_ref().is_none_or(|reach| reach.adds_up) {
                    others.under.push(condition);
                }
                reaches.extend(reach);
            }
            judged.extend((!others.under.is_empty()).then_some(others));
        }
        let allowed = input.allowed();
        let pair =
            |a: usize| (0..items.len()).map(|b| allowed.clash(&[items[a], items[b]]).is_none()).collect();
        let own = |budget: Option<Cost>| budget.map(Cost::thousandths);
        PlainSearch {
            input,
            open,
            is_hopeless: facts.too_near_at_entry(input, terms).is_some(),
            needs: facts.ways.iter().filter_map(need).collect(),
            reaches,
            then: None,
            wanted: 1,
            judged: (!judged.is_empty()).then(|| restricted_study(study, judged, terms.stopping.clone())),
            costs: items.iter().map(|&[sensor, _]| thousandths(study, sensor)).collect(),
            most_cost: most_cost.into_iter().chain(own(purchase.budget)).min(),
            together: (0..items.len()).map(pair).collect(),
            looked_at: 0,
            judgements: 0,
            found: Vec::new(),
            is_open: false,
        }
    }

    /// Sets the number of wanted sets.
    pub(super) fn at_least(self, wanted: usize) -> Self {
        PlainSearch { wanted, ..self }
    }

    /// Accepts only sets that are better by the deciding score of counts.
    pub(super) fn beating(mut self, terms: &Terms, reach: Reach<'s>) -> Self {
        if reach.adds_up {
            self.judge_all(terms);
        }
        self.then = Some(Beaten::Score(reach));
        self
    }

    /// Accepts only sets with a larger share seen by at least two sensors (a number if it is a mean). A voxel seen by
    /// two is still seen if one fails.
    pub(super) fn beating_overlap(
        mut self,
        terms: &Terms,
        counted: Counted,
        seen: Result<Ratio, f64>,
    ) -> Self {
        self.judge_all(terms);
        self.then = Some(match seen {
            Ok(seen) => {
                let Ratio { numerator, denominator } = seen;
                let most = Ratio { numerator: denominator - numerator, denominator };
                let bar = Bar::Beats(Limit::AtMost(most));
                let unknown = self.input.reach((Score::Unknown, counted.over, counted.region), bar, 1);
                Beaten::Overlap { unknown: unknown.filter(|unknown| !unknown.adds_up), counted, seen }
            }
            Err(mean) => Beaten::MeanOverlap(counted, mean),
        });
        self
    }

    /// Accepts only sets that keep bodies farther away than this, squared in voxels.
    pub(super) fn beating_nearest(mut self, facts: &NearFacts, terms: &Terms, squared: u32) -> Self {
        self.is_hopeless |= facts.entries.iter().any(|entry| entry.squared <= squared);
        let ways = facts.ways.iter().filter(|way| way.squared <= squared);
        self.needs.extend(ways.map(|way| Need { among: way.noticed_by.clone(), least: 1 }));
        self.judge_all(terms);
        self.judged = self.judged.map(asking_nearest);
        self.then = Some(Beaten::Nearest(squared));
        self
    }

    /// Judges every remaining set: by all requirements, if none else must be judged.
    fn judge_all(&mut self, terms: &Terms) {
        let study = self.input.study;
        let all = || restricted_study(study, terms.requirements.clone(), terms.stopping.clone());
        self.judged = Some(self.judged.take().unwrap_or_else(all));
    }

    /// Runs the search.
    ///
    /// # Errors
    /// If a backend fails; `Error::Stopped`.
    pub(super) fn run(self) -> Result<SearchEnd> {
        let (mut found, is_open) = self.find()?;
        Ok(match found.pop() {
            Some(set) => SearchEnd::Passes(set),
            None if is_open => SearchEnd::Open,
            None => SearchEnd::NonePasses,
        })
    }

    /// Runs the search and returns the found sets, and whether there were too many to try.
    ///
    /// # Errors
    /// If a backend fails; `Error::Stopped`.
    pub(super) fn find(mut self) -> Result<(Vec<Vec<usize>>, bool)> {
        let ProofInput { purchase, items, .. } = self.input;
        let fixed: Vec<usize> =
            (0..items.len()).filter(|&item| purchase.always.contains(&items[item])).collect();
        let others: Vec<usize> = (0..items.len()).filter(|item| !fixed.contains(item)).collect();
        if !self.is_hopeless && self.affords(self.cost(&fixed)) && fixed.len() <= purchase.at_most {
            self.try_sets(&fixed, &others)?;
        }
        Ok((self.found, self.is_open))
    }

    fn is_done(&self) -> bool {
        self.found.len() >= self.wanted || self.is_open
    }

    /// Tries all sets that contain some members.
    fn try_sets(&mut self, chosen: &[usize], others: &[usize]) -> Result<()> {
        if self.is_done() {
            return Ok(());
        }
        self.input.progress.check_stop()?;
        self.looked_at += 1;
        if self.looked_at > MOST_SETS {
            self.is_open = true;
            return Ok(());
        }
        let later = self.joinable(chosen, others);
        let Some(unmet) = self.unmet_needs(chosen, &later) else { return Ok(()) };
        let left = self.input.purchase.at_most - chosen.len();
        if unmet.members > left || !self.affords(self.cost(chosen) + unmet.cost) {
            return Ok(());
        }
        if self.all_reaches().any(|reach| reach.is_out_of_reach(chosen, &later)) {
            return Ok(());
        }
        if unmet.members > 0 {
            for (number, &item) in unmet.first.iter().enumerate() {
                let is_tried = |other: &usize| unmet.first[..=number].contains(other);
                let rest: Vec<usize> = later.iter().copied().filter(|other| !is_tried(other)).collect();
                self.try_sets(&extend_set(chosen, item), &rest)?;
            }
            return Ok(());
        }
        if self.passes(chosen)? {
            self.found.push(chosen.to_vec());
            if self.is_done() {
                return Ok(());
            }
        }
        self.try_supersets(chosen, later, left)
    }

    /// Tries all sets that contain some members and at least one more, most useful first.
    fn try_supersets(&mut self, chosen: &[usize], mut later: Vec<usize>, left: usize) -> Result<()> {
        let tallies: Vec<Tally> =
            self.all_reaches().flat_map(|reach| reach.tallies(chosen, &later)).collect();
        let mut order: Vec<usize> = (0..later.len()).collect();
        if let Some(worst) = tallies.iter().find(|tally| tally.lacks > 0) {
            order.sort_by_key(|&place| std::cmp::Reverse(worst.gains[place]));
        }
        later = order.iter().map(|&place| later[place]).collect();
        let tallies: Vec<Tally> = tallies.into_iter().map(|tally| tally.in_order(&order)).collect();
        let costs: Vec<u64> = later.iter().map(|&item| self.costs[item]).collect();
        let money = self.most_cost.map(|most| most - self.cost(chosen));
        for place in 0..later.len() {
            if !tallies.iter().all(|tally| tally.may_reach(place, left, (&costs, money))) {
                break;
            }
            self.try_sets(&extend_set(chosen, later[place]), &later[place + 1..])?;
        }
        Ok(())
    }

    /// The candidates that may join a set.
    fn joinable(&self, chosen: &[usize], others: &[usize]) -> Vec<usize> {
        let ProofInput { study, purchase, items, .. } = self.input;
        let cost = self.cost(chosen);
        let joins = |&item: &usize| {
            let sensor = items[item][0];
            let of_it = chosen.iter().filter(|&&other| items[other][0] == sensor).count();
            self.affords(cost + self.costs[item])
                && chosen.iter().all(|&other| self.together[other][item])
                && study.sensors[sensor].terms.at_most.is_none_or(|most| of_it < most as usize)
        };
        if chosen.len() >= purchase.at_most {
            Vec::new()
        } else {
            others.iter().copied().filter(joins).collect()
        }
    }

    /// The unmet demands of ways in; `None` if too few candidates are left.
    fn unmet_needs(&self, chosen: &[usize], later: &[usize]) -> Option<Unmet> {
        let mut unmet: Vec<(usize, Vec<usize>)> = Vec::new();
        for Need { among, least } in &self.needs {
            let lacks = least.saturating_sub(chosen.iter().filter(|&&item| among[item]).count());
            let may: Vec<usize> = later.iter().copied().filter(|&item| among[item]).collect();
            if may.len() < lacks {
                return None;
            }
            if lacks > 0 {
                unmet.push((lacks, may));
            }
        }
        unmet.sort_by_key(|(lacks, may)| may.len() - lacks);
        let (mut cost, mut members, mut used) = (0, 0, vec![false; self.costs.len()]);
        for (lacks, may) in &unmet {
            if may.iter().any(|&item| used[item]) {
                continue;
            }
            let mut costs: Vec<u64> = may.iter().map(|&item| self.costs[item]).collect();
            costs.sort_unstable();
            cost += costs[..*lacks].iter().sum::<u64>();
            members += lacks;
            may.iter().for_each(|&item| used[item] = true);
        }
        let first = unmet.into_iter().next().map_or(Vec::new(), |(_, may)| may);
        Some(Unmet { first, cost, members })
    }

    fn passes(&mut self, set: &[usize]) -> Result<bool> {
        let counts_decide = |reach: &&Reach| !reach.adds_up;
        if set.is_empty() || !self.all_reaches().filter(counts_decide).all(|reach| reach.holds(set)) {
            return Ok(false);
        }
        let Some(study) = &self.judged else { return Ok(true) };
        self.judgements += 1;
        if self.judgements > MOST_JUDGED {
            self.is_open = true;
            return Ok(false);
        }
        let mut set = set.to_vec();
        set.sort_unstable();
        let verdict = judge(self.input, study, &set, self.open)?;
        let is_better = self.then.as_ref().is_none_or(|then| then.is_beaten_by(&verdict));
        Ok(verdict.misses_more_than(0).is_none() && is_better)
    }

    fn all_reaches(&self) -> impl Iterator<Item = &Reach<'s>> {
        let then = match &self.then {
            Some(Beaten::Score(reach)) => Some(reach),
            Some(Beaten::Overlap { unknown, .. }) => unknown.as_ref(),
            _ => None,
        };
        self.reaches.iter().chain(then)
    }

    fn affords(&self, cost: u64) -> bool {
        self.most_cost.is_none_or(|most| cost <= most)
    }

    fn cost(&self, set: &[usize]) -> u64 {
        set.iter().map(|&item| self.costs[item]).sum()
    }
}

impl Beaten<'_> {
    /// Whether a judged set beats the bound.
    fn is_beaten_by(&self, verdict: &Verdict) -> bool {
        match self {
            // If unions decide, the bound was checked before.
            Beaten::Score(reach) => !reach.adds_up || reach.is_met(&verdict.counts[reach.region]),
            Beaten::Overlap { counted: Counted { score, over, region }, seen, .. } => {
                let limit = Limit::AtLeast(*seen);
                let value = Value::from_counts(*score, *over, &limit, &verdict.counts[*region]);
                value.is_some_and(|value| value.cmp_ratio(*seen).is_gt())
            }
            Beaten::MeanOverlap(Counted { score, over, region }, mean) => {
                value(*score, *over, &verdict.counts[*region]).is_some_and(|value| value > *mean)
            }
            Beaten::Nearest(squared) => verdict.nearest.is_some_and(|nearest| nearest > *squared),
        }
    }
}

impl<'a> ProofInput<'a> {
    /// A score over a region that a set must have; `None` if nothing was cast in it.
    pub(super) fn reach(
        self,
        (score, over, region): (Score, Across, usize),
        bar: Bar,
        dead: usize,
    ) -> Option<Reach<'a>> {
        let ProofInput { study, purchase, regions, evidence, .. } = self;
        if score == Score::SeenTwice {
            // A union does not contain the overlap of two members.
            return None;
        }
        let evidence = &evidence[regions.iter().position(|own| *own == region)?];
        let adds_up = is_of_labels(score)
            && odds_of(study, purchase.fusion, &purchase.representations, evidence).is_some();
        Some(Reach { evidence, region, score, over, bar, dead, adds_up })
    }
}

fn extend_set(chosen: &[usize], item: usize) -> Vec<usize> {
    [chosen, &[item]].concat()
}
