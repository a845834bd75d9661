//! How many more sensors of each kind fit the budget and the limits, and an upper bound for what candidates
//! can add within them.

use super::rules::{SetLimits, SetRules};

/// Most ways to share out what is left; if there are more, costs are not looked at.
const MOST_WAYS: usize = 64;

/// How the places that are left may be shared out among the sensors.
pub(super) struct Budget {
    left: usize,
    /// The maximal numbers of each sensor; empty if only the number of places limits them.
    ways: Vec<Vec<usize>>,
}

impl Budget {
    /// For so many more sensors beside some chosen ones, which cost so much.
    pub(super) fn new(
        rules: &SetRules,
        limits: SetLimits,
        chosen: &[usize],
        cost: u64,
        left: usize,
    ) -> Budget {
        let sensors = rules.most.len();
        let of = |sensor: usize| chosen.iter().filter(|&&item| rules.sensor[item] == sensor).count();
        let most: Vec<usize> = (0..sensors).map(|s| rules.most[s].saturating_sub(of(s)).min(left)).collect();
        if limits.budget.is_none() && most.iter().all(|&most| most >= left) {
            return Budget { left, ways: Vec::new() };
        }
        let mut ways = Vec::new();
        let rest = limits.budget.map_or(u64::MAX, |budget| budget.saturating_sub(cost));
        let price = cheapest(rules);
        share(&most, &price, left, rest, &mut Vec::new(), &mut ways);
        if ways.len() > MOST_WAYS { Budget { left, ways: Vec::new() } } else { Budget { left, ways } }
    }

    /// How many more sensors there is room for.
    pub(super) fn left(&self) -> usize {
        self.left
    }

    /// For each sensor, what is left after one more of it; a single one if that is the same for all.
    pub(super) fn after_each(
        rules: &SetRules,
        limits: SetLimits,
        chosen: &[usize],
        cost: u64,
        left: usize,
    ) -> Vec<Budget> {
        let alike = limits.budget.is_none() && rules.most.iter().all(|&most| most > chosen.len() + left);
        if alike {
            return vec![Budget { left, ways: Vec::new() }];
        }
        let price = cheapest(rules);
        let beside = |sensor: usize| {
            let item = rules.sensor.iter().position(|&own| own == sensor);
            let Some(item) = item else { return Budget { left: 0, ways: Vec::new() } };
            Budget::new(rules, limits, &[chosen, &[item]].concat(), cost + price[sensor], left)
        };
        (0..rules.most.len()).map(beside).collect()
    }

    /// Which of those of [`Budget::after_each`] a candidate's is.
    pub(super) fn number(budgets: &[Budget], rules: &SetRules, item: usize) -> usize {
        if budgets.len() == 1 { 0 } else { rules.sensor[item] }
    }

    /// The most that some candidates add together. Each comes with what it adds at most, largest first; `value`
    /// has what it truly adds, by its place among them.
    #[inline(always)]
    pub(super) fn most(
        &self,
        rules: &SetRules,
        sorted: impl Iterator<Item = (usize, i64)>,
        value: impl Fn(usize) -> i64,
    ) -> i64 {
        if self.left == 0 {
            return 0;
        }
        let groups = self.ways.first().map_or(1, Vec::len);
        // The best of each sensor, largest first.
        let mut best = vec![0i64; groups * self.left];
        let mut worst = 0;
        for (place, (item, limit)) in sorted.enumerate() {
            if limit <= worst {
                break;
            }
            let group = if self.ways.is_empty() { 0 } else { rules.sensor[item] };
            let own = &mut best[group * self.left..(group + 1) * self.left];
            let value = value(place);
            if value > own[self.left - 1] {
                let mut at = self.left - 1;
                while at > 0 && own[at - 1] < value {
                    own[at] = own[at - 1];
                    at -= 1;
                }
                own[at] = value;
                // Values after this one are no larger than the last kept one of any sensor.
                worst = best.chunks(self.left).map(|own| own[self.left - 1]).min().unwrap_or(0);
            }
        }
        if self.ways.is_empty() {
            return best.iter().sum();
        }
        let of = |way: &Vec<usize>| -> i64 {
            way.iter()
                .enumerate()
                .map(|(group, &count)| best[group * self.left..][..count].iter().sum::<i64>())
                .sum()
        };
        self.ways.iter().map(of).max().unwrap_or(0)
    }
}

/// The cheapest candidate of each sensor.
fn cheapest(rules: &SetRules) -> Vec<u64> {
    let mut price = vec![u64::MAX; rules.most.len()];
    for (item, &sensor) in rules.sensor.iter().enumerate() {
        price[sensor] = price[sensor].min(rules.cost[item]);
    }
    price
}

/// Lists the maximal numbers of each sensor, from the next sensor on.
fn share(
    most: &[usize],
    price: &[u64],
    left: usize,
    rest: u64,
    begun: &mut Vec<usize>,
    ways: &mut Vec<Vec<usize>>,
) {
    if ways.len() > MOST_WAYS {
        return;
    }
    let sensor = begun.len();
    if sensor == most.len() {
        let covers = |way: &Vec<usize>| way.iter().zip(begun.iter()).all(|(a, b)| a >= b);
        if !ways.iter().any(covers) {
            ways.push(begun.clone());
        }
        return;
    }
    let afforded =
        rest.checked_div(price[sensor]).map_or(usize::MAX, |n| usize::try_from(n).unwrap_or(usize::MAX));
    for count in (0..=most[sensor].min(left).min(afforded)).rev() {
        begun.push(count);
        share(most, price, left - count, rest - price[sensor].saturating_mul(count as u64), begun, ways);
        begun.pop();
    }
}
