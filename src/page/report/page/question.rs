//! The question, in a sentence or two, and the title of the page.

use crate::report::apart::Writing;
use crate::report::chosen_sets::{self, Spelling, describe_limits, four};
use crate::report::page::{ReportedSweep, measure};
use crate::report::wording::{count, describe_moments};
use perirobot_decide::cheapest::{PurchaseQuestion, PurchaseReport};
use perirobot_study::input::PurchaseFront;

/// Most sensors, combinations or scenes that are named.
const MOST_NAMED: usize = 4;

/// The question of a study, in a sentence or two.
pub(super) fn question(sweep: &ReportedSweep) -> String {
    let results = sweep.results;
    if let Some(chosen) = sweep.chosen {
        return format!("Asked: {}.", chosen_sets::question(chosen, &IN_WORDS));
    }
    if let Some(purchase) = sweep.purchase {
        return format!("Asked: {}.", purchase_question(purchase, &IN_WORDS));
    }
    let all: Vec<(&str, usize)> =
        results.combinations.iter().map(|one| (one.name.as_str(), one.choices())).collect();
    let sum = all.iter().map(|(_, choices)| *choices).fold(0, usize::saturating_add);
    let (of, parts) = match all.as_slice() {
        [(name, _)] => (format!("of “{name}”"), String::new()),
        some if some.len() <= MOST_NAMED => {
            let parts: Vec<String> =
                some.iter().map(|(name, choices)| format!("{choices} of “{name}”")).collect();
            ("of sensors".into(), format!(" They are {}.", join_words(&parts)))
        }
        many => (format!("of {} combinations of sensors", many.len()), String::new()),
    };
    let regions = if results.regions.len() == 1 { "region" } else { "regions" };
    format!(
        "Asked: which of {sum} choices of poses {of} is the best in {regions} {}?{parts}",
        join_words(&results.regions)
    )
}

/// The question for the cheapest set, in a sentence.
fn purchase_question(report: &PurchaseReport, spelling: &Spelling) -> String {
    let PurchaseQuestion { at_most, budget, apart_m, disturb, always, then, front, sensors, require, .. } =
        &report.asked;
    let budget = budget.map(|budget| report.amount(budget));
    let mut text = format!(
        "the cheapest set that passes {}, by at most {}{}",
        count(require.len(), "requirement"),
        count(*at_most, "sensor"),
        describe_limits(budget, *apart_m, *disturb, always)
    );
    if let Some(then) = then {
        let best = match then.counted() {
            Some((score, region)) => {
                let (score, over) = ((spelling.score)(score), (spelling.over)(then.over));
                format!("{score} ({over}) in region {region}")
            }
            None => then.score.clone(),
        };
        text += &format!(", of equally cheap ones the one with the best {best}");
    }
    let sensors: Vec<&str> = sensors.keys().map(String::as_str).collect();
    text += &format!("; among {} poses of {}", report.candidates, sensors.join(", "));
    text + match front {
        Some(PurchaseFront::Speed) => "; and the same at each speed of the robot",
        Some(PurchaseFront::Requirements) => {
            "; and the same without each requirement, and for each number of them"
        }
        None => "",
    }
}

/// Names of scores on the page.
pub(super) const IN_WORDS: Spelling = Spelling {
    score: measure::title,
    over: describe_moments,
    least: |score, least| match measure::is_share(score) {
        true => Writing::Percent.exactly(least),
        false => least.to_string(),
    },
    value: |score, value| match measure::is_share(score) {
        true => measure::percent(value, 2),
        false => four(score, value),
    },
    change: |score, change| match measure::is_share(score) {
        true => format!("{:+.2} points", 100.0 * change),
        false => format!("{change:+.4}"),
    },
};

/// `a, b and c`.
fn join_words<S: AsRef<str>>(names: &[S]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => one.to_string(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The title of the page, as a sentence.
pub(super) fn title(sweep: &ReportedSweep) -> String {
    // The swept ones: a study may list more.
    let is_swept = |name: &str| {
        let mut members = sweep.results.combinations.iter().flat_map(|one| &one.members);
        members.any(|member| member.sensor == name)
    };
    let names = sweep.study.sensors.iter().map(|sensor| sensor.name.as_str());
    let names: Vec<&str> = names.filter(|name| is_swept(name)).collect();
    let sensors = if names.len() > MOST_NAMED {
        format!("{} sensors", names.len())
    } else {
        format!("the {}", join_words(&names))
    };
    let scenes: Vec<&str> = sweep.results.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let scenes =
        if scenes.len() > MOST_NAMED { format!("{} scenes", scenes.len()) } else { join_words(&scenes) };
    match sweep.chosen.is_some() || sweep.purchase.is_some() {
        true => format!("Which sensors, and where, in {scenes}"),
        false => format!("Where to put {sensors} in {scenes}"),
    }
}
