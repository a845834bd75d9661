//! The linear program of cuts, solved for both sides: the weights of cuts that give the lowest bound, and the
//! shares of candidates with the highest value. Newton's method solves smooth programs that approach it.
//!
//! # Theory
//! Cuts c say that shares x have no more than a_c + Σ b_ci·x_i. Weights w that add up to one allow
//! Σ a_c·w_c + the sum of the largest k of g_i = Σ b_ci·w_c. At a temperature T that sum is
//! k·ν + T·Σ ln(1 + exp((g_i − ν)/T)) at the best ν, whose slope by g_i is a share between 0 and 1, and
//! weights stay above zero by −T·Σ ln w_c. The hotter, the farther from corners are shares and weights, which
//! makes better cuts; the colder, the nearer are they to the optimum.
//!
//! Nothing is proven here: all of it is floating point. `gap` rounds the weights and checks the proof.

use rayon::prelude::*;

/// Newton steps at one temperature, at most.
const STEPS: usize = 20;
/// The first temperature.
const HOTTEST: f64 = 0.03;
/// By which factor it falls.
const COOLING: f64 = 0.2;

/// The linear program.
pub(super) struct Lp {
    /// What each cut has without candidates.
    pub(super) constant: Vec<f64>,
    /// What each candidate adds to each cut, cut by cut.
    pub(super) added: Vec<Vec<f64>>,
    /// How many are cuts, whose weights add up to one; one more may be the budget.
    pub(super) cuts: usize,
}

impl Lp {
    /// The optimal weights and shares at a temperature. `begin` has the weights to begin from, and then those found.
    pub(super) fn solve_at(&self, left: usize, smooth: f64, begin: &mut Vec<f64>) -> (Vec<f64>, Vec<f64>) {
        let (cuts, count) = (self.constant.len(), self.added[0].len());
        let is_cut: Vec<f64> = (0..cuts).map(|c| if c < self.cuts { 1.0 } else { 0.0 }).collect();
        // Weights to begin from: above zero, and one in sum.
        begin.resize(cuts, 0.0);
        let mut weights: Vec<f64> = begin.iter().map(|weight| weight.max(1e-3 / cuts as f64)).collect();
        let sum: f64 = weights.iter().zip(&is_cut).map(|(w, is)| w * is).sum();
        weights.iter_mut().zip(&is_cut).filter(|(_, is)| **is > 0.0).for_each(|(w, _)| *w /= sum);
        let mut gains = self.gains(&weights);
        let mut level = {
            let mut sorted = gains.clone();
            sorted.sort_unstable_by(|a, b| b.total_cmp(a));
            sorted[left.min(count) - 1]
        };
        let mut temperature = HOTTEST.max(smooth);
        loop {
            for _ in 0..STEPS {
                let share: Vec<f64> =
                    gains.iter().map(|gain| sigmoid((gain - level) / temperature)).collect();
                let curve: Vec<f64> =
                    share.iter().map(|s| (s * (1.0 - s)).max(1e-12) / temperature).collect();
                let mut slope: Vec<f64> = (0..cuts)
                    .map(|c| self.constant[c] + dot(&self.added[c], &share) - temperature / weights[c])
                    .collect();
                slope.push(left as f64 - share.iter().sum::<f64>());
                let row = |c: usize| {
                    let mut row = vec![0.0; cuts + 1];
                    let own: Vec<f64> = self.added[c].iter().zip(&curve).map(|(a, b)| a * b).collect();
                    (0..=c).for_each(|d| row[d] = dot(&own, &self.added[d]));
                    row[c] += temperature / (weights[c] * weights[c]);
                    // What belongs in the last row.
                    row[cuts] = -own.iter().sum::<f64>();
                    row
                };
                let mut hessian: Vec<Vec<f64>> = (0..cuts).into_par_iter().map(row).collect();
                let mut last: Vec<f64> = hessian.iter().map(|row| row[cuts]).collect();
                last.push(curve.iter().sum::<f64>() + 1e-9);
                hessian.push(last);
                if !factor(&mut hessian) {
                    break;
                }
                let mut ones = is_cut.clone();
                ones.push(0.0);
                let mut newton_step = slope.clone();
                solve(&hessian, &mut newton_step);
                let mut side = ones.clone();
                solve(&hessian, &mut side);
                let shift = dot(&ones, &newton_step) / dot(&ones, &side);
                let step: Vec<f64> = newton_step
                    .iter()
                    .zip(&side)
                    .map(|(newton_step, side)| shift * side - newton_step)
                    .collect();
                let decrement = -dot(&slope, &step);
                if decrement < 1e-3 * temperature {
                    break;
                }
                let mut long = (0..cuts)
                    .filter(|&c| step[c] < 0.0)
                    .map(|c| -0.95 * weights[c] / step[c])
                    .fold(1.0, f64::min);
                let before = self.height(&weights, level, &gains, left, temperature);
                loop {
                    let tried: Vec<f64> = weights.iter().zip(&step).map(|(w, s)| w + long * s).collect();
                    let tried_gains = self.gains(&tried);
                    let tried_level = level + long * step[cuts];
                    if self.height(&tried, tried_level, &tried_gains, left, temperature)
                        <= before - 0.1 * long * decrement
                        || long < 1e-6
                    {
                        (weights, gains, level) = (tried, tried_gains, tried_level);
                        break;
                    }
                    long *= 0.5;
                }
            }
            if temperature <= smooth {
                let share: Vec<f64> =
                    gains.iter().map(|gain| sigmoid((gain - level) / temperature)).collect();
                let too_many = (share.iter().sum::<f64>() / left as f64).max(1.0);
                let share = share.into_iter().map(|share| share / too_many).collect();
                begin.clone_from(&weights);
                return (weights, share);
            }
            temperature = (temperature * COOLING).max(smooth);
        }
    }

    fn gains(&self, weights: &[f64]) -> Vec<f64> {
        let mut gains = vec![0.0; self.added[0].len()];
        for (added, &weight) in self.added.iter().zip(weights) {
            gains.iter_mut().zip(added).for_each(|(gain, added)| *gain += weight * added);
        }
        gains
    }

    /// The function that is minimised.
    fn height(&self, weights: &[f64], level: f64, gains: &[f64], left: usize, temperature: f64) -> f64 {
        let over = |gain: &f64| {
            let x = (gain - level) / temperature;
            temperature * (x.max(0.0) + (-x.abs()).exp().ln_1p())
        };
        dot(&self.constant, weights) + left as f64 * level + gains.iter().map(over).sum::<f64>()
            - temperature * weights.iter().map(|weight| weight.ln()).sum::<f64>()
    }
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// The sum of products, in eight lanes.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (parts, rest) = a.as_chunks::<8>();
    let (others, last) = b.as_chunks::<8>();
    for (a, b) in parts.iter().zip(others) {
        for lane in 0..8 {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    lanes.iter().sum::<f64>() + rest.iter().zip(last).map(|(a, b)| a * b).sum::<f64>()
}

/// The lower Cholesky factor in the place of a symmetric matrix; whether there is one.
fn factor(matrix: &mut [Vec<f64>]) -> bool {
    for i in 0..matrix.len() {
        for j in 0..=i {
            let sum = matrix[i][j] - dot(&matrix[i][..j], &matrix[j][..j]);
            if i == j {
                if sum <= 0.0 || !sum.is_finite() {
                    return false;
                }
                matrix[i][i] = sum.sqrt();
            } else {
                matrix[i][j] = sum / matrix[j][j];
            }
        }
    }
    true
}

/// Solves with a Cholesky factor.
fn solve(factor: &[Vec<f64>], side: &mut [f64]) {
    for i in 0..side.len() {
        side[i] = (side[i] - dot(&factor[i][..i], &side[..i])) / factor[i][i];
    }
    for i in (0..side.len()).rev() {
        side[i] /= factor[i][i];
        let own = side[i];
        side[..i].iter_mut().zip(&factor[i][..i]).for_each(|(side, factor)| *side -= own * factor);
    }
}
