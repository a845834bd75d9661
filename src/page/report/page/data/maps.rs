//! The data of the maps of a sensor's places for the page's script: their positions on paper, and the objects there.
//! The script adds screen sizes and colours.

use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::render::scale::{marks, step};
use crate::report::unfolded::{Map, MapPart, Position, maps};
use perirobot_study::sensor::{Sensor, Setting};

/// A scene's room and objects: corners in metres.
pub(super) struct Furnished {
    pub(super) room_m: [DVec3; 2],
    pub(super) things_m: Vec<[DVec3; 2]>,
}

/// A place on paper, in metres.
type OnPaper = [f64; 2];

/// The maps of a sensor's places, and the objects in each scene.
#[derive(Serialize)]
pub(super) struct MapsData {
    /// For each kind of room.
    maps: Vec<Vec<MapData>>,
    scenes: Vec<SceneOfMaps>,
}

#[derive(Serialize)]
struct SceneOfMaps {
    /// The maps of its room.
    maps: usize,
    /// For each map, part and object the corners of the covered area; empty for a sensor on a link.
    covered: Vec<Vec<Vec<[OnPaper; 2]>>>,
}

#[derive(Serialize)]
struct MapData {
    title: String,
    /// The axes to the right and up; `None` for unfolded walls.
    axes: Option<[usize; 2]>,
    /// Round metres along these.
    metres: Option<[Vec<String>; 2]>,
    /// The corners of the drawing, and of its part seen from above.
    ends: [OnPaper; 2],
    flat: [OnPaper; 2],
    parts: Vec<PartData>,
}

#[derive(Serialize)]
struct PartData {
    label: Option<LabelData>,
    /// Width and height of a spot in a lattice.
    size: Option<OnPaper>,
    /// The middle of each spot, with its candidates.
    spots: Vec<(OnPaper, Vec<usize>)>,
}

#[derive(Serialize)]
struct LabelData {
    text: String,
    at: OnPaper,
    is_turned: bool,
}

/// The maps of all candidates of a sensor.
pub(super) fn maps_data(sensor: &Sensor, scenes: &[Furnished]) -> MapsData {
    let position = |(candidate, one): (usize, &perirobot_study::sensor::Candidate)| match one.setting {
        Setting::Pose(pose) => Some((candidate, pose.position_m)),
        _ => None,
    };
    let all = sensor.candidates.iter().enumerate().filter_map(position);
    let positions: Vec<Position> = all
        .map(|(candidate, at)| Position { candidate, group: &sensor.candidates[candidate].group, at })
        .collect();
    let mut rooms: Vec<([DVec3; 2], Vec<Map>)> = Vec::new();
    let mut of_scenes = Vec::new();
    for Furnished { room_m, things_m } in scenes {
        let known = rooms.iter().position(|(known, _)| known == room_m);
        let number = known.unwrap_or_else(|| {
            rooms.push((*room_m, maps(&positions, Some(*room_m).filter(|_| sensor.on.is_none()))));
            rooms.len() - 1
        });
        let things = || things_m.iter().filter(|_| sensor.on.is_none());
        let on_part = |part: &MapPart| things().map(|thing| part.face.shadow(*thing).map(tidy)).collect();
        let on_map = |map: &Map| map.parts.iter().map(on_part).collect();
        of_scenes.push(SceneOfMaps { maps: number, covered: rooms[number].1.iter().map(on_map).collect() });
    }
    let maps = rooms.iter().map(|(_, maps)| maps.iter().map(map_data).collect()).collect();
    MapsData { maps, scenes: of_scenes }
}

fn map_data(map: &Map) -> MapData {
    let part = |part: &MapPart| PartData {
        label: part.label.as_ref().map(|label| LabelData {
            text: label.text.clone(),
            at: tidy(label.at),
            is_turned: label.is_turned,
        }),
        size: part.size.map(tidy),
        spots: part.spots.iter().map(|spot| (tidy(spot.at), spot.candidates.clone())).collect(),
    };
    MapData {
        title: map.title.clone(),
        axes: map.axes,
        metres: map.axes.map(|_| {
            [(0, 6.0), (1, 5.0)].map(|(r, marks)| round_metres(map.ends.map(|corner| corner[r]), marks))
        }),
        ends: map.ends.map(tidy),
        flat: map.flat.map(tidy),
        parts: map.parts.iter().map(part).collect(),
    }
}

/// About this many round metres between two places.
pub(super) fn round_metres([low, high]: [f64; 2], count: f64) -> Vec<String> {
    let apart = step((high - low).max(1e-3) / count);
    marks(low, high, apart).map(|(_, text)| text).collect()
}

/// Metres to a tenth of a millimetre.
fn tidy(at: DVec2) -> OnPaper {
    at.to_array().map(|metres| (metres * 1e4).round() / 1e4)
}
