//! The list price of a device: what a public shop asks for one. A sensor takes it only with `cost = "list"`, and whatever
//! shows its cost names the price and its source, so that it is not mistaken for a quote.

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::DeviceModel;
use crate::diagnostics::Place;
use crate::sensor::Cost;
use perirobot_march::Result;

/// What a sensor writes as its cost to take the list price of its model.
const LIST: &str = "list";

/// What a public shop asks for one device, to be checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListPrice {
    /// How much one costs.
    pub amount: f64,
    /// In which currency.
    pub currency: String,
    /// When the price was read: a year, month or day, as in 2026-11.
    pub date: String,
    /// Where it was read.
    pub source: String,
}

impl ListPrice {
    /// Checks the price of a device of a catalogue.
    pub(super) fn check(&self, at: &Place) -> Result<()> {
        Cost::check(at, "amount", self.amount)?;
        Cost::check_currency(at, Some(&self.currency))?;
        if !is_date(&self.date) {
            let rule = "must be a year, month or day, as in \"2026-11\"";
            return Err(at.wrong("date", format!("{:?}", self.date), rule));
        }
        match self.source.trim().is_empty() {
            true => Err(at.wrong("source", "\"\"", "must name the shop or the list")),
            false => Ok(()),
        }
    }

    /// With its date and source, as people read it.
    pub fn to_text(&self) -> String {
        let ListPrice { amount, currency, date, source } = self;
        format!("{amount} {currency} ({source}, {date})")
    }
}

/// Whether a text is a year, or one with month or day.
fn is_date(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let lengths: Vec<usize> = parts.iter().map(|part| part.len()).collect();
    [4, 2, 2].starts_with(&lengths)
        && !lengths.is_empty()
        && parts.iter().all(|part| part.chars().all(|c| c.is_ascii_digit()))
}

/// Replaces `cost = "list"` by the list price of a sensor's model.
///
/// # Errors
/// When the model has no price, or one in another currency than the study's.
pub(super) fn take_list_price(
    at: &Place,
    keys: &mut Table,
    model: Option<&DeviceModel>,
    currency: Option<&str>,
) -> Result<Option<ListPrice>> {
    let Some(Value::String(word)) = keys.get("cost") else { return Ok(None) };
    let wrong = |rule: &str| Err(at.wrong("cost", format!("{word:?}"), rule));
    if word != LIST {
        return wrong("must be an amount, as in cost = 450.0, or \"list\" for the list price of the model");
    }
    let Some(model) = model else {
        return wrong("is the list price of a model, and the sensor has none: write an amount");
    };
    let Some(price) = &model.price else {
        return wrong(&format!("{} has no list price in the catalogue: write an amount", model.name));
    };
    let said = format!("the list price of {} is in {}", model.name, price.currency);
    match currency {
        Some(currency) if currency == price.currency => {
            keys.insert("cost".into(), price.amount.into());
            Ok(Some(price.clone()))
        }
        Some(currency) => wrong(&format!("{said}, and the study's currency is {currency}: write an amount")),
        None => {
            let cure = format!("write currency = {:?} at the top of the study, or an amount", price.currency);
            wrong(&format!("{said}: {cure}"))
        }
    }
}

/// Which costs are list prices, in a sentence; nothing if none is. Each price has the name of its sensor.
pub fn describe_list_prices<'a>(
    prices: impl IntoIterator<Item = (&'a str, Option<&'a ListPrice>)>,
) -> Option<String> {
    let named = prices.into_iter().filter_map(|(sensor, price)| Some((sensor, price?)));
    let all: Vec<String> = named.map(|(sensor, price)| format!("{sensor} {}", price.to_text())).collect();
    (!all.is_empty()).then(|| format!("prices from the catalogue, to be checked: {}", all.join("; ")))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::input::catalogue::{models, resolve};

    fn price() -> ListPrice {
        let [currency, date, source] = ["USD", "2026-11", "a shop"].map(String::from);
        ListPrice { amount: 12.5, currency, date, source }
    }

    fn resolved(keys: &str, currency: Option<&str>) -> Result<(Table, Option<ListPrice>), String> {
        let mut keys: Table = toml::from_str(keys).unwrap();
        let place = Place::new(Path::new("study.toml"));
        let found = resolve(&place, &mut keys, &[], currency).map_err(|e| e.to_string())?;
        Ok((keys, found.list_price))
    }

    #[test]
    fn prices_that_ship_are_right_and_some_devices_have_none() {
        let place = Place::new(Path::new("catalogue.toml"));
        let priced: Vec<_> = models().iter().filter_map(|model| model.price.as_ref()).collect();
        assert!(priced.len() >= 10 && priced.len() < models().len());
        priced.iter().for_each(|price| price.check(&place).unwrap());
    }

    #[test]
    fn a_list_price_is_taken_only_if_the_study_asks_for_it_in_its_currency() {
        let list = "model = \"realsense-d435\"\ncost = \"list\"";
        let (keys, price) = resolved(list, Some("USD")).unwrap();
        assert_eq!((keys["cost"].as_float(), price.unwrap().amount), (Some(314.0), 314.0));
        let (keys, price) = resolved("model = \"realsense-d435\"", Some("USD")).unwrap();
        assert_eq!((keys.get("cost"), price), (None, None));
        let (keys, price) = resolved("model = \"realsense-d435\"\ncost = 300", Some("USD")).unwrap();
        assert_eq!((keys["cost"].as_integer(), price), (Some(300), None));
        for (keys, currency, expected) in [
            (list, Some("EUR"), "realsense-d435 is in USD, and the study's currency is EUR: write an amount"),
            (list, None, "is in USD: write currency = \"USD\" at the top of the study, or an amount"),
            (
                "model = \"sick-s300\"\ncost = \"list\"",
                Some("EUR"),
                "sick-s300 has no list price in the catalogue",
            ),
            (
                "kind = \"rgbd\"\ncost = \"list\"",
                None,
                "is the list price of a model, and the sensor has none",
            ),
            (
                "model = \"sick-s300\"\ncost = \"free\"",
                None,
                "cost = \"free\": must be an amount, as in cost = 450.0",
            ),
        ] {
            let error = resolved(keys, currency).unwrap_err();
            assert!(error.contains(expected), "no {expected:?} in {error}");
        }
    }

    #[test]
    fn prices_of_own_catalogues_are_checked() {
        let place = Place::new(Path::new("ours.toml"));
        price().check(&place).unwrap();
        for date in ["2026", "2026-11-30"] {
            ListPrice { date: date.into(), ..price() }.check(&place).unwrap();
        }
        for wrong in [
            ListPrice { amount: -1.0, ..price() },
            ListPrice { currency: "US dollars".into(), ..price() },
            ListPrice { date: "November".into(), ..price() },
            ListPrice { date: "26-11".into(), ..price() },
            ListPrice { date: String::new(), ..price() },
            ListPrice { source: " ".into(), ..price() },
        ] {
            assert!(wrong.check(&place).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn list_prices_are_named_with_their_source() {
        let price = price();
        assert_eq!(describe_list_prices([("lidar", None)]), None);
        assert_eq!(
            describe_list_prices([("camera", Some(&price)), ("lidar", None)]).unwrap(),
            "prices from the catalogue, to be checked: camera 12.5 USD (a shop, 2026-11)"
        );
    }
}
