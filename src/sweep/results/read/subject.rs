//! The subject of a sweep, from `manifest.json` (scenes with their regions and baselines, combinations with their
//! sensors) and `poses.csv` (the poses of each sensor).

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use crate::results::columns::BETWEEN_MEMBERS;
use crate::results::files::{MANIFEST, read_regular};
use crate::results::manifest::{Identity, Manifest, SensorIdentity, Sensors};
use crate::results::read::CURE;
use crate::results::read::csv_rows::CsvRows;
use crate::results::swept::{self, CombinationResults, MemberResults, PoseResults, SceneResults, Subject};
use perirobot_march::error::{Issue, Site};
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use perirobot_scene::source::sha256;
use perirobot_study::input::{MAX_NAMES_BYTES, MAX_ROWS, bytes_of_names};
use perirobot_study::world::{Baselines, Described, DescribedRegion};

/// Upper limit of a grid's voxels; sums of such numbers do not overflow.
const MOST_VOXELS: u64 = 1 << 32;

/// Upper limit of a snapshot's duration: 10⁹ seconds for each of some crossed lists.
const MOST_SECONDS: f64 = 1e100;

/// A sensor with its poses.
struct Posed<'m> {
    file: &'m SensorIdentity,
    poses: Arc<Vec<PoseResults>>,
}

/// The subject of a sweep.
pub(super) fn read(folder: &Path, manifest: &Manifest) -> Result<Subject> {
    let path = folder.join(MANIFEST);
    let says = |issue: Issue| Error::from(issue.cure(CURE).with_place(&path));
    let file = &manifest.identity;
    plain_names(file).map_err(says)?;
    let dwell_s = swept::dwell_s(file.scenes.iter().map(|scene| scene.dwell_s).collect());
    if dwell_s.iter().flatten().any(|seconds| !(0.0..=MOST_SECONDS).contains(seconds)) {
        return Err(says(Issue::says("has an impossible dwell_s")));
    }
    let (scenes, regions, baselines) = scenes(&file.scenes).map_err(says)?;
    let poses = folder.join("poses.csv");
    let bytes = read_regular(&poses)?;
    let sensors = sensors(&poses, &bytes, &file.sensors)?;
    if sha256([&bytes]) != file.poses_sha256 {
        let what = format!("differs from the table of {MANIFEST}");
        return Err(Issue::damaged(what).cure(CURE).with_place(poses).into());
    }
    // Their indices are stored, and each is in at least one row.
    let ranges = file.combinations.iter().flat_map(|combination| combination.poses.iter().flatten());
    let listed: u128 = ranges.map(|[first, end]| end.saturating_sub(*first) as u128).sum();
    if listed > MAX_ROWS as u128 {
        return Err(says(Issue::says(format!(
            "has {listed} poses in its combinations, but at most {MAX_ROWS} are possible"
        ))));
    }
    let mut room = MAX_NAMES_BYTES;
    let combinations = file.combinations.iter().map(|entry| combination(entry, &sensors, &mut room));
    let combinations: Vec<CombinationResults> = combinations.collect::<Result<_, Issue>>().map_err(says)?;
    let of_one =
        |c: &CombinationResults| (c.choices() as u128).saturating_mul(c.representations.len() as u128);
    let choices = combinations.iter().map(of_one).fold(0, u128::saturating_add);
    let blocks = (file.repeats as u128).saturating_mul(baselines.len() as u128);
    let rows = choices.saturating_mul(regions.len() as u128).saturating_mul(blocks);
    if !(1..=MAX_ROWS as u128).contains(&rows) {
        return Err(says(Issue::says(format!(
            "has an impossible number of rows: {rows} (repeats = {})",
            file.repeats
        ))));
    }
    Ok(Subject { scenes, regions, repeats: file.repeats, combinations, baselines, dwell_s })
}

/// Names that are safe for a terminal.
fn plain_names(file: &Identity) -> Result<(), Issue> {
    let regions = file.scenes.iter().flat_map(|scene| scene.regions.iter().map(|region| &region.name));
    let variants = file.scenes.iter().filter_map(|scene| scene.variant.as_ref());
    let scenes = variants.flat_map(|variant| [&variant.scene, &variant.place]);
    let scenes = scenes.chain(file.scenes.iter().map(|scene| &scene.name));
    let sensors = file.sensors.iter().flat_map(|sensor| sensor.representations.iter().chain([&sensor.name]));
    let combinations = file.combinations.iter().map(|combination| &combination.name);
    match regions.chain(scenes).chain(sensors).chain(combinations).find(|name| !is_plain(name)) {
        Some(name) => Err(Issue::says(format!("the name {name:?} has control characters"))),
        None => Ok(()),
    }
}

fn is_plain(name: &str) -> bool {
    !name.contains(char::is_control)
}

type Scenes = (Vec<SceneResults>, Vec<String>, Vec<Vec<Baselines>>);

/// The scenes, the names of the regions, and the baselines of each moment and region.
fn scenes(files: &[Described]) -> Result<Scenes, Issue> {
    let Some(first) = files.first() else { return Err(Issue::says("scenes is empty")) };
    let regions: Vec<String> = first.regions.iter().map(|region| region.name.clone()).collect();
    let mut scenes: Vec<SceneResults> = Vec::new();
    let mut all: Vec<Vec<Baselines>> = Vec::new();
    for scene in files {
        if !scene.regions.iter().map(|region| &region.name).eq(&regions) {
            return Err(Issue::says(format!("scene {:?} has other regions than the first", scene.name)));
        }
        let moment = all.len();
        match scenes.last_mut() {
            Some(last) if last.name == scene.name && last.moments.len() == scene.snapshot => {
                last.moments.end += 1;
            }
            _ if scene.snapshot == 0 => {
                let variant = scene.variant.clone();
                scenes.push(SceneResults { name: scene.name.clone(), moments: moment..moment + 1, variant });
            }
            _ => {
                return Err(Issue::says(format!("scene {:?}", scene.name))
                    .with_advice(format!("snapshot {} is alone", scene.snapshot)));
            }
        }
        all.push(scene.regions.iter().map(baselines).collect::<Result<_, _>>()?);
    }
    Ok((scenes, regions, all))
}

fn baselines(region: &DescribedRegion) -> Result<Baselines, Issue> {
    let Baselines { all_occupied, all_free, nothing_seen, ceiling } = region.baselines;
    let all = [all_occupied, all_free, nothing_seen, ceiling];
    if all.iter().flat_map(Confusion::numbers).any(|count| count > MOST_VOXELS) {
        return Err(Issue::says(format!(
            "region {:?} has more voxels in its baselines than a grid",
            region.name
        )));
    }
    Ok(region.baselines)
}

/// The sensors with their poses, in the file's order.
fn sensors<'m>(path: &Path, bytes: &[u8], files: &'m [SensorIdentity]) -> Result<Vec<Posed<'m>>> {
    let mut rows = CsvRows::new(path, bytes, &["sensor", "pose", "group", "x_m", "place"])?;
    let mut sensors = Vec::new();
    for file in files {
        let (mut poses, mut known) = (Vec::new(), HashSet::new());
        for _ in 0..file.poses {
            let row = rows.next()?;
            if row.text(0) != file.name {
                return Err(row.wrong(
                    0,
                    &format!("must be {:?}: {MANIFEST} has {} poses of it", file.name, file.poses),
                ));
            }
            if let Some(column) = [1, 2, 4].into_iter().find(|column| !is_plain(row.text(*column))) {
                return Err(row.wrong(column, "has control characters"));
            }
            let name = row.text(1).to_string();
            if !known.insert(name.clone()) {
                return Err(row.wrong(1, "occurs twice for this sensor"));
            }
            let group = (!row.text(3).is_empty()).then(|| row.text(2).to_string());
            poses.push(PoseResults { name, group, place: row.text(4).to_string() });
        }
        sensors.push(Posed { file, poses: Arc::new(poses) });
    }
    rows.end()?;
    Ok(sensors)
}

/// A combination; its representations are all combinations of its sensors' representations, the last sensor varying
/// fastest. `room` limits the bytes of their names.
fn combination(entry: &Sensors, sensors: &[Posed], room: &mut usize) -> Result<CombinationResults, Issue> {
    let says = |what: &str| {
        Err(Issue::says(what).with_place(Site::Subject(format!("combination {:?}", entry.name))))
    };
    if entry.sensors.is_empty() || entry.sensors.len() != entry.poses.len() {
        return says("must have sensors, and poses of each");
    }
    let known = |name: &String| sensors.iter().find(|sensor| sensor.file.name == *name);
    let names = entry.sensors.iter().filter_map(known).map(|sensor| &sensor.file.representations);
    let bytes = bytes_of_names(names);
    if bytes == 0 || bytes > *room {
        return says("must have a representation of each sensor, and not too many together");
    }
    *room -= bytes;
    let mut representations: Vec<String> = Vec::new();
    let mut members = Vec::new();
    for (name, ranges) in entry.sensors.iter().zip(&entry.poses) {
        let Some(sensor) = known(name) else {
            return says(&format!("has an unknown sensor {name:?}"));
        };
        if ranges.iter().any(|[first, end]| first >= end || *end > sensor.poses.len()) {
            return says(&format!("has unknown poses of {name:?}"));
        }
        if ranges.windows(2).any(|two| two[0][1] > two[1][0]) {
            return says(&format!("has poses of {name:?} twice"));
        }
        let candidates = ranges.iter().flat_map(|[first, end]| *first..*end).collect();
        members.push(MemberResults { sensor: name.clone(), poses: sensor.poses.clone(), candidates });
        let own = &sensor.file.representations;
        representations = match members.len() {
            1 => own.clone(),
            _ => {
                let joined =
                    |one: &String| own.iter().map(move |r| format!("{one}{BETWEEN_MEMBERS}{r}")).collect();
                representations.iter().flat_map(|one| -> Vec<String> { joined(one) }).collect()
            }
        };
    }
    Ok(CombinationResults { name: entry.name.clone(), members, representations })
}
