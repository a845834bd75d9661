//! One sensor at one pose, from rays to evidence: the order in which the other files' work is done.

use fearless_simd::Level;

use super::beam::{Beam, Cone};
use super::bundle::{Bundle, Bundles, Lanes, Places, RAYS, TILE};
use super::end::{Ends, Rules, Sent};
use super::gather::Gather;
use super::meet::Meeting;
use super::plan::{self, LARGEST, Wanted};
use super::pyramid::Pyramid;
use super::strike::{self, Layer, Search, Strike};
use super::view::{BOXES, Sight, View};
use super::walk::{meets, walk};
use crate::backend::{Carving, Noise, Placement, Planes, Rays};
use crate::march::{self, End, Gates};

/// A table of rays made ready.
pub(super) struct Table {
    pub(super) bundles: Bundles,
    /// For a camera's bundles.
    cones: Vec<Cone>,
    gates: Gates,
    noise: Noise,
}

impl Table {
    pub(super) fn new(rays: &Rays) -> Self {
        let bundles = Bundles::new(rays);
        let tiles = if rays.image.is_some() { bundles.count() } else { 0 };
        let cones = (0..tiles).map(|tile| Cone::of(&bundles, tile)).collect();
        Table { bundles, cones, gates: rays.gates, noise: rays.noise.clone() }
    }
}

/// What stops rays: one layer, or what stands still in all snapshots and the rest.
pub(super) struct Blockers<'a> {
    pub(super) still: Option<&'a Layer>,
    pub(super) moving: &'a Layer,
}

/// A pose being sensed.
struct Shoot<'a> {
    placement: &'a Placement,
    /// Where its rays are cast from.
    caster: Placement,
    still: Option<Search<'a>>,
    moving: Search<'a>,
    /// Strikes on the still layer, bundle by bundle, if they are kept.
    first_hits: Option<&'a mut [Strike]>,
    /// Where the end of every ray is wanted.
    see: Option<&'a mut [End]>,
}

impl Shoot<'_> {
    /// Whether rays outside the window must be cast, too: their ends are wanted, or the mount is off, so that
    /// they hit elsewhere than they are believed to go.
    fn casts_all(&self) -> bool {
        self.see.is_some() || self.placement.truly.is_some()
    }
}

/// Length of a section of a beam in voxels, how many are looked at one after the other, and the most blockers
/// that are held against all rays: beyond that, rays go on one by one.
const SECTION: f32 = 4.0;
const SECTIONS: usize = 4;
const MOST_NEAR: usize = 48;

/// A table of rays in a scene, before it has a pose.
pub(super) struct Sensor<'a> {
    pub(super) level: Level,
    /// Whether vectors are wide enough to hold all rays against all blockers near.
    pub(super) wide: bool,
    pub(super) table: &'a Table,
    pub(super) blockers: Blockers<'a>,
    pub(super) wanted: &'a Wanted,
    pub(super) carving: Option<Carving>,
}

/// What a thread works on, kept from pose to pose.
pub(super) struct Desk {
    bundle: Bundle,
    /// The rays as they are truly cast, where those of the bundle are only believed.
    truly: Bundle,
    strikes: Lanes<Strike>,
    ends: Ends,
    places: Places,
    made: [Lanes<u32>; 3],
    pyramid: Option<Pyramid>,
    meeting: Meeting,
    /// Blockers that a beam comes to.
    near: Vec<[i32; 3]>,
}

impl Desk {
    pub(super) fn new(table: &Table) -> Self {
        Desk {
            bundle: Bundle::new(),
            truly: Bundle::new(),
            strikes: [strike::UNKNOWN; RAYS],
            ends: Ends::new(),
            places: Places { t_q16: [0; RAYS], axis: [2; RAYS] },
            made: [[0; RAYS]; 3],
            pyramid: table.bundles.image().map(Pyramid::new),
            meeting: Meeting::new(),
            near: Vec::new(),
        }
    }
}

/// Whether a tile of a camera is cast, and whether it sees voxels that are near.
#[derive(Clone, Copy, Default)]
struct Tile {
    cast: bool,
    near: bool,
}

impl Sensor<'_> {
    /// Casts and carves a placement. `first_hits` are the strikes on the still layer, bundle by bundle,
    /// filled in where they are unknown. `see` receives the end of every ray.
    pub(super) fn sense(
        &self,
        placement: &Placement,
        desk: &mut Desk,
        first_hits: Option<&mut [Strike]>,
        see: Option<&mut [End]>,
    ) -> Planes {
        let window = self.wanted.cells.window();
        let mut planes = Planes::blank(window);
        let caster = placement.caster();
        let search = |layer| {
            let cell = caster.origin_q16.map(|x| x >> 16);
            let ignore_q16 = self.table.gates.near_ignore_q16;
            Search { layer, ignore_q16, clearing: Layer::clearing(layer, cell) }
        };
        let (still, moving) = (self.blockers.still.map(search), search(self.blockers.moving));
        let mut shoot = Shoot { placement, caster, still, moving, first_hits, see };
        let carving = self.carving.unwrap_or_else(|| plan::carving(&self.table.bundles, window));
        match (carving, self.table.bundles.image()) {
            (Carving::Gather, Some(image)) => {
                self.gather(&View::new(placement, image), &mut shoot, desk, &mut planes);
            }
            _ => self.walk(&mut shoot, desk, &mut planes),
        }
        planes
    }

    /// Rays first, then voxels look at the image that they make.
    fn gather(&self, view: &View, shoot: &mut Shoot, desk: &mut Desk, planes: &mut Planes) {
        let bundles = &self.table.bundles;
        let mut tiles = vec![Tile { cast: shoot.casts_all(), near: false }; bundles.count()];
        let mut boxes = Vec::new();
        for corners in self.wanted.boxes.chunks(BOXES) {
            let sights = view.sights(self.level, corners, LARGEST, &view.all());
            for (i, &corner) in corners.iter().enumerate() {
                if let Some(sight) = sights.of(i) {
                    mark(&mut tiles, bundles, &sight);
                    boxes.push((corner, sight));
                }
            }
        }
        let Some(mut pyramid) = desk.pyramid.take() else { return };
        pyramid.clear();
        let until_q16 = view.near_q16();
        for bundle in (0..tiles.len()).filter(|&bundle| tiles[bundle].cast) {
            desk.bundle.start(self.level, shoot.placement, bundles.dirs_q15(bundle));
            self.cast(bundle, shoot, desk);
            let numbers = bundles.numbers(bundle);
            for lane in 0..RAYS {
                let freed = desk.ends.freed[lane];
                pyramid.set(numbers[lane] as usize, freed);
                if tiles[bundle].near {
                    walk(&desk.bundle, lane, freed, until_q16, &mut planes.free);
                }
            }
            desk.ends.mark(planes);
        }
        pyramid.build();
        let placement = shoot.placement;
        let (level, wanted) = (self.level, self.wanted);
        let gather = Gather { level, view, bundles, placement, pyramid: &pyramid, wanted };
        for (corner, sight) in boxes {
            gather.decide(corner, LARGEST, &sight, &mut planes.free);
        }
        desk.pyramid = Some(pyramid);
    }

    /// Ray by ray.
    fn walk(&self, shoot: &mut Shoot, desk: &mut Desk, planes: &mut Planes) {
        let bundles = &self.table.bundles;
        for bundle in 0..bundles.count() {
            desk.bundle.start(self.level, shoot.placement, bundles.dirs_q15(bundle));
            if !shoot.casts_all() && !(0..RAYS).any(|lane| meets(&desk.bundle, lane, &planes.free)) {
                continue;
            }
            self.cast(bundle, shoot, desk);
            for lane in 0..RAYS {
                walk(&desk.bundle, lane, desk.ends.freed[lane], march::NEVER, &mut planes.free);
            }
            desk.ends.mark(planes);
        }
    }

    /// How the rays of a bundle end, which are on the desk as they are believed to go.
    fn cast(&self, bundle: usize, shoot: &mut Shoot, desk: &mut Desk) {
        let table = self.table;
        desk.strikes = [strike::NOTHING; RAYS];
        let is_off = shoot.placement.truly.is_some();
        if is_off {
            std::mem::swap(&mut desk.bundle, &mut desk.truly);
            desk.bundle.start(self.level, &shoot.caster, table.bundles.dirs_q15(bundle));
        }
        if let Some(still) = &shoot.still {
            let part = bundle * RAYS..(bundle + 1) * RAYS;
            match shoot.first_hits.as_mut().map(|first_hits| &mut first_hits[part]) {
                Some(kept) if kept[0] != strike::UNKNOWN => desk.strikes.copy_from_slice(kept),
                kept => {
                    self.strike(still, bundle, &shoot.caster, desk);
                    kept.into_iter().for_each(|kept| kept.copy_from_slice(&desk.strikes));
                }
            }
        }
        self.strike(&shoot.moving, bundle, &shoot.caster, desk);
        if is_off {
            std::mem::swap(&mut desk.bundle, &mut desk.truly);
        }
        let rules = Rules {
            gates: &table.gates,
            noise: &table.noise,
            draws: shoot.placement.draws,
            size: self.blockers.moving.blockers.window().size,
            all: shoot.see.is_some(),
        };
        let numbers = table.bundles.numbers(bundle);
        let bundles = Sent { believed: &desk.bundle, truly: is_off.then_some(&desk.truly) };
        desk.ends.end(self.level, &bundles, &numbers, &desk.strikes, &rules, &self.wanted.cells);
        if let Some(see) = &mut shoot.see {
            (0..RAYS).for_each(|lane| see[numbers[lane] as usize] = desk.ends.get(lane));
        }
    }

    /// The strikes of a bundle on a layer, where they come before those already known.
    fn strike(&self, search: &Search, bundle: usize, placement: &Placement, desk: &mut Desk) {
        let range = strike::range(self.table.gates.range_max_q16);
        let Some(cone) = self.table.cones.get(bundle) else {
            for lane in 0..RAYS {
                let known = desk.strikes[lane];
                let ray = desk.bundle.ray(lane, [0; 3]);
                desk.strikes[lane] = search.strike(ray, true, known.min(range), known);
            }
            return;
        };
        let beam = cone.sent(placement);
        let mut clear = beam.clear(search);
        let mut open = u64::MAX;
        if self.wide && clear > 0.0 {
            (open, clear) = self.meet(search, &beam, clear, desk, range);
        }
        if open == 0 {
            return;
        }
        let clear_q16 = (clear * 65_536.0) as u32;
        if clear_q16 > 0 {
            desk.places.t_q16 = [clear_q16; RAYS];
            desk.bundle.made(self.level, &desk.places, &mut desk.made);
        } else {
            desk.made = [[0; RAYS]; 3];
        }
        for lane in (0..RAYS).filter(|lane| open >> lane & 1 == 1) {
            let ray = desk.bundle.ray(lane, std::array::from_fn(|r| desk.made[r][lane]));
            let known = desk.strikes[lane];
            desk.strikes[lane] = search.strike(ray, clear_q16 == 0, known.min(range), known);
        }
    }

    /// The strikes of rays that end soon after where a beam is clear. Says which lanes are open still, and
    /// from where.
    fn meet(&self, search: &Search, beam: &Beam, clear: f32, desk: &mut Desk, range: Strike) -> (u64, f32) {
        let grid = search.layer.blockers.window();
        let mut open = u64::MAX;
        let mut from = clear;
        desk.meeting.start(self.level, &desk.bundle);
        for _ in 0..SECTIONS {
            let to = from + SECTION;
            let section = beam.section(from, to);
            desk.near.clear();
            search.layer.blockers.each_in(&section, |cell| {
                if beam.touches(cell, to) {
                    desk.near.push(cell);
                }
            });
            if desk.near.len() > MOST_NEAR {
                break;
            }
            for cell in &desk.near {
                let away = std::array::from_fn(|r| cell[r] - desk.bundle.cell[r]);
                if away != [0; 3] {
                    desk.meeting.meet(self.level, away, search.ignore_q16);
                }
            }
            let until = u64::from(strike::range((to * 65_536.0) as u32));
            let inside = section.intersection(&grid) == section;
            for lane in 0..RAYS {
                let (entered, known) = (desk.meeting.entered[lane], desk.strikes[lane]);
                // A ray that has come to the end of its range may have left the grid before.
                let ended = entered.min(known.into()) <= until || inside && u64::from(range) <= until;
                if ended && open >> lane & 1 == 1 {
                    let first = entered < u64::from(known.min(range));
                    desk.strikes[lane] = if first { entered as Strike } else { known };
                    open &= !(1 << lane);
                }
            }
            // Rays that are open may have left the grid in this section: they go on from where they surely
            // had not.
            if open == 0 || !inside {
                break;
            }
            from = to;
        }
        (open, from)
    }
}

/// Marks the tiles that see a box.
fn mark(tiles: &mut [Tile], bundles: &Bundles, Sight { rect, near, .. }: &Sight) {
    let across = bundles.image().map_or(1, |image| image.size_px[0].div_ceil(TILE));
    for v in rect.first[1] / TILE..=rect.last[1] / TILE {
        for u in rect.first[0] / TILE..=rect.last[0] / TILE {
            let tile = &mut tiles[(v * across + u) as usize];
            *tile = Tile { cast: true, near: tile.near | *near };
        }
    }
}
