//! The table of a study's poses as CSV for pandas, and the names of poses in other tables.

use rayon::prelude::*;

use perirobot_march::metrics::{COUNTERS, DETECTION_COUNTERS, OVERLAP_COUNTERS};
use perirobot_scene::pose::Pose;
use perirobot_study::input::{Combination, Study};
use perirobot_study::sensor::{Candidate, Setting};
use perirobot_study::world::World;
use perirobot_study::world::place::Places;

/// The columns of the counters, in the order of [`perirobot_march::metrics::Confusion::counts`].
pub const COUNT_COLUMNS: [&str; COUNTERS] = [
    "tp", "fp", "fn", "tn", "uo", "uf", "tp_human", "fn_human", "uo_human", "tp_robot", "fn_robot",
    "uo_robot",
];

/// The columns of detections, in the order of [`perirobot_march::metrics::Detection::counts`].
pub const DETECTION_COLUMNS: [&str; DETECTION_COUNTERS] =
    ["hit_human", "people", "people_detected", "parts", "parts_detected"];

/// The columns of the overlap of sensors, in the order of [`perirobot_march::metrics::Overlap::counts`].
pub const OVERLAP_COLUMNS: [&str; OVERLAP_COUNTERS] = ["twice", "hit_human_twice"];

/// The column with the names of missed body parts.
pub const MISSED_COLUMN: &str = "parts_missed";

/// The separator of a combination's members in the columns `poses` and `representation`.
pub const BETWEEN_MEMBERS: &str = ";";

/// `poses.csv`: every candidate. Position in metres and rotation of the link frame (x forward, y left, z up) are in the
/// world, or, if `on` names a robot and its link, in that link's frame; both are empty without a pose. `place` is the
/// position in words, in a world of the study.
pub fn poses_csv(study: &Study, world: &World) -> Vec<u8> {
    let places = Places::new(study, world);
    let mut csv = Csv::new(&[
        "sensor",
        "pose",
        "group",
        "x_m",
        "y_m",
        "z_m",
        "qw",
        "qx",
        "qy",
        "qz",
        "inflation_m",
        "on",
        "place",
    ]);
    for (number, sensor) in study.sensors.iter().enumerate() {
        let on = sensor.on.as_ref().map_or(String::new(), |on| format!("{}/{}", on.object, on.link));
        let row = |(index, candidate): (usize, &Candidate)| {
            let mut fields = vec![sensor.name.clone(), candidate.name.clone(), candidate.group.clone()];
            match candidate.setting {
                Setting::Pose(Pose { position_m: p, rotation: q }) => {
                    fields.extend([p.x, p.y, p.z, q.w, q.x, q.y, q.z].map(|v| v.to_string()));
                    fields.push(String::new());
                }
                Setting::Inflation(metres) => {
                    fields.extend([const { String::new() }; 7]);
                    fields.push(metres.to_string());
                }
                Setting::Fixed => fields.extend([const { String::new() }; 8]),
            }
            fields.push(on.clone());
            fields.push(places.words(number, index));
            fields
        };
        let rows: Vec<Vec<String>> = sensor.candidates.par_iter().enumerate().map(row).collect();
        rows.iter().for_each(|fields| csv.row(fields));
    }
    csv.bytes()
}

/// The poses of a choice: `camera:right-wall/8/1;pads:floor/3/0`.
pub fn pose_names(study: &Study, combination: &Combination, choice: usize) -> String {
    let members = combination.members.iter().zip(combination.choice(choice));
    let names = members.map(|(member, candidate)| {
        let sensor = &study.sensors[member.sensor];
        format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
    });
    names.collect::<Vec<_>>().join(BETWEEN_MEMBERS)
}

/// The representations of each choice: `points;volume`.
pub fn representation_names(study: &Study, combination: &Combination) -> Vec<String> {
    let named = |way: Vec<usize>| {
        let members = combination.members.iter().zip(way);
        let names = members.map(|(member, r)| study.sensors[member.sensor].kind.representations()[r]);
        names.collect::<Vec<_>>().join(BETWEEN_MEMBERS)
    };
    combination.representations(&study.sensors).into_iter().map(named).collect()
}

/// CSV rows in memory, where writing cannot fail.
pub struct Csv(csv::Writer<Vec<u8>>);

impl Csv {
    /// A table with its header.
    pub fn new(header: &[&str]) -> Self {
        let mut csv = Csv(csv::Writer::from_writer(Vec::new()));
        csv.row(header);
        csv
    }

    /// Adds a row, as long as the header.
    pub fn row<T: AsRef<[u8]>>(&mut self, fields: &[T]) {
        self.0.write_record(fields).expect("all rows are as long as the header, and memory takes them");
    }

    /// The text of the table.
    pub fn bytes(self) -> Vec<u8> {
        self.0.into_inner().expect("memory takes all bytes")
    }
}
