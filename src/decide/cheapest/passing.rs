//! Whether a set passes: decided by the code of judge, from the evidence of each candidate.

use std::collections::BTreeSet;

use perirobot_cover::cheapest::{Demand, SetTest, TestAnswer};
use perirobot_cover::{Problem, Ratio, Worth};
use perirobot_march::Result;
use perirobot_march::metrics::Confusion;
use perirobot_study::input::{ApproachScore, Counted, Limit, Measure, Nearness, Requirement};

use super::areas::LargestArea;
use super::remaining::Remaining;
use super::terms::{Terms, dead_in, is_counted, is_of_overlap};
use super::ways::{SceneWays, WayIn};
use crate::approach::NearestApproach;
use crate::judge::{Conditions, Value, approach_value, dead_members};

/// The most new ways in per failing set, for each passage.
const MOST_WAYS: usize = 8;

/// The most candidates of which all pairs are left out.
const MOST_IN_PAIRS: usize = 200;

/// Decides whether a set meets its terms.
pub(super) struct PassingTest<'t, 'a> {
    terms: &'t Terms,
    /// The evidence of the candidates in each counted region.
    problems: &'t [(usize, Problem<'a>)],
    ways: &'t [SceneWays<'a>],
    /// The ways in found so far; new ones are added.
    known: &'t mut Vec<WayIn>,
    candidates: usize,
    /// The source of distances.
    scale: Conditions,
    remaining: Remaining<'t>,
}

/// An entry at which a body is already too near.
pub(super) struct EntryTooNear {
    /// Index of scene, company and repeat.
    pub(super) scene: usize,
    pub(super) passage: usize,
    /// The distance, squared in voxels.
    pub(super) squared: u32,
}

impl<'t, 'a> PassingTest<'t, 'a> {
    pub(super) fn new(
        terms: &'t Terms,
        problems: &'t [(usize, Problem<'a>)],
        (ways, known): (&'t [SceneWays<'a>], &'t mut Vec<WayIn>),
        (candidates, voxel_size_m): (usize, f64),
        remaining: Remaining<'t>,
    ) -> PassingTest<'t, 'a> {
        let needed = terms.stopping.as_ref().map(|stopping| *stopping.fastest());
        let scale = Conditions { voxel_size_m, needed, ..Conditions::default() };
        PassingTest { terms, problems, ways, known, candidates, scale, remaining }
    }

    /// The demands of the known ways in.
    pub(super) fn known_demands(&self) -> Vec<Demand> {
        self.known.iter().filter_map(|way| self.demand(way)).collect()
    }

    /// The demand of a way in that leads too near: one more candidate that notices it than may be dead.
    fn demand(&self, way: &WayIn) -> Option<Demand> {
        let near = NearestApproach { squared: Some(way.squared), unnoticed: 0, joined: 0 };
        let passage = &self.ways[way.scene].passages[way.passage];
        let fails = self.nearness().filter(|(requirement, nearness, _)| {
            let is_asked = passage.is_asked(nearness) && !nearness.score.is_area();
            is_asked && !self.is_met(nearness.score, &requirement.limit, &near)
        });
        let dead = fails.map(|(.., dead)| dead).max()?;
        Some(Demand::new(self.candidates, way.noticed_by.iter().copied(), dead + 1))
    }

    /// The first requirement that fails for every set, since a body is too near at its entry.
    pub(super) fn too_near_at_entry(&self) -> Option<EntryTooNear> {
        for (scene, ways) in self.ways.iter().enumerate() {
            for (passage, squared) in ways.at_entries().into_iter().enumerate() {
                let Some(squared) = squared else { continue };
                let near = NearestApproach { squared: Some(squared), unnoticed: 0, joined: 0 };
                let mut demands = self.nearness().filter(|(_, nearness, _)| {
                    ways.passages[passage].is_asked(nearness) && !nearness.score.is_area()
                });
                if demands.any(|(one, nearness, _)| !self.is_met(nearness.score, &one.limit, &near)) {
                    return Some(EntryTooNear { scene, passage, squared });
                }
            }
        }
        None
    }

    /// The areas that the requirements limit.
    pub(super) fn largest_areas(&self) -> Vec<LargestArea> {
        let mut all = Vec::new();
        for (requirement, nearness, dead) in self.nearness() {
            if nearness.score != ApproachScore::UnnoticedM2 {
                continue;
            }
            for (scene, ways) in self.ways.iter().enumerate() {
                let passages =
                    ways.passages.iter().enumerate().filter(|(_, passage)| passage.is_asked(nearness));
                let bodies: BTreeSet<usize> =
                    passages.map(|(passage, _)| ways.body_and_entry(passage)[0]).collect();
                all.extend(bodies.into_iter().map(|body| {
                    let most = self.most_unnoticed(requirement, ways.free()[body].count());
                    LargestArea { of: [scene, body], most, dead }
                }));
            }
        }
        all
    }

    /// The most places that a requirement allows to be left unnoticed.
    fn most_unnoticed(&self, requirement: &Requirement, places: u64) -> u64 {
        let is_small = |unnoticed: u64| {
            let near = NearestApproach { squared: None, unnoticed, joined: 0 };
            self.is_met(ApproachScore::UnnoticedM2, &requirement.limit, &near)
        };
        // Bisection for the smallest number that is too large.
        let (mut low, mut high) = (0, places + 1);
        while low < high {
            let middle = low + (high - low) / 2;
            if is_small(middle) { low = middle + 1 } else { high = middle }
        }
        low.saturating_sub(1)
    }

    /// A way in that leads too near and that fewer candidates notice than a passing set needs.
    pub(super) fn unnoticeable_way(&self) -> Option<&WayIn> {
        let is_out_of_reach =
            |way: &&WayIn| self.demand(way).is_some_and(|demand| demand.least > way.noticed_by.len());
        self.known.iter().find(is_out_of_reach)
    }

    /// The score of all candidates together, or without as few as may be dead, if it misses a requirement of counts;
    /// with the left-out ones.
    pub(super) fn missed_by_all(&self, requirement: &Requirement) -> Option<(f64, Vec<usize>)> {
        let counted = requirement.counted_score().filter(|_| !is_of_overlap(requirement))?;
        let (_, problem) = self.problems.iter().find(|(region, _)| *region == counted.region)?;
        let all: Vec<usize> = (0..self.candidates).collect();
        left_out_of_all(requirement, self.candidates).find_map(|out| {
            let counts = problem.counts(&living_members(&all, &out));
            let value = Value::from_counts(counted.score, counted.over, &requirement.limit, &counts)?;
            (!value.meets(&requirement.limit)).then(|| (value.number(), out))
        })
    }

    pub(super) fn ways(&self) -> &'t [SceneWays<'a>] {
        self.ways
    }

    /// Whether a set meets a requirement of counts in all cases without `dead` of its members.
    fn meets_counted(
        &self,
        requirement: &Requirement,
        counted: &Counted,
        set: &[usize],
        dead: usize,
    ) -> bool {
        let known = self.problems.iter().find(|(region, _)| *region == counted.region);
        let Some((_, problem)) = known else { return false };
        dead_members(set.len(), dead).iter().all(|dead| {
            let counts: Vec<Confusion> = problem.counts(&living_members(set, dead));
            let value = Value::from_counts(counted.score, counted.over, &requirement.limit, &counts);
            value.is_some_and(|value| value.meets(&requirement.limit))
        })
    }

    /// Requirements on approaching bodies, each with the number of sensors that may be dead.
    fn nearness(&self) -> impl Iterator<Item = (&'t Requirement, &'t Nearness, usize)> + use<'t, 'a> {
        nearness_of(self.terms)
    }

    fn is_met(&self, score: ApproachScore, limit: &Limit, near: &NearestApproach) -> bool {
        is_met(&self.scale, score, limit, near)
    }

    /// How near each body comes by each passage of each scene, squared in voxels; `None` if it does not fit.
    fn nearest(&self, set: &[usize]) -> Vec<([usize; 2], u32)> {
        let of_scene = |(scene, ways): (usize, &SceneWays)| {
            let nearest = ways.nearest(&ways.watched_by(set)).into_iter().enumerate();
            let near = nearest.filter_map(|(passage, near)| Some(([scene, passage], near.squared?)));
            near.collect::<Vec<_>>()
        };
        self.ways.iter().enumerate().flat_map(of_scene).collect()
    }

    /// Checks whether bodies stay far enough away in all cases; if not, adds demands.
    fn come_near(&mut self, set: &[usize]) -> TestAnswer {
        let ways = self.ways;
        let mut fails = false;
        for dead in 0..=2 {
            if self.nearness().all(|(.., own)| own != dead) {
                continue;
            }
            for out in dead_members(set.len(), dead) {
                let alive = living_members(set, &out);
                for (scene, ways) in ways.iter().enumerate() {
                    let nearest = ways.nearest(&ways.watched_by(&alive));
                    let mut failed = Vec::new();
                    for (passage, near) in nearest.iter().enumerate() {
                        let demands = self.nearness().filter(|(_, nearness, own)| {
                            *own == dead && ways.passages[passage].is_asked(nearness)
                        });
                        let missed = demands.filter(|(requirement, nearness, _)| {
                            !self.is_met(nearness.score, &requirement.limit, near)
                        });
                        let mut missed = missed.peekable();
                        fails |= missed.peek().is_some();
                        // An area is not a way in.
                        if missed.any(|(_, nearness, _)| !nearness.score.is_area()) {
                            failed.push(passage);
                        }
                    }
                    let before = self.known.len();
                    failed.iter().for_each(|&passage| self.find_ways([scene, passage], &alive, dead));
                    if self.known.len() > before {
                        return TestAnswer::Lacks(self.known_demands());
                    }
                }
            }
        }
        if fails { TestAnswer::Fails } else { TestAnswer::Passes }
    }

    /// Finds ways in on which some candidates do not notice a body, adding to them candidates that do, until none is
    /// left.
    fn find_ways(&mut self, [scene, passage]: [usize; 2], alive: &[usize], dead: usize) {
        let (ways, terms, scale) = (self.ways, self.terms, self.scale.clone());
        let case = &ways[scene].passages[passage];
        let is_too_near = |squared: u32| {
            let near = NearestApproach { squared: Some(squared), unnoticed: 0, joined: 0 };
            nearness_of(terms).any(|(requirement, nearness, own)| {
                let is_asked = case.is_asked(nearness) && !nearness.score.is_area();
                own == dead && is_asked && !is_met(&scale, nearness.score, &requirement.limit, &near)
            })
        };
        self.find_ways_by([scene, passage], alive, &is_too_near);
    }

    /// The same for ways that lead too near by another measure.
    fn find_ways_by(
        &mut self,
        [scene, passage]: [usize; 2],
        alive: &[usize],
        is_too_near: &dyn Fn(u32) -> bool,
    ) {
        let (ways, mut watching) = (&self.ways[scene], alive.to_vec());
        for _ in 0..MOST_WAYS {
            let Some(way) = ways.way_in([scene, passage], &watching, is_too_near) else { return };
            // The next way differs: the first of these candidates does not notice it.
            let next = way.noticed_by.first().copied();
            self.known.push(way);
            match next {
                Some(next) => watching.push(next),
                None => return,
            }
        }
    }
}

/// Requirements on approaching bodies, each with the number of sensors that may be dead.
fn nearness_of(terms: &Terms) -> impl Iterator<Item = (&Requirement, &Nearness, usize)> {
    terms.requirements.iter().flat_map(|requirement| {
        let nearness = match &requirement.measure {
            Measure::Nearness(nearness) => Some(nearness),
            Measure::Counted(_) | Measure::Controller(_) => None,
        };
        let under = requirement.under.iter().filter_map(|&condition| dead_in(condition));
        under.filter_map(move |dead| Some((requirement, nearness?, dead)))
    })
}

fn is_met(scale: &Conditions, score: ApproachScore, limit: &Limit, near: &NearestApproach) -> bool {
    approach_value(score, near, scale).is_some_and(|value| value.meets(limit))
}

impl SetTest for PassingTest<'_, '_> {
    fn test(&mut self, set: &[usize]) -> Result<TestAnswer> {
        for requirement in &self.terms.requirements {
            let Measure::Counted(counted) = &requirement.measure else { continue };
            let under = requirement.under.iter().filter(|&&condition| is_counted(requirement, condition));
            let mut dead = under.filter_map(|&condition| dead_in(condition));
            if !dead.all(|dead| self.meets_counted(requirement, counted, set, dead)) {
                return Ok(TestAnswer::Fails);
            }
        }
        match self.come_near(set) {
            // A set needs at least one sensor.
            TestAnswer::Passes if set.is_empty() => Ok(TestAnswer::Fails),
            TestAnswer::Passes if self.remaining.passes(set)? => Ok(TestAnswer::Passes),
            TestAnswer::Passes => Ok(TestAnswer::Fails),
            other => Ok(other),
        }
    }

    /// The closest distance of any body by any entry, squared in voxels.
    fn worth(&mut self, set: &[usize]) -> Option<Worth> {
        self.nearest(set).into_iter().map(|(_, squared)| squared).min().map(worth_of_squared)
    }

    fn demands_above(&mut self, set: &[usize], worth: Worth) -> Vec<Demand> {
        let is_no_better = |squared: u32| worth_of_squared(squared) <= worth;
        let candidates = self.candidates;
        if self.ways.iter().flat_map(SceneWays::at_entries).flatten().any(is_no_better) {
            // This holds for every set: none is better.
            return vec![Demand::new(candidates, [], 1)];
        }
        for ([scene, passage], squared) in self.nearest(set) {
            let is_missed = |way: &WayIn| {
                [way.scene, way.passage] == [scene, passage]
                    && is_no_better(way.squared)
                    && !way.noticed_by.iter().any(|item| set.contains(item))
            };
            if is_no_better(squared) && !self.known.iter().any(is_missed) {
                self.find_ways_by([scene, passage], set, &is_no_better);
            }
        }
        let leads_near = self.known.iter().filter(|way| is_no_better(way.squared));
        leads_near.map(|way| Demand::new(candidates, way.noticed_by.iter().copied(), 1)).collect()
    }
}

/// The worth of a set by the closest distance, squared in voxels.
pub(super) fn worth_of_squared(squared: u32) -> Worth {
    Worth::Exact(Ratio { numerator: squared.into(), denominator: 1 })
}

/// The candidates that may be dead under a requirement: none, then as many as it allows.
pub(super) fn left_out_of_all(
    requirement: &Requirement,
    candidates: usize,
) -> impl Iterator<Item = Vec<usize>> + use<> {
    let dead = requirement.under.iter().filter_map(|&condition| dead_in(condition)).max();
    // All pairs of many candidates would take too long.
    let few = (0..=2).filter(move |few| dead.is_some_and(|dead| *few <= dead));
    let few = few.filter(move |&few| few < 2 || candidates <= MOST_IN_PAIRS);
    few.flat_map(move |few| dead_members(candidates, few))
}

/// The members of a set without those at some places.
pub(super) fn living_members(set: &[usize], dead: &[usize]) -> Vec<usize> {
    let alive = set.iter().enumerate().filter(|(place, _)| !dead.contains(place));
    alive.map(|(_, &item)| item).collect()
}
