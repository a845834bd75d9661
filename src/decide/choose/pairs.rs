//! Pairs of candidates that are excluded from sets: too close, or disturbing each other.

use rayon::prelude::*;

use perirobot_study::input::{Disturb, Study};
use perirobot_study::sensor::Setting;
use perirobot_study::sensor::lens::Lens;
use perirobot_study::world::World;

/// Tolerance of a distance: lattices are computed in floating point.
const NEARLY: f64 = 1e-9;

/// The rules for pairs of a set.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairTerms {
    /// Least distance between two sensors, in metres.
    pub(crate) apart_m: f64,
    /// When sensors that emit the same kind of light disturb each other.
    pub(crate) disturb: Option<Disturb>,
}

/// A candidate in a world, reduced to what the rules need.
struct Posed<'a> {
    setting: Setting,
    emits: Option<&'a str>,
    lens: Option<Lens>,
}

/// For each candidate a bit for each other that a rule excludes in some world; empty if no rule applies.
pub(super) fn forbidden_pairs(
    study: &Study,
    items: &[[usize; 2]],
    worlds: &[World],
    terms: PairTerms,
) -> Vec<Vec<u64>> {
    if terms.apart_m <= NEARLY && terms.disturb.is_none() {
        return Vec::new();
    }
    let mut forbidden = vec![vec![0u64; items.len().div_ceil(64)]; items.len()];
    for (number, world) in worlds.iter().enumerate() {
        // Most worlds have the same sensor poses as the one before.
        if number > 0 && world.settings == worlds[number - 1].settings {
            continue;
        }
        let posed: Vec<Posed> = items.iter().map(|&item| Posed::new(study, world, item)).collect();
        let one_way: Vec<Vec<usize>> =
            (0..posed.len()).into_par_iter().map(|a| terms.excluded_by(&posed, a, world)).collect();
        for (a, others) in one_way.iter().enumerate() {
            for &b in others {
                forbidden[a][b / 64] |= 1 << (b % 64);
                forbidden[b][a / 64] |= 1 << (a % 64);
            }
        }
    }
    forbidden
}

/// The pairs of some candidates that may disturb each other in some world, by their places among them, the lower first.
pub fn disturbing_pairs(
    study: &Study,
    worlds: &[World],
    items: &[[usize; 2]],
    disturb: Disturb,
) -> Vec<[usize; 2]> {
    let terms = PairTerms { apart_m: 0.0, disturb: Some(disturb) };
    let forbidden = forbidden_pairs(study, items, worlds, terms);
    let is_forbidden = |a: usize, b: usize| forbidden[a][b / 64] >> (b % 64) & 1 == 1;
    let with = |a: usize| (a + 1..items.len()).filter(move |&b| is_forbidden(a, b)).map(move |b| [a, b]);
    (0..items.len()).flat_map(with).collect()
}

impl PairTerms {
    /// The candidates that a rule excludes for one, by their distance or by its view.
    fn excluded_by(&self, posed: &[Posed], a: usize, world: &World) -> Vec<usize> {
        let one = &posed[a];
        let overlap = self.disturb.and_then(|disturb| disturb.overlap);
        let places =
            one.lens.filter(|_| overlap.is_some()).map_or(Vec::new(), |lens| lens.places_m(&world.grid));
        let sees_too = |other: &Lens| {
            let shared = places.iter().filter(|place| other.reaches(**place)).count();
            overlap.is_some_and(|most| shared as f64 / places.len() as f64 > most)
        };
        let is_broken = |other: &Posed| {
            let is_near = match (one.setting, other.setting) {
                (Setting::Pose(at), Setting::Pose(other)) => {
                    at.position_m.distance(other.position_m) < self.apart_m - NEARLY
                }
                _ => false,
            };
            is_near
                || match (self.disturb, one.lens, other.lens) {
                    (Some(disturb), Some(lens), Some(other_lens)) if one.emits == other.emits => {
                        look_at_each_other(&disturb, &lens, &other_lens) || sees_too(&other_lens)
                    }
                    _ => false,
                }
        };
        (0..posed.len()).filter(|&b| b != a && is_broken(&posed[b])).collect()
    }
}

/// Whether each of two lenses is in the other's field of view, and close enough to its axis.
fn look_at_each_other(disturb: &Disturb, one: &Lens, other: &Lens) -> bool {
    let is_in_view = |lens: &Lens, other: &Lens| {
        let off_rad = lens.off_view_rad(other.position_m);
        off_rad.is_some_and(|off| disturb.apart_deg.is_none_or(|most| off < most.to_radians() - NEARLY))
    };
    is_in_view(one, other) && is_in_view(other, one)
}

impl<'a> Posed<'a> {
    fn new(study: &'a Study, world: &World, [sensor, candidate]: [usize; 2]) -> Posed<'a> {
        let (spec, setting) = (&study.sensors[sensor], world.settings[sensor][candidate]);
        let emits = spec.emits.as_deref();
        let lens = match setting {
            Setting::Pose(pose) if emits.is_some() => Lens::new(&*spec.kind, &pose),
            _ => None,
        };
        Posed { setting, emits, lens }
    }
}

#[cfg(test)]
pub(crate) mod plain_camera;
#[cfg(test)]
mod tests;
