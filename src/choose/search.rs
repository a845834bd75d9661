//! Whether any set is worth more than what is known: branch and bound over all allowed sets.
//!
//! # Theory
//! A node is a set, and what may still join it comes after it in the order of its parent, so each set is met
//! once. A union gains no more from several candidates than the sum of what it gains from each, less what the
//! one with the most false alarms takes from it. Where that sum does not pass an inequality of the question
//! for the best ones that are left, no set below the node does.
//!
//! # Practice
//! The last two candidates are a pair: what both add is counted for few pairs, and given up as soon as it is
//! too much. Nodes below the first level are shared out among threads, so many at a time; what a lot finds is
//! judged when all of it is done, so the answer does not depend on how many threads there are.

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use super::evidence::Union;
use super::problem::{Found, Problem, SetLimits};
use super::question::{Inequality, Question, UnionState, question};
use super::worth::Worth;

/// Most candidates for which a table of all pairs is made: 134 MB.
const MOST_PAIRED: usize = 4096;

/// Nodes of the first level that are searched before what they found is judged.
const LOT: usize = 16;

/// What a search came to.
pub(super) enum Outcome {
    /// A set that is worth more.
    Better(Found),
    /// None is.
    None,
    /// It was stopped; no set is worth more than this, if that is known.
    Stopped(Option<f64>),
}

/// What is asked, and within which limits.
struct SetSearch<'a> {
    problem: &'a Problem<'a>,
    limits: SetLimits,
    question: Question,
    level: Level,
    stop: &'a (dyn Fn() -> bool + Sync),
    /// What each candidate adds to the first inequality beside each other one, row by row; empty if not known.
    beside: Vec<i64>,
}

/// A candidate, and what it adds to the first inequality at most.
type Hinted = (usize, i64);

/// What a candidate adds at most of which nothing is known.
const ANYTHING: i64 = 1 << 58;

/// A set on the way.
struct Node {
    chosen: Vec<usize>,
    cost: u64,
    union: Union,
    states: Vec<UnionState>,
}

/// The candidates that may join a node, the most promising first.
struct Open {
    items: Vec<usize>,
    /// What each adds to each inequality at most, item by item.
    gains: Vec<i64>,
    /// The same, less its share of what is lost.
    charged: Vec<i64>,
    /// What the first inequality loses.
    losses: Vec<i64>,
    inequalities: usize,
}

/// Whether an allowed set is worth more than what is known.
pub(super) fn search(
    problem: &Problem,
    limits: SetLimits,
    beaten: Option<Worth>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Outcome {
    let question = question(problem, beaten);
    SetSearch { problem, limits, question, level: Level::new(), stop, beside: Vec::new() }.run()
}

impl SetSearch<'_> {
    fn run(mut self) -> Outcome {
        let evidence = self.problem.evidence;
        let always = &self.problem.always;
        let mut union = evidence.nothing();
        always.iter().for_each(|&item| union.add(evidence, item));
        let root = self.node(always.clone(), union);
        let items: Vec<Hinted> = (0..evidence.count()).map(|item| (item, ANYTHING)).collect();
        let left = self.limits.at_most - always.len();
        if left <= 2 {
            return match self.expand(&root, left, &items) {
                Some(found) => Outcome::Better(found),
                None if (self.stop)() => Outcome::Stopped(self.bound(&[self.most(&root, left, &items)])),
                None => Outcome::None,
            };
        }
        if let Some(found) = self.judge_node(&root) {
            return Outcome::Better(found);
        }
        self.beside = self.all_beside(&root);
        let open = self.open(&root, left, &items);
        let mut first = 0;
        while first < open.items.len() && self.may_pass(&root, &open, first, left) {
            let lot = first..(first + LOT).min(open.items.len());
            let below = |i: usize| {
                let passes = self.may_pass(&root, &open, i, left);
                passes
                    .then(|| self.expand(&self.child(&root, open.items[i]), left - 1, &open.after(i)))
                    .flatten()
            };
            let found: Vec<Option<Found>> = lot.clone().into_par_iter().map(below).collect();
            // The first of the best, whoever was quicker.
            let best = found
                .into_iter()
                .flatten()
                .reduce(|best, next| if next.worth > best.worth { next } else { best });
            if let Some(best) = best {
                return Outcome::Better(best);
            }
            if (self.stop)() {
                let rest = (first..open.items.len()).filter(|&i| self.may_pass(&root, &open, i, left));
                let rest: Vec<usize> = rest.collect();
                let most = rest
                    .into_par_iter()
                    .map(|i| self.most(&self.child(&root, open.items[i]), left - 1, &open.after(i)));
                return Outcome::Stopped(self.bound(&most.collect::<Vec<_>>()));
            }
            first = lot.end;
        }
        Outcome::None
    }

    /// What each candidate adds beside a root and each other one.
    fn all_beside(&self, root: &Node) -> Vec<i64> {
        let count = self.problem.evidence.count();
        let Some(first) = self.question.all.first().filter(|_| count <= MOST_PAIRED) else {
            return Vec::new();
        };
        let row = |item: usize| {
            let node = self.child(root, item);
            dispatch!(self.level, simd => gains(simd, first, self.problem, &node))
        };
        (0..count).into_par_iter().flat_map_iter(row).collect()
    }

    /// What a candidate adds at most beside another.
    fn beside(&self, other: usize, item: usize) -> i64 {
        self.beside.get(other * self.problem.evidence.count() + item).copied().unwrap_or(ANYTHING)
    }

    /// What no set is worth more than, if none of some nodes leads to larger values than these.
    fn bound(&self, most: &[Vec<i64>]) -> Option<f64> {
        let count = self.question.all.len();
        let values: Vec<i64> =
            (0..count).map(|j| most.iter().map(|most| most[j]).max().unwrap_or(i64::MIN / 2)).collect();
        self.question.bound(&values)
    }

    /// The largest values that a node leads to, one for each inequality.
    fn most(&self, node: &Node, left: usize, items: &[Hinted]) -> Vec<i64> {
        if left == 0 {
            return node.states.iter().map(|state| state.value).collect();
        }
        let items = self.joining(node, items);
        let open = dispatch!(self.level, simd => self.weigh(simd, node, left, &items));
        let count = open.inequalities;
        let of = |j: usize| node.states[j].value + best(open.of(j), left);
        (0..count).map(of).collect()
    }

    fn node(&self, chosen: Vec<usize>, union: Union) -> Node {
        let states = self.question.all.iter().map(|inequality| inequality.state(&union)).collect();
        Node { cost: self.problem.cost_of(&chosen), chosen, union, states }
    }

    fn child(&self, node: &Node, item: usize) -> Node {
        let mut union = node.union.clone();
        union.add(self.problem.evidence, item);
        self.node([&node.chosen[..], &[item]].concat(), union)
    }

    fn may_join(&self, node: &Node, item: usize) -> bool {
        self.limits.afford(node.cost + self.problem.cost[item]) && self.problem.may_join(&node.chosen, item)
    }

    /// The candidates that may join a node, those that may add most first.
    fn joining(&self, node: &Node, items: &[Hinted]) -> Vec<Hinted> {
        let last = node.chosen[self.problem.always.len()..].last();
        let hinted = |&(item, hint): &Hinted| {
            let hint = last.map_or(hint, |&last| hint.min(self.beside(last, item)));
            self.may_join(node, item).then_some((item, hint))
        };
        let mut hinted: Vec<Hinted> = items.iter().filter_map(hinted).collect();
        hinted.sort_by_key(|&(_, hint)| std::cmp::Reverse(hint));
        hinted
    }

    /// A set, if it is worth more than what is known.
    fn judge(&self, set: &[usize]) -> Option<Found> {
        let found = self.problem.found(set)?;
        self.question.beaten.is_none_or(|beaten| found.worth > beaten).then_some(found)
    }

    /// The set of a node itself.
    fn judge_node(&self, node: &Node) -> Option<Found> {
        let passes = self.question.all.iter().zip(&node.states).all(|(one, state)| state.value >= one.least);
        (passes && !node.chosen.is_empty()).then(|| self.judge(&node.chosen)).flatten()
    }

    /// A set that is worth more, among a node and those with up to so many more of some candidates.
    fn expand(&self, node: &Node, left: usize, items: &[Hinted]) -> Option<Found> {
        if let Some(found) = self.judge_node(node) {
            return Some(found);
        }
        if left == 0 || (self.stop)() {
            return None;
        }
        let open = self.open(node, left, items);
        match left {
            1 => open.items.iter().find_map(|&item| self.judge(&[&node.chosen[..], &[item]].concat())),
            2 => dispatch!(self.level, simd => self.pairs(simd, node, &open)),
            _ => (0..open.items.len())
                .take_while(|&i| self.may_pass(node, &open, i, left))
                .find_map(|i| self.expand(&self.child(node, open.items[i]), left - 1, &open.after(i))),
        }
    }

    /// The candidates that may lead from a node to a set that passes.
    fn open(&self, node: &Node, left: usize, items: &[Hinted]) -> Open {
        let items = self.joining(node, items);
        let open = dispatch!(self.level, simd => self.weigh(simd, node, left, &items));
        let others: Vec<i64> = (0..open.inequalities).map(|j| best(open.of(j), left - 1)).collect();
        let passes = |i: &usize| {
            let own = &open.charged[i * open.inequalities..(i + 1) * open.inequalities];
            let all = self.question.all.iter().zip(&node.states).zip(own.iter().zip(&others));
            all.into_iter().all(|((one, state), (own, others))| state.value + own + others >= one.least)
        };
        let mut order: Vec<usize> = (0..open.items.len()).filter(passes).collect();
        if open.inequalities > 0 {
            order.sort_by_key(|&i| std::cmp::Reverse(open.charged[i * open.inequalities]));
        }
        open.reordered(&order)
    }

    /// What each candidate adds to a node, as long as one may lead to a set that passes.
    #[inline(always)]
    fn weigh<S: Simd>(&self, _: S, node: &Node, left: usize, hinted: &[Hinted]) -> Open {
        let (evidence, inequalities) = (self.problem.evidence, self.question.all.len());
        let (mut gains, mut charged, mut losses) = (Vec::new(), Vec::new(), Vec::new());
        // What the best of those before add, all but one of a set.
        let (mut items, mut top) = (Vec::new(), vec![0; left - 1]);
        for &(item, hint) in hinted {
            if let Some(first) = self.question.all.first() {
                // Nobody after this one adds more than it may.
                let others: i64 = top.iter().map(|&best: &i64| best.max(hint)).sum();
                if node.states[0].value + hint + others < first.least {
                    break;
                }
            }
            items.push(item);
            for (number, (one, state)) in self.question.all.iter().zip(&node.states).enumerate() {
                let gain = one.gain(evidence, &node.union, state, item);
                let loss = one.loss(evidence, &node.union, item);
                gains.push(gain);
                charged.push(gain - loss / left as i64);
                if number == 0 {
                    losses.push(loss);
                    let at = top.partition_point(|&best| best >= gain);
                    if at < top.len() {
                        top.insert(at, gain);
                        top.pop();
                    }
                }
            }
        }
        Open { items, gains, charged, losses, inequalities }
    }

    /// Whether a candidate with the best of those after it may pass the first inequality.
    fn may_pass(&self, node: &Node, open: &Open, i: usize, left: usize) -> bool {
        let Some(first) = self.question.all.first() else { return true };
        let after =
            (i + 1..open.items.len().min(i + left)).map(|l| open.charged[l * open.inequalities].max(0));
        node.states[0].value + open.charged[i * open.inequalities] + after.sum::<i64>() >= first.least
    }

    /// A set that is worth more, among those with one or two more candidates.
    #[inline(always)]
    fn pairs<S: Simd>(&self, _: S, node: &Node, open: &Open) -> Option<Found> {
        let (evidence, count) = (self.problem.evidence, open.inequalities);
        for (i, &item) in open.items.iter().enumerate() {
            let one = [&node.chosen[..], &[item]].concat();
            let alone = self.question.all.iter().zip(&node.states).enumerate();
            // Less than its whole loss was taken, which lets more pass.
            if alone.into_iter().all(|(j, (q, state))| state.value + open.charged[i * count + j] >= q.least)
                && let Some(found) = self.judge(&one)
            {
                return Some(found);
            }
            let value = node.states.first().map_or(0, |state| state.value);
            let mut fresh = None;
            for l in i + 1..open.items.len() {
                let both = |j: usize| {
                    node.states[j].value + open.charged[i * count + j] + open.charged[l * count + j]
                };
                if count > 0 && both(0) < self.question.all[0].least {
                    break;
                }
                if !(1..count).all(|j| both(j) >= self.question.all[j].least) {
                    continue;
                }
                let other = open.items[l];
                if count > 0
                    && value + open.charged[i * count] + self.beside(item, other) < self.question.all[0].least
                {
                    continue;
                }
                let cost = node.cost + self.problem.cost[item] + self.problem.cost[other];
                if !self.limits.afford(cost) || !self.problem.may_join(&one, other) {
                    continue;
                }
                if let Some(first) = self.question.all.first().filter(|first| first.is_plain()) {
                    let gain = open.gains[i * count] + open.gains[l * count];
                    let slack =
                        node.states[0].value + gain - open.losses[i].max(open.losses[l]) - first.least;
                    let fresh = fresh.get_or_insert_with(|| first.added(evidence, &node.union, item));
                    if slack < 0 || first.overlap_exceeds(fresh, evidence, other, slack) {
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

/// What each candidate adds to a node.
#[inline(always)]
fn gains<S: Simd>(_: S, inequality: &Inequality, problem: &Problem, node: &Node) -> Vec<i64> {
    let gain = |item| inequality.gain(problem.evidence, &node.union, &node.states[0], item);
    (0..problem.evidence.count()).map(gain).collect()
}

impl Open {
    /// The candidates after one.
    fn after(&self, i: usize) -> Vec<Hinted> {
        let gain = |l: usize| self.gains.get(l * self.inequalities).copied();
        let hinted =
            |l: usize| (self.items[l], gain(l).filter(|_| self.inequalities > 0).unwrap_or(ANYTHING));
        (i + 1..self.items.len()).map(hinted).collect()
    }

    /// What each candidate adds to one inequality, less its share of what is lost.
    fn of(&self, inequality: usize) -> impl Iterator<Item = i64> + '_ {
        self.charged.iter().copied().skip(inequality).step_by(self.inequalities.max(1))
    }

    fn reordered(&self, order: &[usize]) -> Open {
        let count = self.inequalities;
        let rows =
            |all: &[i64]| order.iter().flat_map(|&i| all[i * count..(i + 1) * count].to_vec()).collect();
        Open {
            items: order.iter().map(|&i| self.items[i]).collect(),
            gains: rows(&self.gains),
            charged: rows(&self.charged),
            losses: if count > 0 { order.iter().map(|&i| self.losses[i]).collect() } else { Vec::new() },
            inequalities: count,
        }
    }
}

/// The sum of the largest so many that are above zero.
fn best(gains: impl Iterator<Item = i64>, count: usize) -> i64 {
    let mut best: Vec<i64> = Vec::with_capacity(count + 1);
    if count == 0 {
        return 0;
    }
    for gain in gains {
        if gain > 0 && (best.len() < count || gain > best[best.len() - 1]) {
            let at = best.partition_point(|&other| other >= gain);
            best.insert(at, gain);
            best.truncate(count);
        }
    }
    best.iter().sum()
}
