//! What sensors cost, in whole thousandths of any currency, so that sums are exact.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::diagnostics::Place;
use perirobot_march::Result;

/// On which terms a sensor can be had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CostTerms {
    /// What one of them costs, if the study says so.
    pub cost: Option<Cost>,
    /// How many a set may have, if the study says so.
    pub at_most: Option<u32>,
}

/// An amount of money.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cost {
    thousandths: u64,
}

/// No amount of a study is larger.
const MOST: f64 = 1e9;

/// Most characters of a currency.
const MOST_OF_CURRENCY: usize = 8;

/// No sum of a study's amounts is larger.
const MOST_OF_A_SET: f64 = 16.0 * MOST;

impl Cost {
    /// Nothing.
    pub const ZERO: Cost = Cost { thousandths: 0 };

    /// An amount from 0 to 1,000,000,000 with at most three digits after the point; `None` of any other.
    fn new(amount: f64) -> Option<Cost> {
        let thousandths = (amount * 1e3).round();
        let fits = (0.0..=MOST).contains(&amount) && (thousandths / 1e3 == amount);
        fits.then_some(Cost { thousandths: thousandths as u64 })
    }

    /// The amount of a key.
    pub(crate) fn check(at: &Place, key: &str, amount: f64) -> Result<Cost> {
        let rule = "must be a number from 0 to 1000000000 with at most three digits after the point";
        Cost::new(amount).ok_or_else(|| at.wrong(key, amount, rule))
    }

    /// The word for the unit of all amounts of a study, if it has one.
    pub(crate) fn check_currency(at: &Place, currency: Option<&str>) -> Result<()> {
        let Some(word) = currency else { return Ok(()) };
        let is_plain = !word.contains(|c: char| c.is_whitespace() || c.is_control());
        match is_plain && (1..=MOST_OF_CURRENCY).contains(&word.chars().count()) {
            true => Ok(()),
            false => {
                let rule = format!(
                    "must be a word of 1 to {MOST_OF_CURRENCY} characters without spaces, as in \"EUR\""
                );
                Err(at.wrong("currency", format!("{word:?}"), &rule))
            }
        }
    }

    /// From thousandths.
    pub fn from_thousandths(thousandths: u64) -> Cost {
        Cost { thousandths }
    }

    /// In thousandths.
    pub fn thousandths(self) -> u64 {
        self.thousandths
    }

    /// As a number, for drawings.
    pub fn amount(self) -> f64 {
        self.thousandths as f64 / 1e3
    }

    /// As people read it: with a currency "2,800 EUR", without one "2800".
    pub fn to_text(self, currency: Option<&str>) -> String {
        let plain = self.to_string();
        let Some(currency) = currency else { return plain };
        let whole = plain.find('.').unwrap_or(plain.len());
        let digit = |(place, digit): (usize, char)| {
            let begins_group = place > 0 && place < whole && (whole - place).is_multiple_of(3);
            begins_group.then_some(',').into_iter().chain([digit])
        };
        let grouped: String = plain.chars().enumerate().flat_map(digit).collect();
        format!("{grouped} {currency}")
    }

    /// The sum of both.
    pub fn plus(self, other: Cost) -> Cost {
        Cost { thousandths: self.thousandths + other.thousandths }
    }
}

/// A number, as in a study.
impl Serialize for Cost {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.amount().serialize(to)
    }
}

impl<'de> Deserialize<'de> for Cost {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Cost, D::Error> {
        let amount = f64::deserialize(from)?;
        let is_amount = (0.0..=MOST_OF_A_SET).contains(&amount);
        let wrong = || serde::de::Error::custom(format!("{amount} is no amount of money"));
        is_amount.then(|| Cost { thousandths: (amount * 1e3).round() as u64 }).ok_or_else(wrong)
    }
}

impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (whole, rest) = (self.thousandths / 1000, self.thousandths % 1000);
        match rest {
            0 => write!(f, "{whole}"),
            _ => write!(f, "{whole}.{}", format!("{rest:03}").trim_end_matches('0')),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_exact_and_read_as_they_were_written() {
        for (amount, text) in
            [(0.0, "0"), (450.0, "450"), (0.1, "0.1"), (12.345, "12.345"), (1e9, "1000000000")]
        {
            assert_eq!(Cost::new(amount).unwrap().to_string(), text);
        }
        for (amount, text) in [
            (0.0, "0 EUR"),
            (450.0, "450 EUR"),
            (2800.0, "2,800 EUR"),
            (12_345.125, "12,345.125 EUR"),
            (1e9, "1,000,000,000 EUR"),
        ] {
            assert_eq!(Cost::new(amount).unwrap().to_text(Some("EUR")), text);
        }
        assert_eq!(Cost::new(2800.0).unwrap().to_text(None), "2800");
        let tenth = Cost::new(0.1).unwrap();
        assert_eq!((0..10).fold(Cost::ZERO, |sum, _| sum.plus(tenth)), Cost::new(1.0).unwrap());
        for wrong in [-1.0, 0.0001, 1e9 + 1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Cost::new(wrong), None, "{wrong}");
        }
    }
}
