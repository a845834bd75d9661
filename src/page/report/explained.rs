//! Why voxels of a region stay unknown, in words, and how to avoid it.

use perirobot_decide::view::View;
use perirobot_decide::view::why::{Cause, CauseTally, Reason};
use perirobot_march::metrics::Confusion;

/// Least share of the unknown voxels, in percent, for which a reason gets advice.
const WORTH_ADVICE: u64 = 10;

/// Most pieces of advice for a region.
const MOST_ADVICE: usize = 3;

/// Why voxels of a region stay unknown, as text.
#[derive(Clone, Debug)]
pub(super) struct Explained {
    /// Their number, and the most frequent causes.
    pub(super) headline: String,
    /// For each cause, the most frequent first: reason, object, share, voxels, occupied, a person's, free.
    pub(super) rows: Vec<[String; 7]>,
    /// The number of monitored ones.
    pub(super) monitored: String,
    /// Advice against the most frequent causes.
    pub(super) advice: Vec<Advice>,
    /// The number of voxels in the region.
    #[cfg_attr(not(feature = "report"), expect(dead_code))]
    pub(super) total: u64,
}

/// Advice against a cause.
#[derive(Clone, Debug)]
pub(super) struct Advice {
    pub(super) cause: String,
    pub(super) cure: String,
    /// The number of its unknown voxels, and of those that are a person's.
    #[cfg_attr(not(feature = "report"), expect(dead_code))]
    pub(super) voxels: u64,
    #[cfg_attr(not(feature = "report"), expect(dead_code))]
    pub(super) human: u64,
}

impl Explained {
    /// The columns of its rows.
    pub(super) fn columns(&self) -> [&'static str; 7] {
        ["reason", "object", "share", "voxels", "occupied", "a person's", "free"]
    }
}

/// Explains the unknown voxels of a region by their tallies.
pub(super) fn explain(view: &View, counts: &Confusion, mut tallies: Vec<CauseTally>) -> Explained {
    let unknown = counts.uo + counts.uf;
    // Ties keep the order of the reasons.
    tallies.sort_by_key(|tally| std::cmp::Reverse(tally.voxels()));
    let of_all = percent(unknown, counts.total());
    let people = match counts.human.uo {
        0 => String::new(),
        some => format!(", {some} of them people's"),
    };
    let mut headline = format!("{of_all} unknown ({unknown} of {} voxels{people})", counts.total());
    if !tallies.is_empty() {
        let phrase = |tally: &CauseTally| {
            format!("{} {}", percent(tally.voxels(), unknown), phrase(view, &tally.cause))
        };
        let phrases: Vec<_> = tallies.iter().take(MOST_ADVICE).map(phrase).collect();
        let more = if tallies.len() > MOST_ADVICE { ", …" } else { "" };
        headline += &format!(": {}{more}", phrases.join(", "));
    }
    let row = |tally: &CauseTally| {
        let CauseTally { cause, occupied, free, human } = tally;
        let object = view.object(cause).unwrap_or_default().to_string();
        let [voxels, occupied, human, free] =
            [tally.voxels(), *occupied, *human, *free].map(|n| n.to_string());
        [cause.reason.name().into(), object, percent(tally.voxels(), unknown), voxels, occupied, human, free]
    };
    let monitored: u64 =
        tallies.iter().filter(|t| t.cause.reason.is_monitored()).map(CauseTally::voxels).sum();
    let worth = tallies.iter().filter(|t| 100 * t.voxels() >= WORTH_ADVICE * unknown).take(MOST_ADVICE);
    Explained {
        headline,
        rows: tallies.iter().map(row).collect(),
        monitored: format!(
            "monitored, but not known: {}; not monitored: {}",
            percent(monitored, unknown),
            percent(unknown - monitored, unknown)
        ),
        advice: worth.map(|tally| Advice::new(view, tally)).collect(),
        total: counts.total(),
    }
}

impl Advice {
    fn new(view: &View, tally: &CauseTally) -> Advice {
        Advice {
            cause: phrase(view, &tally.cause),
            cure: cure(view, &tally.cause),
            voxels: tally.voxels(),
            human: tally.human,
        }
    }
}

/// Rounded, but to 0 % or 100 % only if exact.
fn percent(part: u64, of: u64) -> String {
    match (200 * part + of) / (2 * of).max(1) {
        0 if part > 0 => "<1 %".into(),
        100 if part < of => ">99 %".into(),
        rounded => format!("{rounded} %"),
    }
}

/// A cause in words.
pub fn phrase(view: &View, cause: &Cause) -> String {
    let object = view.object(cause).unwrap_or_default();
    match cause.reason {
        Reason::OutOfView => "out of view".into(),
        Reason::OutOfRange => "out of range".into(),
        Reason::Muted => "under a switch that is muted".into(),
        Reason::Silent => "under a switch that is off".into(),
        Reason::BetweenRays => "between rays".into(),
        Reason::Hidden => format!("hidden by {object}"),
        Reason::Blind => format!("lost to {object}, too near to the lens"),
        Reason::TooDark => format!("before {object}, too dark from so far away"),
        Reason::NoReturn => "nothing behind to return the ray".into(),
        Reason::Misread => "misread by noise".into(),
        Reason::Cancelled => "voted down".into(),
    }
}

/// A sentence of advice.
fn cure(view: &View, cause: &Cause) -> String {
    let object = view.object(cause).unwrap_or_default();
    match cause.reason {
        Reason::OutOfView => {
            "turn the sensor there, move it back, take a wider field of view, or add a sensor".into()
        }
        Reason::OutOfRange => "move the sensor nearer, or take one that measures farther".into(),
        Reason::Muted => "watch the zone with another sensor while the switch is muted".into(),
        Reason::Silent => {
            "an idle switch proves nothing here; only if its data sheet says that idle means free, write otherwise = \"free\""
                .into()
        }
        Reason::BetweenRays => "move the sensor nearer, or take one with a finer resolution".into(),
        Reason::Hidden => {
            format!("look past {object}, from above or from its other side, or add a sensor there")
        }
        Reason::Blind => {
            format!("move the sensor away from {object}, or, if that is its own mount, say near_ignore_m")
        }
        Reason::TooDark => {
            format!("move the sensor nearer to {object}, or take one that detects dark objects farther away")
        }
        Reason::NoReturn => {
            "face a wall or the floor; where silence does certify free space, say no_return = \"free\", and \
                             of an open hall outside = \"backdrop\""
                .into()
        }
        Reason::Misread => {
            "readings scatter by more than a voxel: take a steadier sensor, or larger voxels".into()
        }
        Reason::Cancelled => {
            "sensors contradict each other; fusion = \"occupied_wins\" keeps the cautious answer".into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_not_rounded_to_nothing_or_all() {
        let shares = [(0, 10), (1, 1000), (1, 200), (1, 3), (999, 1000), (10, 10), (0, 0)];
        assert_eq!(
            shares.map(|(part, of)| percent(part, of)),
            ["0 %", "<1 %", "1 %", "33 %", ">99 %", "100 %", "0 %"]
        );
    }
}
