//! Whether a choice of sensors is good enough: requirements that pass or fail, as planned and when something is
//! not as planned.
//!
//! # Theory
//! A condition has cases: one as planned, one for each sensor that may be dead, one for each draw of mounts, one for
//! each person at a spot. A requirement is met under a condition if it is met in each of its cases. Every value is a
//! fraction of counts, a mean of fractions, a distance by its square, or a difference of two, and is compared with the
//! limit exactly.
//!
//! # Practice
//! `scope` has the conditions that a study asks for; `cases` has the counts of each case, `what_if` makes them by leaving sensors out, by `draws` of mounts and by
//! `postures` of people, `near` adds how near bodies come in each, `value` and `excess` compare scores, `verdict`
//! decides, `spread` sums up how good scores are under a condition, `leaders` finds the choices that meet most
//! requirements; `judging` does all of it for the choices of a sweep. `table` and `junit` write the files, `tables` says by which tables of the study a verdict was decided.
//! Where the study says how far people must be, `speed` tells how fast the robot may run, and `separation` what a
//! controller would measure; `separations` makes that of each moment and case, and its table. `alter` makes a case
//! a study of its own.

mod alter;
mod alteration;
mod cases;
mod cheapest;
mod draws;
mod excess;
mod judged;
mod judging;
mod junit;
mod leaders;
mod near;
mod postures;
mod scope;
mod separation;
mod separations;
mod speed;
mod spread;
mod table;
mod tables;
mod value;
mod verdict;
mod what_if;

pub use alter::alter;
pub use alteration::Alteration;
pub use cases::{Case, Conditions, Moment, Passage};
pub use cheapest::cheapest;
pub use draws::Draws;
pub use excess::Excess;
pub use judged::JudgedSet;
pub use judging::{Judged, Judging, forget, requires_something};
pub use junit::junit_xml;
pub use leaders::{Among, chosen_sets, leaders};
pub use postures::check_postures;
pub use separation::{Decision, Separation, Surroundings};

pub use speed::Speeds;
pub use spread::{Spread, Summed, spreads};

pub use tables::tables_sha256;
pub use value::Value;
pub use verdict::{Judgement, Part, Where, judgements};
pub use what_if::WhatIf;
