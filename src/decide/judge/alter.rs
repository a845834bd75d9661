//! A case as a study of its own, for commands that examine it.

use super::alteration::Alteration;
use super::postures::{PostureStudy, find_posture};
use super::what_if::WhatIf;
use crate::view::Choice;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// Makes the study and worlds of an altered choice, and the choice in them.
///
/// # Errors
/// If the choice has no sensor of a given name, or no sensor is left; if the study has no such draw or posture.
pub fn alter(
    study: &Study,
    worlds: &[World],
    choice: &Choice,
    alteration: &Alteration,
) -> Result<(Study, Vec<World>, Choice)> {
    let what_if = WhatIf::new(study, worlds, choice);
    let own = &study.combinations[choice.combination];
    let (study, worlds, members) = match alteration {
        Alteration::None => return Ok((study.clone(), worlds.to_vec(), *choice)),
        Alteration::Dead(sensors) => {
            let members = what_if.remaining_members(&what_if.dead(sensors)?);
            if members.is_empty() {
                let place = Site::Argument(Argument("dead"), sensors.join(", "));
                return Err(Error::input(place, "no sensor is left to look at"));
            }
            (study.clone(), worlds.to_vec(), members)
        }
        Alteration::Draw(draw) => {
            let place = Site::Argument(Argument("draw"), draw.to_string());
            let Some(error) = &study.mounting_error else {
                let what = Issue::says(format!("{} has no [mounting_error]", study.path.display()));
                let example = "[mounting_error] draws = 20, position_m = 0.01, angle_deg = 0.5";
                return Err(what
                    .with_advice(format!("add one to the study, as in {example}"))
                    .with_place(place)
                    .into());
            };
            if *draw >= error.draws {
                return Err(Error::input(place, format!("must be from 0 to {}", error.draws - 1)));
            }
            let draws = what_if.draws(error)?;
            let members = what_if.draw(&draws, *draw);
            (draws.study, draws.worlds, members)
        }
        Alteration::Posture(name) => {
            let posture_study = PostureStudy::new(study, worlds, find_posture(study, name)?)?;
            (posture_study.study, posture_study.worlds, what_if.members.clone())
        }
    };
    let name = format!("{}, {}", own.name, alteration.words());
    let (combination, representation) = what_if.as_combination(&study, &members, name);
    let study = Study { combinations: vec![combination], ..study };
    Ok((study, worlds, Choice { combination: 0, choice: 0, representation, repeat: choice.repeat }))
}
