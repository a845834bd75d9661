//! Whether sets meet what a study requires, as `perirobot judge` does it.

use std::path::Path;

use perirobot_decide::choose::as_swept;
use perirobot_decide::judge::{Judging, LeaderScope, chosen_sets, forget, leaders, requires_something};
use perirobot_decide::view::{Choice, ChoiceSelector, find};
use perirobot_march::Result;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::{Results, Subject};

use crate::backends::{BackendWords, open};
use crate::look::with_named_set;
use crate::watch::Listener;

/// Judges the sets that were chosen into a folder, and writes what `perirobot judge` writes. Once a sweep has taken their
/// place, it is the choice of that which meets most requirements.
pub(crate) fn judge(
    study: &Study,
    worlds: &[World],
    words: &BackendWords,
    listener: &Listener,
    folder: &Path,
) -> Result<()> {
    requires_something(study)?;
    let (results, warnings) = Results::read(folder)?;
    let (study, worlds) = as_swept(folder, study.clone(), worlds.to_vec())?;
    let choices = match chosen_sets(folder, &results)? {
        Some(sets) => sets,
        None => leaders(&study.requirements, &results, 1, LeaderScope::default())?,
    };
    warnings.into_iter().for_each(|warning| listener.warns_of_study(warning));
    write(&study, &worlds, (&results, &choices), words, listener, folder)
}

/// Judges a choice of poses that need not have been swept, and writes what `perirobot judge` writes into a folder.
pub(crate) fn judge_choice(
    (study, worlds): (&Study, &[World]),
    wanted: &ChoiceSelector,
    words: &BackendWords,
    listener: &Listener,
    folder: &Path,
) -> Result<()> {
    let study = with_named_set(study, wanted);
    requires_something(&study)?;
    let choice = find(&study, worlds, wanted)?.1;
    // Nothing was swept: the choice is counted as well.
    let unswept = Study { combinations: Vec::new(), ..study.clone() };
    let results = Results::from_counts(Subject::from_study(&unswept, worlds), []);
    write(&study, worlds, (&results, &[choice]), words, listener, folder)
}

/// Judges choices, and writes the verdicts.
fn write(
    study: &Study,
    worlds: &[World],
    (results, choices): (&Results, &[Choice]),
    words: &BackendWords,
    listener: &Listener,
    folder: &Path,
) -> Result<()> {
    let judging = Judging::new(study, worlds, results, choices)?;
    judging.warnings.iter().for_each(|warning| listener.warns_of_study(warning.clone()));
    for (scene, warnings) in &judging.cut_off {
        warnings.iter().for_each(|warning| listener.warns_of_study(format!("{scene}: {warning}")));
    }
    forget(folder, None)?;
    listener.begins("cases", judging.total());
    let judged = judging.judge(&|| open(words, listener), listener)?;
    judged.warnings.iter().for_each(|warning| listener.warns_of_study(warning.clone()));
    judged.caveats().into_iter().for_each(|caveat| listener.warns_of_study(caveat.into()));
    judging.write(folder, &judged).map(drop)
}
