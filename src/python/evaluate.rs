//! Counts of poses that Python asks for, again and again; the backend is kept open between.

use glam::DVec3;
use numpy::ndarray::{Array6, ArrayView1, ArrayView2};
use perirobot::backend::factory::BackendFactory;
use perirobot::error::Issue;
use perirobot::pose::Frame;
use perirobot::sweep::run_on;
use perirobot::world::World;
use perirobot::{Error, Pose, Result, Study};

use crate::watch::Listener;

/// Counters of a choice in a region, labels and detection.
pub(crate) const COUNTERS: usize = perirobot::metrics::COUNTERS + perirobot::metrics::DETECTION_COUNTERS;

/// Rows of x, y, z in metres and the quaternion w, x, y, z as poses; quaternions are made one long.
pub(crate) fn poses(rows: ArrayView2<f64>) -> Result<Vec<Pose>> {
    let shape = rows.shape();
    if shape[1] != 7 || shape[0] == 0 {
        return Err(wrong(
            "poses",
            format!("has shape {shape:?}"),
            "must have 7 columns: x, y, z, qw, qx, qy, qz",
        ));
    }
    let one = |(number, row): (usize, ArrayView1<f64>)| {
        let what = || format!("is {:?}", row.to_vec());
        pose(std::array::from_fn(|i| row[i])).ok_or_else(|| {
            wrong(&format!("poses[{number}]"), what(), "must be finite, with a quaternion that is not 0")
        })
    };
    rows.outer_iter().enumerate().map(one).collect()
}

/// The pose at x, y, z in metres, turned by the quaternion w, x, y, z, if that is one.
pub(crate) fn pose([x, y, z, qw, qx, qy, qz]: [f64; 7]) -> Option<Pose> {
    let (at, wxyz) = (DVec3 { x, y, z }, [qw, qx, qy, qz]);
    let length = wxyz.iter().map(|part| part * part).sum::<f64>().sqrt();
    // Optimisers make others of unit length.
    let of_length_1 = |_| Pose::from_quaternion(at, wxyz.map(|part| part / length), Frame::Link);
    Pose::from_quaternion(at, wxyz, Frame::Link).or_else(of_length_1).ok().filter(|_| at.is_finite())
}

fn wrong(place: &str, what: String, wanted: &str) -> Error {
    Error::from(Issue::says(what).wanted(wanted).at(place))
}

/// The counts of a study whose combinations have one choice each: combinations, moments, repeats, representations, regions,
/// counters.
pub(crate) fn counts(
    study: &Study,
    worlds: &[World],
    backends: &mut dyn BackendFactory,
    mut listener: &Listener,
) -> Result<Array6<i64>> {
    let (choices, repeats) = (study.combinations.len(), study.repeats as usize);
    let ways = study.combinations[0].representation_count(&study.sensors);
    let mut counts = Array6::zeros([choices, worlds.len(), repeats, ways, study.regions.len(), COUNTERS]);
    for row in run_on(study, worlds, backends, &mut listener)? {
        let here = |world: &World| (world.scene, world.snapshot) == (row.scene, row.snapshot);
        let moment = worlds.iter().position(here).expect("rows are of worlds that were given");
        let numbers = row.counts.counts().into_iter().chain(row.counts.detection.counts());
        for (counter, number) in numbers.enumerate() {
            let at = [row.combination, moment, row.repeat, row.representation, row.region, counter];
            counts[at] = number as i64;
        }
    }
    Ok(counts)
}
