//! The checks of a study file, in their order: each of its tables is checked in a file of its own.

use std::path::Path;

use glam::DVec3;

use super::approach::ApproachFile;
use super::file::{self, StudyFile};
use super::region::{self, RegionSpec};
use super::scene_file::parse_scene;
use super::{
    Overrides, Stopping, Study, approach, candidates, choose, combination, region_file, require, sensor,
    stopping,
};
use crate::diagnostics::{
    self, List, Place, Problems, Written, parse_in_parts, refuse_folder, top_keys, wrong_with,
};
use crate::sensor::{SaidOfNoise, Sensor};
use perirobot_march::error::{Argument, Issue, Site, Words};
use perirobot_march::voxel::grid::VOXEL_SIZES_M;
use perirobot_march::{Error, Result};
use perirobot_scene::scene::spec::SceneSpec;
use perirobot_scene::source::Sources;

/// Most repeats of a study; more would be more precise than the noise is known.
const MAX_REPEATS: u32 = 10_000;

/// Reads a study and its scene files, and tells all errors that can be judged independently.
pub(super) fn study(path: &Path, overrides: &Overrides, sources: Sources) -> Result<Study, Vec<Error>> {
    let mut problems = Problems::default();
    refuse_folder(path, "a study").map_err(|e| vec![e])?;
    let Some(text) = problems.keep(sources.text(path)) else { return Err(all(problems)) };
    refuse_scene(path, &text).map_err(|e| vec![e])?;
    let file: Option<StudyFile> = parse_in_parts(path, &text, &LISTS, &mut problems);
    let Some(file) = file else { return Err(all(problems)) };
    let is_whole = problems.is_empty();
    let at = Place::new(path);

    let voxel_size_m = problems.keep(voxel_size(&at, &file, overrides));
    let bounds_m = file.grid.bounds_m.map(|b| bounds(&at.key("grid"), b)).transpose();
    let bounds_m = problems.keep(bounds_m);
    if is_whole {
        problems.keep(at.some("scene", &file.scene, "[[scene]] file = \"scene.toml\""));
        problems.keep(at.some("region", &file.region, "[[region]] name = \"robot\""));
        problems.keep(at.some("sensor", &file.sensor, "[[sensor]] name = \"camera\""));
    }
    let mut scenes = scenes(&at, &file, &sources, &mut problems);
    let has_candidates = !file.candidate.is_empty();
    if has_candidates && problems.is_empty() {
        let variants = problems.keep(candidates::expand(&at, file.candidate, scenes.clone()));
        scenes = variants.unwrap_or(scenes);
    }
    let (seed, noiseless) = (file.seed, overrides.noiseless);
    let written = Written::new(&text);
    let context = sensor::Context {
        seed,
        noiseless,
        index: 0,
        earlier: &[],
        poses: 0,
        sources: &sources,
        scenes: &scenes,
        line_of: &|steps| written.line_of(steps),
    };
    let mut of_sensors = Problems::default();
    let sensors = sensors(&at, file.sensor, context, &mut of_sensors);
    let floor_m = file.approach.as_ref().map_or(0.0, ApproachFile::standing_m);
    let stopping = file.stopping.map(|file| stopping::check(&at, file, &sensors, floor_m)).transpose();
    let stopping = problems.keep(stopping);
    let known = stopping.as_ref().map(Option::as_ref);
    let regions = regions(&at, file.region, is_whole, known, &mut problems);
    problems.keep_all(of_sensors.none());
    problems.keep(at.unique("scene", scenes.iter().map(|s| s.name.as_str())));
    problems.keep(at.unique("region", regions.iter().map(|(name, _)| name.as_str())));
    problems.keep(at.unique("sensor", sensors.iter().map(|s| s.name.as_str())));
    problems.keep(no_semicolons(&at, &sensors));
    if !file.mixed_noise && !noiseless {
        problems.keep(no_mixed_noise(&at, &sensors));
    }
    if !(1..=MAX_REPEATS).contains(&file.repeats) {
        problems.keep::<()>(Err(at.wrong(
            "repeats",
            file.repeats,
            &format!("must be from 1 to {MAX_REPEATS}"),
        )));
    }
    if file.min_hits == 0 {
        problems.keep::<()>(Err(at.wrong("min_hits", 0, "must be 1 or more")));
    }
    // Keys that name sensors can be checked only if all sensors could be read.
    let (Some(voxel_size_m), Some(bounds_m), Some(stopping), true) =
        (voxel_size_m, bounds_m, stopping, problems.is_empty())
    else {
        return Err(all(problems));
    };
    let mounting_error = file.mounting_error.map(|file| file.check(&at)).transpose();
    let mounting_error = mounting_error.map_err(|e| vec![e])?;
    let known = approach::Known { regions: &regions, sensors: &sensors };
    let has_approach = file.approach.as_ref().is_some_and(ApproachFile::asks);
    let approach = approach::check(&at, file.approach, &known).map_err(|e| vec![e])?;
    let postures = file.postures.map(|file| file.check(&at, approach.standing_m())).transpose();
    let postures = postures.map_err(|e| vec![e])?.unwrap_or_default();
    let recorded = sensors.iter().find(|sensor| sensor.kind.name() == "recorded");
    if let (Some(sensor), false) = (recorded, postures.is_empty()) {
        let what = format!(
            "postures and sensor {:?}, which was recorded with the people who were there",
            sensor.name
        );
        return Err(vec![at.says(what).wanted("take one of them away")]);
    }
    let known = require::Known {
        regions: &regions,
        approach: &approach,
        has_draws: mounting_error.is_some(),
        has_postures: !postures.is_empty(),
        has_stopping: stopping.is_some(),
    };
    let requirements = require::check(&at, file.require, &known)?;
    // Without noise every repeat would be the first again.
    let noisy = sensors.iter().any(|sensor| sensor.kind.is_noisy());
    let repeats = if noisy { file.repeats } else { 1 };
    let combinations = combination::check(&at, file.combination, file.fusion, &sensors)?;
    let snapshots: usize = scenes.iter().map(|scene| scene.snapshots).sum();
    let per_choice = regions.len() * snapshots * repeats as usize;
    combination::check_rows(&at, &combinations, &sensors, per_choice).map_err(|e| vec![e])?;
    let known = choose::Known { fusion: file.fusion, regions: &regions, sensors: &sensors };
    let choose = file.choose.map(|file| choose::check(&at, file, &known)).transpose()?;
    let mut warnings = diagnostics::warnings(&text);
    warnings.extend(stopping.iter().flat_map(|stopping| stopping.warnings.clone()));
    if has_candidates {
        warnings.extend(candidates::warnings(&regions));
    }
    Ok(Study {
        path: path.into(),
        warnings,
        text,
        seed: file.seed,
        voxel_size_m,
        bounds_m,
        backdrop: file.grid.outside == file::Outside::Backdrop,
        scenes,
        regions,
        sensors,
        fusion: file.fusion,
        combinations,
        choose,
        requirements,
        mounting_error,
        postures,
        approach,
        has_approach,
        stopping,
        noiseless: overrides.noiseless,
        repeats,
        min_hits: file.min_hits,
        sources,
    })
}

/// Refuses what is a scene by its keys.
fn refuse_scene(path: &Path, text: &str) -> Result<()> {
    let keys = top_keys(text);
    match keys.contains_key("object") && !["scene", "sensor"].iter().any(|key| keys.contains_key(*key)) {
        true => Err(Error::input(path, "this looks like a scene file")
            .wanted("name the study that lists it, with [[scene]]")),
        false => Ok(()),
    }
}

/// The lists of a study that can be read entry by entry; sensors always are.
const LISTS: [List; 4] = [
    ("scene", wrong_with::<file::SceneEntry>),
    ("region", wrong_with::<region_file::RegionFile>),
    ("combination", wrong_with::<file::CombinationFile>),
    ("require", wrong_with::<require::RequirementFile>),
];

/// All errors that were found, for a check that cannot continue.
fn all(problems: Problems) -> Vec<Error> {
    problems.none().err().unwrap_or_default()
}

fn voxel_size(at: &Place, file: &StudyFile, overrides: &Overrides) -> Result<f64> {
    let rule = "a size in metres from 0.0001 to 10";
    at.key("grid").number("voxel_size_m", file.grid.voxel_size_m, VOXEL_SIZES_M, rule)?;
    match overrides.voxel_size_m {
        Some(size) if !VOXEL_SIZES_M.contains(&size) => {
            let place = Site::Argument(Argument("voxel size"), size.to_string());
            Err(Issue::says(format!("must be {rule}")).at(place).into())
        }
        other => Ok(other.unwrap_or(file.grid.voxel_size_m)),
    }
}

/// The scenes that are right.
fn scenes(at: &Place, file: &StudyFile, sources: &Sources, problems: &mut Problems) -> Vec<SceneSpec> {
    let scenes = file.scene.iter().enumerate().filter_map(|(i, entry)| {
        let path = at.folder().join(&entry.file);
        // An error inside the file names the file; an error of opening it also names the study.
        let text = sources.text(&path).map_err(|e| at.around(e.at(format!("scene[{i}].file"))));
        let mut scene = problems.keep(text).and_then(|text| problems.keep_all(parse_scene(&path, text)))?;
        scene.name = entry.name.clone().unwrap_or(scene.name);
        Some(scene)
    });
    scenes.collect()
}

/// The regions that are right. Where some could not be read, those that are made of others are passed over; where
/// `[stopping]` could not (`stopping` is `None`), those that need it.
fn regions(
    at: &Place,
    entries: Vec<region_file::RegionFile>,
    is_whole: bool,
    stopping: Option<Option<&Stopping>>,
    problems: &mut Problems,
) -> Vec<(String, RegionSpec)> {
    let (mut names, mut regions) = (Vec::new(), Vec::new());
    let is_whole = is_whole && stopping.is_some();
    for entry in entries {
        let made_of_others = entry.union.is_some() || entry.difference.is_some();
        let can_be_read = is_whole || !made_of_others;
        let stopping = if entry.separation.is_some() { stopping } else { Some(None) };
        let (Some(stopping), true) = (stopping, can_be_read) else { continue };
        let own = entry.name.clone();
        match problems.keep(region::check(at, entry, &names, stopping)) {
            Some(found) => {
                names.extend(found.iter().map(|(name, _)| name.clone()));
                regions.extend(found);
            }
            // Regions below may name it.
            None => names.push(own),
        }
    }
    regions
}

/// The sensors that are right. One that has the poses of a wrong one is passed over.
fn sensors(
    at: &Place,
    entries: Vec<toml::Table>,
    context: sensor::Context,
    problems: &mut Problems,
) -> Vec<Sensor> {
    let (mut sensors, mut wrong, mut poses) = (Vec::<Sensor>::new(), Vec::new(), 0);
    for (index, keys) in entries.into_iter().enumerate() {
        let (name, like) = (keys.get("name").cloned(), keys.get("same_poses_as").cloned());
        if like.is_some() && wrong.contains(&like) {
            continue;
        }
        let context = sensor::Context { index, earlier: &sensors, poses, ..context };
        match problems.keep_all(sensor::check(at, keys, &context)) {
            Some(sensor) => {
                poses += sensor.candidates.len();
                sensors.push(sensor);
            }
            None => wrong.push(name),
        }
    }
    sensors
}

/// Tables name a choice by joining the names of its poses.
fn no_semicolons(at: &Place, sensors: &[Sensor]) -> Result<()> {
    let poses = sensors.iter().flat_map(|sensor| sensor.candidates.iter().map(|c| c.name.as_str()));
    let names = sensors.iter().map(|sensor| sensor.name.as_str()).chain(poses);
    match names.into_iter().find(|name| name.contains(';')) {
        Some(name) => {
            Err(at.around(Error::input(format!("{name:?}"), "names of sensors and poses hold no semicolon")))
        }
        None => Ok(()),
    }
}

/// A sensor of unknown noise is cast without noise, so it would beat sensors whose noise is known.
fn no_mixed_noise(at: &Place, sensors: &[Sensor]) -> Result<()> {
    let first = |said| sensors.iter().find(|sensor| sensor.noise == said);
    match (first(SaidOfNoise::Unknown), first(SaidOfNoise::Model)) {
        (Some(unknown), Some(known)) => {
            let [unknown, known] = [unknown, known].map(|sensor| &sensor.name);
            let what = format!(
                "the noise of sensor {unknown:?} is unknown and that of sensor {known:?} is not, so they cannot be compared"
            );
            let cure = Words::from(format!(
                "give {unknown:?} noise = {{ std_m = ... }}, or write mixed_noise = true at the top of the study (or sweep \
                 with "
            )) + Argument("noiseless")
                + ")";
            Err(at.says(what).wanted(cure))
        }
        _ => Ok(()),
    }
}

fn bounds(at: &Place, bounds: file::BoundsFile) -> Result<[DVec3; 2]> {
    let at = at.key("bounds_m");
    let (min, max) = (at.vector("min", bounds.min)?, at.vector("max", bounds.max)?);
    if !min.cmplt(max).all() {
        return Err(at.wrong("max", format!("{:?}", bounds.max), "must be above min on every axis"));
    }
    Ok([min, max])
}
