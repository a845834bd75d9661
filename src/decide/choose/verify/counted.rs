//! Sets counted again, and their scores by plain code.

use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_march::metrics::{Across, Confusion, Score};
use perirobot_march::progress::Progress;
use perirobot_study::input::{Choose, Combination, Member, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::run_unless;

/// The counts of a sweep for some sets, repeat by repeat, and then world by world.
///
/// # Errors
/// If the backend fails; `Error::Stopped` if it is stopped.
pub(crate) fn recount(
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    sets: &[Vec<[usize; 2]>],
    backend: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Confusion>>> {
    let combination = |(number, set): (usize, &Vec<[usize; 2]>)| Combination {
        name: number.to_string(),
        fusion: choose.fusion,
        members: set.iter().map(|&[sensor, c]| Member { sensor, candidates: vec![c] }).collect(),
    };
    let combinations = sets.iter().enumerate().map(combination).collect();
    let study = Study { combinations, ..study.clone() };
    let mut rows = run_unless(&study, worlds, backend, progress)?;
    rows.sort_by_key(|row| row.repeat);
    let mut counts = vec![Vec::new(); sets.len()];
    let representations: Vec<_> =
        study.combinations.iter().map(|one| one.representations(&study.sensors)).collect();
    for row in rows.iter().filter(|row| row.region == choose.region) {
        let wanted = study.combinations[row.combination]
            .members
            .iter()
            .map(|member| choose.representations[member.sensor]);
        if wanted.eq(representations[row.combination][row.representation].iter().copied()) {
            counts[row.combination].push(row.counts);
        }
    }
    Ok(counts)
}

/// A score over moments, as in the tables.
pub(super) fn value(score: Score, over: Across, counts: &[Confusion]) -> Option<f64> {
    let values: Vec<f64> = counts.iter().filter_map(|counts| score.evaluate(counts)).collect();
    match over {
        Across::Pooled => score.evaluate(&sum(counts)),
        Across::Worst => values.into_iter().reduce(f64::min),
        Across::Mean if values.is_empty() => None,
        Across::Mean => Some(values.iter().sum::<f64>() / values.len() as f64),
    }
}

pub(super) fn value_reaches(value: Option<f64>, least: f64) -> bool {
    value.is_some_and(|value| value >= least)
}

pub(super) fn sum(counts: &[Confusion]) -> Confusion {
    counts.iter().fold(Confusion::default(), |all, one| all.plus(one))
}

/// Numerator and denominator of a score, unless it is a mean.
pub(super) fn exact(score: Score, over: Across, counts: &[Confusion]) -> Option<(i128, i128)> {
    let one = |c: &Confusion| -> Option<(i128, i128)> {
        let [tp, fp, fn_, tn, uo, uf] = [c.tp, c.fp, c.fn_, c.tn, c.uo, c.uf].map(i128::from);
        let (n, d) = match score {
            Score::F1 => (2 * tp, 2 * tp + fp + fn_ + uo + uf),
            Score::Kappa => {
                let s = tp + fp + fn_ + tn + uo + uf;
                let chance = (tp + fp) * (tp + fn_ + uo) + (fn_ + tn) * (fp + tn + uf);
                (s * (tp + tn) - chance, s * s - chance)
            }
            Score::HumanSeen => (c.detection.hit_human.into(), c.people_voxels().into()),
            Score::PeopleDetected => (c.detection.people_detected.into(), c.detection.people.into()),
            _ => (c.detection.parts_detected.into(), c.detection.parts.into()),
        };
        (d != 0).then_some((n, d))
    };
    match over {
        Across::Pooled => one(&sum(counts)),
        Across::Worst => counts.iter().filter_map(one).min_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1))),
        Across::Mean => None,
    }
}
