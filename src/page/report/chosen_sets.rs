//! The best sets of sensors: the question in words, and the tables of the front, of a set and of places.

use super::table::{NONE, Table};
use super::wording::count;
use perirobot_decide::choose::{
    AskedScore, ChooseQuestion, Chosen, DisturbedReport, RefinedReport, SetReport, StepReport,
};
use perirobot_march::metrics::{Across, Score};
use perirobot_study::input::Disturb;

/// The names of scores.
pub(super) struct Spelling {
    pub(super) score: fn(Score) -> String,
    /// The counts that a score covers.
    pub(super) over: fn(Across) -> &'static str,
    /// The lower limit of a score.
    pub(super) least: fn(Score, f64) -> String,
    /// A value of a score.
    pub(super) value: fn(Score, f64) -> String,
    /// A signed difference of two values.
    pub(super) change: fn(Score, f64) -> String,
}

/// Four decimals for files and terminals.
pub(super) fn four(_: Score, value: f64) -> String {
    format!("{value:.4}")
}

/// The question, in a sentence or two.
pub(super) fn question(chosen: &Chosen, spelling: &Spelling) -> String {
    let (Chosen { candidates, asked, .. }, currency) = (chosen, currency(chosen));
    let ChooseQuestion { objective, over, region, at_most, .. } = asked;
    let (score, over) = ((spelling.score)(*objective), (spelling.over)(*over));
    let mut text =
        format!("the highest {score} ({over}) in region {region}, by at most {}", count(*at_most, "sensor"));
    let budget = asked.budget.map(|budget| budget.to_text(currency));
    text += &describe_limits(budget, asked.apart_m, asked.disturb, &asked.always);
    for AskedScore { score, over, at_least } in &asked.require {
        let (name, over, least) =
            ((spelling.score)(*score), (spelling.over)(*over), (spelling.least)(*score, *at_least));
        text += &format!(", with {name} ({over}) {least} or more");
    }
    let sensors: Vec<&str> = asked.sensors.keys().map(String::as_str).collect();
    text + &format!("; among {candidates} poses of {}", sensors.join(", "))
}

/// The limits of every allowed set, in words.
pub(super) fn describe_limits(
    budget: Option<String>,
    apart_m: f64,
    disturb: Option<Disturb>,
    always: &[String],
) -> String {
    let mut text = budget.map_or(String::new(), |budget| format!(" for {budget} together"));
    if apart_m > 0.0 {
        text += &format!(", {apart_m} m apart");
    }
    if let Some(disturb) = disturb {
        text += &format!(", {}", describe_disturb_rule(disturb));
    }
    if !always.is_empty() {
        text += &format!(", always with {}", always.join(", "));
    }
    text
}

/// The rule for sensors that emit the same kind of light.
fn describe_disturb_rule(Disturb { apart_deg, overlap }: Disturb) -> String {
    let lens = match apart_deg {
        Some(0.0) => None,
        Some(most) => Some(format!("looks into another's lens within {most} degrees of its view")),
        None => Some("looks into another's lens".into()),
    };
    let share = overlap.map(|most| format!("sees more than {most} of what another sees"));
    let rules: Vec<String> = lens.into_iter().chain(share).collect();
    format!("where no sensor {} that emits the same light", rules.join(" or "))
}

/// The meaning of the front's columns, and the scope of its proof.
pub(super) fn reading_guide(chosen: &Chosen) -> String {
    let (score, certified) = (chosen.asked.objective.title(), &chosen.certified);
    let costs = if is_priced(chosen) { " for that cost or less" } else { "" };
    let proven = match all_proven(chosen) {
        true => format!("All are proven: no set of as many sensors or fewer{costs} has a higher {score}."),
        false => format!("best possible: no set of as many sensors or fewer{costs} has a higher {score}."),
    };
    let holds = match chosen.report.steps.iter().any(|step| step.proven) {
        true => format!(" That holds for {certified}."),
        false => " Nothing is proven.".into(),
    };
    format!("{proven}{holds}\ngain: above the best set of fewer sensors{costs}.\n")
}

/// Whether a better set exists without the exclusion of disturbing pairs, and its disturbing sensors.
pub(super) fn describe_disturb(chosen: &Chosen, spelling: &Spelling) -> String {
    let report = &chosen.report;
    match (report.bound_by_disturb(), &report.if_disturbed) {
        (Some(DisturbedReport { set, disturbed, .. }), _) => {
            let pairs: Vec<String> = disturbed.iter().map(|[a, b]| format!("{a} and {b}")).collect();
            format!(
                "disturb binds: if sensors might disturb each other, {} would have {}; in it {} do\n",
                set.name(),
                describe_score(chosen, spelling, set),
                pairs.join(", ")
            )
        }
        (None, Some(one)) if one.proven => "disturb does not bind: no set that it forbids is better\n".into(),
        (None, Some(_)) => {
            "whether disturb binds is not proven: no better set that it forbids was found\n".into()
        }
        (None, None) => String::new(),
    }
}

/// The currency of all costs, if the study has one.
fn currency(chosen: &Chosen) -> Option<&str> {
    chosen.asked.currency.as_deref()
}

fn is_priced(chosen: &Chosen) -> bool {
    chosen.report.steps.iter().any(|step| step.best.cost.is_some())
}

/// Whether every set of the front is proven.
fn all_proven(chosen: &Chosen) -> bool {
    chosen.report.steps.iter().all(|step| step.proven)
}

/// The front, a row for each step.
pub(super) fn front(chosen: &Chosen, spelling: &Spelling) -> Table {
    let priced = is_priced(chosen);
    let cost: &[&str] = if priced { &["cost"] } else { &[] };
    let objective = chosen.asked.objective;
    let score = (spelling.score)(objective);
    let possible: &[&str] = if all_proven(chosen) { &[] } else { &["<best possible"] };
    let mut table =
        Table::new(&[&["at most"], cost, &[score.as_str()], possible, &["gain", "<set"]].concat());
    for step in &chosen.report.steps {
        let cost = step.best.cost.map(|cost| cost.to_text(currency(chosen))).filter(|_| priced);
        let gain = step.gain.map_or(String::new(), |gain| (spelling.change)(objective, gain));
        let value = (spelling.value)(objective, step.best.score);
        let score = [step.at_most.to_string()].into_iter().chain(cost).chain([value]);
        let possible = (!possible.is_empty()).then(|| bound(step, objective, spelling));
        table.row(score.chain(possible).chain([gain, step.best.name()]));
    }
    table
}

/// The upper bound of a step, in words.
fn bound(step: &StepReport, objective: Score, spelling: &Spelling) -> String {
    match step.no_set_is_above {
        Some(_) if step.proven => "proven".into(),
        // Rounded up, since it is a bound.
        Some(bound) => {
            let up = |value: f64| (value * 1e4).ceil() / 1e4;
            format!(
                "{} ({})",
                (spelling.value)(objective, up(bound)),
                (spelling.change)(objective, up(bound - step.best.score))
            )
        }
        None => "no bound".into(),
    }
}

/// The places of the front's poses, in words.
pub(super) fn places(chosen: &Chosen) -> Table {
    let mut table = Table::new(&["<pose", "<place"]);
    let mut listed: Vec<&String> = Vec::new();
    for best in chosen.report.steps.iter().map(|step| &step.best) {
        for (pose, one) in best.poses.iter().zip(&best.sensors) {
            if !listed.contains(&pose) {
                listed.push(pose);
                table.row([pose.clone(), one.place.clone()]);
            }
        }
    }
    table
}

/// The best set in a sentence, and whether a better one may exist.
pub(super) fn sentence(chosen: &Chosen, spelling: &Spelling, best: &StepReport) -> String {
    let (asked, set) = (&chosen.asked, &best.best);
    let cost = set.cost.map(|cost| format!(" for {}", cost.to_text(currency(chosen))));
    let possible = match best.no_set_is_above {
        Some(_) if best.proven => "no allowed set has more, which is proven".to_string(),
        Some(_) => format!("at most {} is possible", bound(best, asked.objective, spelling)),
        None => "it is not known how much more is possible".into(),
    };
    format!(
        "{}{} {} {} {} in region {}; {possible}",
        count(set.poses.len(), "sensor"),
        cost.unwrap_or_default(),
        if set.poses.len() == 1 { "has" } else { "have" },
        (spelling.score)(asked.objective),
        (spelling.value)(asked.objective, set.score),
        asked.region
    )
}

/// A set in words: its score and its cost.
pub(super) fn describe_score(chosen: &Chosen, spelling: &Spelling, set: &SetReport) -> String {
    let objective = chosen.asked.objective;
    let cost = set.cost.map(|cost| format!(", cost {}", cost.to_text(currency(chosen))));
    let (score, value) = ((spelling.score)(objective), (spelling.value)(objective, set.score));
    format!("{score} {value}{}", cost.unwrap_or_default())
}

/// A set sensor by sensor: the worth and place of each.
pub(super) fn set(chosen: &Chosen, spelling: &Spelling, set: &SetReport) -> Table {
    let objective = chosen.asked.objective;
    let cost: &[&str] = if set.cost.is_some() { &["cost"] } else { &[] };
    let without = format!("{} without it", (spelling.score)(objective));
    let mut table = Table::new(&[&["<sensor", "<pose"], cost, &[&without, "<place"]].concat());
    for one in &set.sensors {
        let cost = one.cost.map(|cost| cost.to_text(currency(chosen))).filter(|_| set.cost.is_some());
        let without = one.score_without.map_or(NONE.into(), |score| (spelling.value)(objective, score));
        let names = [one.sensor.clone(), one.pose.clone()];
        table.row(names.into_iter().chain(cost).chain([without, one.place.clone()]));
    }
    table
}

/// The result of refining the best set of a size, in words.
pub(super) fn refined_words(chosen: &Chosen, spelling: &Spelling, refined: &RefinedReport) -> String {
    let objective = chosen.asked.objective;
    let RefinedReport { at_most, score_before, rounds, cast, stays, .. } = refined;
    let found = match (&refined.best, refined.gain) {
        (Some(best), Some(gain)) => {
            let gain = (spelling.change)(objective, gain);
            format!("{}, {gain} by finer poses, not proven", describe_score(chosen, spelling, best))
        }
        _ => {
            let (score, value) = ((spelling.score)(objective), (spelling.value)(objective, *score_before));
            format!("{score} {value}, nothing gained by finer poses")
        }
    };
    let stay = match stays.as_slice() {
        [] => String::new(),
        [pose] => format!("; {pose} stays as listed"),
        poses => format!("; {} stay as listed", poses.join(", ")),
    };
    format!("refined, at most {at_most}: {found} ({cast} poses cast in {rounds} rounds{stay})")
}
