//! The line under the title: what is recommended, in five facts.

use super::first_screen::FirstScreen;
use super::good::Good;
use crate::report::page::Findings;
use crate::report::purchased::describe_speed;
use crate::report::wording::count;

/// How many sensors, what they cost, whether they pass, how fast the robot may run, how much of the floor is blind; what is
/// unknown is left out.
pub(super) fn summary(findings: &Findings, first: &FirstScreen, good: &Good) -> String {
    let own = findings.recommended.map(|one| one.names(findings.sweep.results, findings.rankings));
    let judged = findings.judged.iter().find(|one| Some(&one.names) == own.as_ref());
    let speed = judged.and_then(|judged| judged.verdicts.allowed_speed).map(describe_speed);
    let facts = [
        Some(count(first.sensors.len(), "sensor")),
        first.cost.clone(),
        good.summary(),
        speed,
        Some(format!("{} of the floor is blind", first.blind_floor)),
    ];
    facts.into_iter().flatten().collect::<Vec<_>>().join(" · ")
}
