//! Plans are checked by what they cover and what they hold; nothing is run.

use super::*;

/// A window of 30 000 words in a grid through which a ray may make `longest` crossings.
fn cell(longest: u32, regions: &[(u32, u32)]) -> CellSizes {
    let regions = regions.iter().map(|&(first, end)| first..end).collect();
    CellSizes { grid: [longest, 0, 0], window_words: 30_000, regions }
}

fn table(rays: u32) -> TableSizes {
    TableSizes { rays, reach: 4000 }
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

/// Every (row, item) of a stage is in exactly one dispatch, no dispatch is too large, and its workgroups cover it.
#[track_caller]
fn covers_once(dispatches: &[Dispatch], expected: &[(Stage, u64)]) {
    for dispatch in dispatches {
        let per_group =
            if dispatch.stage == Stage::Count { WORKGROUP * WORDS_PER_INVOCATION } else { WORKGROUP };
        let items = dispatch.part.end - dispatch.part.first;
        assert!(dispatch.groups[0] * per_group >= items, "{dispatch:?}");
        assert!((dispatch.groups[0] - 1) * per_group < items, "an idle group: {dispatch:?}");
        assert!(dispatch.groups[0].max(dispatch.groups[1]) <= 65_535, "{dispatch:?}");
        assert!(dispatch.work <= CROSSINGS_PER_DISPATCH + WORKGROUP as u64 * 4096, "{dispatch:?}");
    }
    for &(stage, expected) in expected {
        let of_stage = dispatches.iter().filter(|d| d.stage == stage);
        let items = of_stage.map(|d| (d.part.end - d.part.first) as u64 * d.groups[1] as u64);
        assert_eq!(items.sum::<u64>(), expected, "{stage:?}");
    }
}

#[test]
fn rays_are_cast_and_carved_once() {
    for rays in [0, 1, 63, 64, 65, 300, 921_600, 3_000_000] {
        for longest in [1, 263, 3069] {
            for placements in [1, 3, 64] {
                let total = rays as u64 * placements as u64;
                let dispatches = cell(longest, &[]).sensing(&table(rays), placements);
                covers_once(&dispatches, &[(Stage::Cast, total), (Stage::Carve, total)]);
            }
        }
    }
}

#[test]
fn words_are_fused_and_counted_once() {
    let three = cell(1, &[(40, 30_000), (17, 18), (5, 5)]);
    for (jobs, readings) in [(1, 0), (1, 1), (256, 3), (7, 200), (3, 2048)] {
        let expected = [(Stage::Fuse, (30_000 - 17) * jobs as u64), (Stage::Count, 29_961 * jobs as u64)];
        let dispatches = three.scoring(jobs, readings);
        covers_once(&dispatches, &expected);
        // Nothing is counted before all of it is fused.
        let fused = dispatches.iter().rposition(|d| d.stage == Stage::Fuse);
        assert!(fused < dispatches.iter().position(|d| d.stage == Stage::Count));
    }
    covers_once(&cell(1, &[(0, 33_000_000)]).scoring(2, 4), &[(Stage::Fuse, 66_000_000)]);
    assert_eq!(cell(1, &[(5, 5)]).scoring(2, 4), []);
}

#[test]
fn noise_may_take_a_ray_behind_its_range() {
    let mut rays = rays(1);
    assert_eq!(TableSizes::of(&rays, &adapter(1 << 27, true)).unwrap().reach, 103);
    rays.noise_q16 = vec![-9 << 16, 5 << 16, 0];
    assert_eq!(TableSizes::of(&rays, &adapter(1 << 27, true)).unwrap().reach, 108);
}

#[test]
fn submissions_are_the_dispatches_in_order() {
    let dispatches = cell(263, &[]).sensing(&table(921_600), 3);
    let groups = submissions(&dispatches);
    assert!(groups.len() > 3 && groups.len() < dispatches.len());
    assert_eq!(groups.concat(), dispatches);
    assert_eq!(submissions(&[]), vec![&[] as &[Dispatch]]);
}

#[test]
fn batches_fit_the_binding_and_the_budget() {
    let (software, hardware) = (adapter(1 << 27, true), adapter(1 << 27, false));
    assert_eq!(table(300).placements_at_once(&software), 64);
    assert_eq!(table(0).placements_at_once(&software), 64);
    let camera = table(921_600);
    assert_eq!(camera.placements_at_once(&software), 18, "18 times 3.7 MB of ends in 64 MiB");
    assert_eq!(camera.placements_at_once(&hardware), 36, "36 times 3.7 MB of ends in 128 MiB");
    assert_eq!(camera.placements_at_once(&adapter(1 << 10, true)), 1);

    // Two planes of 120 kB.
    let cell = cell(263, &[]);
    assert_eq!((cell.slots(&software, None), cell.jobs_at_once(&software)), (1118, 256));
    assert_eq!(cell.slots(&adapter(1 << 30, false), None), 2048);
    assert_eq!(cell.slots(&software, Some(128 << 20)), 279, "a quarter of 1118");
    assert_eq!(
        (cell.slots(&adapter(1 << 10, true), None), cell.jobs_at_once(&adapter(1 << 10, true))),
        (1, 1)
    );
    let large = CellSizes { window_words: 1 << 20, ..cell };
    assert_eq!(
        (large.slots(&software, None), large.jobs_at_once(&software)),
        (32, 8),
        "128 MiB and 32 MiB a plane"
    );
}

fn rays(number: usize) -> Rays {
    let gates = crate::march::Gates {
        range_min_q16: 0,
        range_max_q16: 100 << 16,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    };
    Rays { dirs_q15: vec![[0, 0, 32_768]; number], image: None, gates, noise_q16: vec![] }
}

#[test]
fn what_cannot_be_bound_is_refused_with_its_size() {
    use crate::voxel::{BitGrid, Window};
    let grid = BitGrid::new(Window::between([0; 3], [1022, 19, 0]));
    let [blockers, truth, human, robot] = std::array::from_fn(|_| grid.clone());
    let cell =
        Cell { window: grid.window(), blockers, still: None, truth, human, robot, regions: vec![grid] };
    assert!(CellSizes::of(&cell, &adapter(2560, true)).is_ok(), "exactly as large as a binding");
    let refused = CellSizes::of(&cell, &adapter(2559, true)).unwrap_err().to_string();
    assert!(refused.contains("the grid takes 2560 bytes"), "{refused}");
    assert!(TableSizes::of(&rays(213), &adapter(2560, true)).is_ok());
    let refused = TableSizes::of(&rays(214), &adapter(2560, true)).unwrap_err().to_string();
    assert!(refused.contains("rays takes 2568 bytes") && refused.contains("at most 2560"), "{refused}");
}

#[test]
fn a_missing_workgroup_is_noticed_and_named() {
    let mut launched = Launched::default();
    launched.add(&cell(263, &[]).sensing(&table(1000), 1));
    launched.add(&cell(263, &[]).sensing(&table(1000), 1));
    launched.add(&cell(263, &[(0, 2048)]).scoring(2, 1));
    assert_eq!(launched.check(&[32, 32, 64, 4]), Ok(()));
    let missing = launched.check(&[32, 31, 64, 4]).unwrap_err();
    assert!(missing.contains("31 of 32 workgroups of `carve`"), "{missing}");
    let missing = launched.check(&[32, 32, 63, 4]).unwrap_err();
    assert!(missing.contains("63 of 64 workgroups of `fuse`"), "{missing}");
    assert!(launched.check(&[32, 32, 64, 5]).is_err(), "too many is as wrong");
}
