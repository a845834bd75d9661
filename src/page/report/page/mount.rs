//! Mounting sheets of a choice of poses. The section `instead` explains their numbers.

use maud::{Markup, PreEscaped, html};

use super::device::describe_device;
use super::sketch::Sketch;
use super::sketch::compass::compass;
use super::surroundings::{LowerObject, Surroundings, WAYS};
use crate::letters::letter;
use perirobot_study::input::Study;
use perirobot_study::sensor::turned::Turned;
use perirobot_study::sensor::{Setting, Stance};
use perirobot_study::world::World;
use perirobot_study::world::near::{lens_of, near_blindness};
use perirobot_study::world::place::room_m;

/// The mounting sheet of one sensor.
#[derive(Debug)]
pub(super) struct MountSheet {
    /// Its letter in the floor plan.
    pub(super) letter: String,
    pub(super) sensor: String,
    pub(super) pose: String,
    /// Measured quantities, with their values.
    pub(super) lines: Vec<(String, String)>,
    /// Plan and elevation of a sensor mounted in the cell.
    pub(super) sketches: Vec<String>,
    /// The device, for an order.
    pub(super) device: String,
}

impl MountSheet {
    /// Its table.
    pub(super) fn view(&self) -> Markup {
        html! {
            table.sheet {
                caption { "Mounting sheet " (self.letter) ": " (self.sensor) ", " (self.pose) }
                @for (name, value) in &self.lines { tr { th scope="row" { (name) } td { (value) } } }
                @if !self.device.is_empty() { tr { th scope="row" { "device" } td { (self.device) } } }
            }
        }
    }
}

impl MountSheet {
    /// Its table, with its drawings.
    pub(super) fn view_with_sketches(&self) -> Markup {
        html! {
            div.mount {
                (self.view())
                div.sketches { @for sketch in &self.sketches { (PreEscaped(sketch)) } }
            }
        }
    }
}

/// How to read the sheets, with the compass of pan.
pub(super) fn explain_sheets() -> Markup {
    html! {
        div.explained {
            (PreEscaped(compass()))
            p.hint {
                "Distances are to the next surface along each axis, in the scene’s files and not in voxels, people and robots \
                 left out. The thick line shows the sensor’s direction of view. Pan is counted from x to y, seen from above; tilt is \
                 above or below the horizon. A dashed line is a distance to something lower, at the height where that ends. Grey areas are objects, blue ones robots; in red \
                 ones a body is too near to be seen."
            }
        }
    }
}

/// A sheet for each sensor of a choice that has a mount or a setting.
pub(super) fn sheets(
    (study, worlds): (&Study, &[World]),
    surroundings: &Surroundings,
    combination: usize,
    choice: usize,
) -> Vec<MountSheet> {
    let spec = &study.combinations[combination];
    let candidates = spec.choice(choice);
    let members = spec.members.iter().zip(candidates).enumerate();
    members
        .filter_map(|(number, (member, candidate))| {
            sheet((study, worlds), surroundings, letter(number), (member.sensor, candidate))
        })
        .collect()
}

fn sheet(
    (study, worlds): (&Study, &[World]),
    surroundings: &Surroundings,
    letter: String,
    (number, candidate): (usize, usize),
) -> Option<MountSheet> {
    let sensor = &study.sensors[number];
    let named = &sensor.candidates[candidate];
    let mut sketches = Vec::new();
    let text = |name: &str, value: String| (name.to_string(), value);
    let lines = match (named.setting, &sensor.on) {
        (Setting::Fixed, _) => return None,
        (Setting::Inflation(metres), _) => vec![text("senses up to", format!("{metres:.3} m"))],
        (Setting::Pose(pose), on) => {
            let p = pose.position_m;
            let level = sensor.kind.stance() == Stance::Level;
            let what = if level { "corner" } else { "position" };
            let mut lines = vec![text(what, format!("x {:.3} m, y {:.3} m, z {:.3} m", p.x, p.y, p.z))];
            match on {
                Some(link) => lines.push(text("mounted on", format!("{}, link {}", link.object, link.link))),
                None => {
                    let objects = surroundings.objects();
                    let found = |next: Option<(f64, usize)>| match next {
                        Some((metres, object)) => format!("{metres:.3} m to {}", objects[object]),
                        None => "nothing".into(),
                    };
                    let around = surroundings.measure(p);
                    let mut lengths = around.map(found);
                    let lower = surroundings.measure_lower(p, &around);
                    for (length, lower) in lengths.iter_mut().zip(lower) {
                        let Some(LowerObject { away_m, below_m, object }) = lower else { continue };
                        *length += &format!(
                            "; {away_m:.3} m to {}, which ends {below_m:.3} m lower",
                            objects[object]
                        );
                    }
                    lines.extend(WAYS.iter().zip(lengths).map(|(way, next)| text(way, next)));
                    let lens = lens_of(sensor, &named.setting);
                    let near_m = lens.map_or(Vec::new(), |lens| lens.near_parts_m());
                    let sketch = Sketch {
                        letter: &letter,
                        pose: &pose,
                        stance: sensor.kind.stance(),
                        room_m: room_m(&worlds[0].truth()),
                        around: &around,
                        lower: &lower,
                        names: &objects,
                        things: surroundings.things(),
                        near_m: &near_m,
                    };
                    sketches = sketch.views().into();
                }
            }
            let turned = Turned::new(&pose);
            let turns = [
                ("pan", format!("{:.1}°", turned.pan_deg)),
                ("tilt", describe_tilt(turned.tilt_deg)),
                ("roll", format!("{:.1}°", turned.roll_deg)),
            ];
            let turns = turns.into_iter().take(if level { 1 } else { 3 });
            lines.extend(turns.map(|(name, value)| text(name, value)));
            if let Some(near) = near_blindness(study, &worlds[0], [number, candidate]) {
                let regions = near.describe_regions(study).unwrap_or_else(|| "no part of a region".into());
                let distance = near.describe_distance();
                let floor = near.describe_floor().map(|floor| format!(", {floor}")).unwrap_or_default();
                lines.push(text("blind near the lens", format!("{distance}: {regions}{floor}")));
            }
            lines
        }
    };
    let device = describe_device(study, &sensor.name);
    Some(MountSheet {
        letter,
        sensor: sensor.name.clone(),
        pose: named.name.clone(),
        lines,
        sketches,
        device,
    })
}

/// A tilt with its direction.
fn describe_tilt(tilt_deg: f64) -> String {
    let degrees = format!("{:.1}°", tilt_deg.abs());
    match degrees.as_str() {
        "0.0°" => format!("{degrees}, level"),
        _ if tilt_deg < 0.0 => format!("{degrees} down"),
        _ => format!("{degrees} up"),
    }
}

#[cfg(test)]
mod tests {
    use super::describe_tilt;

    #[test]
    fn a_tilt_is_up_down_or_level() {
        let found = [-50.0, 12.34, 0.0, -0.04].map(describe_tilt);
        assert_eq!(found, ["50.0° down", "12.3° up", "0.0°, level", "0.0°, level"]);
    }
}
