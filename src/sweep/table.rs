//! The tables of a sweep as CSV, made for pandas: one row a pose, one row a result.

use super::Row;
use crate::metrics::COUNTERS;
use crate::study::Study;

/// The representation that a range sensor's raw returns have (paper: "PC").
pub const POINTS: &str = "points";

const COUNT_COLUMNS: [&str; COUNTERS] = [
    "tp", "fp", "fn", "tn", "uo", "uf", "tp_human", "fn_human", "uo_human", "tp_robot", "fn_robot",
    "uo_robot",
];

/// `poses.csv`: every candidate, its position in metres and its link frame's rotation (x forward, y left, z up).
pub fn poses_csv(study: &Study) -> Vec<u8> {
    let mut csv = Csv::new(&["sensor", "pose", "group", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]);
    for sensor in &study.sensors {
        for candidate in &sensor.candidates {
            let (p, q) = (candidate.pose.position_m, candidate.pose.rotation);
            let mut fields = vec![sensor.name.clone(), candidate.name.clone(), candidate.group.clone()];
            fields.extend([p.x, p.y, p.z, q.w, q.x, q.y, q.z].map(|v| v.to_string()));
            csv.row(&fields);
        }
    }
    csv.bytes()
}

/// `results.csv`: counts and scores of every scene, pose and region, in study order. A score that has no value (a zero
/// denominator) is empty.
pub fn results_csv(study: &Study, rows: &[Row]) -> Vec<u8> {
    let mut header = vec!["scene", "snapshot", "repeat", "combination", "poses", "representation", "region"];
    header.extend(COUNT_COLUMNS);
    header.extend(["f1", "kappa", "human_seen", "unknown", "false_alarm"]);
    let mut csv = Csv::new(&header);
    for row in rows {
        let sensor = &study.sensors[row.sensor];
        let mut fields = vec![
            study.scenes[row.scene].name.clone(),
            row.snapshot.to_string(),
            "0".into(),
            sensor.name.clone(),
            format!("{}:{}", sensor.name, sensor.candidates[row.pose].name),
            POINTS.into(),
            study.regions[row.region].0.clone(),
        ];
        let c = &row.counts;
        fields.extend(c.counts().map(|n| n.to_string()));
        let scores = [c.f1(), c.kappa(), c.human_seen(), c.unknown(), c.false_alarm()];
        fields.extend(scores.map(|score| score.map_or(String::new(), |s| s.to_string())));
        csv.row(&fields);
    }
    csv.bytes()
}

/// Rows in memory, where writing cannot fail.
struct Csv(csv::Writer<Vec<u8>>);

impl Csv {
    fn new(header: &[&str]) -> Self {
        let mut csv = Csv(csv::Writer::from_writer(Vec::new()));
        csv.row(header);
        csv
    }

    fn row<T: AsRef<[u8]>>(&mut self, fields: &[T]) {
        self.0.write_record(fields).expect("all rows are as long as the header, and memory takes them");
    }

    fn bytes(self) -> Vec<u8> {
        self.0.into_inner().expect("memory takes all bytes")
    }
}
