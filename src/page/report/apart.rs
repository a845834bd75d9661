//! A value next to a limit, with enough digits to distinguish them.

use std::cmp::Ordering;

use super::table::number as three_digits;
use perirobot_decide::judge::Summed;
use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_study::input::ControllerScore;

/// The format of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Writing {
    /// As in tables, with at least three decimals.
    Plain,
    /// A distance with a lower limit, never rounded up; at least three decimals.
    Down,
    /// A distance with an upper limit, never rounded down; at least three decimals.
    Up,
    /// A share, as percent.
    Percent,
}

impl Writing {
    /// The format of a score's values in text: distances are rounded to the safe side.
    pub(super) fn new(score: Summed) -> Writing {
        match score {
            Summed::Nearness(score) if !score.is_area() => Writing::Down,
            Summed::Controller(ControllerScore::MissedM) => Writing::Up,
            Summed::Counted(..) | Summed::Nearness(_) | Summed::Controller(_) => Writing::Plain,
        }
    }

    /// A value with three decimals, as in tables.
    pub(super) fn to_table_text(self, value: f64) -> String {
        self.show(value, 3)
    }

    /// A value, with its exact comparison to a limit.
    pub(super) fn apart(self, value: f64, order: Ordering, limit: f64) -> String {
        let is_told =
            |text: &String| self.read(text).partial_cmp(&limit) == Some(order) && self.is_fair(text, value);
        (self.least()..=17).map(|digits| self.show(value, digits)).find(is_told).unwrap_or_else(|| {
            let limit = self.exactly(limit);
            match order {
                Ordering::Less => format!("just below {limit}"),
                Ordering::Equal => limit,
                Ordering::Greater => format!("just above {limit}"),
            }
        })
    }

    /// A number of the study, with all its digits.
    pub(super) fn exactly(self, number: f64) -> String {
        match self {
            Writing::Percent => {
                let digits = format!("{:.9}", number * 100.0);
                format!("{}\u{a0}%", digits.trim_end_matches('0').trim_end_matches('.'))
            }
            _ => number.to_string(),
        }
    }

    fn least(self) -> usize {
        if self == Writing::Percent { 0 } else { 3 }
    }

    fn show(self, value: f64, digits: usize) -> String {
        match self {
            Writing::Percent => format!("{:.digits$}\u{a0}%", value * 100.0),
            Writing::Down if digits < 10 => rounded_down(value, digits as u32),
            Writing::Up if digits < 10 => rounded_up(value, digits as u32),
            Writing::Plain if digits == 3 => three_digits(Some(value)),
            _ => format!("{value:.digits$}"),
        }
    }

    /// The number of a text.
    fn read(self, text: &str) -> f64 {
        let number = text.trim_end_matches("\u{a0}%").parse().unwrap_or(f64::NAN);
        if self == Writing::Percent { number / 100.0 } else { number }
    }

    /// A share is not rounded to 0 % or 100 %.
    fn is_fair(self, text: &str, value: f64) -> bool {
        let read = self.read(text);
        self != Writing::Percent || value == read || (read != 0.0 && read != 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(writing: Writing, value: f64, limit: f64, wanted: &str) {
        let order = value.partial_cmp(&limit).unwrap();
        assert_eq!(
            writing.apart(value, order, limit),
            wanted.replace(' ', "\u{a0}"),
            "{value} beside {limit}"
        );
    }

    #[test]
    fn distances_are_rounded_to_the_safe_side() {
        check(Writing::Down, 1.8439, 1.0, "1.843");
        check(Writing::Plain, 1.8439, 1.0, "1.844");
        check(Writing::Up, 0.1004, 0.2, "0.101");
        check(Writing::Up, 0.1, 0.1, "0.100");
        check(Writing::Up, 0.0996, 0.1, "0.0996");
        assert_eq!(Writing::Down.to_table_text(-0.2001), "-0.201");
        assert_eq!(Writing::Up.to_table_text(0.1001), "0.101");
    }

    #[test]
    fn shares_are_percent() {
        check(Writing::Percent, 0.7, 0.7, "70 %");
        check(Writing::Percent, 0.696, 0.7, "69.6 %");
        check(Writing::Percent, 0.58, 0.58, "58 %");
        check(Writing::Percent, 0.2921, 0.3, "29 %");
        check(Writing::Percent, 0.004, 0.3, "0.4 %");
        check(Writing::Percent, 0.9996, 0.3, "99.96 %");
        check(Writing::Percent, 0.0, 0.3, "0 %");
        assert_eq!(Writing::Percent.apart(0.7, Ordering::Less, 0.7), "just below 70\u{a0}%");
        assert_eq!(
            [0.58, 0.7, 0.055, 1.0].map(|share| Writing::Percent.exactly(share)),
            ["58", "70", "5.5", "100"].map(|share| format!("{share}\u{a0}%"))
        );
    }
}
