//! The cheapest set that passes, as text: one sentence first, then where its sensors are, what proves it, and what else
//! was asked.

use crate::report::purchased::{describe_bound, describe_proof, sentence};
use crate::report::table::Table;
use perirobot_decide::cheapest::{AimReport, PurchasePoint, PurchaseReport, PurchasedSet};
use perirobot_decide::judge::SetVerdicts;

/// The answer; `judged` has the verdicts on the recommended set, if there is one.
pub fn render(report: &PurchaseReport, judged: Option<&SetVerdicts>) -> String {
    let mut text = format!("{}\n", sentence(report, judged));
    for reason in &report.main().reasons {
        text += &format!("  {}: {}\n", reason.requirement, reason.why);
    }
    if let Some(set) = report.recommended() {
        text += &format!("\n{}", sensors(set).text());
    }
    text += &format!("\n{}\n", describe_proof(report));
    if let Some(front) = front(report) {
        text += &format!("\n{}", front.text());
    }
    text
}

/// The sensors of a set.
fn sensors(set: &PurchasedSet) -> Table {
    let mut table = Table::new(&["<sensor", "<pose", "cost", "<place"]);
    for one in &set.sensors {
        table.row([one.sensor.clone(), one.pose.clone(), one.cost.to_string(), one.place.clone()]);
    }
    table
}

/// What else was asked: the cheapest set at each speed, or without each requirement.
fn front(report: &PurchaseReport) -> Option<Table> {
    let (is_speed, is_without) = (
        |point: &&PurchasePoint| matches!(point.aim, AimReport::Speed(_)),
        |point: &&PurchasePoint| matches!(point.aim, AimReport::Without(_)),
    );
    let points: Vec<&PurchasePoint> =
        report.points.iter().filter(|point| is_speed(point) || is_without(point)).collect();
    let first = points.first()?;
    let heading = if is_speed(first) { ">m/s" } else { "<without" };
    let mut table = Table::new(&[heading, "cost", "sensors", "<", "<set"]);
    for point in points {
        let aim = match &point.aim {
            AimReport::Speed(speed) => speed.to_string(),
            AimReport::Without(name) => name.clone(),
            AimReport::All | AimReport::Nearest(_) => continue,
        };
        let (cost, count, set) = match &point.set {
            Some(set) => (set.cost.to_string(), set.sensors.len().to_string(), set.poses()),
            None => {
                let why: Vec<&str> = point.reasons.iter().map(|reason| reason.why.as_str()).collect();
                (String::new(), String::new(), why.join("; "))
            }
        };
        table.row([aim, cost, count, describe_bound(point), set]);
    }
    Some(table)
}
