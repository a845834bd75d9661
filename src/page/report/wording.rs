//! The extent of scores, conditions, and worst places, in words.

use perirobot_decide::approach::Company;
use perirobot_decide::judge::{CasePart, JudgedSet, Judgement, Moment, Passage, Where};
use perirobot_march::metrics::Across;
use perirobot_study::input::Condition;
use perirobot_sweep::results::{Results, Subject};

/// The extent of the scores: `3 scenes, 10 repeats`.
pub(super) fn extent(results: &Results) -> String {
    let (scenes, moments) = (results.scenes.len(), results.moments().len());
    let mut text = count(scenes, "scene");
    if moments > scenes {
        text += &format!(", {moments} snapshots");
    }
    if results.repeats > 1 {
        text += &format!(", {} repeats", results.repeats);
    }
    text
}

/// A number of items: `3 scenes`, `1 scene`.
pub fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// The aggregate of a score over moments.
pub(super) fn describe_moments(over: Across) -> &'static str {
    match over {
        Across::Worst => "the worst of all moments",
        Across::Mean => "the mean of all moments",
        Across::Pooled => "all moments together",
    }
}

/// A condition in words.
pub fn words(condition: Condition) -> &'static str {
    match condition {
        Condition::AsPlanned => "as planned",
        Condition::OneSensorDead => "one sensor dead",
        Condition::TwoSensorsDead => "two sensors dead",
        Condition::MountingError => "mounting error",
        Condition::Postures => "postures",
    }
}

/// The worst place of a requirement, if there are several places.
pub(super) fn worst_case(subject: &Subject, set: &JudgedSet, judgement: &Judgement) -> String {
    match judgement.all_equal {
        true => format!("; the same in all {} cases", judgement.cases),
        false => whereabouts(subject, set, judgement.condition, &judgement.worst),
    }
}

/// The case and its part, if there are several.
pub(super) fn whereabouts(subject: &Subject, set: &JudgedSet, condition: Condition, at: &Where) -> String {
    let case = &set.conditions.cases(condition)[at.case].alteration.words();
    let part = match at.part {
        Some(CasePart::Moment(moment)) if set.conditions.moments.len() > 1 => {
            format!("in {}", title(subject, &set.conditions.moments[moment]))
        }
        Some(CasePart::Passage(passage)) => way_in(subject, &set.conditions.passages[passage]),
        _ => String::new(),
    };
    let parts: Vec<&str> = [case.as_str(), &part].into_iter().filter(|part| !part.is_empty()).collect();
    if parts.is_empty() { String::new() } else { format!("; worst {}", parts.join(", ")) }
}

/// `of standing from door, people as cover, in scene cell`, if there are several scenes.
fn way_in(subject: &Subject, passage: &Passage) -> String {
    let mut text = format!("of {} from {}", passage.body, passage.entry);
    if passage.company == Company::Cover {
        text += ", people as cover";
    }
    if subject.scenes.len() > 1 {
        text += &format!(", in scene {}", subject.scenes[passage.scene].name);
    }
    if subject.repeats > 1 {
        text += &format!(", in repeat {}", passage.repeat);
    }
    text
}

/// `scene cell, snapshot 2, repeat 0`, if there are several.
fn title(subject: &Subject, moment: &Moment) -> String {
    let scene = &subject.scenes[moment.scene];
    let mut text = format!("scene {}", scene.name);
    if scene.moments.len() > 1 {
        text += &format!(", snapshot {}", moment.snapshot);
    }
    if subject.repeats > 1 {
        text += &format!(", repeat {}", moment.repeat);
    }
    text
}
