//! The checks of a study file, in their order: each of its tables is checked in a file of its own.

use std::mem::take;
use std::path::Path;

use glam::DVec3;

use super::approach::ApproachFile;
use super::catalogue::{self, DeviceModel};
use super::file::{self, StudyFile};
use super::poses::Surfaces;
use super::region::{self, RegionSpec};
use super::scene_file::parse_scene;
use super::{
    Approach, MountingError, Overrides, Posture, Requirement, Stopping, Study, approach, candidates, choose,
    combination, region_file, require, sensor, stopping,
};
use crate::diagnostics::{
    self, List, Place, Problems, Written, parse_in_parts, refuse_folder, top_keys, wrong_with,
};
use crate::sensor::{Cost, SaidOfNoise, Sensor};
use crate::world::KeptRays;
use perirobot_march::error::{Argument, Issue, Site, Words};
use perirobot_march::voxel::grid::VOXEL_SIZES_M;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::source::Sources;

/// Most repeats of a study; more would be more precise than the noise is known.
const MAX_REPEATS: u32 = 10_000;

/// Reads a study and its scene files, and tells all errors that can be judged independently.
pub(super) fn study(path: &Path, overrides: &Overrides, sources: Sources) -> Result<Study, Vec<Error>> {
    let mut problems = Problems::default();
    let (text, mut file) = read(path, &sources, &mut problems)?;
    let (at, noiseless, is_whole) = (&Place::new(path), overrides.noiseless, problems.is_empty());
    let has_candidates = !file.candidate.is_empty();

    let voxel_size_m = problems.keep(voxel_size(at, &file, overrides));
    let bounds_m = problems.keep(file.grid.bounds_m.map(|b| bounds(&at.key("grid"), b)).transpose());
    if is_whole {
        problems.keep_each(lists_that_must_be_there(at, &file));
    }
    let listed = file.scene.len();
    let mut scenes = scenes(at, &mut file, &sources, &mut problems);
    let written = Written::new(&text);
    let own_path = file.catalogue.take().map(|path| at.folder().join(path));
    let own = own_path.as_ref().map(|path| catalogue::read_own(at, path, &sources));
    let models: Vec<DeviceModel> = problems.keep(own.transpose()).flatten().unwrap_or_default();
    let currency = file.currency.clone();
    let context = sensor::SensorContext {
        seed: file.seed,
        noiseless,
        index: 0,
        earlier: &[],
        poses: 0,
        sources: &sources,
        models: &models,
        currency: currency.as_deref(),
        scenes: &scenes,
        has_all_scenes: is_whole && scenes.len() >= listed && listed > 0,
        surfaces: &Surfaces::default(),
        line_of: &|steps| written.line_of(steps),
    };
    let of_catalogue =
        own_path.map(|path| catalogue::unnamed_warnings((at.file, &path), &file.sensor, context));
    let mut of_sensors = Problems::default();
    let sensors = sensors(at, take(&mut file.sensor), context, &mut of_sensors);
    let reflectances =
        problems.keep(super::reflectance::shade(at, &mut scenes, &sensors)).unwrap_or_default();
    let stopping = problems.keep(stopping(at, &mut file, &sensors));
    let known = stopping.as_ref().map(Option::as_ref);
    let regions = regions(at, take(&mut file.region), is_whole, known, &mut problems);
    problems.keep_all(of_sensors.none());
    problems.keep_each(rules(at, &file, noiseless, (&scenes, &regions, &sensors)));
    // Keys that name sensors can be checked only if all sensors could be read.
    let (Some(voxel_size_m), Some(bounds_m), Some(stopping), true) =
        (voxel_size_m, bounds_m, stopping, problems.is_empty())
    else {
        return Err(all(problems));
    };
    let demands = demands(at, &mut file, &regions, &sensors, stopping.is_some())?;
    // Without noise every repeat would be the first again.
    let noisy = sensors.iter().any(|sensor| sensor.kind.is_noisy());
    let repeats = if noisy { file.repeats } else { 1 };
    let combinations = combination::check(at, take(&mut file.combination), file.fusion, &sensors)?;
    let snapshots: usize = scenes.iter().map(|scene| scene.snapshots).sum();
    let per_choice = regions.len() * snapshots * repeats as usize;
    combination::check_rows(at, &combinations, &sensors, per_choice).map_err(|e| vec![e])?;
    let known = choose::ChooseNames {
        fusion: file.fusion,
        currency: file.currency.as_deref(),
        regions: &regions,
        sensors: &sensors,
        has_requirements: !demands.requirements.is_empty(),
        has_stopping: stopping.is_some(),
    };
    let choose = match file.choose {
        Some(file) => Some(choose::check(at, file, &known)?),
        None => choose::usual(&known),
    };
    let mut warnings = diagnostics::warnings(&text);
    warnings.extend(of_catalogue.into_iter().flatten());
    warnings.extend(stopping.iter().flat_map(|stopping| stopping.warnings.clone()));
    warnings.extend(demands.approach.warning());
    warnings.extend(latch_warnings(&sensors, &demands));
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
        requirements: demands.requirements,
        mounting_error: demands.mounting_error,
        postures: demands.postures,
        approach: demands.approach,
        has_approach: demands.has_approach,
        stopping,
        reflectances,
        models,
        noiseless,
        repeats,
        min_hits: file.min_hits,
        currency: file.currency,
        sources,
        kept_rays: KeptRays::default(),
    })
}

/// The text of a study, and its keys.
fn read(path: &Path, sources: &Sources, problems: &mut Problems) -> Result<(String, StudyFile), Vec<Error>> {
    refuse_folder(path, "a study").map_err(|e| vec![e])?;
    let text = sources.text(path).map_err(|e| vec![e])?;
    refuse_scene(path, &text).map_err(|e| vec![e])?;
    match parse_in_parts(path, &text, &LISTS, problems) {
        Some(file) => Ok((text, file)),
        None => Err(all(take(problems))),
    }
}

/// The errors of lists that must have an entry.
fn lists_that_must_be_there(at: &Place, file: &StudyFile) -> [Result<()>; 3] {
    [
        at.some("scene", &file.scene, "[[scene]] file = \"scene.toml\""),
        at.some("region", &file.region, "[[region]] name = \"robot\""),
        at.some("sensor", &file.sensor, "[[sensor]] name = \"camera\""),
    ]
}

/// The rules that need no more than what could be read.
fn rules(
    at: &Place,
    file: &StudyFile,
    noiseless: bool,
    (scenes, regions, sensors): (&[SceneSpec], &[(String, RegionSpec)], &[Sensor]),
) -> [Result<()>; 8] {
    [
        at.unique("scene", scenes.iter().map(|s| s.name.as_str())),
        at.unique("region", regions.iter().map(|(name, _)| name.as_str())),
        at.unique("sensor", sensors.iter().map(|s| s.name.as_str())),
        no_semicolons(at, sensors),
        if file.mixed_noise || noiseless { Ok(()) } else { no_mixed_noise(at, sensors) },
        match (1..=MAX_REPEATS).contains(&file.repeats) {
            true => Ok(()),
            false => Err(at.wrong("repeats", file.repeats, &format!("must be from 1 to {MAX_REPEATS}"))),
        },
        match file.min_hits {
            0 => Err(at.wrong("min_hits", 0, "must be 1 or more")),
            _ => Ok(()),
        },
        Cost::check_currency(at, file.currency.as_deref()),
    ]
}

/// What a study requires of its sensors, and under which conditions.
struct Demands {
    mounting_error: Option<MountingError>,
    approach: Approach,
    has_approach: bool,
    postures: Vec<Posture>,
    requirements: Vec<Requirement>,
}

fn demands(
    at: &Place,
    file: &mut StudyFile,
    regions: &[(String, RegionSpec)],
    sensors: &[Sensor],
    has_stopping: bool,
) -> Result<Demands, Vec<Error>> {
    let one = |e: Error| vec![e];
    let mounting_error = file.mounting_error.take().map(|file| file.check(at)).transpose().map_err(one)?;
    let has_approach = file.approach.as_ref().is_some_and(ApproachFile::asks);
    let known = approach::ApproachNames { regions, sensors };
    let approach = approach::check(at, file.approach.take(), &known).map_err(one)?;
    let postures = file.postures.take().map(|file| file.check(at, approach.standing_m())).transpose();
    let postures = postures.map_err(one)?.unwrap_or_default();
    no_postures_of_recordings(at, &postures, sensors).map_err(one)?;
    let known = require::RequirementNames {
        regions,
        approach: &approach,
        has_draws: mounting_error.is_some(),
        has_postures: !postures.is_empty(),
        has_stopping,
    };
    let requirements = require::check(at, take(&mut file.require), &known)?;
    Ok(Demands { mounting_error, approach, has_approach, postures, requirements })
}

/// What verdicts take for granted of sensors that latch, and what states whether it is so.
fn latch_warnings(sensors: &[Sensor], demands: &Demands) -> Vec<String> {
    let asks = demands.has_approach || demands.requirements.iter().any(Requirement::is_of_nearness);
    let proof = match asks {
        true => "perirobot approach states whether there is another way in",
        false => {
            "nothing states whether there is another way in: add [approach], with an [[approach.entry]] where people come from"
        }
    };
    let warning = |sensor: &Sensor| {
        format!(
            "sensor {:?}: latches: people in its zone count as detected on the way in, and must be outside when it is reset; \
             {proof}",
            sensor.name
        )
    };
    sensors.iter().filter(|sensor| sensor.kind.latches()).map(warning).collect()
}

/// A recording shows the people who were there, and nobody else.
fn no_postures_of_recordings(at: &Place, postures: &[Posture], sensors: &[Sensor]) -> Result<()> {
    match sensors.iter().find(|sensor| sensor.kind.name() == "recorded") {
        Some(sensor) if !postures.is_empty() => {
            let what = format!(
                "postures and sensor {:?}, which was recorded with the people who were there",
                sensor.name
            );
            Err(at.says(what).with_advice("take one of them away"))
        }
        _ => Ok(()),
    }
}

/// What `[stopping]` says, if the study has it.
fn stopping(at: &Place, file: &mut StudyFile, sensors: &[Sensor]) -> Result<Option<Stopping>> {
    let floor = file.approach.as_ref().map_or(stopping::StandingFloor::default(), |approach| {
        stopping::StandingFloor { z_m: approach.standing_m(), is_auto: approach.has_several_floors() }
    });
    // Sensors that are in no set of the study make no distance larger; [choose] may take any.
    let is_used = |sensor: &&Sensor| {
        let named = |combination: &file::CombinationFile| combination.sensors.contains(&sensor.name);
        file.combination.is_empty() || file.choose.is_some() || file.combination.iter().any(named)
    };
    let used: Vec<Sensor> = sensors.iter().filter(is_used).cloned().collect();
    file.stopping.take().map(|file| stopping::check(at, file, &used, floor)).transpose()
}

/// Refuses what is a scene by its keys.
fn refuse_scene(path: &Path, text: &str) -> Result<()> {
    let keys = top_keys(text);
    match keys.contains_key("object") && !["scene", "sensor"].iter().any(|key| keys.contains_key(*key)) {
        true => Err(Error::input(path, "this looks like a scene file")
            .with_advice("name the study that lists it, with [[scene]]")),
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
            Err(Issue::says(format!("must be {rule}")).with_place(place).into())
        }
        other => Ok(other.unwrap_or(file.grid.voxel_size_m)),
    }
}

/// The scenes that are right, with their objects in each choice of their candidate places.
fn scenes(at: &Place, file: &mut StudyFile, sources: &Sources, problems: &mut Problems) -> Vec<SceneSpec> {
    let scenes = file.scene.iter().enumerate().filter_map(|(i, entry)| {
        let path = at.folder().join(&entry.file);
        // An error inside the file names the file; an error of opening it also names the study.
        let text = sources.text(&path).map_err(|e| at.wrap(e.with_place(format!("scene[{i}].file"))));
        let mut scene = problems.keep(text).and_then(|text| problems.keep_all(parse_scene(&path, text)))?;
        scene.name = entry.name.clone().unwrap_or(scene.name);
        Some(scene)
    });
    let scenes: Vec<SceneSpec> = scenes.collect();
    if file.candidate.is_empty() || !problems.is_empty() {
        return scenes;
    }
    let variants = candidates::expand(at, take(&mut file.candidate), scenes.clone());
    problems.keep(variants).unwrap_or(scenes)
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
    context: sensor::SensorContext,
    problems: &mut Problems,
) -> Vec<Sensor> {
    let (mut sensors, mut wrong, mut poses) = (Vec::<Sensor>::new(), Vec::new(), 0);
    for (index, keys) in entries.into_iter().enumerate() {
        let (name, like) = (keys.get("name").cloned(), keys.get("same_poses_as").cloned());
        if like.is_some() && wrong.contains(&like) {
            continue;
        }
        let context = sensor::SensorContext { index, earlier: &sensors, poses, ..context };
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
            Err(at.wrap(Error::input(format!("{name:?}"), "names of sensors and poses hold no semicolon")))
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
            Err(at.says(what).with_advice(cure))
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
