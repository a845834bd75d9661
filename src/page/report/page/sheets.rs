//! The mounting sheets of one set as a separate page, for the technicians: the floor plan, and a sheet for each sensor.

use maud::{DOCTYPE, PreEscaped, html};

use super::mount::{explain_sheets, sheets};
use super::surroundings::Surroundings;
use crate::render::plan::{self, floor_plan};
use crate::report::colours::variables;
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// The browser neither runs nor fetches anything.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

/// The page of the first choice of poses of a combination. `note` is printed at its top.
///
/// # Errors
/// Those of files of the scenes.
pub fn mounting_sheets(
    study: &Study,
    worlds: &[World],
    combination: usize,
    note: Option<&str>,
) -> Result<String> {
    let surroundings = Surroundings::new(study, &worlds[0])?;
    let choice = Choice { combination, choice: 0, representation: 0, repeat: 0 };
    let of_scene = worlds.chunk_by(|one, next| one.scene == next.scene).next().unwrap_or(worlds);
    let drawing = floor_plan(study, of_scene, 0, Some(choice));
    let sheets = sheets((study, worlds), &surroundings, combination, 0);
    let name = study.path.file_stem().unwrap_or_default().to_string_lossy();
    let style = [&variables(), plan::STYLE, include_str!("style.css")].concat();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (name) " · mounting sheets" }
                style { (PreEscaped(style)) }
            }
            body {
                (PreEscaped(plan::PATTERNS))
                header { h1 { "Mounting sheets of " (name) } @if let Some(note) = note { p.warning { (note) } } }
                main {
                    (PreEscaped(drawing.inline()))
                    (explain_sheets())
                    @for sheet in &sheets { (sheet.view_with_sketches()) }
                }
            }
        }
    };
    Ok(page.into_string())
}
