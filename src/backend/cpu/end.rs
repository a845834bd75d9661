//! From what rays struck to how they ended: ranges, noise, and where each is read. What that proves of the cells is marked
//! elsewhere.
//!
//! # Theory
//! A ray's place, a distance and an axis, says how many crossings of each axis it has made, in closed form (`SEMANTICS.md`,
//! "A ray, in integers"); so neither path nor cell need be kept from the search.

use fearless_simd::{Level, Simd, dispatch};

use super::bundle::{Bundle, Lanes, Places, RAYS};
use super::strike::{self, Strike};
use crate::march::{self, BLIND, End, Gates, LEFT, NOTHING, RETURN};

/// How the rays of a bundle ended.
pub(super) struct Ends {
    pub(super) ends: Lanes<End>,
    /// For each return, the crossings of each axis made on reaching its endpoint.
    pub(super) made: [Lanes<u32>; 3],
    places: Places,
    steps_q16: Lanes<i32>,
}

/// What decides how rays end.
pub(super) struct Rules<'a> {
    pub(super) gates: &'a Gates,
    /// Steps of noise; none for a silent sensor.
    pub(super) noise_q16: &'a [i32],
    /// The hash of what precedes the ray.
    pub(super) draws: u32,
    /// The grid.
    pub(super) size: [u32; 3],
    /// Whether crossings are wanted of rays that free nothing.
    pub(super) all: bool,
}

impl Ends {
    pub(super) fn new() -> Self {
        Ends {
            ends: [End { kind: NOTHING, crossings: 0 }; RAYS],
            made: [[0; RAYS]; 3],
            places: Places { t_q16: [0; RAYS], axis: [0; RAYS] },
            steps_q16: [0; RAYS],
        }
    }

    /// Ends the rays of a bundle; `first` is the number of each lane's ray.
    pub(super) fn end(
        &mut self,
        level: Level,
        bundle: &Bundle,
        rays: &Lanes<u32>,
        strikes: &Lanes<Strike>,
        rules: &Rules,
    ) {
        if !rules.noise_q16.is_empty() {
            let mut draws = [0; RAYS];
            dispatch!(level, simd => draw(simd, rules.draws, rays, &mut draws));
            for lane in 0..RAYS {
                self.steps_q16[lane] = rules.noise_q16[draws[lane] as usize];
            }
        }
        dispatch!(level, simd => read(simd, strikes, &self.steps_q16, &mut self.places));
        bundle.made(level, &self.places, &mut self.made);
        for lane in 0..RAYS {
            self.ends[lane] = self.end_of(bundle, lane, strikes[lane], rules);
        }
    }

    #[inline]
    fn end_of(&mut self, bundle: &Bundle, lane: usize, strike: Strike, rules: &Rules) -> End {
        if strike >= strike::LEFT {
            let kind = if strike == strike::LEFT && rules.gates.backdrop { LEFT } else { NOTHING };
            let free = kind == LEFT || rules.gates.no_return_is_free;
            if !free && !rules.all {
                return End { kind, crossings: 0 };
            }
            let begin = bundle.march(lane, [0; 3]);
            let room = march::room(&begin, rules.size);
            return End { kind, crossings: march::crossings_at(&begin, room, rules.gates.range_max_q16) };
        }
        let t_q16 = strike::crossing(strike).t_q16;
        if t_q16 < rules.gates.range_min_q16 {
            // Not where a return would be read, but where the blocker is.
            let places = strike::crossing(strike);
            let made = |r: usize| {
                let d = bundle.dir_q16[r][lane].unsigned_abs();
                let (first, period) = (bundle.first_q16[r][lane], bundle.period_q16[r][lane]);
                march::leap::made_at(first, period, d, r as u32, places.t_q16, places.axis)
            };
            return End { kind: BLIND, crossings: if rules.all { (0..3).map(made).sum() } else { 0 } };
        }
        let mut made: [u32; 3] = std::array::from_fn(|r| self.made[r][lane]);
        if self.steps_q16[lane] > 0 {
            let begin = bundle.march(lane, [0; 3]);
            let room = march::room(&begin, rules.size);
            if (0..3).any(|r| made[r] > room[r]) {
                made = march::made_until(&begin, room, self.places.t_q16[lane]);
                (0..3).for_each(|r| self.made[r][lane] = made[r]);
            }
        }
        End { kind: RETURN, crossings: made.iter().sum() }
    }
}

#[inline(always)]
fn draw<S: Simd>(_: S, hash: u32, rays: &Lanes<u32>, draws: &mut Lanes<u32>) {
    for lane in 0..RAYS {
        draws[lane] = march::draw(hash, rays[lane]);
    }
}

/// Where returns are read: at the crossing into the blocker, or with noise after all crossings up to there.
#[inline(always)]
fn read<S: Simd>(_: S, strikes: &Lanes<Strike>, steps_q16: &Lanes<i32>, places: &mut Places) {
    for lane in 0..RAYS {
        let hit = if strikes[lane] < strike::LEFT { strikes[lane] } else { 0 };
        let silent = steps_q16[lane] == 0;
        places.t_q16[lane] = march::noisy_q16(hit >> 2, steps_q16[lane]);
        places.axis[lane] = if silent { hit & 3 } else { 2 };
    }
}
