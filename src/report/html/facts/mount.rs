//! Mounting sheets of a choice of poses. What the numbers mean is said in the template.

use crate::report::html::Sweep;
use crate::report::html::mounting::{Turned, distances_m, room_m};
use crate::sensor::Setting;

/// How to mount one sensor.
#[derive(Debug)]
pub(in crate::report::html) struct Sheet {
    pub(in crate::report::html) sensor: String,
    pub(in crate::report::html) pose: String,
    /// What is measured, and its value.
    pub(in crate::report::html) lines: Vec<(String, String)>,
}

/// A sheet for each sensor of a choice that is mounted somewhere, or set to something.
pub(super) fn sheets(sweep: &Sweep, combination: usize, choice: usize) -> Vec<Sheet> {
    let asked = &sweep.study.combinations[combination];
    let candidates = asked.choice(choice);
    let members = asked.members.iter().zip(candidates);
    members.filter_map(|(member, candidate)| sheet(sweep, member.sensor, candidate)).collect()
}

fn sheet(sweep: &Sweep, number: usize, candidate: usize) -> Option<Sheet> {
    let sensor = &sweep.study.sensors[number];
    let named = &sensor.candidates[candidate];
    let text = |name: &str, value: String| (name.to_string(), value);
    let lines = match (named.setting, &sensor.on) {
        (Setting::Fixed, _) => return None,
        (Setting::Inflation(metres), _) => vec![text("senses up to", format!("{metres:.3} m"))],
        (Setting::Pose(pose), on) => {
            let p = pose.position_m;
            let mut lines = vec![text("position", format!("x {:.3} m, y {:.3} m, z {:.3} m", p.x, p.y, p.z))];
            match on {
                Some(link) => lines.push(text("mounted on", format!("{}, link {}", link.object, link.link))),
                None => {
                    let distances = distances_m(p, room_m(&sweep.worlds[0].truth));
                    lines.extend(distances.map(|(name, metres)| text(name, format!("{metres:.3} m"))));
                }
            }
            let turned = Turned::of(&pose);
            let turns = [("pan", turned.pan_deg), ("tilt", turned.tilt_deg), ("roll", turned.roll_deg)];
            lines.extend(turns.map(|(name, degrees)| text(name, format!("{degrees:.1}°"))));
            lines
        }
    };
    Some(Sheet { sensor: sensor.name.clone(), pose: named.name.clone(), lines })
}
