//! How the work is cut: what fits the device at once, which dispatches do it, and whether all of them were done.
//! Pure arithmetic; recording and running is left to `mod.rs`.

use std::ops::Range;

use super::adapter::AdapterReport;
use super::types::{Part, Stage, WORDS_PER_INVOCATION, WORKGROUP};
use crate::backend::{Cell, Rays};
use crate::march::MAX_RANGE_VOXELS;
use crate::{Error, Result};

/// Crossings that one dispatch may have to make at worst. A software adapter makes some ten million a second on a
/// core, so that this is seconds there and milliseconds on a GPU: no driver's watchdog bites.
const CROSSINGS_PER_DISPATCH: u64 = 1 << 27;
/// Rays of one dispatch, however short they are.
const RAYS_PER_DISPATCH: u64 = 1 << 18;
/// Words of regions that one dispatch counts.
const WORDS_PER_DISPATCH: u32 = 1 << 20;
/// Placements of a batch: more would not make the dispatches any larger.
const PLACEMENTS_PER_BATCH: u64 = 64;
/// Bytes of ends and evidence of a batch, on the processor's memory and on a GPU's.
const SOFTWARE_BUDGET: u64 = 64 << 20;
const HARDWARE_BUDGET: u64 = 512 << 20;

/// One dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dispatch {
    pub(super) stage: Stage,
    pub(super) part: Part,
    /// Workgroups on x (rays or words) and y (placements).
    pub(super) groups: [u32; 2],
    /// Crossings it may have to make at worst.
    pub(super) crossings: u64,
}

/// The sizes of a loaded scene and sensor that decide how the work is cut.
#[derive(Clone, Debug)]
pub(super) struct Sizes {
    pub(super) rays: u32,
    /// Words of a plane over the window.
    pub(super) window_words: u32,
    /// The words of each region that are not zero, from the first to the last.
    pub(super) regions: Vec<Range<u32>>,
    /// Crossings of the longest possible ray.
    longest: u64,
}

impl Sizes {
    /// The sizes of a scene and a sensor, if the adapter can bind them.
    pub(super) fn of(cell: &Cell, rays: &Rays, adapter: &AdapterReport) -> Result<Self> {
        let limit = adapter.max_binding_bytes.min(adapter.max_buffer_bytes);
        let fits = |what: &str, bytes: u64, cure: &str| {
            if bytes <= limit {
                return Ok(());
            }
            Err(Error::Input(format!(
                "{what} {bytes} bytes, but adapter {} binds at most {limit}: use {cure}, or `--backend cpu`",
                adapter.label()
            )))
        };
        let ray_count = rays.dirs_q15.len() as u64;
        fits("the grid takes", cell.blockers.words().len() as u64 * 4, "larger voxels")?;
        fits("the sensor's table of rays takes", ray_count * 12, "fewer rays")?;
        fits("the evidence of one placement takes", cell.truth.words().len() as u64 * 4, "smaller regions")?;
        let range = (rays.gates.range_max_q16 >> 16).min(MAX_RANGE_VOXELS) as u64 + 2;
        let longest = cell.blockers.window().size.iter().map(|&n| range.min(n as u64)).sum::<u64>().max(1);
        let region_words = |words: &[u32]| {
            let first = words.iter().position(|&w| w != 0).unwrap_or(0);
            let end = words.iter().rposition(|&w| w != 0).map_or(first, |last| last + 1);
            first as u32..end as u32
        };
        Ok(Sizes {
            rays: ray_count as u32,
            window_words: cell.truth.words().len() as u32,
            regions: cell.regions.iter().map(|region| region_words(region.words())).collect(),
            longest,
        })
    }

    /// How many placements go in a batch: as many as the budget and a binding hold, at least one.
    pub(super) fn batch(&self, adapter: &AdapterReport) -> u32 {
        let budget = if adapter.software { SOFTWARE_BUDGET } else { HARDWARE_BUDGET };
        let (ends, plane) = (self.rays as u64 * 4, self.window_words as u64 * 4);
        let binding = adapter.max_binding_bytes.min(adapter.max_buffer_bytes);
        let fit = (budget / (ends + 2 * plane).max(1)).min(binding / ends.max(plane).max(1));
        fit.clamp(1, PLACEMENTS_PER_BATCH) as u32
    }

    /// The dispatches for `placements` placements, in the order they must run; counting is left out without regions.
    pub(super) fn dispatches(&self, placements: u32) -> Vec<Dispatch> {
        let rays_at_once = (CROSSINGS_PER_DISPATCH / self.longest).min(RAYS_PER_DISPATCH) as u32;
        let rays_at_once = rays_at_once.next_multiple_of(WORKGROUP);
        let mut out = Vec::new();
        for stage in [Stage::Cast, Stage::Carve] {
            for (rows, rays) in cut(placements, 0..self.rays, rays_at_once) {
                let crossings = (rays.len() * rows.len()) as u64 * self.longest;
                let groups = [(rays.len() as u32).div_ceil(WORKGROUP), rows.len() as u32];
                let part = Part { first_placement: rows.start, first: rays.start, end: rays.end, region: 0 };
                out.push(Dispatch { stage, part, groups, crossings });
            }
        }
        for (words, region) in self.regions.iter().zip(0..) {
            for (rows, words) in cut(placements, words.clone(), WORDS_PER_DISPATCH) {
                let groups =
                    [(words.len() as u32).div_ceil(WORKGROUP * WORDS_PER_INVOCATION), rows.len() as u32];
                let part = Part { first_placement: rows.start, first: words.start, end: words.end, region };
                out.push(Dispatch { stage: Stage::Count, part, groups, crossings: 0 });
            }
        }
        out
    }
}

/// Cuts rows of `items` into blocks of about `at_once` items: several whole rows, or parts of one.
fn cut(rows: u32, items: Range<u32>, at_once: u32) -> Vec<(Range<u32>, Range<u32>)> {
    let rows_at_once = (at_once / (items.len() as u32).max(1)).max(1) as usize;
    let mut blocks = Vec::new();
    for row in (0..rows).step_by(rows_at_once) {
        for first in items.clone().step_by(at_once as usize) {
            let end = first.saturating_add(at_once).min(items.end);
            blocks.push((row..row.saturating_add(rows_at_once as u32).min(rows), first..end));
        }
    }
    blocks
}

/// Groups dispatches into submissions, so that none may take longer than its largest dispatch may.
pub(super) fn submissions(dispatches: &[Dispatch]) -> Vec<&[Dispatch]> {
    let mut out = Vec::new();
    let (mut first, mut crossings) = (0, 0);
    for (i, dispatch) in dispatches.iter().enumerate() {
        if i > first && crossings + dispatch.crossings > CROSSINGS_PER_DISPATCH {
            out.push(&dispatches[first..i]);
            (first, crossings) = (i, 0);
        }
        crossings += dispatch.crossings;
    }
    out.push(&dispatches[first..]);
    out
}

/// Compares the workgroups that reported their end, a counter a stage, with those launched.
pub(super) fn check_complete(dispatches: &[Dispatch], done: &[u32]) -> Result<(), String> {
    for stage in Stage::ALL {
        let of_stage = dispatches.iter().filter(|d| d.stage == stage);
        let launched: u64 = of_stage.map(|d| d.groups[0] as u64 * d.groups[1] as u64).sum();
        let ended = done[stage as usize];
        if ended as u64 != launched {
            return Err(format!(
                "incomplete dispatch: {ended} of {launched} workgroups of `{}` ran to their end, so its counts \
                 cannot be trusted; use another adapter, or `--backend cpu`",
                stage.name()
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::Gates;
    use crate::voxel::{BitGrid, Window};

    fn sizes(rays: u32, longest: u64, regions: &[(u32, u32)]) -> Sizes {
        let regions = regions.iter().map(|&(first, end)| first..end).collect();
        Sizes { rays, window_words: 30_000, regions, longest }
    }

    fn adapter(max_binding_bytes: u64, software: bool) -> AdapterReport {
        AdapterReport {
            index: 0,
            name: "test".into(),
            driver: "1".into(),
            backend: "Vulkan".into(),
            device_type: "Cpu".into(),
            software,
            max_binding_bytes,
            max_buffer_bytes: 1 << 31,
            max_workgroups: 65_535,
            max_storage_buffers: 8,
        }
    }

    /// Every (placement, item) of a stage is in exactly one dispatch, no dispatch is too large, and its workgroups
    /// cover it.
    #[track_caller]
    fn covers_once(sizes: &Sizes, placements: u32) {
        let dispatches = sizes.dispatches(placements);
        for dispatch in &dispatches {
            let per_group =
                if dispatch.stage == Stage::Count { WORKGROUP * WORDS_PER_INVOCATION } else { WORKGROUP };
            let items = dispatch.part.end - dispatch.part.first;
            assert!(dispatch.groups[0] * per_group >= items, "{dispatch:?}");
            assert!((dispatch.groups[0] - 1) * per_group < items, "an idle group: {dispatch:?}");
            assert!(dispatch.groups[0].max(dispatch.groups[1]) <= 65_535, "{dispatch:?}");
            assert!(dispatch.crossings <= CROSSINGS_PER_DISPATCH + WORKGROUP as u64 * 4096, "{dispatch:?}");
        }
        let total = |stage: Stage| {
            let of_stage = dispatches.iter().filter(move |d| d.stage == stage);
            of_stage.map(|d| (d.part.end - d.part.first) as u64 * d.groups[1] as u64).sum::<u64>()
        };
        let rays = sizes.rays as u64 * placements as u64;
        assert_eq!((total(Stage::Cast), total(Stage::Carve)), (rays, rays));
        let words: u64 = sizes.regions.iter().map(|w| w.len() as u64).sum();
        assert_eq!(total(Stage::Count), words * placements as u64);
    }

    #[test]
    fn dispatches_cover_everything_once() {
        for rays in [0, 1, 63, 64, 65, 300, 921_600, 3_000_000] {
            for longest in [1, 263, 3069] {
                for placements in [1, 3, 64] {
                    covers_once(&sizes(rays, longest, &[(0, 30_000), (17, 18), (5, 5)]), placements);
                }
            }
        }
        covers_once(&sizes(1, 1, &[(0, 33_000_000)]), 2);
    }

    #[test]
    fn submissions_are_the_dispatches_in_order() {
        let dispatches = sizes(921_600, 263, &[(0, 30_000)]).dispatches(3);
        let groups = submissions(&dispatches);
        assert!(groups.len() > 3 && groups.len() < dispatches.len());
        assert_eq!(groups.concat(), dispatches);
        assert_eq!(submissions(&[]), vec![&[] as &[Dispatch]]);
    }

    #[test]
    fn batches_fit_the_binding_and_the_budget() {
        assert_eq!(sizes(300, 263, &[]).batch(&adapter(1 << 27, true)), 64);
        let camera = sizes(921_600, 263, &[]);
        assert_eq!(camera.batch(&adapter(1 << 27, true)), 17);
        assert_eq!(camera.batch(&adapter(1 << 27, false)), 36, "36 times 3.7 MB of ends in 128 MiB");
        assert_eq!(camera.batch(&adapter(1 << 10, true)), 1);
    }

    #[test]
    fn what_cannot_be_bound_is_refused_with_its_size() {
        let grid = BitGrid::new(Window::between([0; 3], [1022, 19, 0]));
        let gates = Gates {
            range_min_q16: 0,
            range_max_q16: 100 << 16,
            near_ignore_q16: 0,
            no_return_is_free: false,
            backdrop: false,
        };
        let [blockers, truth, human, robot] = std::array::from_fn(|_| grid.clone());
        let cell = Cell { window: grid.window(), blockers, truth, human, robot, regions: vec![grid] };
        let rays = Rays { dirs_q15: vec![[0, 0, 32_768]; 200], gates };
        let refusal = |bytes| Sizes::of(&cell, &rays, &adapter(bytes, true)).unwrap_err().to_string();
        assert!(Sizes::of(&cell, &rays, &adapter(2560, true)).is_ok(), "exactly as large as a binding");
        assert!(refusal(2559).contains("the grid takes 2560 bytes"), "{}", refusal(2559));
        let rays = Rays { dirs_q15: vec![[0, 0, 32_768]; 214], gates };
        let refused = Sizes::of(&cell, &rays, &adapter(2560, true)).unwrap_err().to_string();
        assert!(refused.contains("rays takes 2568 bytes") && refused.contains("at most 2560"), "{refused}");
    }

    #[test]
    fn a_missing_workgroup_is_noticed_and_named() {
        let dispatches = sizes(1000, 263, &[(0, 2048)]).dispatches(2);
        assert_eq!(check_complete(&dispatches, &[32, 32, 4]), Ok(()));
        let missing = check_complete(&dispatches, &[32, 31, 4]).unwrap_err();
        assert!(missing.contains("31 of 32 workgroups of `carve`"), "{missing}");
        assert!(check_complete(&dispatches, &[32, 32, 5]).is_err(), "too many is as wrong");
    }
}
