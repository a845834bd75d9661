//! A controller's measurements with a set of sensors, summed up over all moments, as text.

use crate::report::table::Table;
use perirobot_decide::controller::{Decision, Separation};
use perirobot_decide::judge::JudgedSet;
use perirobot_march::voxel::rounded_up;
use perirobot_study::input::Stopping;
use perirobot_sweep::results::Subject;

/// The text for one set.
pub fn render(subject: &Subject, set: &JudgedSet, stopping: &Stopping, voxel_size_m: f64) -> String {
    let all = set.conditions.measurements();
    let moments = all.clone().count();
    let mut text =
        "\nwhat a controller would measure between people and robot, from the labels\n".to_string();
    let missed = all.clone().filter_map(|(moment, one)| Some((moment, one.missed_m(voxel_size_m)?)));
    // The first of equal ones.
    let worst = missed.reduce(|old, new| if new.1 > old.1 { new } else { old });
    if let Some((moment, metres)) = worst {
        let at = match &subject.scenes[moment.scene] {
            scene if moments > 1 => {
                format!(" (scene {}, snapshot {}, repeat {})", scene.name, moment.snapshot, moment.repeat)
            }
            _ => String::new(),
        };
        text += &match metres > 0.0 {
            true => format!(
                "  the nearest person is measured up to {} m too far away{at}\n",
                rounded_up(metres, 2)
            ),
            false => "  no measured distance is larger than the true one\n".into(),
        };
    }
    let unseen = |one: &&Separation| one.truly.is_some() && one.unknown_free.is_none();
    let unseen = all.clone().map(|(_, one)| one).filter(unseen).count();
    if unseen > 0 {
        text += &format!("  in {unseen} of {} moments people are present, but not measured\n", moments);
    }
    let mut table =
        Table::new(&["<unknown voxels", "m/s", "needed", "stops", "runs", "missed stops", "needless stops"]);
    for (taken, measured) in [
        ("taken as free", (|one| one.unknown_free) as fn(&Separation) -> Option<u32>),
        ("taken as occupied", |one| one.unknown_occupied),
    ] {
        for at in &stopping.speeds {
            let decision =
                |one: &Separation| Decision::new(measured(one), one.truly, at.needed_m, voxel_size_m);
            let count = |wanted| all.clone().filter(|(_, one)| decision(one) == wanted).count().to_string();
            let counts =
                [Decision::Stops, Decision::Runs, Decision::MissedStop, Decision::NeedlessStop].map(count);
            let needed = [at.speed_m_s.to_string(), format!("{} m", rounded_up(at.needed_m, 2))];
            table.row([taken.to_string()].into_iter().chain(needed).chain(counts));
        }
    }
    text + &table.text()
}
