//! Plans are checked by what they cover and what they hold; nothing is run.

use super::*;
use crate::backend::adapter::AdapterReport;
use crate::backend::body_words::BodyWords;
use crate::backend::gpu::loop_bounds::{WORKGROUP, most_tiles};
use crate::backend::gpu::pace::TimedWork;
use crate::backend::{Image, Noise, Rays};

/// A window of 30 000 words, `longest` voxels in all directions together, of 700 boxes, 500 with voxels of
/// regions.
fn voxel(longest: u32, regions: &[(u32, u32)]) -> SceneSizes {
    let regions = regions.iter().map(|&(first, end)| first..end).collect();
    SceneSizes {
        window: [longest, 0, 0],
        window_words: 30_000,
        boxes: [500, 700],
        regions,
        body: 0,
        counters: 0,
    }
}

fn table(rays: u32) -> TableSizes {
    TableSizes { rays, reach: 4000, image: None, most_tiles: most_tiles(true) }
}

/// A camera of 1280 × 720 pixels: 20 × 12 of the largest blocks, which come two by two.
fn camera() -> TableSizes {
    let image = Image { size_px: [1280, 720], focal_px: [674.4, 649.5] };
    TableSizes { rays: 921_600, reach: 300, image: Some(image), most_tiles: most_tiles(true) }
}

fn batch(placements: u32, carving: Carving) -> CastBatch {
    CastBatch { placements, everything: false, carving, whole_layer: true, plain: false, lists: false }
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

/// Every (row, item) of a stage is in exactly one dispatch, no dispatch is too large, and its workgroups
/// cover it.
#[track_caller]
fn covers_once(dispatches: &[Dispatch], pace: &Pace, expected: &[(Stage, u64)]) {
    for dispatch in dispatches.iter().filter(|d| d.head().is_none()) {
        let per_group = per_group(dispatch.stage, &dispatch.part);
        let items = dispatch.part.end - dispatch.part.first;
        assert!(dispatch.groups[0] * per_group >= items, "{dispatch:?}");
        assert!((dispatch.groups[0] - 1) * per_group < items, "an idle group: {dispatch:?}");
        assert!(dispatch.groups[0].max(dispatch.groups[1]) <= 65_535, "{dispatch:?}");
        let items = items as u64 * dispatch.groups[1] as u64;
        let most = pace.work_at_once(dispatch.stage) * 3 / 2 + 2 * per_group as u64 * dispatch.work / items;
        assert!(dispatch.work <= most, "{dispatch:?}");
    }
    for &(stage, expected) in expected {
        let of_stage = dispatches.iter().filter(|d| d.stage == stage);
        let items = of_stage.map(|d| (d.part.end - d.part.first) as u64 * d.groups[1].max(1) as u64);
        assert_eq!(items.sum::<u64>(), expected, "{stage:?}");
    }
}

/// A dispatch of so much work that took so many milliseconds.
fn timed(work: u64, ms: u64) -> TimedWork {
    let mut timed = TimedWork::default();
    timed.add(work, std::time::Duration::from_millis(ms));
    timed
}

/// The pace of an adapter that is `faster` times as fast as one is taken to be.
fn pace(faster: u64) -> Pace {
    let mut pace = Pace::new(false);
    for stage in Stage::ALL {
        let first = pace.work_at_once(stage);
        (0..40).for_each(|_| pace.took(stage, &timed(faster * first, 250)));
    }
    pace
}

#[test]
fn rays_are_cast_and_carved_once() {
    for pace in [pace(1), pace(1000)] {
        for rays in [0, 1, 63, 64, 65, 300, 921_600, 3_000_000] {
            for longest in [1, 263, 3069] {
                for placements in [1, 3, 64] {
                    let total = rays as u64 * placements as u64;
                    let by_ray = batch(placements, Carving::ByRay);
                    let dispatches = voxel(longest, &[]).sensing(&table(rays), &by_ray, &pace);
                    covers_once(&dispatches, &pace, &[(Stage::Cast, total), (Stage::CarveRays, total)]);
                    let dispatches = voxel(longest, &[]).keeping(&table(rays), placements, &pace);
                    covers_once(&dispatches, &pace, &[(Stage::StaticHits, total)]);
                }
            }
        }
    }
}

#[test]
fn carve_boxes_and_carve_voxels_decide_each_box_once() {
    for pace in [pace(1), pace(1000)] {
        for (everything, boxes) in [(false, 500), (true, 700)] {
            let batch = CastBatch { everything, ..batch(18, Carving::ByVoxel) };
            let dispatches = voxel(300, &[]).sensing(&camera(), &batch, &pace);
            let expected = [
                (Stage::Cast, 18 * 921_600),
                (Stage::CarveRays, 0),
                (Stage::Pyramid, 18 * 240),
                (Stage::CarveBoxes, 18 * boxes),
                (Stage::CarveVoxels, 18 * boxes),
            ];
            covers_once(&dispatches, &pace, &expected);
            // What is left of some boxes is scanned next, and each has its own head.
            let by_voxel = dispatches.iter().position(|d| d.stage == Stage::CarveVoxels).unwrap();
            let (before, after) = dispatches.split_at(by_voxel);
            let order: Vec<_> = before.iter().map(|d| d.stage).collect();
            let first = |stage| order.iter().position(|&s| s == stage);
            assert!(
                first(Stage::Cast) < first(Stage::Pyramid)
                    && first(Stage::Pyramid) < first(Stage::CarveBoxes)
            );
            for (three, head) in after.chunks(3).zip(0..) {
                let stages = [Stage::CarveVoxels, Stage::CarveCrowded, Stage::CarveNear];
                assert_eq!(three.iter().map(|d| d.stage).collect::<Vec<_>>(), stages);
                assert!(three.iter().all(|d| d.part == three[0].part));
                assert_eq!([1, 2].map(|i: usize| three[i].head()), [Some(head), Some(HEADS + head)]);
                assert!(three[0].part.end - three[0].part.first <= BOXES_AT_ONCE);
            }
        }
    }
}

#[test]
fn slow_kernels_behind_carve_voxels_get_fewer_boxes() {
    let most = |pace: &Pace| {
        let dispatches = voxel(300, &[]).sensing(&camera(), &batch(18, Carving::ByVoxel), pace);
        let crowded = dispatches.iter().filter(|d| d.stage == Stage::CarveCrowded);
        crowded.map(|d| d.part.end - d.part.first).max().unwrap()
    };
    for stage in [Stage::CarveCrowded, Stage::CarveNear] {
        let mut pace = Pace::new(false);
        assert!(most(&pace) > 1000, "{}", most(&pace));
        (0..40).for_each(|_| pace.took(stage, &timed(0, 1000)));
        assert!(most(&pace) < 300, "{}", most(&pace));
    }
}

#[test]
fn several_workgroups_share_the_near_voxels_of_large_images() {
    let groups = |size_px: [u32; 2]| {
        let image = Image { size_px, focal_px: [1e3; 2] };
        TableSizes { image: Some(image), ..camera() }.groups_of_near()
    };
    assert_eq!([[9, 9], [1280, 720], [1024, 1024], [1032, 1024], [4096, 4096]].map(groups), [1, 1, 1, 2, 16]);
}

#[test]
fn what_costs_less_is_chosen() {
    let voxel = voxel(300, &[]);
    assert_eq!(voxel.carving(&camera()), Carving::ByVoxel);
    assert_eq!(
        voxel.carving(&TableSizes { image: None, ..camera() }),
        Carving::ByRay,
        "rays without an image"
    );
    assert_eq!(voxel.carving(&TableSizes { rays: 3000, ..camera() }), Carving::ByRay, "few rays");
    let line = Image { size_px: [1 << 20, 1], focal_px: [1e6; 2] };
    let line = TableSizes { rays: 1 << 20, image: Some(line), ..camera() };
    assert_eq!(voxel.carving(&line), Carving::ByRay, "an image whose pyramid would be mostly padding");
}

#[test]
fn ends_are_those_of_whole_tiles_where_rays_may_go_by_them() {
    let sizes = |[x, y]: [u32; 2]| {
        let image = Image { size_px: [x, y], focal_px: [1e3; 2] };
        let sizes = TableSizes { rays: x * y, image: Some(image), ..camera() };
        (sizes.has_tiles(), sizes.ends_words())
    };
    assert_eq!(sizes([1280, 720]), (true, 921_600 + 14_400));
    assert_eq!(sizes([9, 9]), (true, 4 * 64 + 4), "2 × 2 tiles");
    assert_eq!(sizes([17, 1]), (true, 3 * 64 + 4), "three tiles, in whole fours");
    assert_eq!(sizes([1 << 20, 1]), (false, 1 << 20), "a pyramid of 178 MB");
    assert_eq!(sizes([4096, 4096]), (true, (1 << 24) + (1 << 18)));
    assert_eq!(sizes([4096, 4097]), (false, 4096 * 4097), "more pixels than floats number");
    // A word a ray of 17 pixels fits what one a pixel of three tiles does not.
    let image = Some(Image { size_px: [17, 1], focal_px: [1e3; 2] });
    let rays = Rays { image, ..rays(17) };
    assert!(TableSizes::new(&rays, &adapter(784, true)).is_ok());
    let refused = TableSizes::new(&rays, &adapter(783, true)).unwrap_err().to_string();
    assert!(refused.contains("rays take 784 bytes"), "{refused}");
}

#[test]
fn the_ends_of_a_camera_come_back_in_the_order_of_its_rays() {
    let [x, y] = [9, 11];
    let image = Image { size_px: [x, y], focal_px: [1e3; 2] };
    let sizes = TableSizes { rays: x * y, image: Some(image), ..camera() };
    let mut words = vec![u32::MAX; sizes.ends_words() as usize];
    for (ray, pixel) in (0..y).flat_map(|v| (0..x).map(move |u| [u, v])).enumerate() {
        let place = &mut words[crate::backend::gpu::tiles::place_of_pixel(2, pixel) as usize];
        assert_eq!(*place, u32::MAX, "two pixels have one place: {pixel:?}");
        *place = ray as u32;
    }
    assert_eq!(sizes.order_ends(words, Carving::ByVoxel), (0..x * y).collect::<Vec<_>>());
    assert_eq!(sizes.order_ends((0..300).collect(), Carving::ByRay), (0..x * y).collect::<Vec<_>>());
}

#[test]
fn rays_by_tiles_of_plain_placements_are_cast_as_plain() {
    for (carving, plain) in
        [Carving::ByVoxel, Carving::ByRay].into_iter().flat_map(|c| [(c, false), (c, true)])
    {
        let batch = CastBatch { plain, ..batch(3, carving) };
        let expected = if plain && carving == Carving::ByVoxel { Caster::Plain } else { Caster::Any };
        assert_eq!(batch.caster(), expected, "{batch:?}");
    }
    // Images that are not whole tiles are cast in whole ones.
    let image = Image { size_px: [1279, 717], focal_px: [674.4, 649.5] };
    let table = TableSizes { rays: 1279 * 717, image: Some(image), ..camera() };
    let dispatches = voxel(300, &[]).sensing(&table, &batch(3, Carving::ByVoxel), &pace(1));
    covers_once(&dispatches, &pace(1), &[(Stage::Cast, 3 * 921_600), (Stage::CarveRays, 0)]);
}

#[test]
fn plain_placements_are_cast_from_lists_where_tiles_are_listed() {
    let plain = CastBatch { plain: true, lists: true, ..batch(64, Carving::ByVoxel) };
    for (batch, expected) in [
        (plain, Caster::Listed),
        (CastBatch { plain: false, ..plain }, Caster::Any),
        (CastBatch { everything: true, ..plain }, Caster::Any),
        (CastBatch { carving: Carving::ByRay, ..plain }, Caster::Any),
    ] {
        assert_eq!(batch.caster(), expected, "{batch:?}");
    }
    for pace in [pace(1), pace(1000)] {
        let dispatches = voxel(300, &[]).sensing(&camera(), &plain, &pace);
        covers_once(&dispatches, &pace, &[(Stage::CastListed, 64 * 256), (Stage::Cast, 0)]);
        // All parts of a row go in the same steps.
        let listed = dispatches.iter().filter(|d| d.stage == Stage::CastListed);
        assert!(listed.clone().all(|d| d.part.tiles == 256), "{listed:?}");
    }
    let small = Image { size_px: [9, 9], focal_px: [1e3; 2] };
    let small = TableSizes { rays: 81, image: Some(small), ..camera() };
    let dispatches = voxel(300, &[]).sensing(&small, &plain, &pace(1));
    covers_once(&dispatches, &pace(1), &[(Stage::CastListed, 64 * 4)]);
}

#[test]
fn boxes_with_regions_come_first() {
    use crate::voxel::{BitGrid, Window};
    let window = Window::from_corners([3, 4, 5], [3 + 16, 4 + 8, 5]);
    let mut region = BitGrid::new(window);
    region.set([3 + 16, 4 + 7, 5]);
    region.set([3 + 8, 4 + 8, 5]);
    let [blockers, truth, human, robot] = std::array::from_fn(|_| BitGrid::new(window));
    let scene = VoxelScene {
        shades: None,
        window,
        blockers: blockers.into(),
        over_time: None,
        truth,
        human,
        robot,
        regions: vec![region],
        people: Default::default(),
    };
    let expected = [[16, 0, 0], [8, 8, 0], [0, 0, 0], [8, 0, 0], [0, 8, 0], [16, 8, 0]];
    assert_eq!(boxes(&scene), (expected.to_vec(), 2));
}

#[test]
fn words_are_fused_and_counted_once() {
    let (three, pace) = (voxel(1, &[(40, 30_000), (17, 18), (5, 5)]), pace(1));
    for (jobs, readings) in [(1, 0), (1, 1), (256, 3), (7, 200), (3, 2048)] {
        let expected = [(Stage::Fuse, (30_000 - 17) * jobs as u64), (Stage::Count, 29_961 * jobs as u64)];
        let dispatches = three.scoring(jobs, readings, &pace);
        covers_once(&dispatches, &pace, &expected);
        // Nothing is counted before all of it is fused.
        let fused = dispatches.iter().rposition(|d| d.stage == Stage::Fuse);
        assert!(fused < dispatches.iter().position(|d| d.stage == Stage::Count));
    }
    covers_once(&voxel(1, &[(0, 33_000_000)]).scoring(2, 4, &pace), &pace, &[(Stage::Fuse, 66_000_000)]);
    assert_eq!(voxel(1, &[(5, 5)]).scoring(2, 4, &pace), []);
}

#[test]
fn noise_may_take_a_ray_behind_its_range() {
    let mut rays = rays(1);
    assert_eq!(TableSizes::new(&rays, &adapter(1 << 27, true)).unwrap().reach, 103);
    rays.noise =
        Noise { unit_q12: vec![-9 << 12, 5 << 12, 0], std_q16: vec![1 << 16, 1 << 15], lost_below: 0 };
    assert_eq!(TableSizes::new(&rays, &adapter(1 << 27, true)).unwrap().reach, 108);
}

#[test]
fn submissions_are_the_dispatches_in_order() {
    let pace = pace(1);
    let all = batch(3, Carving::ByVoxel);
    let dispatches = voxel(263, &[]).sensing(&camera(), &all, &pace);
    let groups = submissions(&dispatches, &pace);
    assert!(groups.len() > 3 && groups.len() < dispatches.len(), "{} of {}", groups.len(), dispatches.len());
    assert_eq!(groups.concat(), dispatches);
    assert_eq!(submissions(&[], &pace), vec![&[] as &[Dispatch]]);
}

#[test]
fn a_gpu_gets_large_batches_as_far_as_its_memory_goes() {
    let scene = voxel(263, &[]);
    let at_once = |table: &TableSizes, binding: u64| {
        let adapter = adapter(binding, false);
        (table.placements_at_once(&scene, &adapter), rays_at_once(&adapter))
    };
    let (small, large) = (1 << 27, 1 << 31);
    // 2 GB, of which a kernel binds 128 MiB at once: 35 times 3.7 MB of ends.
    assert_eq!(at_once(&camera(), small), (35, 1 << 26));
    assert_eq!(at_once(&camera(), large), (72, 1 << 26), "as many as a sweep asks for");
    assert_eq!(at_once(&table(33_475), small), (512, 1 << 26));
    assert_eq!(at_once(&table(33_475), large), (512, 1 << 26));
    let wide = SceneSizes { boxes: [30_000, 60_000], ..voxel(263, &[]) };
    assert_eq!(camera().placements_at_once(&wide, &adapter(large, false)), 34, "2048 heads of 1024 boxes");
    // All that a camera's batch holds besides evidence, and that.
    let held = |table: &TableSizes| table.ends_bytes() + table.pyramid_bytes() + table.tiles_bytes();
    assert!(72 * held(&camera()) < 512 << 20, "{}", 72 * held(&camera()));
    let slots = scene.slots(&adapter(small, false), None) as u64;
    assert!(35 * held(&camera()) + slots * 3 * scene.plane_bytes() < 1 << 29, "a quarter of 2 GB");
}

#[test]
fn batches_are_about_as_large_as_each_other() {
    let sizes =
        |count: usize, most: usize| batches(&vec![0; count], most).map(<[i32]>::len).collect::<Vec<_>>();
    assert_eq!(sizes(72, 72), [72]);
    assert_eq!(sizes(72, 64), [36, 36]);
    assert_eq!(sizes(73, 36), [25, 25, 23]);
    assert_eq!(sizes(3, 1), [1, 1, 1]);
    assert_eq!(sizes(0, 64), []);
}

#[test]
fn batches_fit_the_binding_and_the_budget() {
    let (software, hardware) = (adapter(1 << 27, true), adapter(1 << 27, false));
    let voxel = voxel(263, &[]);
    let at_once = |table: &TableSizes, adapter: &AdapterReport| table.placements_at_once(&voxel, adapter);
    assert_eq!(at_once(&table(300), &software), 64);
    assert_eq!(at_once(&table(0), &software), 64);
    let camera = table(921_600);
    assert_eq!(at_once(&camera, &software), 18, "2^24 rays");
    assert_eq!(rays_at_once(&software), 1 << 24);
    assert_eq!(at_once(&camera, &hardware), 36, "36 times 3.7 MB of ends in 128 MiB");
    assert_eq!(at_once(&camera, &adapter(1 << 10, true)), 1);
    assert_eq!(
        [None, Some(256 << 20)].map(|memory| {
            [&software, &adapter(1 << 34, false)].map(|adapter| camera.first_hits_at_once(adapter, memory))
        }),
        [[36, 582], [18, 18]],
        "a quarter of the memory if that was said"
    );

    // Three planes of 120 kB, two of them in one buffer, and as many of a job.
    assert_eq!(
        (voxel.slots(&software, None), voxel.jobs_at_once(&software)),
        (559, 256),
        "2 · 559 in 128 MiB, and no more jobs than keep a processor busy"
    );
    assert_eq!(voxel.slots(&adapter(1 << 30, false), None), 2048);
    assert_eq!(voxel.slots(&software, Some(128 << 20)), 186, "a third of 64 MiB");
    assert_eq!(
        (voxel.slots(&adapter(1 << 10, true), None), voxel.jobs_at_once(&adapter(1 << 10, true))),
        (1, 1)
    );
    let large = SceneSizes { window_words: 1 << 20, ..voxel };
    assert_eq!(
        (large.slots(&software, None), large.jobs_at_once(&software)),
        (16, 8),
        "128 MiB of two planes, and 96 MiB of three"
    );
}

fn rays(number: usize) -> Rays {
    let gates = crate::march::Gates {
        range_min_q16: 0,
        range_max_q16: 100 << 16,
        shade_ranges_q16: crate::march::FULL_RANGE,
        along_axis: false,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    };
    Rays { dirs_q15: vec![[0, 0, 32_768]; number].into(), image: None, gates, noise: Noise::default() }
}

#[test]
fn what_cannot_be_bound_is_refused_with_its_size() {
    use crate::voxel::{BitGrid, Window};
    let grid = BitGrid::new(Window::from_corners([0; 3], [1022, 19, 0]));
    let [blockers, truth, human, robot] = std::array::from_fn(|_| grid.clone());
    let scene = VoxelScene {
        shades: None,
        window: grid.window(),
        blockers: blockers.into(),
        over_time: None,
        truth,
        human,
        robot,
        regions: vec![grid],
        people: Default::default(),
    };
    // 20 rows of 32 words, and 512 · 10 bricks.
    let sizes = |bytes| SceneSizes::new(&scene, [0; 2], &BodyWords::new(&scene), &adapter(bytes, true));
    assert!(sizes(12_800).is_ok(), "exactly as large as a binding");
    let refused = sizes(12_799).unwrap_err().to_string();
    assert!(refused.contains("the grid takes 12800 bytes"), "{refused}");
    assert!(TableSizes::new(&rays(320), &adapter(2560, true)).is_ok());
    let refused = TableSizes::new(&rays(321), &adapter(2560, true)).unwrap_err().to_string();
    assert!(refused.contains("rays takes 2568 bytes") && refused.contains("at most 2560"), "{refused}");
}

#[test]
fn a_missing_workgroup_is_noticed_and_named() {
    let mut launched = Launched::default();
    let pace = pace(1);
    let by_ray = voxel(263, &[]).sensing(&table(1000), &batch(1, Carving::ByRay), &pace);
    launched.add(&by_ray);
    launched.add(&by_ray);
    let with_people = SceneSizes { body: 130, ..voxel(263, &[(0, 2048)]) };
    launched.add(&with_people.scoring(2, 1, &pace));
    let groups = [0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 4, 16, 4, 6];
    let done = |groups: [u32; 14], whole: [u32; 14]| launched.check(&[groups, whole].concat());
    let whole = groups.map(|groups| groups * WORKGROUP);
    assert_eq!(done(groups, whole), Ok(()));
    let missing = done([0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 3, 16, 4, 6], whole).unwrap_err();
    assert!(missing.to_string().contains("3 of 4 workgroups of `carve_rays`"), "{missing}");
    let missing = done([0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 4, 15, 4, 6], whole).unwrap_err();
    assert!(missing.to_string().contains("15 of 16 workgroups of `fuse`"), "{missing}");
    assert!(done([0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 4, 16, 5, 6], whole).is_err(), "too many is as wrong");
    let missing = done([0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 4, 16, 4, 5], whole).unwrap_err();
    assert!(missing.to_string().contains("5 of 6 workgroups of `detect`"), "{missing}");
    let cut = [0, 0, 0, 4 * 64 - 1, 0, 0, 0, 0, 0, 0, 4 * 64, 16 * 64, 4 * 64, 6 * 64];
    let missing = done(groups, cut).unwrap_err();
    assert!(
        missing.to_string().contains("loops cut short: in 255 of 256 invocations of `cast`"),
        "{missing}"
    );
}
