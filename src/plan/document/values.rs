//! Numbers of a study that have nothing to do with the plan: costs, the budget, boxes and balls.

use toml_edit::Item;

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

use super::apply::{Editor, names};
use super::edit::{BoxTable, ShapeEdit};
use super::group;
use super::number::number;
use super::path::Path;
use super::span::own_end;

impl Editor<'_> {
    pub(super) fn set_cost(&mut self, sensor: &str, cost: f64) -> Result<()> {
        check_amount("cost", cost)?;
        let at = group::sensor(self.source, sensor)?;
        self.source.set_number(&at, "cost", cost)
    }

    pub(super) fn mix_noise(&mut self) -> Result<()> {
        let (root, key) = (Path::default(), "mixed_noise");
        let has_keys = self.source.get(&root).and_then(Item::as_table).and_then(own_end).is_some();
        match has_keys {
            true => self.source.set(&root, key, "true"),
            // Behind the first header it would be a key of that table.
            false => self.source.splice(vec![(0..0, format!("{key} = true\n"))]),
        }
    }

    pub(super) fn set_budget(&mut self, budget: Option<f64>) -> Result<()> {
        let choose = Path::new("choose");
        let Some(budget) = budget else { return self.source.unset(&choose, "budget") };
        check_amount("budget", budget)?;
        let priced = names(self.source).iter().all(|name| {
            group::sensor(self.source, name).is_ok_and(|at| self.source.get(&at.key("cost")).is_some())
        });
        let has_requirements = self.source.count(&Path::new("require")) > 0;
        let is_written = match self.source.get(&choose) {
            Some(Item::Table(table)) => !table.is_implicit() || table.is_dotted(),
            Some(_) => true,
            None => false,
        };
        if is_written {
            return self.source.set_number(&choose, "budget", budget);
        }
        if !(priced && has_requirements) {
            let cure = "write [choose] into the file, with objective, region and at_most; or give each sensor a cost and the \
                        study [[require]]";
            return Err(Error::input("budget", "it is of what is looked for, which the study does not say")
                .with_advice(cure));
        }
        let end = self.source.text().trim_end().len();
        let block = format!("\n[choose]\nbudget = {}", number(budget));
        self.source.append_block(end, &block)
    }

    pub(super) fn set_box(&mut self, table: BoxTable, name: &str, shape: &ShapeEdit) -> Result<()> {
        let (list, what) = match table {
            BoxTable::Region => (Path::new("region"), "region"),
            BoxTable::Entry => (Path::new("approach").key("entry"), "entry"),
        };
        let place = || format!("{what} {name:?}");
        let Some(index) = self.source.position(&list, "name", name) else {
            return Err(
                Error::input(place(), "is not in the study").with_advice("name one that the file has")
            );
        };
        let at = list.entry(index);
        let (numbers, shapes): (&[f64], &[&str]) = match shape {
            ShapeEdit::Box { min_m, max_m } => (&[*min_m, *max_m].concat(), &["box"]),
            ShapeEdit::Sphere { center_m, radius_m } => {
                (&[&center_m[..], &[*radius_m]].concat(), &["sphere", "half_sphere"])
            }
        };
        if let Some(wrong) = numbers.iter().find(|value| value.is_nan() || value.abs() > 1e6) {
            return Err(Error::input(place(), format!("{wrong} is not a length in metres up to 1000000")));
        }
        let numbers: Vec<f64> =
            numbers.iter().map(|metres| (metres * 1000.0).round() / 1000.0 + 0.0).collect();
        let Some(shape) = shapes.iter().find(|shape| self.source.get(&at.key(shape)).is_some()) else {
            let advice = "change what it is in the file";
            return Err(Error::input(place(), format!("is not a {}", shapes[0])).with_advice(advice));
        };
        let at = at.key(shape);
        match numbers[..] {
            [x, y, z, ref high @ ..] if high.len() == 3 => {
                if [x, y, z].iter().zip(high).any(|(low, high)| low >= high) {
                    let rule = "must be above min_m on every axis";
                    return Err(
                        Error::from(Issue::value("max_m", format!("{high:?}"), rule)).with_place(place())
                    );
                }
                self.source.set_numbers(&at, "min_m", &[x, y, z])?;
                self.source.set_numbers(&at, "max_m", high)
            }
            [ref center @ .., radius] => {
                if radius <= 0.0 {
                    let rule = "must be above 0";
                    return Err(Error::from(Issue::value("radius_m", radius, rule)).with_place(place()));
                }
                self.source.set_numbers(&at, "center_m", center)?;
                self.source.set_number(&at, "radius_m", radius)
            }
            [] => Ok(()),
        }
    }
}

/// Fails unless an amount of money is one.
pub(super) fn check_amount(key: &str, amount: f64) -> Result<()> {
    match amount.is_finite() && amount >= 0.0 {
        true => Ok(()),
        false => Err(Issue::value(key, amount, "must be a number, 0 or more").into()),
    }
}
