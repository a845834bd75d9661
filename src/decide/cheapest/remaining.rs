//! Requirements without a bound: shifted mounts, other people, and measurements of a controller. A set that passes
//! everything else is judged, which casts its sensors again.

use std::collections::BTreeMap;

use perirobot_march::Result;
use perirobot_march::backend::factory::ChosenBackends;
use perirobot_march::progress::Progress;
use perirobot_study::input::{Combination, Condition, Member, Purchase, Requirement, Study};
use perirobot_study::world::World;

use super::terms::Terms;
use crate::judge::judge_alone;
use crate::view::Choice;

/// Opens backends.
pub(super) type OpenBackends<'t> = &'t dyn Fn() -> Result<ChosenBackends>;

/// Judges the remaining requirements of sets.
pub(super) struct Remaining<'t> {
    /// The study with only these requirements; `None` if there are none.
    study: Option<Study>,
    worlds: &'t [World],
    purchase: &'t Purchase,
    /// Sensor and candidate index of each candidate of the search.
    items: &'t [[usize; 2]],
    open: OpenBackends<'t>,
    progress: &'t dyn Progress,
    judged: BTreeMap<Vec<usize>, bool>,
}

impl<'t> Remaining<'t> {
    pub(super) fn new(
        (study, purchase, worlds): (&Study, &'t Purchase, &'t [World]),
        terms: &Terms,
        items: &'t [[usize; 2]],
        open: OpenBackends<'t>,
        progress: &'t dyn Progress,
    ) -> Remaining<'t> {
        let requirements = terms.remaining();
        let is_under = |condition| requirements.iter().any(|one| one.under.contains(&condition));
        let [is_off, others_stand] = [Condition::MountingError, Condition::Postures].map(is_under);
        let is_near = requirements.iter().any(Requirement::is_of_nearness);
        let is_measured = is_near || requirements.iter().any(Requirement::is_of_controller);
        let study = (!requirements.is_empty()).then(|| Study {
            mounting_error: study.mounting_error.filter(|_| is_off),
            postures: if others_stand { study.postures.clone() } else { Vec::new() },
            stopping: terms.stopping.clone().filter(|_| is_measured),
            has_approach: study.has_approach && is_near,
            requirements,
            ..study.clone()
        });
        Remaining { study, worlds, purchase, items, open, progress, judged: BTreeMap::new() }
    }

    /// Whether a set with at least one member passes.
    ///
    /// # Errors
    /// If a backend fails; `Error::Stopped`.
    pub(super) fn passes(&mut self, set: &[usize]) -> Result<bool> {
        let Some(study) = &self.study else { return Ok(true) };
        if let Some(&known) = self.judged.get(set) {
            return Ok(known);
        }
        let combination = combination(study, self.purchase, self.items, String::new(), set);
        let study = study.with_combinations(&self.purchase.representations, vec![combination]);
        let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
        let passes = judge_alone(&study, self.worlds, &choice, self.open, self.progress)?.meets_all();
        self.judged.insert(set.to_vec(), passes);
        Ok(passes)
    }
}

/// A set as a combination with one choice of poses.
pub(super) fn combination(
    study: &Study,
    purchase: &Purchase,
    items: &[[usize; 2]],
    name: String,
    set: &[usize],
) -> Combination {
    let mut members: Vec<[usize; 2]> = set.iter().map(|&item| items[item]).collect();
    // In a combination, the sensor that takes precedence is last.
    members.sort_by_key(|&[sensor, _]| study.sensors[sensor].kind.speaks_last());
    let member = |[sensor, candidate]: [usize; 2]| Member { sensor, candidates: vec![candidate] };
    Combination { name, fusion: purchase.fusion, members: members.into_iter().map(member).collect() }
}
