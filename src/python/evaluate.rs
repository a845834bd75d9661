//! Counts of poses that Python asks for, again and again; the backend is kept open between.

use glam::{DMat3, DVec3};
use numpy::ndarray::{Array6, ArrayView1, ArrayView2};
use numpy::{IntoPyArray, PyArray6, PyReadonlyArray2};
use perirobot_march::Result;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::metrics::{self, Confusion, Detection, Overlap, Score};
use perirobot_scene::pose::{Pose, RotationFrame};
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::scoring::run_on;
use pyo3::prelude::*;

use crate::backends::BackendWords;
use crate::study::Study as PyStudy;
use crate::watch::{Listener, run};

/// Counters of a choice in a region: labels, detection and overlap.
pub(crate) const COUNTERS: usize =
    metrics::COUNTERS + metrics::DETECTION_COUNTERS + metrics::OVERLAP_COUNTERS;

/// How far the entries of RᵀR may be from those of the identity, of a rotation R.
const ROUNDED: f64 = 1e-3;

/// Counts sensors at poses of Python's choice: the first of each entry together, the second of each and so on.
#[pyfunction]
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    study: &PyStudy,
    poses: Vec<(String, PyReadonlyArray2<'py, f64>)>,
    is_optical: bool,
    backend: BackendWords,
) -> PyResult<Bound<'py, PyArray6<i64>>> {
    let worlds = study.worlds(py)?;
    let each = poses.iter().map(|(sensor, rows)| Ok((sensor, study.sensor(sensor)?, rows.as_array())));
    let each: Vec<(&String, usize, ArrayView2<f64>)> = each.collect::<PyResult<_>>()?;
    let frame = if is_optical { RotationFrame::Optical } else { RotationFrame::Link };
    let open = study.backends.take();
    let (counts, open) = run(py, None, |listener| {
        let poses = each.into_iter().map(|(name, sensor, rows)| {
            let poses = self::poses(rows, frame);
            Ok((sensor, poses.map_err(|issue| issue.with_place(format!("sensor {name:?}")))?))
        });
        let poses: Vec<(usize, Vec<Pose>)> = poses.collect::<perirobot_march::Result<_>>()?;
        let study = study.study.elsewhere(&poses)?;
        let ways = |(sensor, _): &(usize, _)| study.sensors[*sensor].kind.representations().len();
        let ways = poses.iter().map(ways).product();
        worlds.iter().try_for_each(|world| world.examine_sensors(&study))?;
        let moved: Vec<World> = worlds.iter().map(|world| world.with_sensors(&study.sensors)).collect();
        open.use_backend(backend, listener, |backends| {
            self::counts((&study, ways), &moved, backends, listener)
        })
    })?;
    study.backends.put(py, open);
    Ok(counts.into_pyarray(py))
}

/// Poses of rows: x, y, z in metres and the quaternion w, x, y, z, or the 16 numbers of a matrix that leads from the
/// sensor's frame to the world.
pub(crate) fn poses(rows: ArrayView2<f64>, frame: RotationFrame) -> Result<Vec<Pose>, Issue> {
    let one = |(number, row): (usize, ArrayView1<f64>)| {
        let row = row.to_vec();
        let pose = match row[..] {
            _ if row.iter().any(|value| !value.is_finite()) => Err("must be finite"),
            [x, y, z, qw, qx, qy, qz] => quaternion(DVec3 { x, y, z }, [qw, qx, qy, qz], frame),
            _ => matrix(&row, frame),
        };
        pose.map_err(|wanted| {
            Issue::says(format!("is {row:?}")).with_advice(wanted).with_place(format!("poses[{number}]"))
        })
    };
    rows.outer_iter().enumerate().map(one).collect()
}

fn quaternion(at: DVec3, wxyz: [f64; 4], frame: RotationFrame) -> Result<Pose, &'static str> {
    let pose = Pose::from_quaternion(at, wxyz, frame);
    pose.map_err(|_| "must be x, y, z in metres and a quaternion w, x, y, z of length 1 (within 0.001)")
}

fn matrix(row: &[f64], frame: RotationFrame) -> Result<Pose, &'static str> {
    let rotation = DMat3::from_cols_array(&std::array::from_fn(|i| row[4 * (i % 3) + i / 3]));
    let product = rotation.transpose() * rotation;
    if !product.abs_diff_eq(DMat3::IDENTITY, ROUNDED) || rotation.determinant() < 0.0 {
        return Err(
            "its upper left 3 × 3 must be a rotation: axes of length 1, at right angles, right-handed",
        );
    }
    if row[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err("its last row must be 0, 0, 0, 1, and its last column x, y, z in metres and 1");
    }
    Ok(Pose::from_rotation(DVec3::new(row[3], row[7], row[11]), rotation, frame))
}

/// A score of each row of counters, as [`counts`] has them; NaN where there is no value.
pub(crate) fn score(name: &str, rows: ArrayView2<i64>) -> Result<Vec<f64>> {
    let Some(score) = Score::ALL.into_iter().find(|score| score.name() == name) else {
        let place = Site::Argument(Argument("score"), name.into());
        return Err(Issue::unknown(&Score::ALL.map(Score::name)).with_place(place).into());
    };
    let value = |row: ArrayView1<i64>| {
        let count = |number: usize| row[number].max(0) as u64;
        let detection = std::array::from_fn(|i| count(metrics::COUNTERS + i));
        let overlap = std::array::from_fn(|i| count(metrics::COUNTERS + metrics::DETECTION_COUNTERS + i));
        let counts = Confusion::from_counts(std::array::from_fn(count))
            .with_detection(Detection::from_counts(detection, 0))
            .with_overlap(Overlap::from_counts(overlap));
        score.evaluate(&counts).unwrap_or(f64::NAN)
    };
    Ok(rows.outer_iter().map(value).collect())
}

/// The counts of a study whose combinations have one choice each, in so many representations: combinations, moments, repeats,
/// representations, regions, counters.
pub(crate) fn counts(
    (study, ways): (&Study, usize),
    worlds: &[World],
    backends: &mut dyn BackendFactory,
    listener: &Listener,
) -> Result<Array6<i64>> {
    let (choices, repeats) = (study.combinations.len(), study.repeats as usize);
    let mut counts = Array6::zeros([choices, worlds.len(), repeats, ways, study.regions.len(), COUNTERS]);
    for row in run_on(study, worlds, backends, listener)? {
        let here = |world: &World| (world.scene, world.snapshot) == (row.scene, row.snapshot);
        let moment = worlds.iter().position(here).expect("rows are of worlds that were given");
        let of_labels = row.counts.counts().into_iter();
        let numbers = of_labels.chain(row.counts.detection.counts()).chain(row.counts.overlap.counts());
        for (counter, number) in numbers.enumerate() {
            let at = [row.combination, moment, row.repeat, row.representation, row.region, counter];
            counts[at] = number as i64;
        }
    }
    Ok(counts)
}
