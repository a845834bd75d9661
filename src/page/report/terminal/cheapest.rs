//! The cheapest set that passes, as text: one sentence first, then the places of its sensors, the proof, and the
//! further questions.

use crate::report::purchased::{
    describe_bound, describe_cost, describe_disturb, describe_heading, describe_proof, sentence,
};
use crate::report::table::Table;
use crate::report::wording::words;
use perirobot_decide::cheapest::{AimReport, PurchasePoint, PurchaseReport, PurchasedSet};
use perirobot_decide::choose::describe_asked_prices;
use perirobot_decide::judge::{RequirementVerdict, SetVerdicts};
use perirobot_march::voxel::gap_error_m;
use std::cmp::Ordering;

/// The answer; `judged` has the verdicts on the recommended set, if any.
pub fn render(report: &PurchaseReport, judged: Option<&SetVerdicts>) -> String {
    let mut text = format!("{}\n", sentence(report, judged));
    for reason in &report.main().reasons {
        text += &format!("  {}: {}\n", reason.requirement, reason.why);
        let required = report.asked.require.iter().find(|asked| asked.name == reason.requirement);
        if let Some(words) = required.and_then(|required| required.safety_function.as_ref()) {
            text += &format!("      for {words}\n");
        }
    }
    if let Some(set) = report.recommended() {
        let heading = match report.main().set {
            Some(_) => String::new(),
            None => format!("{}\n", describe_heading(report)),
        };
        text += &format!("\n{heading}{}", sensors(report, set).text());
    }
    text += &format!("\n{}\n", describe_proof(report));
    text += &judged.and_then(|judged| smallest_margin(report, judged)).unwrap_or_default();
    let caveats = judged.map_or(&[][..], |judged| &judged.caveats);
    caveats.iter().for_each(|caveat| text += &format!("but: {caveat}\n"));
    text += &describe_disturb(report);
    if let Some(prices) = describe_asked_prices(&report.asked.sensors) {
        text += &format!("{prices}\n");
    }
    for table in [front(report), numbers(report)].into_iter().flatten() {
        text += &format!("\n{}", table.text());
    }
    text
}

/// The requirement that the set meets with the smallest margin, as a share of its limit (of 1 if that is 0), and the
/// largest error of a distance in voxels.
fn smallest_margin(report: &PurchaseReport, judged: &SetVerdicts) -> Option<String> {
    let margin = |verdict: &&RequirementVerdict| {
        let (limit, value) = (verdict.at_least.or(verdict.at_most)?, verdict.value?.0);
        let scale = if limit == 0.0 { 1.0 } else { limit.abs() };
        (verdict.is_met && value.is_finite()).then(|| (value - limit).abs() / scale)
    };
    let met = judged.requirements.iter().filter(|verdict| margin(verdict).is_some());
    let verdict = met.min_by(|a, b| margin(a).partial_cmp(&margin(b)).unwrap_or(Ordering::Equal))?;
    let (word, limit) = match (verdict.at_least, verdict.at_most) {
        (Some(limit), _) => ("at least", limit),
        (None, limit) => ("at most", limit?),
    };
    let unit = match &verdict.score {
        score if score.ends_with("_m2") => " m²",
        score if score.ends_with("_m") => " m",
        _ => "",
    };
    let mut text = format!(
        "smallest margin: {:?} ({}): {:.3}{unit}, {word} {limit}{unit} is required",
        verdict.requirement,
        words(verdict.condition),
        verdict.value?.0
    );
    let size_m = report.voxel_size_m;
    if unit == " m" {
        text += &format!("; with voxels of {size_m} m the gap may be {:.2} m less", gap_error_m(size_m));
    }
    Some(text + "\n")
}

/// The sensors of a set.
fn sensors(report: &PurchaseReport, set: &PurchasedSet) -> Table {
    let mut table = Table::new(&["<sensor", "<pose", "cost", "<place"]);
    for one in &set.sensors {
        let cost = report.amount(one.cost);
        table.row([one.sensor.clone(), one.pose.clone(), cost, one.place.clone()]);
    }
    table
}

/// The further questions: the cheapest set at each speed, or without each requirement.
fn front(report: &PurchaseReport) -> Option<Table> {
    let aim = |point: &PurchasePoint| match &point.aim {
        AimReport::Speed(speed) => Some((">m/s", speed.to_string())),
        AimReport::Without(name) => Some(("<without", name.clone())),
        AimReport::All | AimReport::Disturbed | AimReport::Number(_) | AimReport::Nearest(_) => None,
    };
    let (heading, _) = report.points.iter().find_map(aim)?;
    let mut table = Table::new(&[heading, "cost", "sensors", "<proof", "<set"]);
    for (point, (_, aim)) in report.points.iter().filter_map(|point| Some((point, aim(point)?))) {
        let [cost, count, proof, set] = row_cells(report, point);
        table.row([aim, cost, count, proof, set]);
    }
    Some(table)
}

/// The cheapest set that meets each number of requirements, and those that it misses.
fn numbers(report: &PurchaseReport) -> Option<Table> {
    let number = |point: &PurchasePoint| match point.aim {
        AimReport::Number(least) => Some(least),
        _ => None,
    };
    report.points.iter().find_map(number)?;
    let mut table = Table::new(&["at least", "cost", "sensors", "<proof", "<missed", "<set"]);
    for (point, least) in report.points.iter().filter_map(|point| Some((point, number(point)?))) {
        let [cost, count, proof, set] = row_cells(report, point);
        let least = format!("{least} of {}", report.asked.require.len());
        table.row([least, cost, count, proof, point.missed.join("; "), set]);
    }
    Some(table)
}

/// Cost and size of the set of a point, its proof, and the set; if there is none, the reason.
fn row_cells(report: &PurchaseReport, point: &PurchasePoint) -> [String; 4] {
    let (cost, count, set) = match &point.set {
        Some(set) => (describe_cost(report, &point.aim, set), set.sensors.len().to_string(), set.poses()),
        None => {
            let why: Vec<&str> = point.reasons.iter().map(|reason| reason.why.as_str()).collect();
            (String::new(), String::new(), why.join("; "))
        }
    };
    [cost, count, describe_bound(report, point), set]
}
