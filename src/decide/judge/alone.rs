//! Judges one set that was not swept.

use super::cases::Conditions;
use super::counting::{count_cases, count_plan};
use super::draws::Draws;
use super::judged::JudgedSet;
use super::measuring::measure_cases;
use super::near::SharedGround;
use super::scope::counted_conditions;
use super::what_if::WhatIf;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::backend::factory::{BackendChoice, BackendFactory, ChosenBackends, Fallback};
use perirobot_march::progress::Progress;
use perirobot_study::input::{Condition, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;

/// Judges a choice of a study without a sweep, with a new backend.
///
/// # Errors
/// If a backend fails; if no mount can move from its planned place; if something cannot be computed; `Error::Stopped`.
pub(crate) fn judge_alone<'a>(
    study: &'a Study,
    worlds: &[World],
    choice: &Choice,
    open: &dyn Fn() -> Result<ChosenBackends>,
    progress: &dyn Progress,
) -> Result<JudgedSet<'a>> {
    judge_set(study, worlds, choice, &mut open()?, progress)
}

/// Judges a choice of a study without a sweep, with existing backends.
///
/// # Errors
/// As for [`judge_alone`].
pub fn judge_set<'a>(
    study: &'a Study,
    worlds: &[World],
    choice: &Choice,
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<JudgedSet<'a>> {
    let what_if = [WhatIf::new(study, worlds, choice)];
    let grounds = SharedGround::of_choices(&what_if)?;
    let subject = Subject::from_study(study, worlds);
    let mut conditions = [count_plan(&what_if[0], &subject, backends, progress)?];
    let conditions_of_study = counted_conditions(study);
    let open = || ChosenBackends::open(&BackendChoice::default()).map(|(backends, _)| backends);
    add_cases(
        &what_if,
        &mut conditions,
        (&conditions_of_study, &grounds),
        (Some(backends), &open),
        progress,
    )?;
    let [conditions] = conditions;
    Ok(JudgedSet::not_swept((study, worlds), choice, conditions))
}

/// Adds the cases of some conditions to the planned counts of choices, with the approaches in each, and the
/// measurements of a controller: work common to choices is done once. Returns the drawn mounts, if any. Without
/// backends only the plan is counted.
///
/// # Errors
/// Those of [`count_cases`], [`SharedGround::come_near`] and [`measure_cases`].
pub(super) fn add_cases(
    what_ifs: &[WhatIf],
    conditions: &mut [Conditions],
    (asked, grounds): (&[Condition], &[SharedGround]),
    (mut backends, open): (Option<&mut dyn BackendFactory>, &dyn Fn() -> Result<ChosenBackends>),
    progress: &dyn Progress,
) -> Result<Option<Draws>> {
    let drawn = match &mut backends {
        Some(backends) if !asked.is_empty() => count_cases(what_ifs, asked, conditions, *backends, progress)?,
        _ => None,
    };
    for ground in grounds {
        ground.come_near(what_ifs, conditions, drawn.as_ref(), progress)?;
    }
    if what_ifs.first().is_some_and(|what_if| what_if.study.stopping.is_some()) {
        let mut own;
        let backends: &mut dyn BackendFactory = match backends {
            Some(backends) => backends,
            None => {
                own = open()?;
                &mut own
            }
        };
        let mut backend = backends.open(Fallback::None)?;
        measure_cases(what_ifs, conditions, drawn.as_ref(), &mut *backend, progress)?;
        backends.take_back(backend);
    }
    Ok(drawn)
}
