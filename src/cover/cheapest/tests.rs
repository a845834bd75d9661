//! Against trying every set.

use std::cell::RefCell;

use super::super::evidence::CandidateEvidence;
use super::super::layout::{CLEAR, FALSE, HIT, MISSED};
use super::super::problem::Problem;
use super::super::rules::{SetLimits, SetRules};
use super::super::tests::{Random, SCORES, evidence, rules};
use super::super::worth::{Ratio, Worth};
use super::search::Search;
use super::share::left_out;
use super::{
    CheapestAnswer, CheapestKnown, CheapestProblem, Coverage, Demand, SetTest, Share, TestAnswer, TieRule,
    TieScore, cheapest,
};
use crate::thorough::cases;
use perirobot_march::Result;
use perirobot_march::metrics::{Across, Overlap, Score};

/// What a made-up test asks of a set besides its shares.
struct MadeUpTest<'a> {
    shares: Vec<Share<'a>>,
    coverages: Vec<Coverage<'a>>,
    /// Demands, of which each failing test reports the first that is not met.
    hidden: Vec<Demand>,
    /// Sets with both of these fail; no demand says so.
    enemies: Option<[usize; 2]>,
    /// What a set is worth that misses a demand, if that is not more than what the others say.
    worths: Vec<(i128, Demand)>,
    tested: usize,
}

fn reaches(share: &Share, set: &[usize]) -> bool {
    let dead = share.dead.min(set.len());
    let counts = |set: &[usize]| Worth::from_counts(share.score, share.over, &share.problem.counts(set));
    left_out(set, dead).into_iter().all(|dead| {
        let alive: Vec<usize> = set.iter().copied().filter(|item| !dead.contains(item)).collect();
        counts(&alive).is_some_and(|worth| match share.score.less_is_better() {
            true => worth <= Worth::Exact(share.limit),
            false => worth.reaches(share.limit),
        })
    })
}

fn covers(coverage: &Coverage, set: &[usize]) -> bool {
    let Coverage { evidence, moment, least, dead } = *coverage;
    left_out(set, dead.min(set.len())).into_iter().all(|dead| {
        let words = evidence.layout.moments[moment].words[0].clone();
        let bit = |word: usize| {
            let own = set.iter().filter(|item| !dead.contains(item));
            own.fold(0, |all, &item| all | evidence.plane(item, HIT).get(word).copied().unwrap_or(0))
        };
        words.map(|word| u64::from(bit(word).count_ones())).sum::<u64>() >= least
    })
}

impl MadeUpTest<'_> {
    fn passes(&self, set: &[usize]) -> bool {
        self.hidden.iter().all(|demand| demand.lacks(set) == 0)
            && self.coverages.iter().all(|coverage| covers(coverage, set))
            && self.shares.iter().all(|share| reaches(share, set))
            && self.enemies.is_none_or(|enemies| !enemies.iter().all(|enemy| set.contains(enemy)))
    }
}

impl SetTest for MadeUpTest<'_> {
    fn test(&mut self, set: &[usize]) -> Result<TestAnswer> {
        self.tested += 1;
        assert!(set.is_sorted());
        let lacks = self.hidden.iter().find(|demand| demand.lacks(set) > 0);
        Ok(match (lacks, self.passes(set)) {
            (Some(demand), _) => TestAnswer::Lacks(vec![demand.clone()]),
            (None, true) => TestAnswer::Passes,
            (None, false) => TestAnswer::Fails,
        })
    }

    fn worth(&mut self, set: &[usize]) -> Option<Worth> {
        let missed = self.worths.iter().filter(|(_, demand)| demand.lacks(set) > 0);
        missed.map(|(numerator, _)| Worth::Exact(Ratio { numerator: *numerator, denominator: 3 })).min()
    }

    fn demands_above(&mut self, set: &[usize], worth: Worth) -> Vec<Demand> {
        let is_enough = |numerator| Worth::Exact(Ratio { numerator, denominator: 3 }) > worth;
        let mut missed =
            self.worths.iter().filter(|(least, demand)| !is_enough(*least) && demand.lacks(set) > 0);
        missed.next().map(|(_, demand)| demand.clone()).into_iter().collect()
    }
}

/// All sets that are allowed.
fn allowed_sets(rules: &SetRules, limits: SetLimits, set: &mut Vec<usize>, all: &mut Vec<Vec<usize>>) {
    let mut sorted = set.clone();
    sorted.sort_unstable();
    all.push(sorted);
    let first = set.iter().filter(|item| !rules.always.contains(item)).max().map_or(0, |last| last + 1);
    for item in first..rules.cost.len() {
        let fits = limits.afford(rules.cost_of(set) + rules.cost[item]) && set.len() < limits.at_most;
        if fits && rules.may_join(set, item) {
            set.push(item);
            allowed_sets(rules, limits, set, all);
            set.pop();
        }
    }
}

fn made_up_share<'a>(random: &mut Random, problem: &'a Problem<'a>) -> Share<'a> {
    let score = [&SCORES[..], &[Score::Unknown, Score::FalseAlarm]].concat()[random.number_below(7) as usize];
    let over = [Across::Pooled, Across::Worst, Across::Mean][random.number_below(3) as usize];
    let limit = Ratio::from_f64(random.number_below(70) as f64 / 100.0);
    let limit = match score {
        Score::Unknown | Score::FalseAlarm => Ratio::from_f64(1.0 - limit.value() / 2.0),
        _ => limit,
    };
    Share { problem, score, over, limit, dead: random.number_below(3) as usize }
}

#[test]
fn the_cheapest_set_is_that_of_trying_every_set() {
    let mut random = Random(56);
    let (mut found_any, mut found_none, mut told, mut by_worth) = (0, 0, 0, [0; 3]);
    let mut ties = 0;
    for case in 0..cases(400, 3000) {
        let count = 4 + random.number_below(6) as usize;
        let (noisy, thin) = (case % 3 == 0, 1 + random.number_below(2));
        let said: Vec<CandidateEvidence> =
            (0..2).map(|_| evidence(&mut random, count, noisy, thin)).collect();
        let (mut rules, _) = rules(&mut random, &said[0]);
        if case % 5 == 0 {
            rules.cost[0] = 0;
        }
        let limits = SetLimits {
            at_most: 1 + random.number_below(5) as usize,
            budget: random.one_in(2).then(|| random.number_below(12)),
        };
        let in_region = |evidence| {
            let goal = (Score::F1, Across::Pooled);
            Problem { evidence, goal, require: Vec::new(), limits, rules: rules.clone(), odds: None }
        };
        let all: Vec<Problem> = said.iter().map(in_region).collect();
        let shares: Vec<Share> = (0..random.number_below(3))
            .map(|place| made_up_share(&mut random, &all[place as usize % 2]))
            .collect();
        let coverages: Vec<Coverage> = (0..random.number_below(2))
            .map(|_| {
                let (moment, dead) = (0, random.number_below(3) as usize);
                let most = said[1].layout.moments[moment].voxels[0];
                Coverage { evidence: &said[1], moment, least: random.number_below(most / 2 + 1), dead }
            })
            .collect();
        let Share { problem, score, over, .. } = made_up_share(&mut random, &all[0]);
        let kind = random.number_below(5) as usize;
        let then = match kind {
            0 => Some(TieRule::Score(TieScore { problem, score, over })),
            1 => Some(TieRule::Score(TieScore { problem, score: Score::SeenTwice, over })),
            2 => Some(TieRule::Tested),
            _ => None,
        };
        let hidden: Vec<Demand> = (0..random.number_below(4))
            .map(|_| {
                let least = 1 + random.number_below(2) as usize;
                let among: Vec<usize> = (0..count).filter(|_| random.one_in(2)).collect();
                Demand::new(count, among, least)
            })
            .collect();
        let enemies = random.one_in(3).then(|| [0, 1 + random.number_below(count as u64 - 1) as usize]);
        let worths = (0..6).map(|place| {
            let among: Vec<usize> = (0..count).filter(|_| random.one_in(3)).collect();
            (place, Demand::new(count, among, 1))
        });
        let worths = worths.collect();
        let most_ties = random.number_below(4) as usize;
        let problem = CheapestProblem {
            rules: &rules,
            limits,
            shares: shares.clone(),
            coverages: coverages.clone(),
            then,
            most_ties,
        };
        let mut test = MadeUpTest { shares, coverages, hidden, enemies, worths, tested: 0 };
        let mut demands = Vec::new();
        let shown = RefCell::new(Vec::new());
        let show = |known: CheapestKnown| {
            let best = known.best.map(|best| best.cost);
            shown.borrow_mut().push((best, known.no_set_below, known.tested));
        };
        let answer = cheapest(&problem, &mut demands, &mut test, &|| None, &show).unwrap();
        assert_shown(&shown.into_inner(), &answer);
        told += usize::from(!demands.is_empty());

        let mut sets = Vec::new();
        if limits.afford(rules.cost_of(&rules.always)) && rules.always.len() <= limits.at_most {
            allowed_sets(&rules, limits, &mut rules.always.clone(), &mut sets);
        }
        sets.retain(|set| test.passes(set));
        let cost = sets.iter().map(|set| rules.cost_of(set)).min();
        assert!(answer.is_proven && answer.is_best_of_cost, "case {case}");
        assert_eq!(answer.best.as_ref().map(|best| best.cost), cost, "case {case}");
        assert_eq!(answer.no_set_below, cost, "case {case}");
        let Some(best) = answer.best else {
            found_none += 1;
            continue;
        };
        found_any += 1;
        assert!(sets.contains(&best.set), "case {case}: {:?} passes", best.set);
        let of_cost = || sets.iter().filter(|set| rules.cost_of(set) == best.cost);
        let Some(then) = &then else {
            let others = (of_cost().count() - 1).min(most_ties);
            assert_eq!(answer.ties, (most_ties > 0).then_some(others), "case {case}");
            ties += usize::from(others > 1);
            continue;
        };
        let worths: Vec<Option<Worth>> = match then {
            TieRule::Score(TieScore { score: Score::SeenTwice, over, problem }) => {
                of_cost().map(|set| seen_twice(problem.evidence, *over, set)).collect()
            }
            TieRule::Score(then) => {
                let counts = of_cost().map(|set| then.problem.counts(set));
                counts.map(|counts| Worth::from_counts(then.score, then.over, &counts)).collect()
            }
            TieRule::Tested => of_cost().map(|set| test.worth(set)).collect(),
        };
        let is_less_better = matches!(then, TieRule::Score(then) if then.score.less_is_better());
        let most = match is_less_better {
            true => worths.iter().flatten().min(),
            false => worths.iter().flatten().max(),
        };
        // What has no value is the worst.
        assert_eq!(best.worth.as_ref(), most, "case {case}");
        by_worth[kind] += usize::from(worths.iter().any(|worth| worth.as_ref() != most));
    }
    assert!(
        found_any > 80 && found_none > 30 && told > 100 && ties > 5 && by_worth.iter().all(|&one| one > 4),
        "{found_any} {found_none} {told} {by_worth:?} {ties}"
    );
}

/// What was shown of a search that found an answer: costs fall, and bounds rise up to the answer.
#[track_caller]
fn assert_shown(shown: &[(Option<u64>, u64, u64)], answer: &CheapestAnswer) {
    let cost = answer.best.as_ref().map(|best| best.cost);
    for pair in shown.windows(2) {
        let [(best, bound, tested), (next_best, next_bound, next_tested)] = [pair[0], pair[1]];
        assert!(best.is_none() || next_best.is_some_and(|next| Some(next) <= best), "{shown:?}");
        assert!(bound <= next_bound && tested <= next_tested, "{shown:?}");
    }
    for &(best, bound, _) in shown {
        assert!(best.is_none_or(|best| Some(best) >= cost && cost.is_some()), "{shown:?}, {answer:?}");
        assert!(cost.is_none_or(|cost| bound <= cost), "{shown:?}, {answer:?}");
    }
    let last = shown.last().and_then(|(best, ..)| *best);
    assert_eq!(last, cost, "the best set is shown");
}

/// The share of a region that at least two of a set label, bit by bit.
fn seen_twice(evidence: &CandidateEvidence, over: Across, set: &[usize]) -> Option<Worth> {
    let labels = |item: usize, planes: [usize; 2], bit: usize| {
        planes.iter().any(|&plane| {
            let row = evidence.plane(item, plane);
            row.get(bit / 64).is_some_and(|word| word >> (bit % 64) & 1 == 1)
        })
    };
    let mut counts = evidence.counts(set);
    for (counts, moment) in counts.iter_mut().zip(&evidence.layout.moments) {
        let mut twice = 0;
        for (space, planes) in [[HIT, MISSED], [FALSE, CLEAR]].into_iter().enumerate() {
            let words = &moment.words[space];
            for bit in words.start * 64..words.end * 64 {
                twice += u64::from(set.iter().filter(|&&item| labels(item, planes, bit)).count() >= 2);
            }
        }
        *counts = counts.with_overlap(Overlap { twice, hit_human_twice: 0 });
    }
    Worth::from_counts(Score::SeenTwice, over, &counts)
}

/// The first candidate passes alone, and so do the next three together; nothing else says so.
struct OneOrThree {
    tested: usize,
}

impl SetTest for OneOrThree {
    fn test(&mut self, set: &[usize]) -> Result<TestAnswer> {
        self.tested += 1;
        let passes = set.contains(&0) || [1, 2, 3].iter().all(|item| set.contains(item));
        Ok(if passes { TestAnswer::Passes } else { TestAnswer::Fails })
    }
}

#[test]
fn a_set_that_costs_nothing_ends_the_search() {
    let cost = (0..20).map(|item| u64::from(item == 0)).collect();
    let rules = SetRules { cost, sensor: vec![0; 20], most: vec![usize::MAX], ..SetRules::default() };
    let limits = SetLimits { at_most: 5, budget: None };
    let (shares, coverages) = (Vec::new(), Vec::new());
    let problem = CheapestProblem { rules: &rules, limits, shares, coverages, then: None, most_ties: 0 };
    let (mut test, mut demands) = (OneOrThree { tested: 0 }, Vec::new());
    let search = Search::new(&problem, &mut demands, &mut test, (&|| None, &|_| {}));
    let answer = search.run(Some(vec![0])).unwrap();
    assert_eq!((answer.is_proven, answer.best.unwrap().set), (true, vec![1, 2, 3]));
    assert!(test.tested < 10, "{} tested", test.tested);
}

/// A search that is stopped keeps a lower bound.
#[test]
fn a_stopped_search_keeps_its_bound() {
    let rules =
        SetRules { cost: vec![3; 9], sensor: vec![0; 9], most: vec![usize::MAX], ..SetRules::default() };
    let limits = SetLimits { at_most: 9, budget: None };
    let hidden = vec![Demand::new(9, 0..4, 2), Demand::new(9, 4..9, 2)];
    let problem = CheapestProblem {
        rules: &rules,
        limits,
        shares: Vec::new(),
        coverages: Vec::new(),
        then: None,
        most_ties: 0,
    };
    for stop_after in 0..12 {
        let asked = std::sync::atomic::AtomicUsize::new(0);
        let stop = || {
            let asked = asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            (asked >= stop_after).then(|| "stopped".to_string())
        };
        let mut test = MadeUpTest {
            shares: Vec::new(),
            coverages: Vec::new(),
            hidden: hidden.clone(),
            enemies: None,
            worths: Vec::new(),
            tested: 0,
        };
        let answer = cheapest(&problem, &mut Vec::new(), &mut test, &stop, &|_| {}).unwrap();
        let best = answer.best.as_ref().map(|best| best.cost);
        assert!(best.is_none_or(|best| best >= 12));
        // A set costs a multiple of 3.
        assert!(answer.no_set_below.is_none_or(|bound| bound <= 12 && bound.is_multiple_of(3)));
        assert_eq!(answer.is_proven, best == Some(12) && answer.no_set_below == Some(12), "{answer:?}");
    }
}
