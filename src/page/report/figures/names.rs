//! The names of scores in figures, and the places of adjacent plots.

use perirobot_march::metrics::Score;

/// The title of a score's axis, without a unit.
pub(super) fn axis_name(score: Score) -> String {
    let better = if score.less_is_better() { "less is better" } else { "more is better" };
    match score {
        Score::F1 => format!("F1 (0 to 1, {better})"),
        Score::Kappa => format!("Cohen's κ (at most 1, {better})"),
        _ => format!("{} (share, 0 to 1, {better})", score.name()),
    }
}

/// The name of a score in a sentence.
pub(super) fn score_name(score: Score) -> &'static str {
    match score {
        Score::Kappa => "κ",
        _ => score.title(),
    }
}

/// The places of adjacent plots between two edges.
pub(super) fn columns(count: usize, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let gap = 34.0;
    let each = (to - from - gap * (count - 1) as f64) / count as f64;
    (0..count).map(|n| from + n as f64 * (each + gap)).map(|left| [left, left + each]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_fill_the_width() {
        assert_eq!(columns(2, [0.0, 234.0]), [[0.0, 100.0], [134.0, 234.0]]);
    }
}
