//! What an answer leaves in its folder: `front.csv`, `sets.csv` and `choose.json`.

use std::path::Path;

use serde_json::{Value, json};

use super::told::{Told, ToldSet};
use super::within::Bound;
use super::worth::Worth;
use crate::results::files::write_whole;
use crate::results::journal::Shard;
use crate::results::manifest::Manifest;
use crate::sensor::{Cost, Sensor};
use crate::study::{Choose, Study};
use crate::world::World;
use crate::{Error, Result};

/// The front, a row for each step.
pub const FRONT: &str = "front.csv";
/// The sets of the front, a row for each sensor.
pub const SETS: &str = "sets.csv";
/// What was asked, what was found, and what is proven of it.
pub const PROOF: &str = "choose.json";

/// Writes the files of an answer, each whole or not at all.
///
/// # Errors
/// When the folder cannot be made or written.
pub fn write(folder: &Path, study: &Study, choose: &Choose, worlds: &[World], told: &Told) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "cannot be made", e))?;
    write_whole(&folder.join(SETS), &sets(choose, told))?;
    write_whole(&folder.join(PROOF), format!("{:#}\n", proof(study, choose, worlds, told)).as_bytes())?;
    write_whole(&folder.join(FRONT), &front(choose, told))
}

fn front(choose: &Choose, told: &Told) -> Vec<u8> {
    let score = choose.objective.name();
    let mut rows =
        vec![["at_most", "sensors", "cost", score, "bound", "proven", "gain", "poses"].map(String::from)];
    for step in &told.steps {
        let (best, proven) = (&step.best, step.bound == Bound::Proven);
        let bound = match step.bound {
            Bound::Proven => best.worth.value().to_string(),
            Bound::AtMost(bound) => bound.to_string(),
            Bound::Unknown => String::new(),
        };
        rows.push([
            step.at_most.to_string(),
            best.members.len().to_string(),
            or_empty(best.cost),
            best.worth.value().to_string(),
            bound,
            proven.to_string(),
            or_empty(step.gain),
            best.names.clone(),
        ]);
    }
    csv(&rows)
}

fn sets(choose: &Choose, told: &Told) -> Vec<u8> {
    let without = format!("{}_without", choose.objective.name());
    let header = ["at_most", "set_cost", "sensor", "pose", "place", "cost", &without];
    let mut rows = vec![header.map(String::from)];
    for step in &told.steps {
        for member in &step.best.members {
            rows.push([
                step.at_most.to_string(),
                or_empty(step.best.cost),
                member.sensor.clone(),
                member.pose.clone(),
                member.place.clone(),
                or_empty(member.cost),
                or_empty(member.without),
            ]);
        }
    }
    csv(&rows)
}

fn or_empty(value: Option<impl ToString>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

fn csv<const N: usize>(rows: &[[String; N]]) -> Vec<u8> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.write_record(row).expect("all rows are as long as the header, and memory takes them");
    }
    csv.into_inner().expect("memory takes all bytes")
}

/// What tells a study from every other, as far as counts go.
pub(super) fn fingerprint(study: &Study, worlds: &[World]) -> String {
    let bytes = Manifest::new(study, worlds, Shard::WHOLE, &[]).fingerprint();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What a study asks for.
pub(super) fn asked(study: &Study, choose: &Choose) -> Value {
    let poses = |&[sensor, candidate]: &[usize; 2]| {
        let sensor = &study.sensors[sensor];
        format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
    };
    let of_sensor = |(sensor, &way): (&Sensor, &usize)| {
        let terms = json!({
            "representation": sensor.kind.representations()[way],
            "cost": sensor.terms.cost.map(amount),
            "at_most": sensor.terms.at_most,
        });
        (sensor.name.clone(), terms)
    };
    let sensors: serde_json::Map<String, Value> =
        study.sensors.iter().zip(&choose.ways).map(of_sensor).collect();
    let require = choose.require.iter().map(|require| {
        json!({ "score": require.score.name(), "over": require.over.name(), "at_least": require.at_least })
    });
    json!({
        "objective": choose.objective.name(),
        "over": choose.over.name(),
        "region": study.regions[choose.region].0,
        "at_most": choose.at_most,
        "budget": choose.budget.map(amount),
        "apart_m": choose.apart_m,
        "always": choose.always.iter().map(poses).collect::<Vec<_>>(),
        "require": require.collect::<Vec<_>>(),
        "sensors": sensors,
    })
}

/// What was asked, found and proven.
fn proof(study: &Study, choose: &Choose, worlds: &[World], told: &Told) -> Value {
    let steps = told.steps.iter().map(|step| {
        let (bound, proven) = match step.bound {
            Bound::Proven => (Some(step.best.worth.value()), true),
            Bound::AtMost(bound) => (Some(bound), false),
            Bound::Unknown => (None, false),
        };
        json!({
            "at_most": step.at_most,
            "budget": step.budget.map(amount),
            "best": set(&step.best),
            "no_set_is_above": bound,
            "proven": proven,
        })
    });
    json!({
        "perirobot": env!("CARGO_PKG_VERSION"),
        "semantics_version": crate::SEMANTICS_VERSION,
        "study": study.path.display().to_string(),
        "fingerprint": fingerprint(study, worlds),
        "voxel_size_m": study.voxel_size_m,
        "noiseless": study.noiseless,
        "asked": asked(study, choose),
        "certified": "the listed poses, at this voxel size, in these scenes, under \"occupied_wins\"",
        "steps": steps.collect::<Vec<_>>(),
        "nearly_as_good": told.ties.iter().map(set).collect::<Vec<_>>(),
    })
}

fn set(told: &ToldSet) -> Value {
    let mut value = json!({
        "poses": told.members.iter().map(|one| format!("{}:{}", one.sensor, one.pose)).collect::<Vec<_>>(),
        "cost": told.cost.map(amount),
        "score": told.worth.value(),
    });
    if let Worth::Exact(ratio) = told.worth {
        // As text: other readers of JSON have no whole numbers of this size.
        value["exactly"] = json!([ratio.numerator.to_string(), ratio.denominator.to_string()]);
    }
    value
}

/// An amount as a number.
fn amount(cost: Cost) -> f64 {
    cost.thousandths() as f64 / 1e3
}
