//! Whether any set is worth more than what is known: branch and bound over all allowed sets.
//!
//! # Theory
//! A node is a set. Only candidates after its last one, in the order of its parent, may join it, so each set is
//! met once. Let g be what a candidate adds to a node, and o the overlap of two: the sum of their g less what
//! they add together. Several candidates add at most the sum of their g less the o along any tree that connects
//! them (Hunter 1976). They lose by false alarms at least what any one of them loses. When another candidate
//! joins the node, the o of a pair falls by at most as much as the g of either. So tables of pairs exclude most
//! sets of three or four without counting a voxel. What a candidate takes from another by a false alarm is no part of
//! o: several may take it. Where cuts bound all sets (`gap`), the numbers of their sum are one more condition.
//!
//! # Practice
//! Nodes below the first level are shared out among threads, so many at a time; what a lot finds is judged
//! when all of it is done, so the answer does not depend on how many threads there are. When a better set is
//! found, what was searched before stays so: the order of the first level is kept.

use std::ops::Range;

use rayon::prelude::*;

use super::budget::Budget;
use super::candidates::{Above, Adds, Candidates, differences, pick_all};
use super::evidence::Union;
use super::gap::{CutSum, WeighedCuts};
use super::layout::FALSE;
use super::pairs::{OverlapTable, PairCounts};
use super::problem::{FoundSet, Problem};
use super::question::{Question, UnionState, question};
use super::rules::SetLimits;

/// Nodes of the first level that are searched before their results are compared.
const LOT: usize = 16;

/// Inequalities of which overlaps are kept, at most.
const TABLED: usize = 6;

/// Most candidates whose pairs are put in a table.
const MOST_PAIRED: usize = 4096;

/// What is asked, and within which limits.
pub(super) struct SetSearch<'a> {
    problem: &'a Problem<'a>,
    limits: SetLimits,
    question: Question,
    /// Of how many of its inequalities overlaps are kept.
    tabled: usize,
    /// What sets must have besides, if anything is known.
    sum: Option<CutSum>,
    stop: &'a (dyn Fn() -> bool + Sync),
}

/// A set that others extend.
struct SearchNode {
    chosen: Vec<usize>,
    cost: u64,
    union: Union,
    states: Vec<UnionState>,
    /// What is missing of the sum of cuts.
    lacks: i64,
}

/// A node below another one.
struct Child {
    node: SearchNode,
    /// Which of the candidates after its last one may join it.
    after: Vec<usize>,
    adds: Vec<Adds>,
}

/// What makes a search shorter.
#[derive(Clone, Copy, Default)]
pub(super) struct Shortcuts<'a> {
    pub(super) overlaps: Option<&'a PairCounts>,
    pub(super) cuts: Option<&'a WeighedCuts>,
}

/// How far a search is.
#[derive(Default)]
pub(super) struct Ahead {
    /// The candidates in the order of the first level.
    order: Option<Vec<usize>>,
    /// How many of them are done: sets that begin with them are worth no more than the best.
    done: usize,
}

/// Searches for a set that is worth more than the best known one, and goes on from where an earlier search
/// stopped. The caller improves each set that is found and returns one at least as good. Answers the best set,
/// and whether the search was completed.
pub(super) fn search(
    problem: &Problem,
    limits: SetLimits,
    best: Option<FoundSet>,
    by: Shortcuts,
    ahead: &mut Ahead,
    stop: &(dyn Fn() -> bool + Sync),
    improve: &mut dyn FnMut(FoundSet) -> FoundSet,
) -> (Option<FoundSet>, bool) {
    let mut best = best;
    loop {
        let question = question(problem, best.as_ref().map(|best| best.worth));
        let sum = by.cuts.zip(best.as_ref()).and_then(|(cuts, best)| cuts.sum(problem, limits, best.worth));
        let search = SetSearch { sum, ..SetSearch::new(problem, limits, question, stop) };
        match search.run(by.overlaps, ahead) {
            Some(found) => best = Some(improve(found)),
            None => return (best, !stop()),
        }
    }
}

/// A set that is worth more than what is known and consists of some that are given and so many others at
/// most; the first that is found.
pub(super) fn complete(
    problem: &Problem,
    limits: SetLimits,
    given: &[usize],
    best: &FoundSet,
    kept: Option<&PairCounts>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<FoundSet> {
    let question = question(problem, Some(best.worth));
    let search = SetSearch::new(problem, limits, question, stop);
    let node = search.root(given);
    let table = kept.and_then(|kept| kept.table(&search.question.all[..search.tabled]));
    let all: Vec<usize> = (0..problem.evidence.count()).collect();
    let left = limits.at_most - given.len();
    let candidates = search.candidates_of(&node, left, &all, table.as_ref());
    search.search_children(&node, left, candidates)
}

impl<'a> SetSearch<'a> {
    fn new(
        problem: &'a Problem<'a>,
        limits: SetLimits,
        question: Question,
        stop: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        let tabled = question.all.len().min(TABLED);
        SetSearch { problem, limits, question, tabled, sum: None, stop }
    }

    /// A set that is worth more, if there is one and it is not stopped.
    fn run(&self, kept: Option<&PairCounts>, ahead: &mut Ahead) -> Option<FoundSet> {
        let root = self.root(&self.problem.rules.always);
        let left = self.limits.at_most - root.chosen.len();
        let all: Vec<usize> = (0..self.problem.evidence.count()).collect();
        let table = kept.and_then(|kept| kept.table(&self.question.all[..self.tabled]));
        let candidates =
            self.candidates_of(&root, left, ahead.order.as_ref().unwrap_or(&all), table.as_ref());
        if left <= 2 {
            return self.search_children(&root, left, candidates);
        }
        if let Some(found) = self.judge_node(&root) {
            return Some(found);
        }
        let candidates = match &ahead.order {
            Some(_) => candidates,
            None => {
                let candidates = candidates.sort();
                ahead.order = Some(candidates.items.clone());
                candidates
            }
        };
        let table = self.table(&candidates);
        while ahead.done < candidates.items.len() && !(self.stop)() {
            if !self.may_pass(&root, left, &candidates, ahead.done..candidates.items.len()) {
                ahead.done = candidates.items.len();
                break;
            }
            let lot = ahead.done..(ahead.done + LOT).min(candidates.items.len());
            let below = |i: usize| {
                let child = self.child(&root, left, &candidates, table.as_ref(), i)?;
                self.search_child(left, &candidates, table.as_ref(), child)
            };
            let found: Vec<Option<FoundSet>> = lot.clone().into_par_iter().map(below).collect();
            // The first of the best in the order of the lot, whichever thread was faster.
            let found = found.into_iter().flatten();
            let best = found.reduce(|best, next| if next.worth > best.worth { next } else { best });
            if best.is_some() {
                return best;
            }
            if !(self.stop)() {
                ahead.done = lot.end;
            }
        }
        None
    }

    fn root(&self, given: &[usize]) -> SearchNode {
        let mut union = self.problem.evidence.nothing();
        given.iter().for_each(|&item| union.add(self.problem.evidence, item));
        self.node(given.to_vec(), union)
    }

    fn node(&self, chosen: Vec<usize>, union: Union) -> SearchNode {
        let evidence = self.problem.evidence;
        let states = self.question.all.iter().map(|one| one.state(evidence, &union)).collect();
        let lacks = self.sum.as_ref().map_or(0, |sum| sum.lacks(&chosen));
        SearchNode { cost: self.problem.rules.cost_of(&chosen), chosen, union, states, lacks }
    }

    fn may_join(&self, node: &SearchNode, item: usize) -> bool {
        self.limits.afford(node.cost + self.problem.rules.cost[item])
            && self.problem.rules.may_join(&node.chosen, item)
    }

    /// The candidates that may join a set that is given. `table` has their overlaps before anything is chosen.
    fn candidates_of<'t>(
        &self,
        node: &SearchNode,
        left: usize,
        items: &[usize],
        table: Option<&'t OverlapTable>,
    ) -> Candidates<'t> {
        let items: Vec<usize> = items.iter().copied().filter(|&item| self.may_join(node, item)).collect();
        let adds = self.weigh_items(node, left, &items);
        let above = table.map(|table| {
            let alone = self.weigh_items(&self.root(&[]), left, &items);
            let less = (0..self.tabled).map(|j| differences(&alone[j].gains, &adds[j].gains)).collect();
            Above { table, at: items.clone(), less }
        });
        Candidates { items, adds, is_sorted: false, above }
    }

    /// What candidates add to a node and take from it at most.
    fn weigh_items(&self, node: &SearchNode, left: usize, items: &[usize]) -> Vec<Adds> {
        let mut found = vec![(Vec::new(), Vec::new()); self.question.all.len()];
        for &item in items {
            self.weigh(node, item, &mut found);
        }
        found.into_iter().map(|(gains, losses)| Adds::new(gains, losses, left)).collect()
    }

    /// Adds to gains and losses what a candidate does to each inequality of a node.
    fn weigh(&self, node: &SearchNode, item: usize, found: &mut [(Vec<i64>, Vec<i64>)]) {
        let evidence = self.problem.evidence;
        let all = self.question.all.iter().zip(&node.states).zip(found);
        for ((one, state), (gains, losses)) in all {
            gains.push(one.gain(evidence, &node.union, state, item));
            losses.push(one.loss(evidence, &node.union, item));
        }
    }

    /// A set, if it is worth more than what is known.
    fn judge(&self, set: &[usize]) -> Option<FoundSet> {
        let found = self.problem.evaluate(set)?;
        self.question.beaten.is_none_or(|beaten| found.worth > beaten).then_some(found)
    }

    /// The set of a node itself.
    fn judge_node(&self, node: &SearchNode) -> Option<FoundSet> {
        let passes = self.question.all.iter().zip(&node.states).all(|(one, state)| state.value >= one.least);
        (passes && !node.chosen.is_empty()).then(|| self.judge(&node.chosen)).flatten()
    }

    /// What a candidate adds to the sum of cuts.
    fn cut_gain(&self, item: usize) -> i64 {
        self.sum.as_ref().map_or(0, |sum| sum.added[item])
    }

    /// The most that so many candidates add to the sum of cuts.
    fn most_in_sum(&self, left: usize, items: &[usize]) -> i64 {
        let mut top = vec![0; left];
        items.iter().for_each(|&item| insert(&mut top, self.cut_gain(item)));
        top.iter().sum()
    }

    /// Whether so many more of some candidates, which are sorted, may pass every inequality.
    fn may_pass(&self, node: &SearchNode, left: usize, candidates: &Candidates, of: Range<usize>) -> bool {
        if self.most_in_sum(left, &candidates.items[of.clone()]) < node.lacks {
            return false;
        }
        let budget = Budget::new(&self.problem.rules, self.limits, &node.chosen, node.cost, left);
        self.question.all.iter().zip(&node.states).enumerate().all(|(j, (one, state))| {
            let all = of.clone().map(|i| (candidates.items[i], candidates.limit(i, j)));
            let own = |place: usize| candidates.adds[j].charged[of.start + place];
            state.value + budget.most(&self.problem.rules, all, own) >= one.least
        })
    }

    /// The candidates that may be in a set that passes, by what is known of their pairs; they stay sorted.
    fn prune<'t>(&self, node: &SearchNode, left: usize, candidates: Candidates<'t>) -> Candidates<'t> {
        let budgets = Budget::after_each(&self.problem.rules, self.limits, &node.chosen, node.cost, left - 1);
        let number = |i: usize| Budget::number(&budgets, &self.problem.rules, candidates.items[i]);
        let others = self.most_in_sum(left - 1, &candidates.items);
        let mut alive: Vec<usize> = (0..candidates.items.len())
            .filter(|&i| self.cut_gain(candidates.items[i]) + others >= node.lacks)
            .collect();
        for j in 0..self.question.all.len() {
            let (least, value) = (self.question.all[j].least, node.states[j].value);
            let own = |i: usize| candidates.adds[j].charged[i];
            let limits = |alive: &[usize]| -> Vec<(usize, i64)> {
                alive.iter().map(|&i| (candidates.items[i], candidates.limit(i, j))).collect()
            };
            // First without overlaps: the bound for the others is then the same for all candidates of a sensor.
            let sorted = limits(&alive);
            let top = |budget: &Budget| {
                budget.most(&self.problem.rules, sorted.iter().copied(), |place| own(alive[place]))
            };
            let tops: Vec<i64> = budgets.iter().map(top).collect();
            alive.retain(|&i| value + own(i) + tops[number(i)] >= least);
            if j == 0 && candidates.above.is_some() && left > 1 {
                let sorted = limits(&alive);
                let passes = |&i: &usize| {
                    let beside = |place: usize| match alive[place] {
                        l if l == i => i64::MIN / 2,
                        l => own(l) - candidates.overlap(i, l, j),
                    };
                    value
                        + own(i)
                        + budgets[number(i)].most(&self.problem.rules, sorted.iter().copied(), beside)
                        >= least
                };
                alive = alive.iter().copied().filter(passes).collect();
            }
        }
        candidates.pick(&alive)
    }

    /// A set that is worth more, among a node and those with up to so many more of some candidates.
    fn search_children(&self, node: &SearchNode, left: usize, candidates: Candidates) -> Option<FoundSet> {
        if let Some(found) = self.judge_node(node) {
            return Some(found);
        }
        if left == 0 || (self.stop)() {
            return None;
        }
        let candidates = self.prune(node, left, candidates.sort());
        match left {
            1 => candidates.items.iter().find_map(|&item| self.judge(&[&node.chosen[..], &[item]].concat())),
            2 => self.pairs(node, &candidates),
            _ => {
                let mut table = self.table(&candidates);
                // The last first: overlaps that are counted there serve those before.
                for i in (0..candidates.items.len()).rev() {
                    if !self.may_pass(node, left, &candidates, i..candidates.items.len()) {
                        continue;
                    }
                    let Some(child) = self.child(node, left, &candidates, table.as_ref(), i) else {
                        continue;
                    };
                    // What it takes from others by false alarms is no overlap: it may be taken by several.
                    let is_right = self.problem.evidence.plane(candidates.items[i], FALSE).is_empty();
                    let known = if is_right { self.tabled } else { 0 };
                    for (j, adds) in child.adds.iter().enumerate().take(known) {
                        for (&l, gain) in child.after.iter().zip(&adds.gains) {
                            table
                                .iter_mut()
                                .for_each(|table| table.set(j, i, l, candidates.adds[j].gains[l] - gain));
                        }
                    }
                    if let Some(found) = self.search_child(left, &candidates, table.as_ref(), child) {
                        return Some(found);
                    }
                }
                None
            }
        }
    }

    /// What is known of the overlaps of candidates beside a node, if they are not too many.
    fn table(&self, candidates: &Candidates) -> Option<OverlapTable> {
        // Each thread has one at some depth.
        let bytes = (candidates.items.len().pow(2) * self.tabled * size_of::<i64>()) as u64;
        let fits = bytes <= self.problem.evidence.spare_bytes() / (rayon::current_num_threads() as u64 + 1);
        let is_small = self.tabled > 0 && candidates.items.len() <= MOST_PAIRED && fits;
        let known = |j: usize, a: usize, b: usize| candidates.overlap(a, b, j);
        is_small.then(|| OverlapTable::new(candidates.items.len(), self.tabled, known))
    }

    /// The node with one more candidate, and those after it that may join it; `None` if nothing below passes.
    fn child(
        &self,
        node: &SearchNode,
        left: usize,
        candidates: &Candidates,
        table: Option<&OverlapTable>,
        i: usize,
    ) -> Option<Child> {
        let item = candidates.items[i];
        let (chosen, cost) =
            ([&node.chosen[..], &[item]].concat(), node.cost + self.problem.rules.cost[item]);
        let joins = |l: usize| {
            let other = candidates.items[l];
            self.limits.afford(cost + self.problem.rules.cost[other])
                && self.problem.rules.may_join(&chosen, other)
        };
        let mut union = None;
        let joined = || {
            let mut union = node.union.clone();
            union.add(self.problem.evidence, item);
            self.node(chosen.clone(), union)
        };
        let Some((first, adds)) = self.question.all.first().zip(candidates.adds.first()) else {
            let after = (i + 1..candidates.items.len()).filter(|&l| joins(l)).collect();
            return Some(Child { node: joined(), after, adds: Vec::new() });
        };
        let needed = first.least - node.states[0].value - adds.charged[i];
        // What each adds beside this one at most.
        let hint = |l: usize| adds.charged[l] - table.map_or(0, |table| table.overlap(0, i, l));
        let most = {
            let budget = Budget::new(&self.problem.rules, self.limits, &chosen, cost, left - 1);
            let sorted =
                (i + 1..candidates.items.len()).map(|l| (candidates.items[l], candidates.limit(l, 0)));
            budget.most(&self.problem.rules, sorted, |place| hint(i + 1 + place))
        };
        if most < needed {
            return None;
        }
        let lacks = node.lacks - self.cut_gain(item) - self.most_in_sum(left - 2, &candidates.items[i + 1..]);
        let mut top = vec![0; left - 2];
        (i + 1..candidates.items.len()).for_each(|l| insert(&mut top, hint(l)));
        let others: i64 = top.iter().sum();
        let mut hinted: Vec<(i64, usize)> = (i + 1..candidates.items.len())
            .map(|l| (hint(l), l))
            .filter(|&(hint, l)| {
                hint + others >= needed && self.cut_gain(candidates.items[l]) >= lacks && joins(l)
            })
            .collect();
        hinted.sort_by_key(|&(hint, l)| (std::cmp::Reverse(hint), l));
        let child: &SearchNode = union.get_or_insert_with(joined);
        top.fill(0);
        let mut after = Vec::new();
        let mut found = vec![(Vec::new(), Vec::new()); self.question.all.len()];
        for (hint, l) in hinted {
            // No later candidate adds more than this hint.
            let others: i64 = top.iter().map(|&best: &i64| best.max(hint)).sum();
            if hint + others < needed {
                break;
            }
            after.push(l);
            self.weigh(child, candidates.items[l], &mut found);
            let gain = found[0].0.last().copied().unwrap_or(0);
            insert(&mut top, gain);
        }
        let adds = found.into_iter().map(|(gains, losses)| Adds::new(gains, losses, left - 1)).collect();
        union.map(|node| Child { node, after, adds })
    }

    /// A set that is worth more, among a child and those below it.
    fn search_child(
        &self,
        left: usize,
        candidates: &Candidates,
        table: Option<&OverlapTable>,
        child: Child,
    ) -> Option<FoundSet> {
        let Child { node, after, adds } = child;
        let above = table.map(|table| {
            let before = |j: usize| pick_all(&candidates.adds[j].gains, &after);
            let less = (0..self.tabled).map(|j| differences(&before(j), &adds[j].gains)).collect();
            Above { table, less, at: after.clone() }
        });
        self.search_children(
            &node,
            left - 1,
            Candidates { items: pick_all(&candidates.items, &after), adds, is_sorted: false, above },
        )
    }

    /// A set that is worth more, among those with one or two more candidates.
    fn pairs(&self, node: &SearchNode, candidates: &Candidates) -> Option<FoundSet> {
        let (evidence, count) = (self.problem.evidence, self.question.all.len());
        let value = |j: usize| node.states[j].value;
        for (i, &item) in candidates.items.iter().enumerate() {
            if (self.stop)() {
                return None;
            }
            let one = [&node.chosen[..], &[item]].concat();
            let alone = self.question.all.iter().zip(&node.states).enumerate();
            if alone.into_iter().all(|(j, (q, state))| {
                state.value + candidates.adds[j].gains[i] - candidates.adds[j].losses[i] >= q.least
            }) && let Some(found) = self.judge(&one)
            {
                return Some(found);
            }
            let mut fresh = None;
            let lacks = node.lacks - self.cut_gain(item);
            for l in i + 1..candidates.items.len() {
                if self.cut_gain(candidates.items[l]) < lacks {
                    continue;
                }
                let charged = |of: usize| candidates.adds[0].charged[of];
                if count > 0 && value(0) + charged(i) + charged(l) < self.question.all[0].least {
                    break;
                }
                // By how much both together exceed the threshold if they do not overlap, less the larger loss.
                let slack = |j: usize| {
                    let Adds { gains, losses, .. } = &candidates.adds[j];
                    value(j) + gains[i] + gains[l] - losses[i].max(losses[l]) - self.question.all[j].least
                };
                if (0..count).any(|j| slack(j) < candidates.overlap(i, l, j)) {
                    continue;
                }
                let other = candidates.items[l];
                let cost = node.cost + self.problem.rules.cost[item] + self.problem.rules.cost[other];
                if !self.limits.afford(cost) || !self.problem.rules.may_join(&one, other) {
                    continue;
                }
                if let Some(first) = self.question.all.first().filter(|first| first.is_plain()) {
                    let fresh = fresh.get_or_insert_with(|| first.added_bits(evidence, &node.union, item));
                    if first.overlap_exceeds(fresh, evidence, other, slack(0)) {
                        continue;
                    }
                }
                if let Some(found) = self.judge(&[&one[..], &[other]].concat()) {
                    return Some(found);
                }
            }
        }
        None
    }
}

/// Inserts a number into a sorted list of the largest ones.
fn insert(top: &mut [i64], value: i64) {
    let mut at = top.len();
    while at > 0 && top[at - 1] < value {
        at -= 1;
        if at + 1 < top.len() {
            top[at + 1] = top[at];
        }
        top[at] = value;
    }
}
