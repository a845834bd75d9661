//! Cost by robot speed: a point per speed; shape and colour show whether a set passes.

use super::super::spot::Spot;
use super::{SetLink, verdict};
use crate::render::svg::tenth;
use crate::report::charts::axis::AxisScale;
use crate::report::charts::sheet::{Sheet, width_of};
use crate::report::purchased::describe_bound;
use perirobot_decide::cheapest::{AimReport, PurchasePoint, PurchaseReport, PurchasedSet};

/// Size of the picture, and the margins of its axes; on a phone its words are larger.
const SIZE: [f64; 2] = [520.0, 260.0];
const LEFT: f64 = 64.0;
const RIGHT: f64 = 24.0;
const ABOVE: f64 = 34.0;
const BELOW: f64 = 44.0;

/// Ratio of the size of letters on a phone.
const PHONE: f64 = 1.4;

/// Half the size of a point.
const HALF: f64 = 6.0;

/// Cost by speed; `None` if no speed was requested or none has a set.
pub(super) fn speed_chart(
    report: &PurchaseReport,
    link_of: &dyn Fn(&PurchasedSet) -> Option<SetLink>,
) -> Option<String> {
    let at_speed = |point: &'_ PurchasePoint| match point.aim {
        AimReport::Speed(speed) => Some(speed),
        _ => None,
    };
    let points: Vec<(f64, &PurchasePoint)> =
        report.points.iter().filter_map(|point| Some((at_speed(point)?, point))).collect();
    let costs = points.iter().filter_map(|(_, point)| Some(point.set.as_ref()?.cost.amount()));
    let highest = costs.reduce(f64::max)?;
    let fastest = points.iter().map(|(speed, _)| *speed).fold(0.0, f64::max);
    let [left, top, right, bottom] = [LEFT, ABOVE, SIZE[0] - RIGHT, SIZE[1] - BELOW];
    let room = |value: f64| if value > 0.0 { 1.1 * value } else { 1.0 };
    let across = AxisScale::new([0.0, room(fastest)], [left, right]);
    let up = AxisScale::new([0.0, room(highest)], [bottom, top]);
    let mut sheet = Sheet::new("cost by speed of the robot");
    sheet.words("", [6.0, 16.0], "cost");
    up.draw_beside(&mut sheet, [left, right]);
    sheet.y = bottom;
    across.draw_below(&mut sheet, top, "speed of the robot, m/s");
    sheet.y = SIZE[1];
    let mut labelled_until = 0.0;
    for (speed, point) in points {
        let x = across.position(speed);
        let y = point.set.as_ref().map_or(top + 2.0 * HALF, |set| up.position(set.cost.amount()));
        let is_open = point.set.is_some() && !point.proven;
        if let Some(bound) = point.no_set_below.filter(|_| is_open) {
            sheet.path("bound", &format!("M{x} {y}V{}", up.position(bound.amount())));
        }
        let class = if is_open { "OPEN" } else { verdict(point) };
        let outline = match &point.set {
            Some(_) => disc([x, y]),
            None => cross([x, y]),
        };
        let link = point.set.as_ref().and_then(link_of);
        sheet.add(&link.as_ref().map_or(String::new(), |link| link.spot.opening()));
        sheet.mark(class, &outline, &describe(report, speed, point));
        sheet.add(link.map_or("", |_| Spot::CLOSING));
        let label = point.set.as_ref().map_or("no set".into(), |set| report.amount(set.cost));
        let half = PHONE * width_of(&label) / 2.0;
        // Of adjacent points only the first has its number; all have a tooltip.
        if x - half >= labelled_until {
            sheet.words("mid over", [x, y - 1.7 * HALF], &label);
            labelled_until = x + half;
        }
    }
    Some(sheet.finish("chart broad", SIZE[0]))
}

/// The tooltip of a speed.
fn describe(report: &PurchaseReport, speed: f64, point: &PurchasePoint) -> String {
    match (&point.set, point.reasons.first()) {
        (Some(set), _) => format!(
            "{speed} m/s: {} for {}, {}",
            set.poses(),
            report.amount(set.cost),
            describe_bound(report, point)
        ),
        (None, Some(reason)) => format!("{speed} m/s: {}: {}", reason.requirement, reason.why),
        (None, None) => format!("{speed} m/s: {}", describe_bound(report, point)),
    }
}

fn disc([x, y]: [f64; 2]) -> String {
    let (left, diameter) = (tenth(x - HALF), 2.0 * HALF);
    format!("M{left} {}a{HALF} {HALF} 0 1 0 {diameter} 0a{HALF} {HALF} 0 1 0 -{diameter} 0Z", tenth(y))
}

fn cross([x, y]: [f64; 2]) -> String {
    let (low, high) = ([x - HALF, y - HALF].map(tenth), [x + HALF, y + HALF].map(tenth));
    format!("M{} {}L{} {}M{} {}L{} {}", low[0], low[1], high[0], high[1], low[0], high[1], high[0], low[1])
}
