//! The scores of a recorded map at one moment: the counts of each region, the labels of each object, and why voxels are
//! missed.

use crate::report::table::{NONE, Table, number};
use perirobot_decide::view::{Overlooked, Oversight, RecordedMap, Verdict, View};
use perirobot_march::metrics::{Confusion, Score};
use perirobot_march::voxel::BitGrid;

/// The counts of the map in each region, as in a row of `results`.
pub fn counts(view: &View) -> Vec<Confusion> {
    (0..view.world.regions.len()).map(|region| view.counts(region)).collect()
}

/// Tables of scores, of the objects in each region, and of the reasons. The view is the map's own.
pub fn render(map: &RecordedMap, view: &View) -> String {
    let overlooked = map.find_overlooked(view);
    let mut columns = vec!["<region".to_string()];
    columns.extend(Verdict::ALL.map(|verdict| verdict.name().to_uppercase()));
    columns.extend(Score::ALL.map(|score| score.name().to_string()));
    let mut scores = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    for (region, counts) in view.world.regions.iter().zip(counts(view)) {
        let [tp, fp, fn_, tn, uo, uf] = [counts.tp, counts.fp, counts.fn_, counts.tn, counts.uo, counts.uf];
        let mut cells = vec![region.name.clone()];
        cells.extend([tp, fp, fn_, tn, uo, uf].map(|count| count.to_string()));
        cells.extend(Score::ALL.map(|score| number(score.evaluate(&counts))));
        scores.row(cells);
    }
    let mut text = format!("\n{}", scores.text());
    for (index, region) in view.world.regions.iter().enumerate() {
        text += &format!("\nregion {}: labels of the map, in voxels\n{}", region.name, objects(view, index));
        text += &why(view, index, &overlooked, map.knows_places());
    }
    text
}

/// The missed voxels of the objects in a region, by reason, and the objects that hide most of them.
fn why(view: &View, region: usize, overlooked: &[Overlooked], knows_places: bool) -> String {
    let inside = &*view.world.regions[region].voxels;
    let mut columns = vec!["<what".to_string()];
    columns.extend(Oversight::ALL.map(|reason| reason.name().replace('_', " ")));
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    let mut row = |what: &str, voxels: &BitGrid| {
        let with_reason = |reason| overlooked.iter().filter(move |one| one.reason == reason);
        let counts = Oversight::ALL
            .map(|reason| with_reason(reason).map(|one| one.count(&[inside, voxels])).sum::<u64>());
        if counts.iter().any(|count| *count > 0) {
            table.row([what.to_string()].into_iter().chain(counts.map(|count| count.to_string())));
        }
        counts
    };
    let all = row("all", inside);
    if all == [0; 4] {
        return String::new();
    }
    for object in &view.truth.objects {
        row(&object.name, &object.voxels);
    }
    let hidden = overlooked.iter().filter(|one| one.reason == Oversight::Hidden);
    let mut hidden: Vec<_> = hidden.map(|one| (one.count(&[inside]), one.object)).collect();
    hidden.retain(|(count, _)| *count > 0);
    // Ties keep the scene's order.
    hidden.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
    let name = |object: Option<usize>| object.map_or(NONE, |index| view.truth.objects[index].name.as_str());
    let hidden = hidden.iter().take(MOST_HIDE).map(|(count, object)| format!("{} {count}", name(*object)));
    let hidden: Vec<String> = hidden.collect();
    let below = match (knows_places, hidden.is_empty()) {
        (false, _) => "  the sensor's position is unknown, so no voxel counts as hidden\n".into(),
        (true, true) => String::new(),
        (true, false) => format!("  hidden by {}\n", hidden.join(", ")),
    };
    let name = &view.world.regions[region].name;
    format!("\nregion {name}: missed voxels, by reason\n{}{below}", table.text())
}

/// Most hiding objects that are named.
const MOST_HIDE: usize = 3;

/// The labels of each object's voxels in a region, and of the free space there.
fn objects(view: &View, region: usize) -> String {
    let inside = &*view.world.regions[region].voxels;
    let mut table =
        Table::new(&["<what", "<role", "voxels", "occupied", "free", "unknown", "called occupied"]);
    let mut row = |what: &str, role: &str, mut voxels: BitGrid| {
        voxels.keep(inside);
        let count = |plane: &BitGrid| {
            let mut plane = plane.clone();
            plane.keep(&voxels);
            plane.count()
        };
        let (all, occupied, free) = (voxels.count(), count(&view.labels.occupied), count(&view.labels.free));
        if all > 0 {
            let share = format!("{:.1} %", 100.0 * occupied as f64 / all as f64);
            let counts = [all, occupied, free, all - occupied - free].map(|count| count.to_string());
            let cells = [what.to_string(), role.to_string()].into_iter().chain(counts);
            table.row(cells.chain([share]));
        }
    };
    for object in &view.truth.objects {
        row(
            &object.name,
            &format!("{:?}", object.role).to_lowercase(),
            object.voxels.to_window(inside.window()),
        );
    }
    let mut free = inside.clone();
    free.remove(&view.truth.occupied);
    row("free space", NONE, free);
    table.text()
}
