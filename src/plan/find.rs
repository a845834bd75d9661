//! Finds sets for the planner as `perirobot choose` does, and reports them as they are found. Sensors that a person placed
//! stay if the page asks for that.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use perirobot_cover::CandidateEvidence;
use perirobot_decide::cheapest::Purchasing;
use perirobot_decide::choose::{CastEvidence, Casting, Choosing, Found, MEMORY_BYTES, SearchEnding};
use perirobot_march::backend::factory::{BackendChoice, ChosenBackends};
use perirobot_march::{Error, Result};
use perirobot_page::report::purchased;
use perirobot_study::input::{Study, Wanted};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use perirobot_sweep::scoring::check::ONE_IN;
use serde::Deserialize;
use toml::{Table, Value};

mod event;
mod listener;

pub use event::{FindEvent, FoundPoint, FoundSensor};

use event::placed_in;
use listener::FindListener;

/// What is to be found.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FindRequest {
    ask: Asked,
    /// The score.
    score: Option<String>,
    /// The region in which it is counted.
    region: Option<String>,
    /// How many sensors a set may have.
    at_most: Option<i64>,
    /// What a set may cost.
    budget: Option<f64>,
    /// Poses that are in every set, as in `camera:wall/1/0`.
    #[serde(default)]
    keep: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Asked {
    /// The cheapest set that passes.
    Cheapest,
    /// The best set by a score.
    Score,
}

impl FindRequest {
    /// The keys of `[choose]` that it stands for.
    fn keys(&self) -> Table {
        let mut keys = Table::new();
        let mut put = |key: &str, value: Option<Value>| {
            if let Some(value) = value {
                keys.insert(key.into(), value);
            }
        };
        let objective = match self.ask {
            Asked::Cheapest => Some("cost".into()),
            Asked::Score => self.score.clone(),
        };
        put("objective", objective.map(Value::from));
        put("region", self.region.clone().filter(|_| self.ask == Asked::Score).map(Value::from));
        put("at_most", self.at_most.map(Value::from));
        put("budget", self.budget.map(Value::from));
        if !self.keep.is_empty() {
            put("always", Some(self.keep.clone().into()));
        }
        keys
    }
}

/// What is said if nothing was found before a stop.
const NOTHING_YET: &str = "Stopped before any set was found.";

/// Finds sets of a study. Evidence is kept in a folder, so that another question casts nothing again.
///
/// # Errors
/// What is wrong with the question; those of the backend.
pub fn find(
    (study, worlds): (&Study, &[World]),
    request: &FindRequest,
    backend: &BackendChoice,
    evidence: &Path,
    stop: &AtomicBool,
    emit: &(dyn Fn(FindEvent) + Sync),
) -> Result<()> {
    let study = study.asking(request.keys())?;
    let listener = FindListener::new(emit, stop);
    let ended = match &study.choose {
        Some(Wanted::Cheapest(_)) => cheapest(&study, worlds, backend, evidence, &listener),
        _ => best(&study, worlds, backend, evidence, &listener),
    };
    match ended {
        Err(Error::Stopped(_)) => {
            listener.end(NOTHING_YET.into(), true);
            Ok(())
        }
        other => other,
    }
}

/// Opens the evidence in a folder, anew if it is of something else.
fn casting<'a>(
    folder: &Path,
    begin: impl Fn(Option<&Path>, bool) -> Result<Casting<'a>>,
) -> Result<Casting<'a>> {
    begin(Some(folder), false).or_else(|_| begin(Some(folder), true))
}

fn cast(
    casting: Casting,
    backends: &mut ChosenBackends,
    listener: &FindListener,
) -> Result<Vec<CandidateEvidence>> {
    listener.begin("poses cast", casting.remaining());
    let CastEvidence { of_regions, .. } = casting.finish(backends, ONE_IN, listener)?;
    Ok(of_regions)
}

fn cheapest(
    study: &Study,
    worlds: &[World],
    backend: &BackendChoice,
    folder: &Path,
    listener: &FindListener,
) -> Result<()> {
    let Some(Wanted::Cheapest(purchase)) = &study.choose else { return Ok(()) };
    let open = || Ok(ChosenBackends::open(backend)?.0);
    let purchasing = Purchasing::new(study, purchase, worlds, MEMORY_BYTES)?;
    let mut backends = open()?;
    let casting = casting(folder, |folder, restart| purchasing.begin_casting(folder, restart))?;
    let evidence = cast(casting, &mut backends, listener)?;
    listener.begin("looks", purchasing.looks());
    let ways = purchasing.look(listener)?;
    listener.begin("sets", 0);
    let report = purchasing.search(&evidence, &ways, &open, listener)?;
    let mut words = purchased::sentence(&report, None);
    // The sets themselves were reported as they were found.
    for point in report.points.iter().filter(|point| point.set.is_none()) {
        let title = purchased::describe_aim(&point.aim);
        let reasons = point.reasons.iter().map(|one| format!("{}: {}", one.requirement, one.why));
        let reasons = reasons.collect::<Vec<_>>().join("; ");
        let why = if reasons.is_empty() { "no set was found so far" } else { &reasons };
        words += &format!("; {title}: {why}");
    }
    let bound = report.main().no_set_below.map(Cost::amount);
    (listener.emit)(FindEvent::Bound { cost: bound, score: None });
    listener.end(words, report.stopped);
    Ok(())
}

fn best<'a>(
    study: &'a Study,
    worlds: &'a [World],
    backend: &BackendChoice,
    folder: &Path,
    listener: &FindListener<'a>,
) -> Result<()> {
    let choosing = Choosing::new(study, worlds, MEMORY_BYTES)?;
    let mut backends = ChosenBackends::open(backend)?.0;
    let casting = casting(folder, |folder, restart| choosing.begin_casting(folder, restart))?;
    let evidence = cast(casting, &mut backends, listener)?.remove(0);
    listener.begin("sets", 0);
    let at_most = match &study.choose {
        Some(Wanted::Best(choose)) => choose.at_most,
        _ => 0,
    };
    listener.set_names((study, &worlds[0]), &evidence.items, at_most);
    let Some(Found { outcome, ending }) = choosing.search(&evidence, &mut backends, listener)? else {
        listener.end(NOTHING_YET.into(), true);
        return Ok(());
    };
    if let SearchEnding::Failed(error) = ending {
        return Err(error);
    }
    let report = &outcome.chosen.report;
    let front = report.steps.iter().map(|step| {
        let sensors = step.best.sensors.iter();
        let (placed, words) = placed_in(sensors.map(|one| [&one.sensor, &one.pose, &one.place]));
        FoundPoint {
            part: None,
            cost: step.best.cost.map(Cost::amount),
            score: Some(step.best.score),
            words,
            placed,
            is_proven: step.proven,
        }
    });
    (listener.emit)(FindEvent::Front(front.collect()));
    if let Some(step) = report.best() {
        (listener.emit)(FindEvent::Bound { cost: None, score: step.no_set_is_above });
    }
    let words = match report.best() {
        Some(step) if step.proven => format!("Best score {:.4}: proven, no set is better.", step.best.score),
        Some(step) => match step.no_set_is_above {
            Some(bound) => format!("Best score so far {:.4}; no set is above {bound:.4}.", step.best.score),
            None => format!("Best score so far {:.4}.", step.best.score),
        },
        None => "No set was found.".into(),
    };
    listener.end(words, report.stopped);
    Ok(())
}
