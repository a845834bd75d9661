//! Finds sets for the planner as `perirobot choose` does, and reports them as they are found. Sensors that a person placed
//! stay if the page asks for that.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use perirobot_decide::cheapest::{PurchasePoint, Purchasing};
use perirobot_decide::choose::{CastEvidence, Casting, Choosing, Found, MEMORY_BYTES, SearchEnding};
use perirobot_march::backend::factory::{BackendChoice, ChosenBackends};
use perirobot_march::progress::{Progress, SearchState};
use perirobot_march::{Error, Result};
use perirobot_page::report::purchased;
use perirobot_study::input::{Study, Wanted};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use perirobot_sweep::scoring::check::ONE_IN;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// What is to be found.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FindRequest {
    /// `cost`, or a score as in `[choose]`; without it what the study asks for.
    objective: Option<String>,
    /// The region of a score.
    region: Option<String>,
    /// How many sensors a set may have.
    at_most: Option<i64>,
    /// What a set may cost.
    budget: Option<f64>,
    /// With the cost: of what else, as in `[choose]`.
    front: Option<String>,
    /// Names of poses that are in every set, as in `camera:wall/1/0`.
    #[serde(default)]
    pub keep: Vec<String>,
}

/// What a search reports.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum FindEvent {
    /// So much of a stage is done.
    Stage {
        /// Its name.
        what: &'static str,
        /// How many things are done.
        done: u64,
        /// Of how many.
        total: u64,
    },
    /// The search within some limits.
    Bound {
        /// How many sensors a set may have.
        at_most: usize,
        /// What it may cost.
        budget: Option<f64>,
        /// The score, or the cost, of the best set so far.
        best: Option<f64>,
        /// What no set is beyond.
        bound: Option<f64>,
    },
    /// A set.
    Point {
        /// For what it is the best.
        title: String,
        /// Names of its poses.
        poses: Vec<String>,
        /// What it costs.
        cost: Option<f64>,
        /// Its score, if a score decided.
        score: Option<f64>,
        /// What no set is beyond, if that is known and not its own value.
        bound: Option<f64>,
        /// Whether it is proven to be the best.
        proven: bool,
    },
    /// Why there is no set for something.
    NoSet {
        /// For what.
        title: String,
        /// Whether it is proven that there is none.
        proven: bool,
        /// Why, and what could help.
        reasons: Vec<String>,
    },
    /// The end.
    Done {
        /// The answer in a sentence.
        words: String,
        /// Whether the search was stopped before its end.
        stopped: bool,
    },
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
        put("objective", self.objective.clone().map(Value::from));
        put("region", self.region.clone().map(Value::from));
        put("at_most", self.at_most.map(Value::from));
        put("budget", self.budget.map(Value::from));
        put("front", self.front.clone().map(Value::from));
        if !self.keep.is_empty() {
            put("always", Some(self.keep.clone().into()));
        }
        keys
    }
}

/// Listens to a search.
struct FindListener<'a> {
    emit: &'a (dyn Fn(FindEvent) + Sync),
    stop: &'a AtomicBool,
    stage: std::sync::Mutex<(&'static str, u64, u64)>,
}

impl FindListener<'_> {
    fn begin(&self, what: &'static str, total: u64) {
        *self.lock() = (what, 0, total);
        (self.emit)(FindEvent::Stage { what, done: 0, total });
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, (&'static str, u64, u64)> {
        self.stage.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Progress for FindListener<'_> {
    fn stop_reason(&self) -> Option<String> {
        self.stop.load(Ordering::Relaxed).then(|| "stopped on the page".into())
    }

    fn advance(&self, more: u64) {
        let (what, done, total) = {
            let mut stage = self.lock();
            stage.1 += more;
            *stage
        };
        // Two hundred reports of a stage are enough for a bar.
        let each = (total / 200).max(1);
        if done == total || done / each != (done - more) / each {
            (self.emit)(FindEvent::Stage { what, done, total });
        }
    }

    fn show_search(&self, state: &SearchState) {
        let budget = state.budget.map(|budget| Cost::from_thousandths(budget).amount());
        let SearchState { at_most, best, bound, .. } = *state;
        (self.emit)(FindEvent::Bound { at_most, budget, best, bound });
    }
}

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
    let listener = FindListener { emit, stop, stage: std::sync::Mutex::new(("", 0, 0)) };
    let ended = match &study.choose {
        Some(Wanted::Cheapest(_)) => cheapest(&study, worlds, backend, evidence, &listener),
        _ => best(&study, worlds, backend, evidence, &listener),
    };
    match ended {
        Err(Error::Stopped(_)) => {
            emit(FindEvent::Done { words: "stopped before any set was found".into(), stopped: true });
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
) -> Result<Vec<perirobot_cover::CandidateEvidence>> {
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
    for point in &report.points {
        (listener.emit)(point_event(point));
    }
    let words = purchased::sentence(&report, None);
    (listener.emit)(FindEvent::Done { words, stopped: report.stopped });
    Ok(())
}

fn point_event(point: &PurchasePoint) -> FindEvent {
    let title = purchased::describe_aim(&point.aim);
    match &point.set {
        Some(set) => {
            let poses = set.sensors.iter().map(|one| format!("{}:{}", one.sensor, one.pose));
            let bound = point.no_set_below.filter(|_| !point.proven).map(Cost::amount);
            FindEvent::Point {
                title,
                poses: poses.collect(),
                cost: Some(set.cost.amount()),
                score: set.score,
                bound,
                proven: point.proven,
            }
        }
        None => FindEvent::NoSet {
            title,
            proven: point.proven,
            reasons: point.reasons.iter().map(|one| format!("{}: {}", one.requirement, one.why)).collect(),
        },
    }
}

fn best(
    study: &Study,
    worlds: &[World],
    backend: &BackendChoice,
    folder: &Path,
    listener: &FindListener,
) -> Result<()> {
    let choosing = Choosing::new(study, worlds, MEMORY_BYTES)?;
    let mut backends = ChosenBackends::open(backend)?.0;
    let casting = casting(folder, |folder, restart| choosing.begin_casting(folder, restart))?;
    let evidence = cast(casting, &mut backends, listener)?.remove(0);
    listener.begin("sets", 0);
    let Some(Found { outcome, ending }) = choosing.search(&evidence, &mut backends, listener)? else {
        let words = "stopped before any set was found".into();
        (listener.emit)(FindEvent::Done { words, stopped: true });
        return Ok(());
    };
    if let SearchEnding::Failed(error) = ending {
        return Err(error);
    }
    let report = &outcome.chosen.report;
    for step in &report.steps {
        let sensors = step.best.poses.len();
        (listener.emit)(FindEvent::Point {
            title: format!("{sensors} {}", if sensors == 1 { "sensor" } else { "sensors" }),
            poses: step.best.poses.clone(),
            cost: step.best.cost.map(Cost::amount),
            score: Some(step.best.score),
            bound: step.no_set_is_above.filter(|_| !step.proven),
            proven: step.proven,
        });
    }
    let words = match report.best() {
        Some(step) if step.proven => format!("best score {:.4}, proven", step.best.score),
        Some(step) => match step.no_set_is_above {
            Some(bound) => format!("best score so far {:.4}; no set is above {bound:.4}", step.best.score),
            None => format!("best score so far {:.4}", step.best.score),
        },
        None => "no set was found".into(),
    };
    (listener.emit)(FindEvent::Done { words, stopped: report.stopped });
    Ok(())
}
