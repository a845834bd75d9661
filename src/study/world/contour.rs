//! The largest field of a scanner that the environment does not trip at any moment, and its reference contour.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use super::World;
use super::stuck::exact_station;
use crate::input::Study;
use crate::sensor::contour::{SHORTEST_M, Scanner, corners_mm, sector, thinning, to_metres};
use crate::sensor::kinds::lidar::FARTHEST_M;
use crate::sensor::{Kind, Station};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::Role;

/// The height of the field of a scanner that has none yet, in metres.
const USUAL_HEIGHT_M: f64 = 2.0;

/// How a contour is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourRule {
    /// How far a ray ends before what it meets, in metres.
    pub margin_m: f64,
    /// How long rays are at most, in metres, if less than the sensor's range.
    pub at_most_m: Option<f64>,
    /// Whether it is what the scanner measures of the environment, as it is, instead of a field that this does not trip.
    pub is_reference: bool,
    /// The case of its fields at whose moments it is drawn; without one those at which no case applies.
    pub case: Option<String>,
}

/// A polygon in the frame of a scanner.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Corners in millimetres, x ahead and y left.
    pub corners_mm: Vec<[i64; 2]>,
    /// The shortest of its rays.
    pub shortest: ContourRay,
    /// The longest of its rays.
    pub longest: ContourRay,
    /// How many rays were shortened because the environment tripped the field.
    pub shortened: usize,
    /// Each how many-th ray is a corner; the others are within the field of their neighbours.
    pub every: usize,
    /// The height of the field for which it was tested, in metres.
    pub height_m: f64,
    /// At how many moments it was drawn.
    pub moments: usize,
}

/// A ray of a contour.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourRay {
    /// Its direction: 0 is ahead, 90 left.
    pub azimuth_deg: f64,
    /// Its length.
    pub reach_m: f64,
    /// The object that ends it; `None` at the end of the range.
    pub limit: Option<String>,
}

/// How far a ray goes, over all moments.
#[derive(Clone, Copy)]
struct Reach {
    metres: f64,
    /// Which world has the least, and the voxel there.
    limit: Option<(usize, [i32; 3])>,
}

impl Contour {
    /// The contour of a sensor at a candidate over all moments of all scenes at which a case of its fields counts, or none.
    ///
    /// # Errors
    /// If the sensor is not a scanner with a level ring, if it is tilted, if there are no such moments, or if no field
    /// remains.
    pub fn new(study: &Study, worlds: &[World], at: [usize; 2], rule: &ContourRule) -> Result<Contour> {
        let [sensor, candidate] = at;
        let spec = &study.sensors[sensor];
        let place = |issue: Issue| {
            issue.with_place(format!("sensor {:?}, pose {}", spec.name, spec.candidates[candidate].name))
        };
        let Some(scanner) = spec.kind.as_scanner() else {
            let what = format!("is of kind {:?}, which has no field", spec.kind.name());
            return Err(place(Issue::says(what).with_advice("name a sensor of kind \"lidar\"")).into());
        };
        let case = rule.case.as_deref().map(|name| find_case(scanner, name)).transpose().map_err(place)?;
        let counts = |world: &&World| {
            scanner.applying_cases(&exact_station(world, &world.truth(), at)).first().copied() == case
        };
        let worlds: Vec<&World> = worlds.iter().filter(counts).collect();
        if worlds.is_empty() {
            let issue = match &rule.case {
                Some(name) => {
                    Issue::says(format!("its field case {name:?} counts at no moment of the scenes"))
                        .with_advice("correct at, scenes and speed_m_s of the case and of those before it")
                }
                None => Issue::says("at each moment one of its field cases counts")
                    .with_advice(format!("choose one of {:?}", scanner.cases())),
            };
            return Err(place(issue).into());
        }
        Contour::draw(scanner, &worlds, (at, case), rule).map_err(|issue| place(issue).into())
    }

    fn draw(
        scanner: &dyn Scanner,
        worlds: &[&World],
        (at, case): ([usize; 2], Option<usize>),
        rule: &ContourRule,
    ) -> Result<Contour, Issue> {
        let height_m = scanner.field_height_m(case).unwrap_or(USUAL_HEIGHT_M);
        let (azimuths_rad, mut reaches) = reaches(scanner, worlds, at, rule, height_m)?;
        let every = thinning(azimuths_rad.len());
        let azimuths_rad = thin(&azimuths_rad, every, |azimuths, kept| azimuths[kept]);
        reaches = if rule.is_reference {
            thin(&reaches, every, |reaches, kept| reaches[kept])
        } else {
            thin(&reaches, every, |reaches, kept| least_around(reaches, kept, every))
        };
        let shortened = match rule.is_reference {
            true => 0,
            false => shorten(scanner, worlds, at, &azimuths_rad, &mut reaches, height_m)?,
        };
        let ray = |number: usize| ContourRay {
            azimuth_deg: azimuths_rad[number].to_degrees(),
            reach_m: reaches[number].metres,
            limit: reaches[number].limit.map(|(world, hit)| name_of(worlds[world], hit)),
        };
        let by_length = |a: &usize, b: &usize| reaches[*a].metres.total_cmp(&reaches[*b].metres);
        let numbers = 0..reaches.len();
        let [shortest, longest] = [numbers.clone().min_by(by_length), numbers.max_by(by_length)]
            .map(|number| number.map_or(0, |n| n));
        Ok(Contour {
            corners_mm: corners_mm(&azimuths_rad, &metres(&reaches))?,
            shortest: ray(shortest),
            longest: ray(longest),
            shortened,
            every,
            height_m,
            moments: worlds.len(),
        })
    }

    /// Its area.
    pub fn area_m2(&self) -> f64 {
        let next = self.corners_mm.iter().cycle().skip(1);
        let twice: i64 = self.corners_mm.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
        twice as f64 / 2e6
    }

    /// Its corners as a table, which a field reads.
    pub fn to_csv(&self) -> String {
        let rows = to_metres(&self.corners_mm);
        let rows = rows.iter().map(|[x, y]| format!("{x:.3},{y:.3}\n"));
        std::iter::once("x_m,y_m\n".into()).chain(rows).collect()
    }
}

/// The number of a case by its name.
fn find_case(scanner: &dyn Scanner, name: &str) -> Result<usize, Issue> {
    let known = scanner.cases();
    known.iter().position(|known| *known == name).ok_or_else(|| match known.is_empty() {
        true => Issue::says(format!("has no field case {name:?}"))
            .with_advice("it has one field: write [[sensor.field_cases]] for others"),
        false => Issue::says(format!("has no field case {name:?}: expected one of {known:?}")),
    })
}

/// How far the rays of the level ring go at all moments, by their azimuths.
fn reaches(
    scanner: &dyn Scanner,
    worlds: &[&World],
    at: [usize; 2],
    rule: &ContourRule,
    height_m: f64,
) -> Result<(Vec<f64>, Vec<Reach>), Issue> {
    let most_m = rule.at_most_m.unwrap_or(FARTHEST_M).min(FARTHEST_M);
    let margin_m = if rule.is_reference { 0.0 } else { rule.margin_m };
    let mut azimuths_rad = Vec::new();
    let mut least: Vec<Reach> = Vec::new();
    for (number, world) in worlds.iter().enumerate() {
        let truth = world.truth();
        let ring = scanner.clear_rays(&exact_station(world, &truth, at), height_m)?;
        if number == 0 {
            azimuths_rad = ring.iter().map(|ray| ray.azimuth_rad).collect();
            least = vec![Reach { metres: most_m, limit: None }; ring.len()];
        }
        for (reach, ray) in least.iter_mut().zip(&ring) {
            let metres = ray.reach_m - if ray.hit.is_some() { margin_m } else { 0.0 };
            if metres < reach.metres {
                *reach = Reach { metres, limit: ray.hit.map(|hit| (number, hit)) };
            }
        }
    }
    if least.iter().all(|reach| reach.metres <= SHORTEST_M) {
        return Err(no_field());
    }
    least.iter_mut().for_each(|reach| reach.metres = reach.metres.max(SHORTEST_M));
    Ok((azimuths_rad, least))
}

fn no_field() -> Issue {
    Issue::says("the environment leaves no field")
        .with_advice("move the scanner away from what is around it, or take a smaller margin")
}

/// Each so many-th of some values, and the last.
fn thin<T: Copy>(all: &[T], every: usize, value: impl Fn(&[T], usize) -> T) -> Vec<T> {
    let last = all.len().saturating_sub(1);
    let kept = (0..last).step_by(every).chain((!all.is_empty()).then_some(last));
    kept.map(|kept| value(all, kept)).collect()
}

/// The least reach of a ray and of those around it that are not kept.
fn least_around(reaches: &[Reach], kept: usize, every: usize) -> Reach {
    let around = kept.saturating_sub(every - 1)..(kept + every).min(reaches.len());
    reaches[around]
        .iter()
        .copied()
        .reduce(|a, b| if b.metres < a.metres { b } else { a })
        .unwrap_or(reaches[kept])
}

fn metres(reaches: &[Reach]) -> Vec<f64> {
    reaches.iter().map(|reach| reach.metres).collect()
}

/// Shortens rays by half a voxel until the environment does not trip their field at any moment; how many were shortened.
fn shorten(
    scanner: &dyn Scanner,
    worlds: &[&World],
    at: [usize; 2],
    azimuths_rad: &[f64],
    reaches: &mut [Reach],
    height_m: f64,
) -> Result<usize, Issue> {
    let mut shortened = BTreeSet::new();
    loop {
        let mut is_done = true;
        for (number, world) in worlds.iter().enumerate() {
            let truth = world.truth();
            let station = exact_station(world, &truth, at);
            loop {
                let corners = to_metres(&corners_mm(azimuths_rad, &metres(reaches))?);
                let field = scanner.guard(corners.into_iter().map(DVec2::from_array).collect(), height_m);
                field.check(&station).map_err(|_| no_field())?;
                let tripping = field.stuck_by(&station);
                if tripping.is_empty() {
                    break;
                }
                is_done = false;
                let too_long = too_long_rays(&*field, &station, &tripping, azimuths_rad, reaches);
                if too_long.is_empty() {
                    return Err(no_field());
                }
                for (ray, voxel) in too_long {
                    let metres = reaches[ray].metres - truth.grid.voxel_size_m / 2.0;
                    reaches[ray] = Reach { metres: metres.max(SHORTEST_M), limit: Some((number, voxel)) };
                    shortened.insert(ray);
                }
            }
        }
        if is_done {
            return Ok(shortened.len());
        }
    }
}

/// The rays that end behind voxels which trip a field, with one of these voxels each: of the two beside a voxel the longer,
/// as the shorter may end at it.
fn too_long_rays(
    field: &dyn Kind,
    at: &Station,
    tripping: &BitGrid,
    azimuths_rad: &[f64],
    reaches: &[Reach],
) -> BTreeMap<usize, [i32; 3]> {
    let (grid, pose) = (&at.truth.grid, at.pose());
    let frame = field.frame(&pose);
    let of = |voxel: [i32; 3]| {
        let away = grid.corner_m(voxel) + grid.voxel_size_m / 2.0 - pose.position_m;
        let towards_rad = libm::atan2(away.dot(frame.y_axis), away.dot(frame.x_axis));
        let [a, b] = sector(azimuths_rad, towards_rad);
        let longer = if reaches[a].metres < reaches[b].metres { b } else { a };
        (reaches[longer].metres > SHORTEST_M).then_some((longer, voxel))
    };
    tripping.voxels().filter_map(of).collect()
}

/// The object of the environment that a voxel of a world belongs to.
fn name_of(world: &World, voxel: [i32; 3]) -> String {
    let truth = world.truth();
    let mut objects = truth.objects.iter().filter(|object| object.role == Role::Environment);
    let found = objects.find(|object| object.voxels.get(voxel));
    found.map_or("the inside of a body".into(), |object| object.name.clone())
}
