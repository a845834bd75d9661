//! Finds why a voxel stays unknown: how the ray nearest to its centre ended, and which object blocked it. `report` makes
//! tables and advice from the reasons.
//!
//! # Theory
//! The paper splits unknown space into what is monitored but occluded and what is not monitored. For a sensor
//! that casts rays, the ray nearest to the voxel's centre decides: for a camera that of the pixel into which
//! the centre falls, for any other table the ray whose direction is nearest to that of the centre, the first
//! of equals. The first reason that applies is the voxel's:
//!
//! | reason | condition | monitored |
//! |---|---|---|
//! | `out_of_view` | the centre is outside the field of view, and the ray does not cross the voxel; for a sensor without rays: the voxel is outside its volume | no |
//! | `out_of_range` | the ray enters the voxel beyond the longest range, or before the shortest of a radar, or, if it misses it, the centre is beyond | no |
//! | `muted` | the voxel is in the volume of a switch that is muted at this moment | no |
//! | `silent` | the voxel is in the volume of a switch that is off, which certifies nothing | yes |
//! | `between_rays` | the ray does not cross the voxel: rays are too sparse there | no |
//! | `hidden` | the ray returned from an object before it came to the voxel | yes |
//! | `blind` | the ray ended, before or behind the voxel, in an object closer than the shortest range | yes |
//! | `too_dark` | the ray ended in something too dark for its distance, and that certifies nothing | yes |
//! | `no_return` | the ray ended in nothing, or its return was lost, and that certifies nothing | yes |
//! | `misread` | the ray returned from the voxel or from behind it, and noise, or a mount that is off, had it read before it; a cover's noise read the voxel elsewhere | yes |
//! | `cancelled` | a sensor labels the voxel, and the votes of others cancel it | yes |
//!
//! The table is complete. A voxel is unknown if no sensor labels it, or if votes cancel. A sensor that casts
//! leaves a voxel that the ray crosses without a label only if the ray was blind, was silent, or returned and
//! was read before the voxel; in the last case its blocker lies before the voxel, or noise misread it.
//! Keypoint volumes only add to labels of rays. So the voxels of all reasons together are those that a sweep
//! counts as `uo` and `uf`.
//!
//! * With a shifted mount, the believed rays count. A ray's blocker is that of the true ray; it is in front of the
//!   voxel if its distance is less than that at which the believed ray enters the voxel.
//! * A field of view ([`perirobot_study::sensor::FieldOfView`]) is a camera's image to the outer edges of its pixels;
//!   of a LIDAR what lies within half a step of its outermost angles; of other tables what is as near to a
//!   ray as the middle of four neighbours would be. A voxel that the ray crosses is in view wherever its
//!   centre is: a scanner of one ring monitors all of its layer.
//! * An object hides if the voxel that ended the ray is one of its own; where several objects share it, the
//!   first in the scene's order. Tags and see-through objects end no ray. The blocker may be the voxel's own
//!   object: its far side, or its inside.
//! * For a voxel outside a radar's field, the radar's rays decide. A still object that stops them hides its own voxel, too.
//! * Of several sensors, the reason in the latest row of the table counts; of equals, that of the first sensor.
//!   So a silent switch does not replace the reason of a ray, and a voxel is out of view only if it is so for all.
//! * `between_rays` counts as not monitored: nothing is in the way, but no ray measures there.
//!
//! A voxel is *watched* ([`perirobot_study::sensor::watch`]) if a body in it would be noticed: it is monitored,
//! and neither hidden nor blinded.
//!
//! # Practice
//! For each unknown voxel, as many closed forms as there are sensors; if a ray crosses the voxel within
//! range, its blocker is searched again, in leaps. Voxels are processed in parallel and independently, so every
//! machine finds the same.

mod nearest;
pub(super) mod sight;
pub(super) mod witness;

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{SensorView, View};
use perirobot_march::voxel::BitGrid;
use witness::Witness;

/// Why a voxel is unknown, in the order of the table above: later reasons are closer to a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reason {
    /// No sensor looks there.
    OutOfView,
    /// It is too far away.
    OutOfRange,
    /// It is in the volume of a muted switch.
    Muted,
    /// It is in the volume of a switch that is off, which certifies nothing.
    Silent,
    /// No ray crosses it.
    BetweenRays,
    /// An object is in front of it.
    Hidden,
    /// An object is too close to the sensor.
    Blind,
    /// An object behind it, or in it, is too dark for its distance.
    TooDark,
    /// Nothing behind it returns the ray, or the return is lost, which certifies nothing.
    NoReturn,
    /// Noise moved the sensor's return.
    Misread,
    /// The votes of several sensors cancel each other.
    Cancelled,
}

impl Reason {
    /// All reasons, in their order.
    pub const ALL: [Reason; 11] = [
        Reason::OutOfView,
        Reason::OutOfRange,
        Reason::Muted,
        Reason::Silent,
        Reason::BetweenRays,
        Reason::Hidden,
        Reason::Blind,
        Reason::TooDark,
        Reason::NoReturn,
        Reason::Misread,
        Reason::Cancelled,
    ];

    /// The name in the column `reason` of reasons.csv.
    pub fn name(self) -> &'static str {
        match self {
            Reason::OutOfView => "out_of_view",
            Reason::OutOfRange => "out_of_range",
            Reason::Muted => "muted",
            Reason::Silent => "silent",
            Reason::BetweenRays => "between_rays",
            Reason::Hidden => "hidden",
            Reason::Blind => "blind",
            Reason::TooDark => "too_dark",
            Reason::NoReturn => "no_return",
            Reason::Misread => "misread",
            Reason::Cancelled => "cancelled",
        }
    }

    /// Whether a sensor watches the voxel anyway: the paper's "monitored, but occluded".
    pub fn is_monitored(self) -> bool {
        !matches!(self, Reason::OutOfView | Reason::OutOfRange | Reason::Muted | Reason::BetweenRays)
    }
}

/// A reason, and the object to blame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cause {
    /// The reason.
    pub reason: Reason,
    /// The object that ended the ray of a hidden, blind or too dark voxel, by its index in
    /// [`perirobot_scene::truth::Truth::objects`].
    pub object: Option<usize>,
}

/// The evidence of one sensor for a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sighting {
    /// It labels the voxel occupied.
    Occupied,
    /// It labels the voxel free.
    Free,
    /// It has no label for the voxel.
    Unknown(Cause),
}

/// Voxels that are unknown for the same cause.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missed {
    /// The cause.
    pub cause: Cause,
    /// The voxels, over the smallest window that contains them.
    pub voxels: BitGrid,
}

/// The number of unknown voxels by cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CauseTally {
    /// The cause.
    pub cause: Cause,
    /// The truly occupied ones.
    pub occupied: u64,
    /// The truly free ones.
    pub free: u64,
    /// The occupied ones that are people's.
    pub human: u64,
}

impl CauseTally {
    /// The total.
    pub fn voxels(&self) -> u64 {
        self.occupied + self.free
    }
}

impl View<'_> {
    /// Why voxels of a set are unknown: each cause that occurs, in order, with its voxels.
    pub(crate) fn why(&self, of: &BitGrid) -> Vec<Missed> {
        let mut unknown = of.clone();
        unknown.remove(&self.labels.occupied);
        unknown.remove(&self.labels.free);
        let witnesses: Vec<_> = self.members.iter().map(|member| Witness::new(self, member)).collect();
        let voxels: Vec<_> = unknown.voxels().collect();
        let causes: Vec<_> = voxels.par_iter().map(|&voxel| cause(&witnesses, voxel)).collect();
        let mut planes = BTreeMap::new();
        for (voxel, cause) in voxels.into_iter().zip(causes) {
            planes.entry(cause).or_insert_with(|| BitGrid::new(unknown.window())).set(voxel);
        }
        planes.into_iter().map(|(cause, plane)| Missed { cause, voxels: plane.trim() }).collect()
    }

    /// The evidence of each sensor for a voxel of the view, in the order of precedence: its label, or why it has none.
    pub fn sightings(&self, voxel: [i32; 3]) -> Vec<Sighting> {
        let sighting = |member: &SensorView| match [&member.says.occupied, &member.says.free] {
            [occupied, _] if occupied.get(voxel) => Sighting::Occupied,
            [_, free] if free.get(voxel) => Sighting::Free,
            _ => Sighting::Unknown(Witness::new(self, member).cause(voxel)),
        };
        self.members.iter().map(sighting).collect()
    }

    /// Why voxels of all regions are unknown.
    pub fn why_in_regions(&self) -> Vec<Missed> {
        self.why(&self.world.region_voxels())
    }

    /// The numbers of the missed voxels in a region; their sum is the number of unknown voxels there.
    pub fn tally(&self, missed: &[Missed], region: usize) -> Vec<CauseTally> {
        let truth = &self.truth;
        let to_tally = |Missed { cause, voxels }: &Missed| {
            let mut inside = voxels.clone();
            inside.keep(&self.world.regions[region].voxels);
            let all = inside.count();
            inside.keep(&truth.occupied);
            let occupied = inside.count();
            inside.keep(&truth.human);
            CauseTally { cause: *cause, occupied, free: all - occupied, human: inside.count() }
        };
        missed.iter().map(to_tally).filter(|tally| tally.voxels() > 0).collect()
    }

    /// The name of the object to blame.
    pub fn object(&self, cause: &Cause) -> Option<&str> {
        cause.object.map(|index| self.truth.objects[index].name.as_str())
    }
}

/// The cause of the sensor that was closest to a label.
fn cause(witnesses: &[Witness], voxel: [i32; 3]) -> Cause {
    let all = witnesses.iter().map(|witness| witness.cause(voxel));
    // The first of equals, so that the object does not depend on later sensors.
    let latest = all.reduce(|best, next| if next.reason > best.reason { next } else { best });
    latest.unwrap_or(Cause { reason: Reason::OutOfView, object: None })
}

#[cfg(test)]
pub(super) mod tests;
