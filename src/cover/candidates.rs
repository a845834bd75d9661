//! The candidates that may join a set, and at most what each adds to it.

use super::pairs::OverlapTable;

/// The table of overlaps of the node above.
pub(super) struct Above<'a> {
    pub(super) table: &'a OverlapTable,
    /// Where each candidate is in it.
    pub(super) at: Vec<usize>,
    /// How much less each adds here than there, for each inequality that has overlaps.
    pub(super) less: Vec<Vec<i64>>,
}

/// Candidates that may join a node.
pub(super) struct Candidates<'a> {
    pub(super) items: Vec<usize>,
    /// For each inequality what they add and take.
    pub(super) adds: Vec<Adds>,
    /// Whether they are in descending order of what they add to the first inequality.
    pub(super) is_sorted: bool,
    pub(super) above: Option<Above<'a>>,
}

/// What candidates add to an inequality at most.
pub(super) struct Adds {
    pub(super) gains: Vec<i64>,
    /// What each takes away.
    pub(super) losses: Vec<i64>,
    /// Gains, each less its share of the largest possible loss.
    pub(super) charged: Vec<i64>,
}

impl Adds {
    pub(super) fn new(gains: Vec<i64>, losses: Vec<i64>, left: usize) -> Adds {
        let share = |loss: i64| if loss == 0 { 0 } else { loss / left.max(1) as i64 };
        let charged = gains.iter().zip(&losses).map(|(gain, &loss)| gain - share(loss)).collect();
        Adds { gains, losses, charged }
    }

    pub(super) fn pick(&self, order: &[usize]) -> Adds {
        let of = |all: &[i64]| pick_all(all, order);
        Adds { gains: of(&self.gains), losses: of(&self.losses), charged: of(&self.charged) }
    }
}

impl<'t> Candidates<'t> {
    /// An upper bound for what a candidate and all after it add to an inequality.
    pub(super) fn limit(&self, i: usize, j: usize) -> i64 {
        if j == 0 && self.is_sorted { self.adds[0].charged[i] } else { i64::MAX }
    }

    /// The candidates, those first that add most to the first inequality.
    pub(super) fn sort(self) -> Candidates<'t> {
        let mut order: Vec<usize> = (0..self.items.len()).collect();
        if let Some(adds) = self.adds.first() {
            order.sort_by_key(|&i| std::cmp::Reverse(adds.charged[i]));
        }
        Candidates { is_sorted: true, ..self.pick(&order) }
    }

    pub(super) fn pick(self, order: &[usize]) -> Candidates<'t> {
        Candidates {
            items: pick_all(&self.items, order),
            adds: self.adds.iter().map(|adds| adds.pick(order)).collect(),
            is_sorted: self.is_sorted,
            above: self.above.map(|above| Above {
                table: above.table,
                at: pick_all(&above.at, order),
                less: above.less.iter().map(|less| pick_all(less, order)).collect(),
            }),
        }
    }

    /// At least how much less two candidates add together.
    #[inline(always)]
    pub(super) fn overlap(&self, a: usize, b: usize, j: usize) -> i64 {
        match &self.above {
            Some(above) if j < above.less.len() => {
                let less = above.less[j][a].min(above.less[j][b]);
                (above.table.overlap(j, above.at[a], above.at[b]) - less).max(0)
            }
            _ => 0,
        }
    }
}

pub(super) fn pick_all<T: Copy>(all: &[T], order: &[usize]) -> Vec<T> {
    order.iter().map(|&i| all[i]).collect()
}

pub(super) fn differences(before: &[i64], now: &[i64]) -> Vec<i64> {
    before.iter().zip(now).map(|(before, now)| before - now).collect()
}
