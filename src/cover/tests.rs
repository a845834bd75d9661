//! Against trying every set.

use std::slice;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use super::cuts::{CutLimits, CutProof, check_cuts};
use super::evidence::CandidateEvidence;
use super::front::answer;
use super::gap::GapSearch;
use super::layout::BitLayout;
use super::mean::bounds_means;
use super::problem::{FoundSet, Problem};
use super::rules::{SetLimits, SetRules};
use super::search::{Ahead, Shortcuts, search};
use super::step::{Bound, find_above, overlaps};
use super::worth::{Ratio, Worth};
use crate::thorough::cases;
use perirobot_march::metrics::{Across, Score};

/// SplitMix64.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(super) fn number_below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    pub(super) fn one_in(&mut self, n: u64) -> bool {
        self.number_below(n) == 0
    }
}

pub(super) const SCORES: [Score; 5] =
    [Score::F1, Score::Kappa, Score::HumanSeen, Score::PeopleDetected, Score::PartsDetected];

/// Made-up evidence of some candidates of three sensors. The larger `thin`, the less each says.
pub(super) fn evidence(random: &mut Random, candidates: usize, noisy: bool, thin: u64) -> CandidateEvidence {
    let one_moment = |random: &mut Random| {
        let voxels = [random.number_below(70), random.number_below(150)];
        let parts: Vec<(usize, u64)> = (0..random.number_below(5))
            .map(|part| ((part / 3) as usize, 1 + random.number_below(12)))
            .collect();
        (voxels, parts)
    };
    let moments: Vec<_> = (0..1 + random.number_below(3)).map(|_| one_moment(random)).collect();
    let layout = BitLayout::made_up(&moments, 1 + random.number_below(4));
    let items = (0..candidates).map(|i| [(random.number_below(3)) as usize, i]).collect();
    let planes = (0..candidates).map(|_| {
        let (some, clear) = (thin * (2 + random.number_below(4)), thin * (1 + random.number_below(4)));
        let mut planes: [Vec<u64>; 6] =
            std::array::from_fn(|plane| vec![0; layout.words[super::layout::SPACE_OF[plane]]]);
        for moment in &layout.moments {
            let set = |planes: &mut [Vec<u64>; 6], plane: usize, first: usize, bit: u64| {
                planes[plane][first + bit as usize / 64] |= 1 << (bit % 64);
            };
            for bit in 0..moment.voxels[0] {
                if random.one_in(some) {
                    set(&mut planes, 0, moment.words[0].start, bit);
                } else if noisy && random.one_in(4) {
                    set(&mut planes, 1, moment.words[0].start, bit);
                }
            }
            for bit in 0..moment.voxels[1] {
                if noisy && random.one_in(6) {
                    set(&mut planes, 2, moment.words[1].start, bit);
                } else if random.one_in(clear) {
                    set(&mut planes, 3, moment.words[1].start, bit);
                }
            }
            for part in &moment.parts {
                for bit in 0..part.voxels {
                    let seen = random.one_in(some + 1);
                    if seen {
                        set(&mut planes, 4, part.words.start, bit);
                    }
                    if seen && random.one_in(20) {
                        set(&mut planes, 5, part.words.start, bit);
                    }
                }
            }
        }
        planes
    });
    let planes = planes.collect();
    CandidateEvidence::made_up(layout, items, planes)
}

/// Made-up rules for the candidates of some evidence, and whether they have prices.
pub(super) fn rules(random: &mut Random, evidence: &CandidateEvidence) -> (SetRules, bool) {
    let count = evidence.count();
    let priced = random.one_in(2);
    let cost: Vec<u64> = (0..count).map(|_| if priced { 1 + random.number_below(4) } else { 0 }).collect();
    let always: Vec<usize> =
        if random.one_in(4) { vec![random.number_below(count as u64) as usize] } else { Vec::new() };
    let mut near = vec![vec![0u64; 1]; if random.one_in(2) { count } else { 0 }];
    if !near.is_empty() {
        for _ in 0..count {
            let [a, b] =
                [random.number_below(count as u64) as usize, random.number_below(count as u64) as usize];
            if a != b {
                near[a][0] |= 1 << b;
                near[b][0] |= 1 << a;
            }
        }
    }
    let most =
        (0..3).map(|_| if random.one_in(3) { 1 + random.number_below(2) as usize } else { usize::MAX });
    let (sensor, most) = (evidence.items.iter().map(|item| item[0]).collect(), most.collect());
    (SetRules { sensor, cost, always, near, most }, priced)
}

fn problem<'a>(random: &mut Random, evidence: &'a CandidateEvidence, over: Across) -> Problem<'a> {
    let (rules, priced) = rules(random, evidence);
    let fixed = rules.cost_of(&rules.always);
    let require = (0..if random.one_in(3) { 1 + random.number_below(2) } else { 0 }).map(|_| {
        let over = [Across::Pooled, Across::Worst, Across::Mean][random.number_below(3) as usize];
        (
            SCORES[random.number_below(5) as usize],
            over,
            Ratio::from_f64(random.number_below(80) as f64 / 100.0),
        )
    });
    let require = require.collect();
    Problem {
        odds: None,
        evidence,
        goal: (SCORES[random.number_below(5) as usize], over),
        require,
        limits: SetLimits {
            at_most: (1 + random.number_below(5) as usize).max(rules.always.len()),
            budget: priced.then(|| fixed + 1 + random.number_below(10)),
        },
        rules,
    }
}

/// The best worth within some limits, from all sets.
fn best_by_trial(problem: &Problem, limits: SetLimits) -> Option<Worth> {
    let allowed = |set: &Vec<usize>| {
        let joined = set.iter().enumerate().all(|(number, &item)| {
            problem.rules.always.contains(&item) || {
                let before = [&set[..number], &[]].concat();
                let others: Vec<usize> =
                    before.into_iter().chain(problem.rules.always.iter().copied()).collect();
                problem.rules.may_join(&distinct(others), item)
            }
        });
        joined
            && !set.is_empty()
            && set.len() <= limits.at_most
            && limits.afford(problem.rules.cost_of(set))
            && problem.rules.always.iter().all(|item| set.contains(item))
    };
    let all = 0..1usize << problem.evidence.count();
    let sets =
        all.map(|bits| (0..problem.evidence.count()).filter(|i| bits >> i & 1 == 1).collect::<Vec<_>>());
    sets.filter(allowed).filter_map(|set| problem.evaluate(&set)).map(|found| found.worth).max()
}

fn distinct(mut items: Vec<usize>) -> Vec<usize> {
    items.sort_unstable();
    items.dedup();
    items
}

#[test]
fn the_answer_is_that_of_trying_every_set() {
    let mut random = Random(7);
    let (mut steps, mut proven_best, mut none, mut by_search) = (0, 0, 0, 0);
    for case in 0..500 {
        let noisy = case % 2 == 1;
        let candidates = 3 + random.number_below(7) as usize;
        let evidence = evidence(&mut random, candidates, noisy, 1);
        let over = [Across::Pooled, Across::Worst][random.number_below(2) as usize];
        let problem = problem(&mut random, &evidence, over);
        let expected = best_by_trial(&problem, problem.limits);
        let found = match answer(&problem, &|| None) {
            Err(error) => {
                assert_eq!(expected, None, "case {case}: {error:?}: {problem:?}");
                none += 1;
                continue;
            }
            Ok(found) => found,
        };
        let largest = found.steps.iter().filter(|step| step.limits.at_most == problem.limits.at_most);
        let whole = largest.clone().find(|step| step.limits == problem.limits).unwrap();
        assert_eq!(whole.best.as_ref().map(|best| best.worth), expected, "case {case}: {problem:?}");
        for step in &found.steps {
            let FoundSet { set, worth } = step.best.as_ref().unwrap();
            assert_eq!(step.bound, Bound::Proven);
            assert_eq!(
                Some(*worth),
                best_by_trial(&problem, step.limits),
                "case {case}: {step:?}: {problem:?}"
            );
            assert_eq!(problem.evaluate(set).unwrap().worth, *worth, "case {case}");
            assert!(set.len() <= step.limits.at_most && step.limits.afford(problem.rules.cost_of(set)));
            steps += 1;
        }
        // Each size ends where a set that costs less is worth nothing, or does not exist.
        for size in found.steps.chunk_by(|a, b| a.limits.at_most == b.limits.at_most) {
            let costs: Vec<u64> =
                size.iter().map(|s| problem.rules.cost_of(&s.best.as_ref().unwrap().set)).collect();
            assert!(costs.is_sorted_by(|a, b| a > b), "case {case}: {costs:?}");
            if costs.last().is_some_and(|&cost| cost > 0) {
                let below = SetLimits { budget: costs.last().map(|cost| cost - 1), ..size[0].limits };
                // Unless it is a set of fewer sensors, which is told where these are.
                let fewer = found.steps.iter().filter(|step| step.limits.at_most < below.at_most);
                let fewer = fewer.filter_map(|step| step.best.as_ref());
                let fewer = fewer.filter(|best| below.afford(problem.rules.cost_of(&best.set)));
                assert_eq!(best_by_trial(&problem, below), fewer.map(|best| best.worth).max(), "case {case}");
            }
        }
        proven_best += 1;
        by_search += usize::from(problem.limits.at_most - problem.rules.always.len() > 2);
    }
    assert!(
        proven_best > 300 && none > 5 && steps > 800 && by_search > 100,
        "{proven_best} {none} {steps} {by_search}"
    );
}

/// Climbing finds most of the best sets of small problems by itself, so here nobody climbs.
#[test]
fn a_search_from_a_poor_set_ends_at_the_best() {
    let mut random = Random(13);
    let mut improved = 0;
    for case in 0..600 {
        let evidence = evidence(&mut random, 9, case % 2 == 1, 1);
        let over = [Across::Pooled, Across::Worst][random.number_below(2) as usize];
        let problem = problem(&mut random, &evidence, over);
        let expected = best_by_trial(&problem, problem.limits);
        let poor = (0..9).filter_map(|item| problem.evaluate(&[item])).min_by_key(|found| found.worth);
        let known = poor.filter(|_| {
            problem.rules.always.is_empty() && problem.require.is_empty() && problem.rules.cost[0] == 0
        });
        let mut last = known.as_ref().map(|known| known.worth);
        let mut keep = |found: FoundSet| {
            assert!(last.is_none_or(|last| found.worth > last), "case {case}");
            last = Some(found.worth);
            improved += 1;
            found
        };
        // With what candidates say twice counted beforehand, and without.
        let kept = overlaps(&problem).filter(|_| case % 3 > 0);
        let by = Shortcuts { overlaps: kept.as_ref(), cuts: None };
        let (best, proven) =
            search(&problem, problem.limits, known, by, &mut Ahead::default(), &|| false, &mut keep);
        assert!(proven);
        assert_eq!(best.map(|best| best.worth), expected, "case {case}: {problem:?}");
    }
    assert!(improved > 600, "{improved}");
}

/// So many candidates that the first level takes several lots, with searches that are stopped and go on, and with
/// sums of cuts as a further condition.
#[test]
fn a_search_that_is_stopped_again_and_again_ends_at_the_best() {
    let mut random = Random(29);
    let (mut pauses, mut with_cuts, mut improved) = (0, 0, 0);
    for case in 0..cases(12, 60) {
        let count = 40 + random.number_below(20) as usize;
        let evidence = evidence(&mut random, count, case % 2 == 1, 3);
        let over = [Across::Pooled, Across::Worst][random.number_below(2) as usize];
        let mut problem = problem(&mut random, &evidence, over);
        (problem.rules.always, problem.rules.near) = (Vec::new(), Vec::new());
        let at_most = 3 + usize::from(case % 8 < 2);
        let limits = SetLimits { at_most, ..problem.limits };
        let expected = best_by_joining(&problem, limits, &mut Vec::new());
        let first = (0..count).filter_map(|item| problem.evaluate(&[item])).min_by_key(|found| found.worth);
        let mut best = first.filter(|found| limits.afford(problem.rules.cost_of(&found.set)));
        let gap = best.as_ref().and_then(|best| GapSearch::new(&problem, limits, &|| false).run(best.worth));
        with_cuts += usize::from(gap.is_some());
        let kept = overlaps(&problem).filter(|_| case % 3 > 0);
        let by = Shortcuts { overlaps: kept.as_ref(), cuts: gap.as_ref().map(|gap| &gap.1) };
        let (mut ahead, mut longest) = (Ahead::default(), 1);
        loop {
            let asked = AtomicUsize::new(0);
            let stop = || asked.fetch_add(1, Relaxed) > longest;
            let mut keep = |found: FoundSet| {
                improved += 1;
                found
            };
            let (found, proven) = search(&problem, limits, best, by, &mut ahead, &stop, &mut keep);
            best = found;
            if proven {
                break;
            }
            (pauses, longest) = (pauses + 1, longest + longest / 4 + 1);
        }
        assert_eq!(best.map(|best| best.worth), expected, "case {case}: {problem:?}");
    }
    assert!(
        pauses > cases(50, 300) && with_cuts > cases(2, 15) && improved > cases(15, 100),
        "{pauses} {with_cuts} {improved}"
    );
}

/// What `a` takes from `b` by a false alarm, `c` takes from it as well, so that it is no overlap of `a` and `b`.
#[test]
fn false_alarms_are_no_overlap() {
    let layout = BitLayout::made_up(&[([40, 4], Vec::new())], 1);
    // Voxels that are rightly called occupied, wrongly so, and rightly called free.
    let says = |hit: std::ops::Range<u32>, wrong: u64, clear: u64| -> [Vec<u64>; 6] {
        let hit = (1u64 << hit.end) - (1 << hit.start);
        [vec![hit], vec![0], vec![wrong], vec![clear], Vec::new(), Vec::new()]
    };
    let [most, c, a] = [says(0..20, 0, 0), says(20..24, 0, 1), says(24..28, 1, 0)];
    let [b, other] = [says(28..31, 0, 1), says(20..23, 0, 2)];
    let items = (0..5).map(|candidate| [0, candidate]).collect();
    let evidence = CandidateEvidence::made_up(layout, items, vec![most, c, a, b, other]);
    let limits = SetLimits { at_most: 4, budget: None };
    let problem = Problem {
        odds: None,
        evidence: &evidence,
        goal: (Score::F1, Across::Pooled),
        require: Vec::new(),
        limits,
        rules: SetRules {
            sensor: vec![0; 5],
            cost: vec![0; 5],
            most: vec![usize::MAX],
            ..SetRules::default()
        },
    };
    let known = problem.evaluate(&[0, 2, 3, 4]);
    let by = Shortcuts::default();
    let (found, proven) =
        search(&problem, limits, known, by, &mut Ahead::default(), &|| false, &mut |found| found);
    assert!(proven);
    assert_eq!(found.unwrap().set, [0, 1, 2, 3]);
}

/// The best worth of all sets that have some candidates and others after the last one.
fn best_by_joining(problem: &Problem, limits: SetLimits, set: &mut Vec<usize>) -> Option<Worth> {
    let mut best = problem.evaluate(set).filter(|_| !set.is_empty()).map(|found| found.worth);
    if set.len() == limits.at_most {
        return best;
    }
    for item in set.last().map_or(0, |last| last + 1)..problem.evidence.count() {
        if limits.afford(problem.rules.cost_of(set) + problem.rules.cost[item])
            && problem.rules.may_join(set, item)
        {
            set.push(item);
            best = best.max(best_by_joining(problem, limits, set));
            set.pop();
        }
    }
    best
}

#[test]
fn climbing_keeps_what_is_always_there() {
    use super::climb::climb;
    let mut random = Random(17);
    let mut swaps = 0;
    for case in 0..400 {
        let evidence = evidence(&mut random, 9, case % 2 == 1, 1);
        let mut problem = problem(&mut random, &evidence, Across::Pooled);
        problem.rules.always = vec![8];
        problem.limits.at_most = problem.limits.at_most.max(2);
        // A search gives its sets sorted, so what is always there need not come first.
        for other in 0..8 {
            let Some(found) = climb(&problem, problem.limits, vec![other, 8], &|| false) else { continue };
            assert!(found.set.contains(&8), "case {case}: {:?} from {other} and 8", found.set);
            swaps += usize::from(!found.set.contains(&other));
        }
    }
    assert!(swaps > 100, "{swaps}");
}

/// No set is above the bound of the cuts; the independent check agrees, and refuses altered cuts.
#[test]
fn no_set_is_above_what_cuts_say() {
    let mut random = Random(23);
    let (mut shown, mut near, mut refused) = (0, 0, [0; 4]);
    for case in 0..cases(24, 80) {
        let evidence = evidence(&mut random, 9, case % 2 == 1, 1);
        let over = [Across::Pooled, Across::Worst][random.number_below(2) as usize];
        let problem = problem(&mut random, &evidence, over);
        let Some(best) = best_by_trial(&problem, problem.limits) else { continue };
        let poor = (0..9).filter_map(|item| problem.evaluate(&[item])).map(|found| found.worth).min();
        let known = poor.unwrap_or(best).min(best);
        let Some((gap, _)) = GapSearch::new(&problem, problem.limits, &|| false).run(known) else { continue };
        assert!(gap.above >= Ratio::from_f64(best.value() - 1e-9), "case {case}: {:?} < {best:?}", gap.above);
        shown += 1;
        near += usize::from(gap.above.value() < best.value() + 0.05);
        let asked = CutLimits {
            evidence: &evidence,
            objective: problem.goal.0,
            over,
            at_most: problem.limits.at_most,
            budget: problem.limits.budget,
            cost: problem.rules.cost.clone(),
            always: problem.rules.always.clone(),
            joins: &|item| {
                let cost = problem.rules.cost_of(&problem.rules.always) + problem.rules.cost[item];
                problem.limits.afford(cost) && problem.rules.may_join(&problem.rules.always, item)
            },
            named: &|name: &str| name.parse().ok(),
        };
        let told = CutProof::new(&gap, |item| item.to_string());
        let checked = check_cuts(&asked, slice::from_ref(&told), gap.above.value());
        assert!(checked.is_ok(), "case {case}: {:?}: {problem:?}", checked.map_err(|why| why.to_string()));
        // What is above is less than the best, more sensors are allowed, a cut is left out, or belongs elsewhere.
        let mut lower = told.clone();
        lower.above[0] = (best.value() * lower.above[1] as f64) as u64 / 2;
        refused[0] += usize::from(
            check_cuts(&asked, slice::from_ref(&lower), lower.above[0] as f64 / lower.above[1] as f64)
                .is_err(),
        );
        let more = CutLimits { at_most: 9, budget: None, cost: vec![0; 9], always: vec![], ..asked };
        refused[1] += usize::from(check_cuts(&more, slice::from_ref(&told), gap.above.value()).is_err());
        let mut fewer = told.clone();
        fewer.cuts.truncate(1);
        refused[2] += usize::from(check_cuts(&asked, slice::from_ref(&fewer), gap.above.value()).is_err());
        let mut elsewhere = told.clone();
        elsewhere.cuts[0].moment += 7;
        refused[3] +=
            usize::from(check_cuts(&asked, slice::from_ref(&elsewhere), gap.above.value()).is_err());
    }
    assert!(shown > cases(5, 20) && near > cases(2, 12), "{shown} {near}");
    assert!(
        refused[0] > cases(3, 15)
            && refused[1] > cases(0, 5)
            && refused[2] > cases(0, 5)
            && refused[3] == shown,
        "{refused:?}"
    );
}

/// Whether any set is above a score is answered for scores that no set has, too.
#[test]
fn sets_above_a_score_are_found_where_there_are_any() {
    let mut random = Random(41);
    let (mut found, mut none) = (0, 0);
    for case in 0..200 {
        let evidence = evidence(&mut random, 8, case % 2 == 1, 1);
        let over = [Across::Pooled, Across::Worst][random.number_below(2) as usize];
        let problem = problem(&mut random, &evidence, over);
        let Some(Worth::Exact(best)) = best_by_trial(&problem, problem.limits) else { continue };
        let kept = overlaps(&problem);
        let by = Shortcuts { overlaps: kept.as_ref(), cuts: None };
        // At the best score itself there is no set above, a millionth below there may be.
        let millionths = (best.numerator * 1_000_000).div_euclid(best.denominator);
        // No score is above one.
        for above in
            [millionths + 1, millionths - 1, millionths - 100_000].map(|above| above.clamp(0, 999_999))
        {
            let (set, is_searched) = find_above(&problem, problem.limits, above, by, &|| false);
            assert!(is_searched);
            let least = Ratio { numerator: above, denominator: 1_000_000 };
            assert_eq!(set.is_some(), best > least, "case {case}: {above} {best:?}: {problem:?}");
            if let Some(set) = set {
                assert_eq!(problem.evaluate(&set.set).map(|again| again.worth), Some(set.worth));
                assert!(set.worth > Worth::Exact(least));
                found += 1;
            } else {
                none += 1;
            }
        }
    }
    assert!(found > 150 && none > 80, "{found} {none}");
}

/// Means of voxels' scores are searched to the end, too.
#[test]
fn the_best_mean_is_that_of_trying_every_set() {
    let mut random = Random(37);
    let (mut proven, mut open, mut several) = (0, 0, 0);
    for case in 0..300 {
        let candidates = 3 + random.number_below(7) as usize;
        let evidence = evidence(&mut random, candidates, case % 2 == 1, 1);
        let problem = problem(&mut random, &evidence, Across::Mean);
        let expected = best_by_trial(&problem, problem.limits);
        let Ok(found) = answer(&problem, &|| None) else {
            assert_eq!(expected, None, "case {case}: {problem:?}");
            continue;
        };
        for step in &found.steps {
            let best = step.best.as_ref().unwrap();
            if !bounds_means(&problem) {
                if best.worth.value() == 1.0 {
                    assert_eq!(step.bound, Bound::Proven, "no score is higher");
                    continue;
                }
                assert_ne!(step.bound, Bound::Proven);
                open += 1;
                continue;
            }
            assert_eq!(step.bound, Bound::Proven, "case {case}");
            assert_eq!(
                Some(best.worth),
                best_by_trial(&problem, step.limits),
                "case {case}: {step:?}: {problem:?}"
            );
            proven += 1;
            several += usize::from(evidence.layout.moments.len() > 1 && best.set.len() > 1);
        }
    }
    assert!(proven > 200 && open > 50 && several > 50, "{proven} {open} {several}");
}

/// No set has a higher mean than the mean of the bounds of its scores; the independent check agrees.
#[test]
fn no_set_is_above_the_bound_of_a_mean() {
    let mut random = Random(31);
    let (mut shown, mut near, mut refused) = (0, 0, [0; 3]);
    for case in 0..cases(20, 60) {
        let evidence = evidence(&mut random, 9, case % 2 == 1, 2);
        let problem = problem(&mut random, &evidence, Across::Mean);
        let problem = Problem { require: Vec::new(), ..problem };
        let answer = answer(&problem, &|| None);
        let Some(step) = answer.ok().and_then(|answer| answer.steps.into_iter().next_back()) else {
            continue;
        };
        let set = &step.best.as_ref().unwrap().set;
        let Some(gaps) = GapSearch::moment_bounds(&problem, step.limits, set, &|| false) else { continue };
        let best = best_by_trial(&problem, step.limits).unwrap().value();
        let above = Bound::AtMost(gaps.clone()).upper_score(0.0).unwrap();
        assert!(above >= best - 1e-9, "case {case}: {above} < {best}");
        near += usize::from(above < best + 0.1);
        let asked = CutLimits {
            evidence: &evidence,
            objective: problem.goal.0,
            over: Across::Mean,
            at_most: step.limits.at_most,
            budget: step.limits.budget,
            cost: problem.rules.cost.clone(),
            always: problem.rules.always.clone(),
            joins: &|item| {
                let cost = problem.rules.cost_of(&problem.rules.always) + problem.rules.cost[item];
                step.limits.afford(cost) && problem.rules.may_join(&problem.rules.always, item)
            },
            named: &|name: &str| name.parse().ok(),
        };
        let told: Vec<CutProof> =
            gaps.iter().map(|gap| CutProof::new(gap, |item| item.to_string())).collect();
        check_cuts(&asked, &told, above).unwrap();
        shown += 1;
        // A bound is lower, a score is left out, or one stands for another.
        let mut lower = told.clone();
        lower[0].above[0] = 0;
        let mean = lower.iter().map(|one| one.above[0] as f64 / one.above[1] as f64).sum::<f64>();
        refused[0] += usize::from(check_cuts(&asked, &lower, mean / lower.len() as f64).is_err());
        if told.len() > 1 {
            let rest = told[1..].iter().map(|one| one.above[0] as f64 / one.above[1] as f64).sum::<f64>();
            refused[1] +=
                usize::from(check_cuts(&asked, &told[1..], rest / (told.len() - 1) as f64).is_err());
            let twice = [&told[1..2], &told[1..]].concat();
            let mean = twice.iter().map(|one| one.above[0] as f64 / one.above[1] as f64).sum::<f64>();
            refused[2] += usize::from(check_cuts(&asked, &twice, mean / twice.len() as f64).is_err());
        }
    }
    assert!(
        shown > cases(2, 10) && near > cases(0, 3) && refused[0] > cases(1, 5) && refused[1] > cases(0, 3),
        "{shown} {near} {refused:?}"
    );
    assert_eq!(refused[1], refused[2]);
}

/// A gate feels all voxels of a person, and one would do: what is above the cap may be more than fits a number.
#[test]
fn no_number_of_felt_voxels_is_too_large() {
    let layout = BitLayout::made_up(&[([0, 0], vec![(0, 1 << 20)])], 3);
    let mut planes: [Vec<u64>; 6] = std::array::from_fn(|_| Vec::new());
    planes[super::layout::FELT] = vec![u64::MAX; layout.words[2]];
    let evidence = CandidateEvidence::made_up(layout, vec![[0, 0]], vec![planes]);
    let all = Ratio { numerator: 1, denominator: 1 };
    let asked = (Score::PeopleDetected, Across::Mean);
    let inequality = super::question::score_inequalities(&evidence.layout, asked, all, false).remove(0);
    let (nothing, mut union) = (evidence.nothing(), evidence.nothing());
    let state = inequality.state(&evidence, &nothing);
    assert!(
        state.value < inequality.least && inequality.gain(&evidence, &nothing, &state, 0) >= inequality.least
    );
    union.add(&evidence, 0);
    assert!(inequality.state(&evidence, &union).value >= inequality.least);
}
