//! Whether a choice of sensors is good enough: requirements that pass or fail, as planned and in altered cases.
//!
//! # Theory
//! A condition has cases: one as planned, one for each sensor that may be dead, one for each draw of mounts, one for
//! each person at a spot. A requirement is met under a condition if it is met in each of its cases. Every value is a
//! fraction of counts, a mean of fractions, a distance by its square, or a difference of two, and is compared with the
//! limit exactly.
//!
//! # Practice
//! - Cases: `scope` has the conditions of a study, `cases` the counts of each case, `alteration` its difference to the plan.
//!   `what_if` is a choice, `counting` makes its cases by leaving sensors out, by `draws` of mounts and by `postures` of
//!   people; `alter` makes a case a study of its own. Work common to several choices is done once.
//! - Added to each case: `near` adds approaches, `measuring` the distances that a [`controller`](crate::controller)
//!   measures.
//! - Verdicts: `value` compares scores, `verdict` decides, `speed` decides at each speed of the robot, `spread` sums up
//!   the scores under a condition, `leaders` finds the choices that meet most requirements, `cheapest` the
//!   cheapest. `judging` does all of this for the choices of a sweep, `alone` for one set that
//!   was not swept.
//! - Files: `judge_json` has verdicts and scores with their types, which the report reads; `table` and `junit` write them
//!   for other programs. `tables` has the tables of the study that decide a verdict.

mod alone;
mod alter;
mod alteration;
mod cases;
mod caveats;
mod cheapest;
mod counting;
mod draws;
mod judge_json;
mod judged;
mod judging;
mod junit;
mod leaders;
mod measuring;
mod near;
mod postures;
mod scope;
mod speed;
mod spread;
mod table;
mod tables;
mod value;
mod verdict;
mod what_if;

pub(crate) use alone::judge_alone;
pub use alone::judge_set;
pub use alter::alter;
pub use alteration::Alteration;
pub use cases::{Case, Conditions, Moment, Passage};
pub use caveats::caveats_as_planned;
pub use cheapest::cheapest;
pub use counting::count_cases;
pub use draws::Draws;
pub use judge_json::{
    AllowedSpeed, ConditionScore, JsonNumber, RequirementVerdict, SetVerdicts, Verdicts, WorstPlace,
};
pub use judged::JudgedSet;
pub use judging::{JudgeResult, Judging, forget, requires_something};
pub use junit::junit_xml;
pub use leaders::{LeaderScope, chosen_sets, leaders};
pub use measuring::measure_cases;
pub use near::nearest_approaches;
pub(crate) use near::passages;
pub use postures::check_postures;
pub use speed::Speeds;
pub(crate) use speed::requirements_at_speeds;
pub use spread::{ScoreSpread, Summed, spreads};
pub(crate) use tables::deciding_tables_sha256;
pub use tables::tables_sha256;
pub use value::Value;
pub(crate) use verdict::approach_value;
pub use verdict::{CasePart, Judgement, Where, judgements};
pub use what_if::WhatIf;
pub(crate) use what_if::dead_members;
