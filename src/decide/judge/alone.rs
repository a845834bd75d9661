//! One set that was not swept, judged.

use super::cases::Conditions;
use super::draws::Draws;
use super::judged::JudgedSet;
use super::scope::counted_conditions;
use super::what_if::WhatIf;
use crate::approach::Ground;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::backend::factory::{BackendChoice, BackendFactory, ChosenBackends, Fallback};
use perirobot_march::progress::Progress;
use perirobot_study::input::{Condition, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;

/// Judges a choice of a study of which nothing was swept, with a backend that is opened for it.
///
/// # Errors
/// When a backend fails; when no mount can be anywhere but where it is planned; when something cannot be asked;
/// `Error::Stopped`.
pub(crate) fn judge_alone<'a>(
    study: &'a Study,
    worlds: &[World],
    choice: &Choice,
    open: &dyn Fn() -> Result<ChosenBackends>,
    progress: &dyn Progress,
) -> Result<JudgedSet<'a>> {
    judge_set(study, worlds, choice, &mut open()?, progress)
}

/// Judges a choice of a study of which nothing was swept, with backends that may have done other work.
///
/// # Errors
/// As of [`judge_alone`].
pub fn judge_set<'a>(
    study: &'a Study,
    worlds: &[World],
    choice: &Choice,
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<JudgedSet<'a>> {
    let what_if = WhatIf::new(study, worlds, choice);
    let grounds = what_if.grounds()?;
    let planned = what_if.count_plan(&Subject::from_study(study, worlds), backends, progress)?;
    let asked = counted_conditions(study);
    let open = || ChosenBackends::open(&BackendChoice::default()).map(|(backends, _)| backends);
    let (conditions, _) = what_if.add_cases(planned, &asked, &grounds, (Some(backends), &open), progress)?;
    Ok(JudgedSet::not_swept((study, worlds), choice, conditions))
}

impl<'a> WhatIf<'a> {
    /// What was counted as planned, with the cases of some conditions, how near bodies come in each, and what a controller
    /// would measure; and the mounts that were drawn, if any were. Without backends nothing but the plan is counted.
    ///
    /// # Errors
    /// Those of [`WhatIf::count`], [`WhatIf::come_near`] and [`WhatIf::measure`].
    pub(super) fn add_cases(
        &self,
        mut conditions: Conditions,
        asked: &[Condition],
        grounds: &[Ground],
        (mut backends, open): (Option<&mut dyn BackendFactory>, &dyn Fn() -> Result<ChosenBackends>),
        progress: &dyn Progress,
    ) -> Result<(Conditions, Option<Draws>)> {
        let drawn = match &mut backends {
            Some(backends) if !asked.is_empty() => self.count(asked, &mut conditions, *backends, progress)?,
            _ => None,
        };
        self.come_near(grounds, &mut conditions, drawn.as_ref(), progress)?;
        if self.study.stopping.is_some() {
            let mut own;
            let backends: &mut dyn BackendFactory = match backends {
                Some(backends) => backends,
                None => {
                    own = open()?;
                    &mut own
                }
            };
            let mut backend = backends.open(Fallback::None)?;
            self.measure(&mut conditions, drawn.as_ref(), &mut *backend, progress)?;
            backends.take_back(backend);
        }
        Ok((conditions, drawn))
    }
}
