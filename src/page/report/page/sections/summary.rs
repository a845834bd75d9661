//! The line under the title: the recommended choice in five facts.

use super::first_screen::FirstScreen;
use super::good::Good;
use crate::report::page::Findings;
use crate::report::purchased::describe_speed;
use crate::report::wording::count;

/// Number of sensors, cost, verdict, allowed robot speed, and blind share of the floor; unknown facts are left out.
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
