//! What a recorded map scores at one moment, for people: the counts of each region, and what the map makes of
//! each object.

use super::table::{NONE, Table, number};
use crate::metrics::{Confusion, Score};
use crate::view::{Verdict, View};
use crate::voxel::BitGrid;

/// The counts of the map in each region, as a row of `results` has them.
pub fn counts(view: &View) -> Vec<Confusion> {
    (0..view.world.regions.len()).map(|region| view.counts(region)).collect()
}

/// Tables of scores, and of what became of the objects in each region.
pub fn render(view: &View) -> String {
    let mut columns = vec!["<region".to_string()];
    columns.extend(Verdict::ALL.map(|verdict| verdict.name().to_uppercase()));
    columns.extend(Score::ALL.map(|score| score.name().to_string()));
    let mut scores = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    for (region, counts) in view.world.regions.iter().zip(counts(view)) {
        let [tp, fp, fn_, tn, uo, uf] = [counts.tp, counts.fp, counts.fn_, counts.tn, counts.uo, counts.uf];
        let mut cells = vec![region.name.clone()];
        cells.extend([tp, fp, fn_, tn, uo, uf].map(|count| count.to_string()));
        cells.extend(Score::ALL.map(|score| number(score.of(&counts))));
        scores.row(cells);
    }
    let mut text = format!("\n{}", scores.text());
    for (index, region) in view.world.regions.iter().enumerate() {
        text += &format!(
            "\nregion {}: what the map makes of it, in voxels\n{}",
            region.name,
            objects(view, index)
        );
    }
    text
}

/// What the map says of each object's voxels in a region, and of the free space there.
fn objects(view: &View, region: usize) -> String {
    let inside = &*view.world.regions[region].voxels;
    let mut table =
        Table::new(&["<what", "<role", "voxels", "occupied", "free", "unknown", "called occupied"]);
    let mut row = |what: &str, role: &str, mut voxels: BitGrid| {
        voxels.keep(inside);
        let said = |plane: &BitGrid| {
            let mut plane = plane.clone();
            plane.keep(&voxels);
            plane.count()
        };
        let (all, occupied, free) = (voxels.count(), said(&view.labels.occupied), said(&view.labels.free));
        if all > 0 {
            let share = format!("{:.1} %", 100.0 * occupied as f64 / all as f64);
            let counts = [all, occupied, free, all - occupied - free].map(|count| count.to_string());
            let cells = [what.to_string(), role.to_string()].into_iter().chain(counts);
            table.row(cells.chain([share]));
        }
    };
    for object in &view.truth.objects {
        row(&object.name, &format!("{:?}", object.role).to_lowercase(), object.voxels.over(inside.window()));
    }
    let mut free = inside.clone();
    free.remove(&view.truth.occupied);
    row("free space", NONE, free);
    table.text()
}
