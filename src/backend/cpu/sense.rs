//! One sensor at one pose, from rays to evidence: the order in which the other files' work is done.

use fearless_simd::Level;

use super::beam::Cone;
use super::bundle::{Bundle, Bundles, Lanes, Places, RAYS, TILE};
use super::end::{Ends, Rules};
use super::gather::{Gather, LARGEST};
use super::plan::{self, Carving, Wanted};
use super::pyramid::{Pyramid, Rect};
use super::strike::{self, Layer, Search, Strike};
use super::view::{Sight, View};
use super::walk::{meets, walk};
use crate::backend::{Placement, Planes, Rays};
use crate::march::{self, End, Gates, RETURN};
use crate::voxel::BitGrid;

/// A table of rays made ready.
pub(super) struct Table {
    pub(super) bundles: Bundles,
    /// For a camera's bundles.
    cones: Vec<Cone>,
    gates: Gates,
    noise_q16: Vec<i32>,
}

impl Table {
    pub(super) fn new(rays: &Rays) -> Self {
        let bundles = Bundles::new(rays);
        let tiles = if rays.image.is_some() { bundles.count() } else { 0 };
        let cones = (0..tiles).map(|tile| Cone::of(&bundles, tile)).collect();
        Table { bundles, cones, gates: rays.gates, noise_q16: rays.noise_q16.clone() }
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
    still: Option<Search<'a>>,
    moving: Search<'a>,
    /// Strikes on the still layer, bundle by bundle, if they are kept.
    hits: Option<&'a mut [Strike]>,
    /// Where the end of every ray is wanted.
    see: Option<&'a mut [End]>,
}

/// Who senses: a table of rays in a scene, whatever the pose.
pub(super) struct Sensor<'a> {
    pub(super) level: Level,
    pub(super) table: &'a Table,
    pub(super) blockers: Blockers<'a>,
    pub(super) wanted: &'a Wanted,
    pub(super) carving: Option<Carving>,
}

/// What a thread works on, kept from pose to pose.
pub(super) struct Desk {
    bundle: Bundle,
    strikes: Lanes<Strike>,
    ends: Ends,
    places: Places,
    made: [Lanes<u32>; 3],
    pyramid: Option<Pyramid>,
}

impl Desk {
    pub(super) fn new(table: &Table) -> Self {
        Desk {
            bundle: Bundle::new(),
            strikes: [strike::UNKNOWN; RAYS],
            ends: Ends::new(),
            places: Places { t_q16: [0; RAYS], axis: [2; RAYS] },
            made: [[0; RAYS]; 3],
            pyramid: table.bundles.image().map(Pyramid::new),
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
    /// Casts and carves a placement. `hits` are the strikes on the still layer, bundle by bundle, filled in where they are
    /// unknown. `see` receives the end of every ray.
    pub(super) fn sense(
        &self,
        placement: &Placement,
        desk: &mut Desk,
        hits: Option<&mut [Strike]>,
        see: Option<&mut [End]>,
    ) -> Planes {
        let window = self.wanted.cells.window();
        let mut planes = Planes { occupied: BitGrid::new(window), free: BitGrid::new(window) };
        let search = |layer| {
            let cell = placement.origin_q16.map(|x| x >> 16);
            let ignore_q16 = self.table.gates.near_ignore_q16;
            Search { layer, ignore_q16, clearing: Layer::clearing(layer, cell) }
        };
        let (still, moving) = (self.blockers.still.map(search), search(self.blockers.moving));
        let mut shoot = Shoot { placement, still, moving, hits, see };
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
        let mut tiles = vec![Tile { cast: shoot.see.is_some(), near: false }; bundles.count()];
        let mut boxes = Vec::new();
        for &corner in &self.wanted.boxes {
            let (rect, near) = match view.sight(corner, LARGEST) {
                Sight::Unseen => continue,
                Sight::Near(rect) => (rect, true),
                Sight::At { rect, .. } => (rect, false),
            };
            boxes.push((corner, rect));
            mark(&mut tiles, bundles, &rect, near);
        }
        let Some(mut pyramid) = desk.pyramid.take() else { return };
        pyramid.clear();
        let until_q16 = view.near_q16();
        for bundle in (0..tiles.len()).filter(|&bundle| tiles[bundle].cast) {
            self.cast(bundle, shoot, desk);
            let numbers = bundles.numbers(bundle);
            for lane in 0..RAYS {
                let freed = march::freed(desk.ends.ends[lane], self.table.gates.no_return_is_free);
                pyramid.set(numbers[lane] as usize, freed);
                if tiles[bundle].near {
                    walk(&desk.bundle, lane, freed, until_q16, &mut planes.free);
                }
            }
            occupy(&desk.bundle, &desk.ends, &mut planes.occupied);
        }
        pyramid.build();
        let placement = shoot.placement;
        let gather = Gather { view, bundles, placement, pyramid: &pyramid, wanted: self.wanted };
        for (corner, rect) in boxes {
            gather.decide(corner, LARGEST, &rect, &mut planes.free);
        }
        desk.pyramid = Some(pyramid);
    }

    /// Ray by ray.
    fn walk(&self, shoot: &mut Shoot, desk: &mut Desk, planes: &mut Planes) {
        let bundles = &self.table.bundles;
        for bundle in 0..bundles.count() {
            desk.bundle.start(self.level, shoot.placement, bundles.dirs_q15(bundle));
            if shoot.see.is_none() && !(0..RAYS).any(|lane| meets(&desk.bundle, lane, &planes.free)) {
                continue;
            }
            self.cast(bundle, shoot, desk);
            for lane in 0..RAYS {
                let freed = march::freed(desk.ends.ends[lane], self.table.gates.no_return_is_free);
                walk(&desk.bundle, lane, freed, march::NEVER, &mut planes.free);
            }
            occupy(&desk.bundle, &desk.ends, &mut planes.occupied);
        }
    }

    /// How the rays of a bundle end.
    fn cast(&self, bundle: usize, shoot: &mut Shoot, desk: &mut Desk) {
        let table = self.table;
        desk.bundle.start(self.level, shoot.placement, table.bundles.dirs_q15(bundle));
        desk.strikes = [strike::NOTHING; RAYS];
        if let Some(still) = &shoot.still {
            let part = bundle * RAYS..(bundle + 1) * RAYS;
            match shoot.hits.as_mut().map(|hits| &mut hits[part]) {
                Some(kept) if kept[0] != strike::UNKNOWN => desk.strikes.copy_from_slice(kept),
                kept => {
                    self.strike(still, bundle, shoot.placement, desk);
                    kept.into_iter().for_each(|kept| kept.copy_from_slice(&desk.strikes));
                }
            }
        }
        self.strike(&shoot.moving, bundle, shoot.placement, desk);
        let rules = Rules {
            gates: &table.gates,
            noise_q16: &table.noise_q16,
            draws: shoot.placement.draws,
            size: self.blockers.moving.blockers.window().size,
            all: shoot.see.is_some(),
        };
        let numbers = table.bundles.numbers(bundle);
        desk.ends.end(self.level, &desk.bundle, &numbers, &desk.strikes, &rules);
        if let Some(see) = &mut shoot.see {
            numbers.iter().zip(desk.ends.ends).for_each(|(&ray, end)| see[ray as usize] = end);
        }
    }

    /// The strikes of a bundle on a layer, where they come before those already known.
    fn strike(&self, search: &Search, bundle: usize, placement: &Placement, desk: &mut Desk) {
        let clear_q16 = self.table.cones.get(bundle).map_or(0, |cone| cone.clear_q16(search, placement));
        let starts = clear_q16 == 0;
        if !starts {
            desk.places.t_q16 = [clear_q16; RAYS];
            desk.bundle.made(self.level, &desk.places, &mut desk.made);
        }
        let range = strike::range(self.table.gates.range_max_q16);
        for lane in 0..RAYS {
            let made = |r: usize| if starts { 0 } else { desk.made[r][lane] };
            let ray = desk.bundle.march(lane, std::array::from_fn(made));
            let d = std::array::from_fn(|r| desk.bundle.dir_q16[r][lane].unsigned_abs());
            let known = desk.strikes[lane];
            desk.strikes[lane] = search.strike(ray, d, starts, known.min(range), known);
        }
    }
}

/// Marks the tiles that a rectangle of pixels touches.
fn mark(tiles: &mut [Tile], bundles: &Bundles, rect: &Rect, near: bool) {
    let across = bundles.image().map_or(1, |image| image.size_px[0].div_ceil(TILE));
    for v in rect.first[1] / TILE..=rect.last[1] / TILE {
        for u in rect.first[0] / TILE..=rect.last[0] / TILE {
            let tile = &mut tiles[(v * across + u) as usize];
            *tile = Tile { cast: true, near: tile.near | near };
        }
    }
}

/// Marks where returns are read.
fn occupy(bundle: &Bundle, ends: &Ends, occupied: &mut BitGrid) {
    for lane in (0..RAYS).filter(|&lane| ends.ends[lane].kind == RETURN) {
        occupied.set(std::array::from_fn(|r| {
            bundle.cell[r] + bundle.dir_q16[r][lane].signum() * ends.made[r][lane] as i32
        }));
    }
}
