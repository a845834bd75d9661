//! The best sets of sensors, as text for a terminal.

use super::table::Table;
use crate::choose::{Bound, Told, ToldSet};
use crate::study::{Choose, Study};

/// The front, the best set sensor by sensor, and sets that are nearly as good.
pub fn render(study: &Study, choose: &Choose, told: &Told) -> String {
    let mut text = head(study, choose);
    let priced = told.steps.iter().any(|step| step.best.cost.is_some());
    let score = choose.objective.title();
    let cost: &[&str] = if priced { &["cost"] } else { &[] };
    let columns = [&["at most"], cost, &[score, "<no set is above", "gain", "<poses"]].concat();
    let mut table = Table::new(&columns);
    for step in &told.steps {
        let cost = step.best.cost.map(|cost| cost.to_string()).filter(|_| priced);
        let bound = match step.bound {
            Bound::Proven => "it (proven)".into(),
            Bound::AtMost(bound) => format!("{bound:.4}"),
            Bound::Unknown => "no bound".into(),
        };
        let gain = step.gain.map_or(String::new(), |gain| format!("{gain:+.4}"));
        let cells = [four(step.best.worth.value()), bound, gain, step.best.names.clone()];
        table.row([step.at_most.to_string()].into_iter().chain(cost).chain(cells));
    }
    text += &table.text();
    if let Some(best) = told.best() {
        text += &format!("\nbest set, {score} {}{}\n", four(best.best.worth.value()), cost_of(&best.best));
        text += &members(&best.best, score);
    }
    for tie in &told.ties {
        text += &format!("\nnearly as good elsewhere, {score} {}{}\n", four(tie.worth.value()), cost_of(tie));
        text += &members(tie, score);
    }
    text
}

fn head(study: &Study, choose: &Choose) -> String {
    let (score, over, region) =
        (choose.objective.title(), choose.over.name(), &study.regions[choose.region].0);
    let poses: usize = study.sensors.iter().map(|sensor| sensor.candidates.len()).sum();
    let budget = choose.budget.map_or(String::new(), |budget| format!(" for {budget} together"));
    let most = choose.at_most;
    format!("region {region}, {score} ({over}): at most {most} of {poses} poses{budget}\n")
}

fn cost_of(set: &ToldSet) -> String {
    set.cost.map_or(String::new(), |cost| format!(", cost {cost}"))
}

fn members(set: &ToldSet, score: &str) -> String {
    let without = format!("{score} without it");
    let mut table = Table::new(&["<sensor", "<pose", &without, "<place"]);
    for member in &set.members {
        let without = member.without.map_or(super::table::NONE.into(), four);
        table.row([member.sensor.clone(), member.pose.clone(), without, member.place.clone()]);
    }
    table.text()
}

fn four(value: f64) -> String {
    format!("{value:.4}")
}
