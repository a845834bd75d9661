//! Recounts the first candidates of a device and then a small share on the CPU: a faulty driver is found before its
//! evidence decides the best set.

use perirobot_cover::CandidateEvidence;
use perirobot_cover::layout::WantedCounts;
use perirobot_march::backend::Backend;
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Combination, Member, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::{check::AT_LEAST, run};

/// Recounts the first candidates and then one in `every`, each alone, in all worlds, and compares the wanted counts of
/// each region with its evidence. `representations` is the representation of each sensor. Returns the number of
/// recounted poses.
///
/// # Errors
/// `Error::Disagreement` that names the first pose with different counts; those of the backend.
pub fn count_again(
    regions: &[((usize, WantedCounts), &CandidateEvidence)],
    (study, worlds): (&Study, &[World]),
    representations: &[usize],
    backend: &mut dyn Backend,
    every: u64,
) -> Result<u64> {
    let items = regions.first().map_or(&[][..], |(_, evidence)| &evidence.items);
    let is_picked = |&item: &usize| (item as u64) < AT_LEAST || (item as u64).is_multiple_of(every);
    let picked: Vec<usize> = (0..items.len()).filter(is_picked).collect();
    let alone = |&item: &usize| {
        let [sensor, candidate] = items[item];
        let spec = &study.sensors[sensor];
        Combination {
            name: format!("{}:{}", spec.name, spec.candidates[candidate].name),
            fusion: Default::default(),
            members: vec![Member { sensor, candidates: vec![candidate] }],
        }
    };
    let alone = study.with_combinations(representations, picked.iter().map(alone).collect());
    let mut rows = run(&alone, worlds, backend)?;
    rows.sort_by_key(|row| row.repeat);
    for (number, &item) in picked.iter().enumerate() {
        for &((region, wanted), evidence) in regions {
            let again = rows.iter().filter(|row| row.combination == number && row.region == region);
            let again = again.map(|row| values(&row.counts, wanted));
            if !again.eq(evidence.counts(&[item]).iter().map(|counts| values(counts, wanted))) {
                let pose = &alone.combinations[number].name;
                let what = format!("the device and the CPU disagree about {pose}: nothing was searched");
                let cure = Words::from("run again with ")
                    + Argument("backend").with_value("cpu")
                    + ", and `perirobot verify-backends` to see more";
                return Err(Error::Disagreement(Issue::says(what).cure(cure)));
            }
        }
    }
    Ok(picked.len() as u64)
}

/// The values of the wanted counts.
fn values(counts: &Confusion, wanted: WantedCounts) -> impl PartialEq {
    let Confusion { tp, fp, fn_, tn, uo, uf, human, robot, detection, .. } = *counts;
    (
        wanted.labels.then_some([tp, fp, fn_, tn, uo, uf]),
        wanted.roles.then_some([human, robot]),
        wanted.people.then_some(detection),
    )
}
