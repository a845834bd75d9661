//! The cheapest set that passes, as text: one sentence first, then where its sensors are, what proves it, and what else
//! was asked.

use crate::report::table::Table;
use perirobot_decide::cheapest::{AimReport, PurchasePoint, PurchaseReport, PurchasedSet};
use perirobot_decide::judge::{JudgedSet, Speeds};
use perirobot_study::input::Stopping;

/// The answer; `judged` is the recommended set, if there is one, with how fast the robot may run with it.
pub fn render(
    report: &PurchaseReport,
    judged: Option<(&JudgedSet, Option<&Speeds>, Option<&Stopping>)>,
) -> String {
    let mut text = format!("{}\n", sentence(report, judged));
    let main = report.main();
    for reason in &main.reasons {
        text += &format!("  {}: {}\n", reason.requirement, reason.why);
    }
    if let Some(set) = report.recommended() {
        text += &format!("\n{}", sensors(set).text());
    }
    text += &format!("\n{}\n", proof(report, main));
    text += &disturb(report);
    if let Some(front) = front(report) {
        text += &format!("\n{}", front.text());
    }
    text
}

/// The answer in one sentence.
pub fn sentence(
    report: &PurchaseReport,
    judged: Option<(&JudgedSet, Option<&Speeds>, Option<&Stopping>)>,
) -> String {
    let Some(set) = report.recommended() else {
        return match report.main().proven {
            true => "no allowed set of the listed places passes, nor does any come near".into(),
            false => "no set that passes was found so far".into(),
        };
    };
    let count = set.sensors.len();
    let size = format!("{count} {} for {}", if count == 1 { "sensor" } else { "sensors" }, set.cost);
    let verdicts = judged.map_or(String::new(), |(judged, ..)| {
        let passed = judged.judgements.iter().filter(|judgement| judgement.is_met).count();
        format!(" pass {passed} of {} verdicts", judged.judgements.len())
    });
    let speed = judged.map_or(String::new(), |(_, speeds, stopping)| at_speed(speeds, stopping));
    let nearest = match report.main().set {
        Some(_) => "",
        None if report.main().proven => "no allowed set passes all; ",
        None => "no set that passes all was found so far; ",
    };
    let next = impossible_speed(report).map_or(String::new(), |(speed, why)| {
        format!("; {speed} m/s is impossible with these places: {why}")
    });
    format!("{nearest}{size}{verdicts}{speed}{next}")
}

fn at_speed(speeds: Option<&Speeds>, stopping: Option<&Stopping>) -> String {
    let (Some(speeds), Some(stopping)) = (speeds, stopping) else { return String::new() };
    match speeds.fastest {
        Some(fastest) => format!("; the robot may run at {} m/s", stopping.speeds[fastest].speed_m_s),
        None => "; the robot may run at none of the listed speeds".into(),
    }
}

/// The lowest speed at which no set passes, with the first reason.
fn impossible_speed(report: &PurchaseReport) -> Option<(f64, &str)> {
    report.points.iter().find_map(|point| match (&point.aim, point.reasons.first()) {
        (AimReport::Speed(speed), Some(reason)) => Some((*speed, reason.why.as_str())),
        _ => None,
    })
}

/// What is proven of the answer.
fn proof(report: &PurchaseReport, main: &PurchasePoint) -> String {
    let PurchasePoint { tested, proven, .. } = main;
    let ways = report.ways_in.len();
    let by = format!("{tested} sets tested, {ways} ways in");
    match (&main.set, main.no_set_below, proven) {
        (Some(_), _, true) => {
            format!("proven: no cheaper set of the {} listed places passes ({by})", report.candidates)
        }
        (Some(set), Some(bound), false) => {
            format!(
                "stopped: a cheaper set may pass, but none below {bound}; this one costs {} ({by})",
                set.cost
            )
        }
        (None, _, true) => {
            format!("proven: no allowed set of the {} listed places passes ({by})", report.candidates)
        }
        (_, Some(bound), _) => format!("stopped: no set below {bound} passes ({by})"),
        (_, None, _) => format!("stopped ({by})"),
    }
}

/// Whether a better set would pass if sensors might disturb each other, and which of its sensors do.
fn disturb(report: &PurchaseReport) -> String {
    let Some(if_disturbed) = report.points.iter().find(|point| point.aim == AimReport::Disturbed) else {
        return String::new();
    };
    match (report.bound_by_disturb(), &if_disturbed.set) {
        (Some(point), Some(set)) => {
            let pairs: Vec<String> = point.disturbed.iter().map(|[a, b]| format!("{a} and {b}")).collect();
            format!(
                "disturb binds: if sensors might disturb each other, {} for {} would pass; in it {} do\n",
                set.poses(),
                set.cost,
                pairs.join(", ")
            )
        }
        _ if if_disturbed.proven && if_disturbed.best_of_cost => {
            "disturb does not bind: no set that it forbids is better\n".into()
        }
        _ => "whether disturb binds is open: the search was stopped\n".into(),
    }
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
            AimReport::All | AimReport::Disturbed | AimReport::Nearest(_) => continue,
        };
        let (cost, count, set) = match &point.set {
            Some(set) => (set.cost.to_string(), set.sensors.len().to_string(), set.poses()),
            None => {
                let why: Vec<&str> = point.reasons.iter().map(|reason| reason.why.as_str()).collect();
                (String::new(), String::new(), why.join("; "))
            }
        };
        let proven = match (&point.set, point.proven) {
            (Some(_), true) => "proven".to_string(),
            (Some(_), false) => {
                point.no_set_below.map_or(String::new(), |bound| format!("none below {bound}"))
            }
            (None, true) => "no set".into(),
            (None, false) => "none found".into(),
        };
        table.row([aim, cost, count, proven, set]);
    }
    Some(table)
}
