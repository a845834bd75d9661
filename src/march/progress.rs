//! How a long job reports its progress, and how it is stopped. The command line and Python each implement it once.

use serde::{Deserialize, Serialize};

use crate::backend::Backend;
use crate::error::Issue;
use crate::{Error, Result};

/// Follows a long job, and may stop it.
pub trait Progress: Sync {
    /// A reason to begin no more work, if there is one.
    fn stop_reason(&self) -> Option<String>;

    /// Whether there is a reason to stop.
    fn stops(&self) -> bool {
        self.stop_reason().is_some()
    }

    /// Fails if there is a reason to stop.
    ///
    /// # Errors
    /// `Error::Stopped` with that reason.
    fn check_stop(&self) -> Result<()> {
        self.stop_reason().map_or(Ok(()), |why| Err(Error::Stopped(Issue::says(why))))
    }

    /// This many more things are done.
    fn advance(&self, _more: u64) {}

    /// The backend of the user's choice begins, at first or once more after a failure.
    fn show_backend(&self, _: &dyn Backend) {}

    /// A device failed, and another backend took over.
    fn show_fault(&self, _: &Fault) {}

    /// A search for sets knows this.
    fn show_search(&self, _: &SearchState) {}

    /// A search for the cheapest set knows this. It comes a few times a second at most, and at the end of each part.
    fn show_purchase(&self, _: &PurchaseState) {}
}

/// Only stops a job; its progress is ignored.
impl<F: Fn() -> Option<String> + Sync> Progress for F {
    fn stop_reason(&self) -> Option<String> {
        self()
    }
}

/// A failure, and which backend took over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// The error message of the backend.
    pub what: String,
    /// The scene that it worked on.
    pub scene: String,
    /// Which backend did the work instead.
    pub instead: String,
}

impl Fault {
    /// The failure of a device. What the user could do about it is left out, since another backend continues; a panic
    /// of its code should be reported.
    pub fn new(error: &Error, scene: impl Into<String>, instead: impl Into<String>) -> Fault {
        let issue = Issue { cures: Vec::new(), ..error.issue().clone() };
        let what = match error {
            Error::Bug(_) => format!("{issue}; please report this with the command"),
            _ => issue.to_string(),
        };
        Fault { what, scene: scene.into(), instead: instead.into() }
    }
}

/// What a search knows of the sets within some limits.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchState {
    /// How many candidates a set may have.
    pub at_most: usize,
    /// What it may cost, in thousandths.
    pub budget: Option<u64>,
    /// The worth of the best set that was found.
    pub best: Option<f64>,
    /// The candidates of that set, by their numbers in the evidence; empty where poses are tried that are not in it.
    pub set: Vec<usize>,
    /// What no set is above.
    pub bound: Option<f64>,
    /// How long these limits were searched, when a part of that search has ended.
    pub seconds: Option<f64>,
}

/// What a search for the cheapest set knows of one part of its question, such as one speed of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct PurchaseState {
    /// The number of the part, in the order in which they are searched: the first is all that is required.
    pub part: usize,
    /// What is searched, in words.
    pub title: String,
    /// How many sets were tested.
    pub tested: u64,
    /// No set that passes costs less, in thousandths; none if it is proven that none passes.
    pub no_set_below: Option<u64>,
    /// The cheapest set that passes, of those found so far.
    pub best: Option<PurchasedState>,
    /// The unit of all costs.
    pub currency: Option<String>,
    /// Whether this part has ended, and it is proven that no set is cheaper, or that none passes.
    pub is_proven: bool,
}

/// A set that passes.
#[derive(Clone, Debug, PartialEq)]
pub struct PurchasedState {
    /// What it costs, in thousandths.
    pub cost: u64,
    /// The score that decides among sets of the same cost, if there is one and it has a value.
    pub score: Option<f64>,
    /// Its sensors.
    pub sensors: Vec<PurchasedMember>,
}

/// A sensor of a set, by the names of the study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PurchasedMember {
    /// The sensor.
    pub sensor: String,
    /// Its pose.
    pub pose: String,
    /// Where that is, in words.
    pub place: String,
}
