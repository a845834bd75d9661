//! A choice of sensors with the verdicts on it.

use super::cases::Conditions;
use super::verdict::{Judgement, judgements};
use crate::view::Choice;
use perirobot_study::input::{Requirement, Study};
use perirobot_study::world::World;
use perirobot_study::world::place::Places;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::columns::{pose_names, representation_names};

/// A judged choice of sensors.
#[derive(Clone, Debug)]
pub struct JudgedSet<'a> {
    /// Its combination.
    pub combination: String,
    /// Its poses, as in results.csv.
    pub poses: String,
    /// Its representation.
    pub representation: String,
    /// The places of its sensors, in words.
    pub place: String,
    /// Its counts under each condition.
    pub conditions: Conditions,
    /// The verdict on each requirement under each condition.
    pub judgements: Vec<Judgement<'a>>,
    /// What speaks against the verdicts: latches that are not proven to hold, and switches that something fixed trips.
    pub caveats: Vec<String>,
}

impl<'a> JudgedSet<'a> {
    /// Judges a choice of a sweep.
    pub fn new(
        requirements: &'a [Requirement],
        results: &Results,
        choice: &Choice,
        conditions: Conditions,
    ) -> JudgedSet<'a> {
        let combination = &results.combinations[choice.combination];
        JudgedSet {
            combination: combination.name.clone(),
            poses: combination.name_of(choice.choice),
            representation: combination.representations[choice.representation].clone(),
            place: combination.place_of(choice.choice),
            judgements: judgements(requirements, &results.baselines, &conditions),
            conditions,
            caveats: Vec::new(),
        }
    }

    /// Judges a choice of a study without a sweep: [`crate::view::with_set`].
    pub(super) fn not_swept(
        (study, worlds): (&'a Study, &[World]),
        choice: &Choice,
        conditions: Conditions,
    ) -> JudgedSet<'a> {
        let combination = &study.combinations[choice.combination];
        let baselines: Vec<_> = worlds.iter().map(|world| world.baselines.clone()).collect();
        JudgedSet {
            combination: combination.name.clone(),
            poses: pose_names(study, combination, choice.choice),
            representation: representation_names(study, combination).swap_remove(choice.representation),
            place: Places::new(study, &worlds[0]).describe_choice(combination, choice.choice),
            judgements: judgements(&study.requirements, &baselines, &conditions),
            conditions,
            caveats: Vec::new(),
        }
    }

    /// Whether all requirements are met.
    pub fn meets_all(&self) -> bool {
        self.judgements.iter().all(|judgement| judgement.is_met)
    }
}
