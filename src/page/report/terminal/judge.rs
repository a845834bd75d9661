//! Verdicts on requirements, and scores under each condition, as text.

use std::collections::BTreeSet;

use crate::report::PLAIN_MEANS;
use crate::report::apart::Writing;
use crate::report::table::{NONE, Table};
use crate::report::wording::{describe_moments, whereabouts, words, worst_case};
use perirobot_decide::judge::{JudgedSet, Judgement, Summed, Value, spreads};
use perirobot_march::voxel::gap_error_m;
use perirobot_study::input::{Counted, Limit, Measure, Nearness, Requirement};
use perirobot_sweep::results::Subject;

/// Writes the command that draws the worst moment of a judgement, if there is one.
pub type Picture<'p> = &'p dyn Fn(&JudgedSet, &Judgement) -> Option<String>;

/// A choice with its verdicts, and a table of the required scores under each condition.
pub fn render(subject: &Subject, set: &JudgedSet, picture: Picture) -> String {
    let mut text = verdicts(subject, set, picture);
    if set.conditions.cases.len() > 1 {
        text += &format!("\n{}", conditions(subject, set).text());
    }
    if subject.dwell_s.is_some() {
        text += &format!("\n{PLAIN_MEANS}\n");
    }
    text
}

/// A choice with its verdicts.
pub fn verdicts(subject: &Subject, set: &JudgedSet, picture: Picture) -> String {
    let place = if set.place.is_empty() { String::new() } else { format!("{}\n", set.place) };
    let mut text = format!("\n{} · {} · {}\n{place}", set.poses, set.combination, set.representation);
    let mut last = None;
    for judgement in &set.judgements {
        let Requirement { name, safety_function, .. } = judgement.requirement;
        text += &format!("{}\n", line(subject, set, judgement));
        if let Some(words) = safety_function.as_ref().filter(|_| last != Some(name)) {
            text += &format!("      for {words}\n");
        }
        last = Some(name);
        if let Some(bound) = &judgement.out_of_reach {
            let bound = distinguished(bound, &judgement.requirement.limit, Writing::Plain);
            text +=
                &format!("      no choice of the listed poses can meet it: their upper bound is {bound}\n");
        }
        if let Some(picture) = picture(set, judgement) {
            text += &format!("      {picture}\n");
        }
    }
    set.caveats.iter().for_each(|caveat| text += &format!("BUT   {caveat}\n"));
    text
}

/// A verdict in a line: the requirement, its score, value and limit, and the worst place.
pub fn line(subject: &Subject, set: &JudgedSet, judgement: &Judgement) -> String {
    let requirement = judgement.requirement;
    let limit = match requirement.limit {
        Limit::AtLeast(ratio) => format!("at least {}", ratio.value()),
        Limit::AtMost(ratio) => format!("at most {}", ratio.value()),
    };
    let (what, worst) = match &requirement.measure {
        Measure::Counted(Counted { score, region, over }) => {
            let region = &subject.regions[*region];
            let which = if set.conditions.moments.len() > 1 { describe_moments(*over) } else { "" };
            (format!("{} in region {region}", score.title()), which)
        }
        Measure::Nearness(Nearness { score, .. }) => {
            (score.name().into(), "the worst of all bodies and entries")
        }
        Measure::Controller(score) => {
            let of_all =
                if set.conditions.moments.len() > 1 { describe_moments(requirement.scope()) } else { "" };
            (score.name().into(), of_all)
        }
    };
    let is = match &judgement.value {
        None => format!("{what} has no value"),
        Some(Value::Endless) if requirement.is_of_controller() => {
            format!("{what} is infinite, since a person is present but not measured")
        }
        Some(Value::Endless) => format!("{what} is infinite, since no body fits through an entry"),
        Some(value) => {
            format!(
                "{what} is {}",
                distinguished(
                    value,
                    &requirement.limit,
                    Writing::new(Summed::from_measure(&requirement.measure))
                )
            )
        }
    };
    let (name, when) = (&requirement.name, words(judgement.condition));
    let mut text = format!("{}  {name} ({when}): {is}, {limit} is required", judgement.word());
    let is_nowhere = requirement.is_of_nearness() && judgement.value == Some(Value::Endless);
    if !worst.is_empty() && judgement.value != Some(Value::Endless) {
        text += &format!(" ({worst})");
    }
    if judgement.cases > 1 {
        text += &format!("; {} of {} cases fail", judgement.failed, judgement.cases);
    }
    let Judgement { values, of, kept, condition, .. } = *judgement;
    if (1..of).contains(&values) {
        text += &format!("; only {values} of {of} moments have a value");
    }
    if kept > 0 {
        let mounts: BTreeSet<&str> =
            set.conditions.cases(condition).iter().flat_map(|case| &case.kept).map(String::as_str).collect();
        let mounts = mounts.into_iter().collect::<Vec<_>>().join(", ");
        text += &format!(
            "; in {kept} of {} draws, no place but the planned one was found for {mounts}",
            judgement.cases
        );
    }
    if !is_nowhere {
        text += &worst_case(subject, set, judgement);
        text += &gap(set, &requirement.measure);
    }
    text
}

/// A note on scores that are distances; empty for others.
fn gap(set: &JudgedSet, measure: &Measure) -> String {
    match measure {
        Measure::Nearness(nearness) if !nearness.score.is_area() => {
            let less_m = gap_error_m(set.conditions.voxel_size_m);
            format!("; between centres of voxels, with sizes rounded: the gap may be {less_m:.2} m less")
        }
        _ => String::new(),
    }
}

/// A value with enough digits to distinguish it from a limit.
fn distinguished(value: &Value, limit: &Limit, writing: Writing) -> String {
    writing.apart(value.number(), value.cmp_ratio(limit.ratio()), limit.ratio().value())
}

/// The required scores, under each condition.
fn conditions(subject: &Subject, set: &JudgedSet) -> Table {
    let mut table =
        Table::new(&["<condition", "<score", "<region", "best", "mean", "5 %", "worst", "<where"]);
    let is_required = |of_what: Summed| {
        set.judgements.iter().any(|one| of_what == Summed::from_measure(&one.requirement.measure))
    };
    for spread in spreads(&set.conditions).iter().filter(|spread| is_required(spread.of_what)) {
        let writing = Writing::new(spread.of_what);
        let [best, mean, twentieth, worst] = [spread.best, spread.mean, spread.twentieth, spread.worst]
            .map(|value| writing.to_table_text(value));
        let at = match spread.is_even() {
            true => "all equal".into(),
            false => {
                let at = whereabouts(subject, set, spread.condition, &spread.at);
                at.strip_prefix("; worst ").unwrap_or(NONE).to_string()
            }
        };
        let region = spread.of_what.region().map_or(NONE.into(), |region| subject.regions[region].clone());
        let names = [words(spread.condition).into(), spread.of_what.name().to_string(), region];
        table.row(names.into_iter().chain([best, mean, twentieth, worst, at]));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_march::metrics::{Across, Confusion, Ratio, Score};

    /// The text of a ratio of voxels next to a limit.
    fn show(part: u64, of: u64, limit: f64) -> String {
        let limit = Limit::AtLeast(Ratio::from_f64(limit));
        let counts = [Confusion { uf: part, tn: of - part, ..Default::default() }];
        distinguished(
            &Value::from_counts(Score::Unknown, Across::Worst, &limit, &counts).unwrap(),
            &limit,
            Writing::Plain,
        )
    }

    #[test]
    fn values_are_distinguished_from_limits() {
        assert_eq!(show(7, 10, 0.7), "0.700");
        assert_eq!(show(6, 10, 0.7), "0.600");
        assert_eq!(show(69_996, 100_000, 0.7), "0.69996");
        assert_eq!(show(69_999_999, 100_000_000, 0.7), "0.69999999");
        assert_eq!(show(6994, 10_000, 0.6991), "0.6994");
        assert_eq!(show(1, 1_000_000, 0.0), "0.000001");
        // The root of 1.103 is 1.05023...; the digits of a distance are rounded down.
        let limit = Limit::AtLeast(Ratio::from_f64(1.0));
        let root = Value::Root(Ratio { numerator: 1_1037, denominator: 10_000 });
        assert_eq!(distinguished(&root, &limit, Writing::Down), "1.050");
        assert_eq!(distinguished(&root, &limit, Writing::Plain), "1.051");
        assert_eq!(show(700_000_000_000_000_001, 1_000_000_000_000_000_000, 0.7), "just above 0.7");
    }
}
