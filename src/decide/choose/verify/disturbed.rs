//! The poses that disturb each other, pair by pair from the definition.

use rayon::prelude::*;

use perirobot_study::input::{Disturb, Study};
use perirobot_study::sensor::lens::Lens;
use perirobot_study::sensor::{Sensor, Setting};
use perirobot_study::world::World;

/// Pairs of sensors and candidates that disturb each other, in both orders, sorted.
#[derive(Clone, Debug, Default)]
pub(crate) struct DisturbedPairs(Vec<[[usize; 2]; 2]>);

impl DisturbedPairs {
    /// None at all.
    pub(crate) fn none() -> &'static DisturbedPairs {
        static NONE: DisturbedPairs = DisturbedPairs(Vec::new());
        &NONE
    }

    /// Those among some candidates of a study, in any world.
    pub(crate) fn from_items(
        items: &[[usize; 2]],
        (study, worlds): (&Study, &[World]),
        disturb: Option<Disturb>,
    ) -> DisturbedPairs {
        let Some(disturb) = disturb else { return DisturbedPairs::default() };
        let disturb_each_other = |a: [usize; 2], b: [usize; 2]| {
            let setting = |world: &World, item: [usize; 2]| world.settings[item[0]][item[1]];
            let mut last = None;
            worlds.iter().any(|world| {
                let settings = [a, b].map(|item| setting(world, item));
                let is_new = last.replace(settings) != Some(settings);
                let sensors = [a, b].map(|item| &study.sensors[item[0]]);
                is_new && disturbs(sensors, settings, world, &disturb)
            })
        };
        let with = |&a: &[usize; 2]| {
            let others = items.iter().filter(|&&b| a != b && disturb_each_other(a, b));
            others.map(|&b| [a, b]).collect::<Vec<_>>()
        };
        let mut pairs: Vec<[[usize; 2]; 2]> = items.par_iter().flat_map_iter(with).collect();
        pairs.sort_unstable();
        DisturbedPairs(pairs)
    }

    /// Whether two of the candidates disturb each other.
    pub(crate) fn has(&self, a: [usize; 2], b: [usize; 2]) -> bool {
        self.0.binary_search(&[a, b]).is_ok()
    }
}

/// Whether two sensors disturb each other in a world.
fn disturbs(sensors: [&Sensor; 2], settings: [Setting; 2], world: &World, disturb: &Disturb) -> bool {
    let [Some(one), Some(other)] = sensors.map(|sensor| sensor.emits.as_ref()) else { return false };
    if one != other {
        return false;
    }
    let lens = |number: usize| match settings[number] {
        Setting::Pose(pose) => Lens::new(&*sensors[number].kind, &pose),
        _ => None,
    };
    let (Some(one), Some(other)) = (lens(0), lens(1)) else { return false };
    let most_rad = disturb.apart_deg.map_or(f64::INFINITY, |most| most.to_radians() - 1e-9);
    if let (Some(a), Some(b)) = (one.off_view_rad(other.position_m), other.off_view_rad(one.position_m))
        && a.max(b) < most_rad
    {
        return true;
    }
    let Some(most) = disturb.overlap else { return false };
    let share = |of: Lens, seen_by: Lens| {
        let places = of.places_m(&world.grid);
        let seen = places.iter().map(|&place| f64::from(seen_by.reaches(place))).sum::<f64>();
        seen / places.len() as f64
    };
    share(one, other).max(share(other, one)) > most
}
