//! The allowed robot speed with a set of sensors, as text.

use crate::report::wording::words;
use perirobot_decide::judge::{Judgement, Speeds};
use perirobot_study::input::Stopping;

/// The text for one set.
pub fn render(speeds: &Speeds, stopping: &Stopping) -> String {
    let m_s = |speed: usize| stopping.speeds[speed].speed_m_s;
    let mut listed: Vec<usize> = speeds.judgements.iter().map(|(speed, _)| *speed).collect();
    listed.sort_unstable();
    listed.dedup();
    let speeds_text: Vec<String> = listed.iter().map(|&speed| m_s(speed).to_string()).collect();
    let up_to = speeds.fastest.map_or("at none".into(), |fastest| format!("up to {} m/s,", m_s(fastest)));
    let (by, speeds_text) = (speed_demands(speeds).join(" and by "), speeds_text.join(", "));
    let mut text = format!("\nhow fast may it run, by {by}: {up_to} of the listed {speeds_text} m/s\n");
    if !speeds.missed_at_all.is_empty() {
        let highest = stopping.fastest().speed_m_s;
        for (of_highest, when) in [(false, "whatever the speed".into()), (true, format!("at {highest} m/s"))]
        {
            let missed = speeds.missed_at_all.iter();
            let missed = missed.filter(|one| one.requirement.measure.is_of_highest_speed() == of_highest);
            let missed: Vec<String> = missed.map(describe).collect();
            if !missed.is_empty() {
                text += &format!("  also missed, {when}: {}\n", missed.join(", "));
            }
        }
    }
    // The misses at the next speed.
    let next = listed.into_iter().find(|speed| speeds.fastest.is_none_or(|fastest| *speed > fastest));
    for (speed, judgement) in &speeds.judgements {
        let (name, m_s) = (describe(judgement), m_s(*speed));
        if judgement.values == 0 {
            let why = "has no value at any moment (for example without a person so close)";
            text += &format!("  at {m_s} m/s not decided: {name} {why}\n");
        } else if Some(*speed) == next && !judgement.is_met {
            text += &format!("  at {m_s} m/s missed: {name}\n");
        }
    }
    text
}

/// The requirements at each speed.
fn speed_demands(speeds: &Speeds) -> Vec<&'static str> {
    let is_counted = |judgement: &Judgement| judgement.requirement.counted_score().is_some();
    let any = |counted: bool| speeds.judgements.iter().any(|(_, judgement)| is_counted(judgement) == counted);
    let both = [
        (any(true), "the requirements in separation regions"),
        (any(false), "how near a person gets unnoticed"),
    ];
    both.into_iter().filter_map(|(is_asked, what)| is_asked.then_some(what)).collect()
}

fn describe(judgement: &Judgement) -> String {
    format!("{} ({})", judgement.requirement.name, words(judgement.condition))
}
