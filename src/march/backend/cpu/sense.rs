//! Senses from one pose, from rays to evidence, in the order of the files named in `mod.rs`.

use super::alike::{self, Alike, DONE};
use super::asked::{AskedPlaces, AskedTiles};
use super::beyond::{self, ConeCourse};
use super::carve_voxels::CarveVoxels;
use super::cast::Clear;
use super::end::{Rules, Sent};
use super::first_hit::{self, FirstHit, Search};
use super::packet::{Lanes, Packets, RAYS, TILE};
use super::plan;
use super::projection::{BOXES, PixelRect, Projection};
use super::pyramid::Pyramid;
use super::scratch::Scratch;
use super::table::{RayTable, TableCaster};
use crate::backend::{Carving, GridPose, Planes};
use crate::march::{self, End};
use crate::voxel::{BitGrid, Window};

/// What is kept of a pose from snapshot to snapshot.
#[derive(Clone, Default)]
pub(super) struct PoseCache {
    /// First hits in the still layer, packet by packet.
    first_hits: Vec<FirstHit>,
    /// The window of the last snapshot.
    window: Option<Window>,
    /// What its rays do in all snapshots, from the second with the same window on.
    alike: Option<Alike>,
}

/// A pose being sensed.
pub(super) struct Shoot<'a> {
    placement: &'a GridPose,
    /// Where its rays are cast from.
    caster: GridPose,
    still: Option<Search<'a>>,
    moving: Search<'a>,
    /// What is kept of it, if anything is.
    kept: Option<&'a mut PoseCache>,
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

/// A box of voxels by its corner, and where a camera sees it.
pub(super) type SeenBox = ([i32; 3], PixelRect);

/// Whether a tile of a camera is cast, whether it sees voxels that are near, and how far the last voxels are that it sees.
#[derive(Clone, Copy, Default)]
pub(super) struct CastTile {
    cast: bool,
    near: bool,
    farthest: f32,
}

impl TableCaster<'_> {
    /// Casts and carves a placement. `kept` is what other snapshots told of it, and is filled in where it is unknown.
    /// `see` receives the end of every ray.
    pub(super) fn sense(
        &self,
        placement: &GridPose,
        scratch: &mut Scratch,
        mut kept: Option<&mut PoseCache>,
        see: Option<&mut [End]>,
    ) -> Planes {
        let window = self.wanted.voxels.window();
        // A window that goes with people who walk is another one each time.
        let is_as_before = kept.as_mut().is_some_and(|kept| kept.window.replace(window) == Some(window));
        let fits = self.wanted.voxels.words().len() <= self.plane_words;
        let mut shoot = Shoot { kept, see, ..self.shoot(placement) };
        let carving = self.carving.unwrap_or_else(|| plan::carving(&self.table.packets, window));
        match (carving, self.table.packets.image()) {
            (Carving::ByVoxel, Some(image)) => {
                let mut planes = Planes::blank(window);
                self.carve_by_voxel(&Projection::new(placement, image), &mut shoot, scratch, &mut planes);
                planes
            }
            _ if !is_as_before || !fits || shoot.casts_all() || self.may_lose_returns() => {
                let mut planes = Planes::blank(window);
                let all = 0..self.table.packets.count();
                self.carve_by_ray(all, &mut shoot, scratch, &mut planes);
                planes
            }
            _ => self.carve_the_rest(&mut shoot, scratch),
        }
    }

    /// A pose of which nothing is kept.
    pub(super) fn shoot<'a>(&'a self, placement: &'a GridPose) -> Shoot<'a> {
        let caster = placement.caster();
        let search = |layer| self.search(layer, &caster);
        let (still, moving) = (self.blockers.still.map(search), search(self.blockers.moving));
        Shoot { placement, caster, still, moving, kept: None, see: None }
    }

    /// Casts the rays first; then each voxel is looked up in the image of what the pixels free.
    fn carve_by_voxel(
        &self,
        projection: &Projection,
        shoot: &mut Shoot,
        scratch: &mut Scratch,
        planes: &mut Planes,
    ) {
        let (tiles, boxes) = self.seen_boxes(projection, shoot);
        let Some(mut pyramid) = scratch.pyramid.take() else { return };
        pyramid.clear();
        let all = 0..tiles.len();
        self.cast_tiles(all, &tiles, projection, shoot, scratch, planes, &mut |packet, freed| {
            pyramid.set_tile(packet, freed);
        });
        pyramid.build(self.level);
        self.decide_boxes(
            &boxes,
            projection,
            shoot.placement,
            &pyramid,
            &mut scratch.asked,
            &mut planes.free,
        );
        scratch.pyramid = Some(pyramid);
    }

    /// The tiles of a camera that must be cast, and the boxes of voxels that it sees.
    pub(super) fn seen_boxes(&self, projection: &Projection, shoot: &Shoot) -> (Vec<CastTile>, Vec<SeenBox>) {
        let packets = &self.table.packets;
        let mut tiles = vec![CastTile { cast: shoot.casts_all(), ..CastTile::default() }; packets.count()];
        let mut boxes = Vec::new();
        let largest = self.wanted.edge;
        for corners in self.wanted.boxes.chunks(BOXES) {
            let pixel_rects = projection.pixel_rects(self.level, corners, largest, &projection.all());
            for (i, &corner) in corners.iter().enumerate() {
                if let Some(pixel_rect) = pixel_rects.rect(i) {
                    mark(&mut tiles, packets, &pixel_rect, projection.farthest(corner, largest));
                    boxes.push((corner, pixel_rect));
                }
            }
        }
        (tiles, boxes)
    }

    /// Casts some of a camera's tiles; `take` gets how many voxels the pixels of each free.
    #[expect(clippy::too_many_arguments, reason = "what is read, what is worked on, what is made")]
    pub(super) fn cast_tiles(
        &self,
        some: impl Iterator<Item = usize>,
        tiles: &[CastTile],
        projection: &Projection,
        shoot: &mut Shoot,
        scratch: &mut Scratch,
        planes: &mut Planes,
        take: &mut dyn FnMut(usize, &Lanes<u32>),
    ) {
        let packets = &self.table.packets;
        let until_q16 = projection.last_near_q16();
        let mut clear = vec![None; self.table.groups.len()];
        for packet in some.filter(|&packet| tiles[packet].cast) {
            let CastTile { near, .. } = tiles[packet];
            let way = self.goes_beyond(packet, shoot, &tiles[packet], &mut clear);
            if near || matches!(way, ConeCourse::Clear(_)) {
                scratch.packet.start(self.level, shoot.placement, packets.dirs_q15(packet));
            }
            let freed = match way {
                ConeCourse::Returns => [u16::MAX.into(); RAYS],
                ConeCourse::Clear(clear) => {
                    self.cast(packet, u64::MAX, Clear::Distance(clear), shoot, scratch);
                    scratch.ends.mark(planes);
                    scratch.ends.freed
                }
            };
            take(packet, &freed);
            if near {
                scratch.through.start(self.level, &scratch.packet, &planes.free.window());
                for lane in 0..RAYS {
                    let ray = (&scratch.packet, &scratch.through, lane);
                    scratch.marks.mark_freed(ray, freed[lane], until_q16, &mut planes.free);
                }
            }
        }
        scratch.marks.finish(&mut planes.free);
    }

    /// Marks what is free of boxes of voxels, by what a camera's pixels free.
    pub(super) fn decide_boxes(
        &self,
        boxes: &[SeenBox],
        projection: &Projection,
        placement: &GridPose,
        pyramid: &Pyramid,
        asked: &mut AskedPlaces,
        free: &mut BitGrid,
    ) {
        let (level, wide, wanted) = (self.level, self.wide, self.wanted);
        let asked = AskedTiles::new(level, &self.table.packets, placement, asked);
        let mut carve = CarveVoxels { level, wide, projection, asked, placement, pyramid, wanted };
        for (corner, pixel_rect) in boxes {
            carve.decide(*corner, wanted.edge, pixel_rect, free);
        }
    }

    /// How a camera's tile goes past all that it sees of what matters.
    fn goes_beyond(
        &self,
        packet: usize,
        shoot: &Shoot,
        tile: &CastTile,
        groups: &mut [Option<f32>],
    ) -> ConeCourse {
        let RayTable { packets, cones, gates, nearer_q16, .. } = self.table;
        if shoot.casts_all() || self.may_lose_returns() {
            return ConeCourse::Clear(0.0);
        }
        let voxels = |q16: u32| q16 as f32 / 65_536.0;
        let [least_q16, most_q16] = self.table.limits(packet).within_q16;
        let least_q16 = least_q16.max(gates.near_ignore_q16);
        let from = (tile.farthest + voxels(*nearer_q16)).max(voxels(least_q16)) + 1.0;
        let to = voxels(most_q16) - 1.0;
        let searches = [&shoot.moving].into_iter().chain(&shoot.still);
        let group = packets.group_of(packet);
        let clear = *groups[group].get_or_insert_with(|| {
            let cone = self.table.groups[group].place(&shoot.caster);
            beyond::clear(&cone, searches.clone(), 0.0)
        });
        beyond::way(&cones[packet].place(&shoot.caster), searches, clear, [from, to])
    }

    /// Ray by ray, those of some packets.
    pub(super) fn carve_by_ray(
        &self,
        some: impl Iterator<Item = usize>,
        shoot: &mut Shoot,
        scratch: &mut Scratch,
        planes: &mut Planes,
    ) {
        let packets = &self.table.packets;
        for packet in some {
            scratch.packet.start(self.level, shoot.placement, packets.dirs_q15(packet));
            scratch.through.start(self.level, &scratch.packet, &planes.free.window());
            if !shoot.casts_all() && scratch.through.lanes().next().is_none() {
                continue;
            }
            self.cast(packet, u64::MAX, Clear::Distance(0.0), shoot, scratch);
            for lane in 0..RAYS {
                let ray = (&scratch.packet, &scratch.through, lane);
                let freed = scratch.ends.freed[lane];
                scratch.marks.mark_freed(ray, freed, march::NEVER, &mut planes.free);
            }
            scratch.ends.mark(planes);
        }
        scratch.marks.finish(&mut planes.free);
    }

    /// Ray by ray, but for what all snapshots have alike.
    fn carve_the_rest(&self, shoot: &mut Shoot, scratch: &mut Scratch) -> Planes {
        let window = self.wanted.voxels.window();
        let known = shoot.kept.as_mut().and_then(|kept| kept.alike.take());
        let known = known.filter(|alike| alike.free.window() == window);
        let alike = known.unwrap_or_else(|| self.alike(shoot, scratch));
        let mut planes = Planes { free: alike.free.clone(), ..Planes::blank(window) };
        let packets = &self.table.packets;
        for packet in 0..packets.count() {
            let Some((marked, moved)) = alike.packet(packet) else { continue };
            scratch.packet.start(self.level, shoot.placement, packets.dirs_q15(packet));
            self.cast(packet, moved, Clear::Places(marked), shoot, scratch);
            scratch.through.start(self.level, &scratch.packet, &window);
            for (lane, &place) in marked.iter().enumerate().filter(|(_, place)| **place != DONE) {
                let ray = (&scratch.packet, &scratch.through, lane);
                let freed = scratch.ends.freed[lane];
                match place {
                    0 => scratch.marks.mark_freed(ray, freed, march::NEVER, &mut planes.free),
                    place => scratch.marks.freed_behind(ray, freed, place, &mut planes.free),
                }
            }
            scratch.ends.mark(&mut planes);
        }
        scratch.marks.finish(&mut planes.free);
        if let Some(kept) = &mut shoot.kept {
            kept.alike = Some(alike);
        }
        planes
    }

    /// What the rays of a pose do alike in all snapshots.
    fn alike(&self, shoot: &mut Shoot, scratch: &mut Scratch) -> Alike {
        let (packets, nearer_q16) = (&self.table.packets, self.table.nearer_q16);
        let sometimes = self.blockers.sometimes.map(|layer| self.search(layer, &shoot.caster));
        let mut alike = Alike {
            free: BitGrid::new(self.wanted.voxels.window()),
            marked: vec![DONE; packets.count() * RAYS],
            moved: vec![0; packets.count()],
        };
        for packet in 0..packets.count() {
            scratch.packet.start(self.level, shoot.placement, packets.dirs_q15(packet));
            scratch.through.start(self.level, &scratch.packet, &alike.free.window());
            let crossing: Vec<usize> = scratch.through.lanes().collect();
            let limits = self.table.limits(packet);
            if crossing.is_empty() {
                continue;
            }
            self.cast(packet, 0, Clear::Distance(0.0), shoot, scratch);
            for lane in crossing {
                let still = scratch.found[lane];
                let ray = scratch.packet.ray(lane, [0; 3]);
                let earlier = |on: &Search| on.first_hit(ray, true, still.min(limits.last[lane]), still);
                let first = sometimes.as_ref().map_or(0, earlier);
                let is_return =
                    |hit: FirstHit| hit < first_hit::LEFT && hit >> 2 >= limits.range_min_q16[lane];
                let (place, crossings) = if is_return(still) && is_return(first) {
                    let place = alike::earliest_hit(first, nearer_q16);
                    let made = scratch.packet.made_by(lane, first_hit::crossing(place));
                    (place, if place == 0 { 0 } else { made.iter().sum() })
                } else if first == still {
                    // It does not return, and frees what it frees here.
                    (DONE, scratch.ends.freed[lane])
                } else {
                    (0, 0)
                };
                let ray = (&scratch.packet, &scratch.through, lane);
                scratch.marks.mark_freed(ray, crossings, march::NEVER, &mut alike.free);
                // It leaves the window before that place.
                let is_done =
                    place > 0 && scratch.through.span(lane).is_some_and(|[_, leaves]| place >= leaves);
                alike.marked[packet * RAYS + lane] = if is_done { DONE } else { place };
                alike.moved[packet] |= u64::from(first != still && !is_done) << lane;
            }
        }
        scratch.marks.finish(&mut alike.free);
        alike
    }

    /// How the rays of a packet end; `scratch` holds the rays as they are believed to go. Only some, a bit each, may meet what
    /// moves; `clear` holds if they are cast from where they are believed to be.
    fn cast(&self, packet: usize, moved: u64, clear: Clear, shoot: &mut Shoot, scratch: &mut Scratch) {
        let table = self.table;
        scratch.found = [first_hit::NOTHING; RAYS];
        let is_off = shoot.placement.truly.is_some();
        if is_off {
            std::mem::swap(&mut scratch.packet, &mut scratch.truly);
            scratch.packet.start(self.level, &shoot.caster, table.packets.dirs_q15(packet));
        }
        if let Some(still) = &shoot.still {
            let part = packet * RAYS..(packet + 1) * RAYS;
            let all = table.packets.count() * RAYS;
            let kept = shoot.kept.as_mut().map(|kept| {
                kept.first_hits.resize(all, first_hit::UNKNOWN);
                &mut kept.first_hits[part]
            });
            match kept {
                Some(kept) if kept[0] != first_hit::UNKNOWN => scratch.found.copy_from_slice(kept),
                kept => {
                    self.first_hits(still, packet, u64::MAX, clear, &shoot.caster, scratch);
                    kept.into_iter().for_each(|kept| kept.copy_from_slice(&scratch.found));
                }
            }
        }
        if moved != 0 {
            self.first_hits(&shoot.moving, packet, moved, clear, &shoot.caster, scratch);
        }
        if is_off {
            std::mem::swap(&mut scratch.packet, &mut scratch.truly);
        }
        let rules = Rules {
            gates: &table.gates,
            limits: table.limits(packet),
            noise: &table.noise,
            draws: shoot.placement.draws,
            shades: self.shades,
            size: self.blockers.moving.blockers.window().size,
            all: shoot.see.is_some(),
        };
        let numbers = table.packets.numbers(packet);
        let packets = Sent { believed: &scratch.packet, truly: is_off.then_some(&scratch.truly) };
        scratch.ends.end(self.level, &packets, &numbers, &scratch.found, &rules, &self.wanted.voxels);
        if let Some(see) = &mut shoot.see {
            (0..RAYS).for_each(|lane| see[numbers[lane] as usize] = scratch.ends.get(lane));
        }
    }
}

/// Marks the tiles that see a box, the farthest of which is so far away, in voxels.
fn mark(tiles: &mut [CastTile], packets: &Packets, PixelRect { rect, near, .. }: &PixelRect, farthest: f32) {
    let across = packets.image().map_or(1, |image| image.size_px[0].div_ceil(TILE));
    for v in rect.first[1] / TILE..=rect.last[1] / TILE {
        for u in rect.first[0] / TILE..=rect.last[0] / TILE {
            let tile = &mut tiles[(v * across + u) as usize];
            *tile = CastTile { cast: true, near: tile.near | *near, farthest: tile.farthest.max(farthest) };
        }
    }
}
