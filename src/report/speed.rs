//! How fast the robot may run with a set of sensors, as text.

use super::judge::words;
use crate::judge::{Speeds, holds};
use crate::study::Stopping;

/// Of one set.
pub fn render(speeds: &Speeds, stopping: &Stopping) -> String {
    let m_s = |speed: usize| stopping.speeds[speed].speed_m_s;
    let mut listed: Vec<usize> = speeds.judgements.iter().map(|(speed, _)| *speed).collect();
    listed.sort_unstable();
    listed.dedup();
    let of: Vec<String> = listed.iter().map(|&speed| m_s(speed).to_string()).collect();
    let of = format!("of the listed {} m/s", of.join(", "));
    let mut text = match speeds.fastest {
        Some(fastest) => {
            format!("\nhow fast may it run: what is required is met up to {} m/s, {of}\n", m_s(fastest))
        }
        None => format!("\nhow fast may it run: what is required is met at none {of}\n"),
    };
    for (speed, judgement) in speeds.judgements.iter().filter(|(_, judgement)| judgement.values == 0) {
        let (name, when) = (&judgement.requirement.name, words(judgement.condition));
        text +=
            &format!("  at {} m/s nobody is so near, or nothing has a value: {name} ({when})\n", m_s(*speed));
    }
    // What stands in the way of the next.
    let next = listed.into_iter().find(|speed| speeds.fastest.is_none_or(|fastest| *speed > fastest));
    let missed =
        speeds.judgements.iter().filter(|(speed, judgement)| Some(*speed) == next && !holds(judgement));
    for (speed, judgement) in missed {
        let (name, when) = (&judgement.requirement.name, words(judgement.condition));
        text += &format!("  at {} m/s missed: {name} ({when})\n", m_s(*speed));
    }
    text
}
