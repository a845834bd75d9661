//! The summary on screen: for each sensor and region the best poses by F1, κ and human_seen, beside the baselines.

use std::fmt::Write;

use super::{Row, World};
use crate::metrics::Confusion;
use crate::study::Study;
use crate::sweep::table::POINTS;

/// A score and its name.
type Score = (&'static str, fn(&Confusion) -> Option<f64>);

const SCORES: [Score; 3] =
    [("F1", Confusion::f1), ("kappa", Confusion::kappa), ("human_seen", Confusion::human_seen)];

/// How many poses each list shows.
const SHOWN: usize = 3;

/// What a score is over several scenes. A scene without a value is left out, never counted as zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverScenes {
    /// Mean of the values there are.
    pub mean: f64,
    /// The smallest of them.
    pub worst: f64,
    /// How many there are.
    pub scenes: usize,
    /// The score of the counts of all scenes together.
    pub pooled: Option<f64>,
}

/// One pose's (or baseline's) score over scenes; `None` if no scene has a value.
pub fn over_scenes(counts: &[Confusion], score: fn(&Confusion) -> Option<f64>) -> Option<OverScenes> {
    let values: Vec<f64> = counts.iter().filter_map(score).collect();
    let worst = values.iter().copied().reduce(f64::min)?;
    let pooled = score(&counts.iter().fold(Confusion::default(), |sum, c| sum.plus(c)));
    Some(OverScenes {
        mean: values.iter().sum::<f64>() / values.len() as f64,
        worst,
        scenes: values.len(),
        pooled,
    })
}

/// The whole summary as text: a block for each sensor and region.
pub fn summary(study: &Study, worlds: &[World], rows: &[Row]) -> String {
    let mut text = String::new();
    let mut some_left_out = false;
    for (s, sensor) in study.sensors.iter().enumerate() {
        for (r, (region, _)) in study.regions.iter().enumerate() {
            let (count, scenes) = (sensor.candidates.len(), study.scenes.len());
            let title = format!(
                "{} · {POINTS} · region {region}: {count} poses, {scenes} scene{}",
                sensor.name,
                if scenes == 1 { "" } else { "s" }
            );
            let _ = writeln!(text, "\n{title}\n{:58}{HEADER}", "");
            let poses = poses(rows, s, r, count);
            for (name, score) in SCORES {
                let mut best: Vec<(usize, f64)> = poses
                    .iter()
                    .enumerate()
                    .filter_map(|(p, c)| Some((p, over_scenes(c, score)?.mean)))
                    .collect();
                // Stable, so that equal scores keep study order.
                best.sort_by(|a, b| b.1.total_cmp(&a.1));
                if best.is_empty() {
                    let _ = writeln!(text, "  best {name:<11} no pose has a value");
                }
                for (rank, (p, _)) in best.iter().take(SHOWN).enumerate() {
                    let label = if rank == 0 { format!("best {name}") } else { String::new() };
                    let candidate = &sensor.candidates[*p];
                    let at = candidate.pose.position_m;
                    let name = format!("{} ({:.2}, {:.2}, {:.2})", candidate.name, at.x, at.y, at.z);
                    some_left_out |= line(&mut text, &label, &name, &poses[*p]);
                }
            }
            for (name, counts) in baselines(worlds, r) {
                some_left_out |= line(&mut text, "baseline", name, &counts);
            }
        }
    }
    let legend = "\n[n] before a mean: only n of the scenes have a value there, and only they are in it\n";
    if some_left_out { text + legend } else { text }
}

/// Column heads above the three scores of a line.
const HEADER: &str = "F1: mean worst pooled   kappa: mean worst pooled   human_seen: mean worst pooled";

/// One pose or baseline; whether a score of it is over fewer scenes than there are.
fn line(text: &mut String, label: &str, name: &str, counts: &[Confusion]) -> bool {
    let mut some_left_out = false;
    let _ = write!(text, "  {label:<16} {name:<38}");
    for (width, (_, score)) in [8, 11, 16].into_iter().zip(SCORES) {
        match over_scenes(counts, score) {
            None => {
                let _ = write!(text, "{:>width$}{:>6}{:>7}  ", "–", "–", "–");
            }
            Some(OverScenes { mean, worst, scenes, pooled }) => {
                let pooled = pooled.map_or("–".into(), |p| format!("{p:.3}"));
                // A mean over fewer scenes than there are must not look like one over all.
                let fewer = scenes < counts.len();
                some_left_out |= fewer;
                let some = if fewer { format!("[{scenes}] ") } else { String::new() };
                let _ = write!(text, "{:>width$}{worst:>6.3}{pooled:>7}  ", format!("{some}{mean:.3}"));
            }
        }
    }
    let _ = writeln!(text);
    some_left_out
}

/// The counts of each pose of a sensor in one region, one entry a scene.
fn poses(rows: &[Row], sensor: usize, region: usize, count: usize) -> Vec<Vec<Confusion>> {
    let mut poses = vec![Vec::new(); count];
    for row in rows.iter().filter(|row| row.sensor == sensor && row.region == region) {
        poses[row.pose].push(row.counts);
    }
    poses
}

fn baselines(worlds: &[World], region: usize) -> [(&'static str, Vec<Confusion>); 4] {
    let each = |pick: fn(&super::world::Baselines) -> Confusion| {
        worlds.iter().map(|world| pick(&world.baselines[region])).collect()
    };
    [
        ("ceiling", each(|b| b.ceiling)),
        ("all occupied", each(|b| b.all_occupied)),
        ("all free", each(|b| b.all_free)),
        ("nothing seen", each(|b| b.nothing_seen)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_without_a_value_are_left_out_of_mean_and_worst() {
        let with = |tp, uf| Confusion { tp, uf, ..Default::default() };
        // F1 1/2 · and 2/3; an empty table has none.
        let counts = [with(1, 2), with(1, 1), Confusion::default()];
        let value = over_scenes(&counts, Confusion::f1).unwrap();
        assert_eq!((value.mean, value.worst, value.scenes), ((0.5 + 2.0 / 3.0) / 2.0, 0.5, 2));
        assert_eq!(value.pooled, Some(4.0 / 7.0));
        assert_eq!(over_scenes(&counts, Confusion::human_seen), None);
        let mut text = String::new();
        assert!(line(&mut text, "best F1", "pose[7]", &counts) && text.contains("[2] 0.583"), "{text}");
        assert!(!line(&mut text, "best F1", "pose[7]", &counts[..2]), "all scenes have a value");
    }
}
