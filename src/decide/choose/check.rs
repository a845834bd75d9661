//! What a device cast is counted again on the CPU for its first candidates and then for a small share: a driver that
//! casts wrongly is found before its evidence decides which set is the best.

use perirobot_cover::CandidateEvidence;
use perirobot_march::backend::Backend;
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::metrics::{Confusion, Score};
use perirobot_march::{Error, Result};
use perirobot_study::study::{Choose, Combination, Member, Study};
use perirobot_study::world::World;
use perirobot_sweep::sweep::{check::AT_LEAST, run};

/// Counts the first candidates and then one in `every` again, each alone, in all worlds, and compares every score
/// that the study asks for. Says how many.
///
/// # Errors
/// `Error::Disagreement` that names the pose that counts otherwise; those of the backend.
pub fn count_again(
    evidence: &CandidateEvidence,
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    backend: &mut dyn Backend,
    every: u64,
) -> Result<u64> {
    let is_picked = |&item: &usize| (item as u64) < AT_LEAST || (item as u64).is_multiple_of(every);
    let picked: Vec<usize> = (0..evidence.count()).filter(is_picked).collect();
    let alone = |&item: &usize| {
        let [sensor, candidate] = evidence.items[item];
        let spec = &study.sensors[sensor];
        Combination {
            name: format!("{}:{}", spec.name, spec.candidates[candidate].name),
            fusion: choose.fusion,
            members: vec![Member { sensor, candidates: vec![candidate] }],
        }
    };
    let alone = study.with_combinations(&choose.representations, picked.iter().map(alone).collect());
    let mut rows = run(&alone, worlds, backend)?;
    rows.sort_by_key(|row| row.repeat);
    rows.retain(|row| row.region == choose.region);
    let required = choose.require.iter().map(|require| require.score);
    let scores: Vec<Score> = [choose.objective].into_iter().chain(required).collect();
    let values = |counts: &Confusion| scores.iter().map(|score| score.evaluate(counts)).collect::<Vec<_>>();
    for (number, &item) in picked.iter().enumerate() {
        let again = rows.iter().filter(|row| row.combination == number).map(|row| values(&row.counts));
        if !again.eq(evidence.counts(&[item]).iter().map(values)) {
            let pose = &alone.combinations[number].name;
            let what = format!("the device and the CPU disagree about {pose}: nothing was searched");
            let cure = Words::from("run again with ")
                + Argument("backend").with_value("cpu")
                + ", and `perirobot verify-backends` to see more";
            return Err(Error::Disagreement(Issue::says(what).cure(cure)));
        }
    }
    Ok(picked.len() as u64)
}
