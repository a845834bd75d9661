//! Warns of field cases of scanners that never count, over all scenes of a study.

use std::collections::BTreeSet;

use super::World;
use super::stuck::exact_station;
use crate::input::Study;

/// The cases that apply at no moment, and those before which an earlier one always counts. `worlds` are those of all scenes.
pub fn case_warnings(study: &Study, worlds: &[World]) -> Vec<String> {
    let mut warnings = Vec::new();
    for (sensor, spec) in study.sensors.iter().enumerate() {
        let names = spec.kind.as_scanner().map_or(Vec::new(), |scanner| scanner.cases());
        let Some(scanner) =
            spec.kind.as_scanner().filter(|_| !names.is_empty() && !spec.candidates.is_empty())
        else {
            continue;
        };
        let applying =
            |world: &World| scanner.applying_cases(&exact_station(world, &world.truth(), [sensor, 0]));
        let moments: Vec<Vec<usize>> = worlds.iter().map(applying).collect();
        for (case, name) in names.iter().enumerate() {
            let of_case: Vec<&Vec<usize>> = moments.iter().filter(|all| all.contains(&case)).collect();
            let before: BTreeSet<usize> = of_case.iter().map(|all| all[0]).collect();
            if of_case.is_empty() {
                warnings.push(format!(
                    "sensor {:?}: field case {name:?} applies at no moment of any scene: correct its at, scenes or speed_m_s",
                    spec.name
                ));
            } else if !before.contains(&case) {
                let before: Vec<&str> = before.iter().map(|&one| names[one]).collect();
                warnings.push(format!(
                    "sensor {:?}: field case {name:?} never counts, since an earlier one always applies, too: put it before \
                     {before:?}",
                    spec.name
                ));
            }
        }
    }
    warnings
}
