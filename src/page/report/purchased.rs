//! The cheapest set that passes, in words: the answer in one sentence, its proof, and the set of each question.

use super::wording::count;
use perirobot_decide::cheapest::{AimReport, MOST_TIES, PurchasePoint, PurchaseReport, PurchasedSet};
use perirobot_decide::judge::{AllowedSpeed, SetVerdicts};
use perirobot_study::sensor::Cost;

/// The answer in one sentence; `judged` has the verdicts on the recommended set, if it was judged.
pub fn sentence(report: &PurchaseReport, judged: Option<&SetVerdicts>) -> String {
    let Some(set) = report.recommended() else {
        return match report.main().proven {
            true if report.stopped => {
                "no allowed set of the listed poses passes; the search for the nearest was stopped".into()
            }
            true => "no allowed set of the listed poses passes, nor does any come near".into(),
            false => "no set that passes was found so far".into(),
        };
    };
    let size = format!("{} for {}", count(set.sensors.len(), "sensor"), report.amount(set.cost));
    let verdicts = judged.map_or(String::new(), |judged| {
        let [met, all] = count_met(judged);
        format!(
            " {} {met} of {}",
            if set.sensors.len() == 1 { "meets" } else { "meet" },
            count(all, "requirement")
        )
    });
    let speed = judged.and_then(|judged| judged.allowed_speed).map_or(String::new(), |speed| {
        let next = dearer_speed(report, speed.m_s)
            .map_or(String::new(), |(next, cost)| format!(", and at {next} m/s for {}", report.amount(cost)));
        format!("; {}{next}", describe_speed(speed))
    });
    let nearest = match report.main().set {
        Some(_) => "",
        None if report.main().proven => "no allowed set passes all; ",
        None => "no set that passes all was found so far; ",
    };
    // If no set passes at any speed, the speed is irrelevant.
    let next = impossible_speed(report).filter(|_| report.main().set.is_some());
    let limits =
        report.asked.budget.map_or(String::new(), |budget| format!(" for {}", report.amount(budget)));
    let next = next.map_or(String::new(), |(speed, why)| {
        format!("; {speed} m/s is impossible with these places{limits}: {why}")
    });
    format!("{nearest}{size}{verdicts}{speed}{next}")
}

/// The number of requirements on a set that are met under all of their conditions, and of all.
fn count_met(judged: &SetVerdicts) -> [usize; 2] {
    let of_names = judged.requirements.chunk_by(|one, next| one.requirement == next.requirement);
    let met = of_names.clone().filter(|own| own.iter().all(|verdict| verdict.is_met)).count();
    [met, of_names.count()]
}

/// The cost of the cheapest set for the next speed above the allowed one, and the highest speed for that cost.
fn dearer_speed(report: &PurchaseReport, allowed_m_s: Option<f64>) -> Option<(f64, Cost)> {
    let faster = report.points.iter().filter_map(|point| match (&point.aim, &point.set) {
        (AimReport::Speed(speed), Some(set)) if allowed_m_s.is_none_or(|allowed| *speed > allowed) => {
            Some((*speed, set.cost))
        }
        _ => None,
    });
    let (_, cost) = faster.clone().next()?;
    faster.take_while(|(_, other)| *other == cost).last()
}

/// The allowed robot speed, in words.
pub(super) fn describe_speed(speed: AllowedSpeed) -> String {
    match speed.m_s {
        Some(fastest) => format!("the robot may run at {fastest} m/s"),
        None => "the robot may run at none of the listed speeds".into(),
    }
}

/// The lowest speed at which no set passes, with the first reason.
fn impossible_speed(report: &PurchaseReport) -> Option<(f64, &str)> {
    report.points.iter().find_map(|point| match (&point.aim, point.reasons.first()) {
        (AimReport::Speed(speed), Some(reason)) => Some((*speed, reason.why.as_str())),
        _ => None,
    })
}

/// The proof of the answer, and its gaps.
pub fn describe_proof(report: &PurchaseReport) -> String {
    let PurchasePoint { set, no_set_below, proven, tested, .. } = report.main();
    let evidence = match tested {
        0 => "nothing had to be tested: the requirements rule out every set".into(),
        _ if report.ways_in.is_empty() => format!("{} tested", count(*tested as usize, "set")),
        _ => {
            format!("{} tested, {} in", count(*tested as usize, "set"), count(report.ways_in.len(), "way"))
        }
    };
    match (set, no_set_below, proven) {
        (Some(_), _, true) => format!(
            "proven: no cheaper set of the {} listed poses passes ({evidence}){}",
            report.candidates,
            describe_ties(report)
        ),
        (Some(set), Some(bound), false) => {
            format!(
                "stopped: a cheaper set may pass, but none below {}; this one costs {} ({evidence})",
                report.amount(*bound),
                report.amount(set.cost)
            )
        }
        (None, _, true) => {
            format!("proven: no allowed set of the {} listed poses passes ({evidence})", report.candidates)
        }
        (_, Some(bound), _) => format!("stopped: no set below {} passes ({evidence})", report.amount(*bound)),
        (_, None, _) => format!("stopped ({evidence})"),
    }
}

/// The number of other sets of the same cost, or how certain it is that none is better.
fn describe_ties(report: &PurchaseReport) -> String {
    let PurchasePoint { ties, compared, best_of_cost, .. } = report.main();
    match (ties, &report.asked.then) {
        (Some(0), _) => "; no other set of this cost passes".into(),
        (Some(ties), _) => {
            let (more, cost) = match *ties {
                1 => ("", "set costs the same and passes"),
                MOST_TIES => (" or more", "sets cost the same and pass"),
                _ => ("", "sets cost the same and pass"),
            };
            format!("; {ties}{more} other {cost}")
        }
        (None, Some(then)) if *best_of_cost => format!("; no set of this cost has a better {}", then.score),
        (None, Some(then)) => {
            let compared =
                compared.map_or(String::new(), |compared| format!(" of the {compared} that were compared"));
            format!("; others of this cost may have a better {}: this is the best{compared}", then.score)
        }
        (None, None) => String::new(),
    }
}

/// Whether a better set would pass without the exclusion of disturbing pairs, and its disturbing sensors.
pub(super) fn describe_disturb(report: &PurchaseReport) -> String {
    let Some(if_disturbed) = report.points.iter().find(|point| point.aim == AimReport::Disturbed) else {
        return String::new();
    };
    match (report.bound_by_disturb(), &if_disturbed.set) {
        (Some(point), Some(set)) => {
            let pairs: Vec<String> = point.disturbed.iter().map(|[a, b]| format!("{a} and {b}")).collect();
            format!(
                "disturb binds: if sensors might disturb each other, {} for {} would pass; in it {} do\n",
                set.poses(),
                report.amount(set.cost),
                pairs.join(", ")
            )
        }
        _ if if_disturbed.proven && if_disturbed.best_of_cost => {
            "disturb does not bind: no set that it forbids is better\n".into()
        }
        _ => "whether disturb binds is open: the search was stopped\n".into(),
    }
}

/// The bound of the cheapest set for one aim, in a few words.
pub(super) fn describe_bound(report: &PurchaseReport, point: &PurchasePoint) -> String {
    match (&point.set, point.proven) {
        (Some(_), true) => "proven".into(),
        (Some(_), false) => {
            point.no_set_below.map_or(String::new(), |bound| format!("none below {}", report.amount(bound)))
        }
        (None, true) => "no set".into(),
        (None, false) => "none found".into(),
    }
}

/// The cost of a set, and its difference to the cheapest for all requirements, for a smaller question.
pub(super) fn describe_cost(report: &PurchaseReport, aim: &AimReport, set: &PurchasedSet) -> String {
    let (cost, whole) = (set.cost, report.main().set.as_ref().map(|set| set.cost));
    let less = whole.map(|whole| whole.thousandths().saturating_sub(cost.thousandths()));
    match (aim, less) {
        (AimReport::Without(_) | AimReport::Number(_), Some(0)) => {
            format!("{} (saves nothing)", report.amount(cost))
        }
        (AimReport::Without(_) | AimReport::Number(_), Some(less)) => {
            format!("{} ({} less)", report.amount(cost), report.amount(Cost::from_thousandths(less)))
        }
        _ => report.amount(cost),
    }
}

/// The heading of a recommended set: one that misses a requirement is not called recommended.
pub(super) fn describe_heading(report: &PurchaseReport) -> &'static str {
    match report.main().set {
        Some(_) => "Recommended",
        None => "Nearest set (does not pass)",
    }
}

/// The terms of a set, in words.
pub fn describe_aim(aim: &AimReport) -> String {
    match aim {
        AimReport::All => "all requirements".into(),
        AimReport::Speed(speed) => format!("{speed} m/s"),
        AimReport::Without(name) => format!("all but “{name}”"),
        AimReport::Disturbed => "all requirements, if sensors may disturb each other".into(),
        AimReport::Number(least) => format!("at least {least} requirements"),
        AimReport::Nearest(names) => format!("all but “{}”", names.join("”, “")),
    }
}
