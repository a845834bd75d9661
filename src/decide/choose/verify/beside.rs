//! Checks the values in addition to the scores of the best sets: gains, places, worth of each sensor, near-ties, and
//! the tables.

use super::counted::{recount, value};
use super::tables::is_written;
use super::{Claims, ProofInput, holds};
use crate::choose::files::{Chosen, FRONT, PROOF, SETS};
use crate::choose::report::{SetReport, StepReport};
use perirobot_march::backend::Backend;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use perirobot_study::sensor::{Cost, Setting};
use perirobot_study::world::World;
use perirobot_study::world::place::Places;

/// The share of the best score that counts as nearly as good.
const NEARLY: f64 = 0.99;

/// Checks these values; `counts` are those of the sets.
pub(super) fn check(
    claims: &Claims,
    given: ProofInput,
    counts: &[Vec<Confusion>],
    recounter: &mut dyn Backend,
) -> Result<()> {
    let Claims { folder, chosen, sets, .. } = claims;
    let Chosen { report, .. } = chosen;
    let path = folder.join(PROOF);
    let at_path = |why: Issue| Error::from(why.with_place(&path));
    about(chosen, given).map_err(at_path)?;
    for (number, step) in report.steps.iter().enumerate() {
        let gain = gain(step, &report.steps);
        if step.gain != gain {
            let what = format!("is {}, but the scores give {}", or_none(step.gain), or_none(gain));
            return Err(at_path(Issue::says(what).with_place(format!("steps[{number}].gain"))));
        }
    }
    let (of_steps, of_ties) = sets.split_at(report.steps.len());
    let best =
        report.best().map(|best| (best, &of_steps[report.steps.iter().position(|s| s == best).unwrap_or(0)]));
    for (number, (tie, set)) in report.ties.iter().zip(of_ties).enumerate() {
        let place = format!("nearly_as_good[{number}]");
        holds(given.choose, tie, &counts[of_steps.len() + number], &place).map_err(at_path)?;
        let Some((best, of_best)) = best else { break };
        let mounts = |set: &[[usize; 2]]| mounts(&given.worlds[0], set);
        let is_told = of_ties[..number].iter().any(|other| mounts(other) == mounts(set));
        if tie.score < NEARLY * best.best.score || is_told || mounts(set) == mounts(of_best) {
            let what = "is not nearly as good as the best set, from mounts that no other has";
            return Err(at_path(Issue::says(what).with_place(place)));
        }
    }
    sensors(claims, given, recounter)?;
    is_written(&folder.join(FRONT), Some(&chosen.front()))?;
    is_written(&folder.join(SETS), Some(&chosen.sets()))
}

/// Whether the proof belongs to this study.
fn about(chosen: &Chosen, ProofInput { study, choose, worlds, .. }: ProofInput) -> Result<(), Issue> {
    let right =
        Chosen { report: chosen.report.clone(), ..Chosen::new(study, choose, worlds, Default::default()) };
    let wrong = [
        ("semantics_version", right.semantics_version != chosen.semantics_version),
        ("certified", right.certified != chosen.certified),
        ("candidates", right.candidates != chosen.candidates),
        ("voxel_size_m", right.voxel_size_m != chosen.voxel_size_m),
        ("noiseless", right.noiseless != chosen.noiseless),
    ];
    match wrong.into_iter().find(|(_, is_wrong)| *is_wrong) {
        Some((key, _)) => Err(Issue::says("differs from the study").with_place(key)),
        None => Ok(()),
    }
}

fn or_none(value: Option<f64>) -> String {
    value.map_or("none".into(), |value| value.to_string())
}

/// The gain of a step over the best set of fewer sensors at no higher cost.
fn gain(step: &StepReport, all: &[StepReport]) -> Option<f64> {
    let cost = |step: &StepReport| step.best.cost.map_or(0, Cost::thousandths);
    let smaller = all.iter().filter(|other| other.at_most < step.at_most && cost(other) <= cost(step));
    let before = smaller.map(|other| other.best.score).reduce(f64::max);
    before.map(|before| step.best.score - before)
}

/// The sensors and mounts of a set.
fn mounts(world: &World, set: &[[usize; 2]]) -> Vec<(usize, [u64; 3])> {
    let mount = |&[sensor, candidate]: &[usize; 2]| match world.settings[sensor][candidate] {
        Setting::Pose(pose) => (sensor, pose.position_m.to_array().map(f64::to_bits)),
        _ => (sensor, [candidate as u64, 0, 0]),
    };
    let mut mounts: Vec<_> = set.iter().map(mount).collect();
    mounts.sort_unstable();
    mounts
}

/// Checks the details of each sensor of each set; the scores without it are counted again.
fn sensors(claims: &Claims, given: ProofInput, recounter: &mut dyn Backend) -> Result<()> {
    let ProofInput { study, choose, worlds, progress, .. } = given;
    let Claims { folder, chosen: Chosen { report, .. }, sets, .. } = claims;
    let all: Vec<&SetReport> = report.steps.iter().map(|step| &step.best).chain(&report.ties).collect();
    let without = |set: &Vec<[usize; 2]>| {
        let rest = |out: usize| (0..set.len()).filter(|i| *i != out).map(|i| set[i]).collect::<Vec<_>>();
        (0..set.len()).map(rest).collect::<Vec<_>>()
    };
    let rests: Vec<Vec<[usize; 2]>> = sets.iter().flat_map(without).filter(|rest| !rest.is_empty()).collect();
    let mut counts = recount(study, choose, worlds, &rests, recounter, progress)?.into_iter();
    let nothing_seen = |world: &World| world.baselines[choose.region].nothing_seen;
    let nothing: Vec<Confusion> = (0..study.repeats).flat_map(|_| worlds.iter().map(nothing_seen)).collect();
    let places = Places::new(study, &worlds[0]);
    for (number, (report, set)) in all.into_iter().zip(sets).enumerate() {
        let place = match number.checked_sub(claims.chosen.report.steps.len()) {
            None => format!("steps[{number}].best.sensors"),
            Some(tie) => format!("nearly_as_good[{tie}].sensors"),
        };
        let wrong =
            |what: &str| Err(Issue::says(what).with_place(&*place).with_place(folder.join(PROOF)).into());
        if report.sensors.len() != set.len() {
            return wrong("differ from the poses");
        }
        for (one, &[sensor, candidate]) in report.sensors.iter().zip(set) {
            let spec = &study.sensors[sensor];
            let rest = if set.len() == 1 { nothing.clone() } else { counts.next().unwrap_or_default() };
            let score = value(choose.objective, choose.over, &rest);
            if (&one.sensor, &one.pose) != (&spec.name, &spec.candidates[candidate].name) {
                return wrong("differ from the poses");
            }
            if one.cost != spec.terms.cost || one.place != places.words(sensor, candidate) {
                return wrong(&format!("cost and place of {} differ from the study", one.sensor));
            }
            if one.score_without != score {
                return wrong(&format!(
                    "score_without of {}:{} is {}, but counted again it is {}",
                    one.sensor,
                    one.pose,
                    or_none(one.score_without),
                    or_none(score)
                ));
            }
        }
    }
    Ok(())
}
