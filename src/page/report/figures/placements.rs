//! Maps of walls and ceiling, coloured by the best score of each place, over all scenes and in each.

use std::sync::Arc;

use super::FiguredSweep;
use super::map::{Outline, colour, colour_bar, draw_map};
use super::names::{axis_name, columns, score_name};
use super::paper::{EDGE, WIDTH, begin, finish};
use super::part::{SceneRange, SweepPart};
use crate::render::plan::short_name;
use crate::report::charts::axis::extremes;
use crate::report::charts::sheet::{SMALL, lines};
use crate::report::series::Series;
use crate::report::table::number;
use crate::report::unfolded::{Map, PaperSpot, Position, maps};
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_scene::objects::Role;
use perirobot_scene::truth::ObjectVoxels;
use perirobot_study::input::Study;
use perirobot_study::sensor::Setting;
use perirobot_study::world::World;
use perirobot_study::world::place::{is_room, room_m};

/// The sensor of a series with several places, and their positions on paper.
#[derive(Clone, Debug)]
pub(super) struct PlacedSeries {
    series: Series,
    member: usize,
    maps: Vec<Map>,
}

impl PlacedSeries {
    /// For a series in which one sensor has several places in the world.
    pub(super) fn new(study: &Study, world: &World, series: Series) -> Option<PlacedSeries> {
        let combination = &study.combinations[series.combination];
        let positions = |member: &perirobot_study::input::Member| {
            let sensor = &study.sensors[member.sensor];
            let candidates = member.candidates.iter().filter(|_| sensor.on.is_none());
            let position = |&candidate: &usize| match sensor.candidates[candidate].setting {
                Setting::Pose(pose) => {
                    let group = sensor.candidates[candidate].group.as_str();
                    Some(Position { candidate, group, at: pose.position_m })
                }
                _ => None,
            };
            candidates.filter_map(position).collect::<Vec<_>>()
        };
        let all = combination.members.iter().map(positions).enumerate();
        let mut placed = all.filter(|(_, positions)| !positions.is_empty());
        let (member, positions) = placed.next()?;
        let maps = maps(&positions, Some(room_m(&world.truth())));
        let several = maps.iter().flat_map(|map| &map.parts).map(|part| part.spots.len()).sum::<usize>() > 1;
        (several && placed.next().is_none()).then_some(PlacedSeries { series, member, maps })
    }
}

/// For each candidate the best value of its choices, and the choice.
type Best = Vec<Option<(f64, usize)>>;

/// The caption and the file of the figure of a region and a series.
pub(super) fn draw(
    sweep: &FiguredSweep,
    part: &SweepPart,
    region: usize,
    placed: &PlacedSeries,
) -> Result<(String, Vec<u8>)> {
    let results = &sweep.results;
    let (title, place) = (placed.series.title(results), &results.regions[region]);
    let scores = part.scores.iter().map(|score| score_name(*score)).collect::<Vec<_>>().join(" and ");
    let caption = format!("{scores} in region {place} by the place of the sensor: {title}");
    let notes = format!(
        "The colour of a place is that of its best orientation, each with {}{}. One scale for all maps of a score. Ring: \
         the best place of a map. Outlines: objects (of the first of several scenes), the robot thick, in single scenes people dashed.",
        part.whole().is_mean_of(results),
        if part.extents.len() > 1 { ", below it each scene for itself" } else { "" },
    );
    let mut sheet = begin(&caption, &notes);
    let places = columns(part.scores.len(), [EDGE, WIDTH - EDGE]);
    let mut all: Vec<Vec<Best>> = Vec::new();
    for extent in &part.extents {
        let bests = part.scores.iter().map(|&score| best(sweep, placed, extent, (region, score)));
        all.push(bests.collect::<Result<_>>()?);
    }
    let spots = || placed.maps.iter().flat_map(|map| &map.parts).flat_map(|part| &part.spots);
    let ends = |(n, &score): (usize, &Score)| {
        let drawn =
            all.iter().flat_map(|row| spots().filter_map(move |spot| spot_best(score, spot, &row[n])));
        extremes(drawn.map(|(value, _)| value))
    };
    let ends: Vec<Option<[f64; 2]>> = part.scores.iter().enumerate().map(ends).collect();
    for (extent, row) in part.extents.iter().zip(&all) {
        let outlines = outlines(sweep, extent);
        for map in &placed.maps {
            sheet.words("strong", [EDGE, sheet.y + 12.0], &format!("{}: {}", extent.name, map.title));
            let top = sheet.y + 20.0;
            let mut end = top;
            for (n, best) in row.iter().enumerate() {
                let (score, Some(ends)) = (part.scores[n], ends[n]) else { continue };
                sheet.y = top;
                let first = first_best(score, map, best);
                let tooltip = |spot: &PaperSpot| {
                    let (value, choice) = spot_best(score, spot, best)?;
                    let name = results.combinations[placed.series.combination].label(choice);
                    let words = format!("{name}: {}", number(Some(value)));
                    Some((colour(value, ends), words, first == Some((value, choice))))
                };
                draw_map(&mut sheet, map, places[n], tooltip, &outlines);
                let named = first.map(|(value, choice)| {
                    let combination = &results.combinations[placed.series.combination];
                    let [label, place] = [combination.label(choice), combination.place_of(choice)];
                    format!("best {}: {label}, {place}", number(Some(value)))
                });
                let named = named.unwrap_or("no value here".into());
                let width = (places[n][1] - places[n][0]) / SMALL;
                for words in [named, extent.bounds(results, region, score)] {
                    for line in lines(&words, width) {
                        sheet.words("soft", [places[n][0], sheet.y + 10.0], &line);
                        sheet.y += 14.0;
                    }
                }
                end = end.max(sheet.y);
            }
            sheet.y = end + 10.0;
        }
    }
    let top = sheet.y;
    for ((&score, &[left, right]), ends) in part.scores.iter().zip(&places).zip(ends) {
        sheet.y = top;
        let name = axis_name(score);
        match ends {
            Some(ends) => colour_bar(&mut sheet, ends, [left + 14.0, right.min(left + 320.0)], &name),
            None => sheet.words("soft", [left, top + 14.0], &format!("{name}: no choice has a value")),
        }
    }
    sheet.y = top + 52.0;
    Ok((caption + ".", finish(sheet)))
}

fn best(
    sweep: &FiguredSweep,
    placed: &PlacedSeries,
    extent: &SceneRange,
    (region, score): (usize, Score),
) -> Result<Best> {
    let combination = &sweep.study.combinations[placed.series.combination];
    let sensor = combination.members[placed.member].sensor;
    let mut found: Best = vec![None; sweep.study.sensors[sensor].candidates.len()];
    for (choice, value) in placed.series.best(&sweep.results, &extent.moments, region, score)? {
        let best = &mut found[combination.choice(choice)[placed.member]];
        // The best comes first.
        *best = best.or(Some((value, choice)));
    }
    Ok(found)
}

/// The best candidate of a spot, and its choice.
fn spot_best(score: Score, spot: &PaperSpot, best: &Best) -> Option<(f64, usize)> {
    let values = spot.candidates.iter().filter_map(|&candidate| best[candidate]);
    values.reduce(|a, b| if score.merit(b.0) > score.merit(a.0) { b } else { a })
}

/// The best of a map, and its choice.
fn first_best(score: Score, map: &Map, best: &Best) -> Option<(f64, usize)> {
    let spots = map.parts.iter().flat_map(|part| &part.spots).filter_map(|spot| spot_best(score, spot, best));
    spots.reduce(|a, b| if score.merit(b.0) > score.merit(a.0) { b } else { a })
}

/// The objects of the first of some scenes, without people if there are several.
fn outlines(sweep: &FiguredSweep, extent: &SceneRange) -> Vec<Outline> {
    let truth = sweep.worlds[extent.moments.start].truth();
    let room = room_m(&truth);
    let objects = truth.objects.iter().filter(|object| !object.voxels.is_empty() && !is_room(object, room));
    let objects = objects.filter(|object| extent.scene.is_some() || object.role != Role::Human);
    let class = |role| match role {
        Role::Robot => "thing robot",
        Role::Human => "thing person",
        Role::Environment => "thing",
    };
    let outline = |object: &Arc<ObjectVoxels>| {
        let corners = object.bounds_m.map(|corner| corner.truncate());
        (short_name(&object.name).to_string(), class(object.role), corners)
    };
    objects.map(outline).collect()
}
