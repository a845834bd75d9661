//! Maps that real sensors recorded, scored against the truth of a study, as `perirobot score` does it.

use std::path::{Path, PathBuf};

use glam::DVec3;
use numpy::PyReadonlyArray3;
use numpy::ndarray::ArrayView3;
use perirobot_decide::view::{ChoiceSelector as Wanted, RecordedMap, View, find_scene};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::recording::{Anchor, Recording, RecordingSelection};
use perirobot_scene::source::Sources;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::scoring::Row;
use pyo3::prelude::*;

use crate::study::Study as PyStudy;
use crate::table::{ArrayColumn, Columns, NameTable, columns};
use crate::watch::run;

/// Where and when something was recorded, and which region is asked: the pose of its frame, scene, snapshot, region.
pub(crate) type RecordedWords = (Vec<f64>, Option<String>, usize, Option<String>);

/// What of a file is read: where the sensor was, the topic of a bag, the number of a message.
pub(crate) type AskedWords = (Option<[f64; 3]>, Option<String>, Option<usize>);

/// What a file says, or bytes in its place. What is odd about it goes to `warn`.
pub(crate) fn file(
    path: &Path,
    bytes: Option<Vec<u8>>,
    (sensor_m, topic, message): &AskedWords,
    warn: impl FnMut(String),
) -> Result<Recording> {
    let sensor_m = sensor_m.map(DVec3::from_array);
    let asked = RecordingSelection { sensor_m, topic: topic.as_deref(), message: *message };
    let sources = Sources::from_main(path).allow_outside();
    let sources = match bytes {
        Some(bytes) => sources.with_file(path, bytes),
        None => sources,
    };
    let recording = Recording::read(path, asked, &sources)?;
    sources.take_remarks().into_iter().for_each(warn);
    Ok(recording)
}

/// What labels say: 1 occupied, 0 free, 255 unknown.
pub(crate) fn labels(labels: ArrayView3<u8>, origin_m: [f64; 3], voxel_size_m: f64) -> Result<Recording> {
    let shape = labels.shape().try_into().expect("there are three axes");
    let label = |[x, y, z]: [usize; 3]| labels[[x, y, z]];
    let read = Recording::from_labels(shape, &label, DVec3::from_array(origin_m), voxel_size_m);
    read.map_err(|issue| issue.with_place("recorded").into())
}

/// Scores a map or a point cloud in a file, or in bytes in its place; the columns of the table, and of that of reasons.
#[pyfunction]
pub(crate) fn score_file(
    py: Python<'_>,
    study: &PyStudy,
    path: PathBuf,
    data: Option<Vec<u8>>,
    asked: AskedWords,
    words: RecordedWords,
) -> PyResult<[Columns; 2]> {
    let worlds = study.worlds(py)?;
    run(py, None, |listener| {
        let recording = file(&path, data, &asked, |remark| listener.warns_of_study(remark))?;
        score(&study.study, worlds, recording, words)
    })
}

/// Scores labels of voxels; the columns of the table, and of that of reasons.
#[pyfunction]
pub(crate) fn score_labels(
    py: Python<'_>,
    study: &PyStudy,
    labels: PyReadonlyArray3<'_, u8>,
    origin_m: [f64; 3],
    voxel_size_m: f64,
    words: RecordedWords,
) -> PyResult<[Columns; 2]> {
    let (worlds, labels) = (study.worlds(py)?, labels.as_array());
    run(py, None, |_| score(&study.study, worlds, self::labels(labels, origin_m, voxel_size_m)?, words))
}

/// The rows of a recording, as `results.csv` has them, and why it does not call occupied what is there.
pub(crate) fn score(
    study: &Study,
    worlds: &[World],
    recording: Recording,
    (pose, scene, snapshot, region): RecordedWords,
) -> Result<[Columns; 2]> {
    let regions: Vec<&str> = study.regions.iter().map(|(name, _)| name.as_str()).collect();
    let is_known = |name: &String| regions.contains(&name.as_str());
    if let Some(unknown) = region.as_ref().filter(|name| !is_known(name)) {
        let what = Issue::value("region", format!("{unknown:?}"), format!("must be one of {regions:?}"));
        return Err(what.into());
    }
    let scene = find_scene(study, &Wanted { scene, snapshot, ..Wanted::default() })?;
    let here = |world: &&World| (world.scene, world.snapshot) == (scene, snapshot);
    let world = worlds.iter().find(here).expect("the study has such a moment");
    let map = RecordedMap::new(study, world, recording, anchor(&pose)?)?;
    let view = map.view()?;
    let mut rows = map.rows(&view);
    rows.retain(|row| region.as_ref().is_none_or(|name| regions[row.region] == name));
    Ok([columns((&map.study).into(), &rows), reasons(&map, &view, &rows)])
}

/// Why voxels of the rows' regions are overlooked: region, reason, what hides them, how many, and of those a person's.
fn reasons(map: &RecordedMap, view: &View, rows: &[Row]) -> Columns {
    let (mut words, mut counts) = ([(); 3].map(|()| Vec::new()), [(); 2].map(|()| Vec::new()));
    let overlooked = map.find_overlooked(view);
    for Row { region, .. } in rows {
        let region = &view.world.regions[*region];
        for one in &overlooked {
            let voxels =
                [&[&*region.voxels][..], &[&*region.voxels, &view.truth.human]].map(|of| one.count(of));
            if voxels[0] == 0 {
                continue;
            }
            let object = one.object.map_or("", |object| view.truth.objects[object].name.as_str());
            for (column, word) in words.iter_mut().zip([&region.name, one.reason.name(), object]) {
                column.push(word.to_string());
            }
            for (column, count) in counts.iter_mut().zip(voxels) {
                column.push(count as i64);
            }
        }
    }
    let words = ["region", "reason", "object"].into_iter().zip(words);
    let counts = ["voxels_occupied", "voxels_human"].into_iter().zip(counts);
    let words = words.map(|(name, all)| (name, NameTable::new(all.into_iter()).column()));
    words.chain(counts.map(|(name, all)| (name, ArrayColumn::Counts(all)))).collect()
}

/// Where a frame stands: x, y, z and the yaw in degrees, or x, y, z and a quaternion.
fn anchor(numbers: &[f64]) -> Result<Anchor> {
    Anchor::from_numbers(numbers).ok_or_else(|| {
        let rule =
            "must be x, y, z in metres and the yaw in degrees, or x, y, z and a quaternion of length 1, qw, qx, qy, qz, within 1e8";
        Error::from(Issue::value("pose", format!("{numbers:?}"), rule))
    })
}
