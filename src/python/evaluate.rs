//! Counts of poses that Python asks for, again and again.

use glam::DVec3;
use numpy::ndarray::Array6;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use perirobot::backend::Backend;
use perirobot::error::Issue;
use perirobot::pose::Frame;
use perirobot::results::{PoseChoice, layout_of};
use perirobot::sweep::{BatchSize, Ledger, Row, run_choices};
use perirobot::world::World;
use perirobot::{Error, Pose, Result, Study};

use crate::watch::Listener;

/// Counters of a choice in a region, labels and detection.
pub(crate) const COUNTERS: usize = perirobot::metrics::COUNTERS + perirobot::metrics::DETECTION_COUNTERS;

/// Rows of x, y, z in metres and the quaternion w, x, y, z as poses; quaternions are made one long.
pub(crate) fn poses(rows: &PyReadonlyArray2<f64>) -> Result<Vec<Pose>> {
    let shape = rows.shape();
    if shape[1] != 7 || shape[0] == 0 {
        return Err(wrong(
            "poses",
            format!("has shape {shape:?}"),
            "must have 7 columns: x, y, z, qw, qx, qy, qz",
        ));
    }
    let pose = |(number, row): (usize, numpy::ndarray::ArrayView1<f64>)| {
        let [x, y, z, qw, qx, qy, qz] = std::array::from_fn(|i| row[i]);
        let at = DVec3 { x, y, z };
        let made = Pose::from_quaternion(at, [qw, qx, qy, qz], Frame::Link).filter(|_| at.is_finite());
        let what = || format!("is {:?}", row.to_vec());
        made.ok_or_else(|| {
            wrong(&format!("poses[{number}]"), what(), "must be finite, with a quaternion that is not 0")
        })
    };
    rows.as_array().outer_iter().enumerate().map(pose).collect()
}

fn wrong(place: &str, what: String, wanted: &str) -> Error {
    Error::from(Issue::says(what).wanted(wanted).at(place))
}

/// The counts of a study's one combination: choices, moments, repeats, representations, regions, counters.
pub(crate) fn counts(
    study: &Study,
    worlds: &[World],
    backend: &mut dyn Backend,
    listener: &Listener,
) -> Result<Array6<i64>> {
    let combination = &study.combinations[0];
    let (choices, ways) = (combination.choices(), combination.representation_count(&study.sensors));
    let shape = [choices, worlds.len(), study.repeats as usize, ways, study.regions.len(), COUNTERS];
    let mut taken = Taken { counts: Array6::zeros(shape), worlds, listener };
    let all: Vec<PoseChoice> = layout_of(study).all_choices().collect();
    run_choices(study, worlds, &all, BatchSize::FULL, backend, &mut taken)?;
    Ok(taken.counts)
}

/// The counts so far.
struct Taken<'a> {
    counts: Array6<i64>,
    worlds: &'a [World],
    listener: &'a Listener,
}

impl Ledger for Taken<'_> {
    fn wants(&self, _: &World, _: usize, _: &PoseChoice) -> bool {
        true
    }

    fn take(&mut self, rows: &[Row]) -> Result<()> {
        for row in rows {
            let here = |world: &World| (world.scene, world.snapshot) == (row.scene, row.snapshot);
            let moment = self.worlds.iter().position(here).expect("rows are of worlds that were given");
            let numbers = row.counts.counts().into_iter().chain(row.counts.detection.counts());
            for (counter, number) in numbers.enumerate() {
                let at = [row.choice, moment, row.repeat, row.representation, row.region, counter];
                self.counts[at] = number as i64;
            }
        }
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.listener.stop().is_some()
    }
}
