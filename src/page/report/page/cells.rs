//! The cell in voxels for the page's 3D view: the truth at some moments, the labels of the best choices in the regions,
//! and the reasons for unknown voxels.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use serde::Serialize;

use super::measure::BESTS;
use super::ranking::{Ranking, firsts};
use super::recommended::Recommended;
use crate::report::explained::{Explained, explain, phrase};
use crate::report::series::{Series, worst_snapshot};
use crate::viewer::runs::put_runs;
use perirobot_decide::view::why::Missed;
use perirobot_decide::view::{Choice, View, Viewer};
use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_march::metrics::Score;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::BitGrid;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::swept::SceneResults;
use perirobot_sweep::results::{Results, RowKey};

/// Most bytes of voxels before compression to about a quarter, so that the page stays below 3 MB.
const MOST_BYTES: usize = 8 << 20;

/// Views computed together, so that all cores are busy.
const AT_ONCE: usize = 128;

/// A range of the bytes.
type ByteRange = [usize; 2];

/// The scene at a moment. Voxels are stored with x fastest, then y, then z.
#[derive(Debug, Serialize)]
struct CellMoment {
    moment: usize,
    /// World key of the first voxel.
    origin: [i32; 3],
    size: [u32; 3],
    /// Classes: 0 free, 1 environment, 2 robot, 3 human, 4 of no region.
    truth: ByteRange,
    /// For each region, 1 if a voxel belongs to it.
    regions: Vec<ByteRange>,
}

/// The labels of a choice at a moment.
#[derive(Debug, Serialize)]
pub(super) struct CellLabels {
    pub(super) series: usize,
    pub(super) choice: usize,
    pub(super) moment: usize,
    /// Classes of the voxels in any region, in their order: 0 labelled free, 1 labelled occupied, 2 and more unknown
    /// for the first cause and so on.
    labels: ByteRange,
    causes: Vec<CauseData>,
    /// The explained voxels.
    #[serde(skip)]
    pub(super) explained: Vec<(ExplainedVoxels, Explained)>,
}

/// Why voxels are unknown.
#[derive(Debug, Serialize)]
struct CauseData {
    /// The reason as in the column `reason` of reasons.csv.
    reason: &'static str,
    words: String,
    monitored: bool,
}

/// All parts, with their places in the bytes.
#[derive(Debug, Default, Serialize)]
pub(super) struct Cells {
    moments: Vec<CellMoment>,
    pub(super) labels: Vec<CellLabels>,
    #[serde(skip)]
    pub(super) bytes: Vec<u8>,
}

/// The choice whose unknown voxels are explained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExplainedVoxels {
    /// The recommended choice.
    Recommended,
    /// The best of all in a region by one of [`BESTS`].
    Best {
        /// Index of the score.
        best: usize,
        /// Index of the region.
        region: usize,
    },
}

/// A choice of poses at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct ShownPoses {
    series: usize,
    choice: usize,
    moment: usize,
}

/// The views for the page.
#[derive(Debug)]
pub(super) struct Views {
    /// In the order of inclusion, until the page is full.
    sights: Vec<ShownPoses>,
    asked: Vec<ToExplain>,
}

impl Views {
    /// The best choices of each region and representation by F1, at most `looked_at`, and some of the best by
    /// human_seen and by parts_detected, in each scene's first moment and in the choice's worst one; before all others
    /// the recommended choice, at every moment. The voxels missed by it and by the best choice of a region are
    /// explained, at the worst moment of each.
    ///
    /// # Errors
    /// Those of a journal that cannot be read.
    pub(super) fn new(
        results: &Results,
        rankings: &[Ranking],
        recommended: Option<&Recommended>,
        most: usize,
    ) -> Result<Views> {
        Ok(Views {
            sights: sights(results, rankings, recommended, most)?,
            asked: explained_moments(results, rankings, recommended)?,
        })
    }

    /// Their number.
    pub(super) fn total(&self) -> u64 {
        self.sights.len() as u64
    }

    /// Computes the views that fit.
    ///
    /// # Errors
    /// Those of the backend; `Error::Stopped`.
    pub(super) fn look(
        &self,
        (study, worlds): (&Study, &[World]),
        (results, rankings): (&Results, &[Ranking]),
        backend: &mut dyn Backend,
        progress: &dyn Progress,
    ) -> Result<Cells> {
        let mut cells = Cells::default();
        results.scenes.iter().for_each(|scene| cells.put_moment(worlds, scene.moments.start));
        let mut viewer = Viewer::new(study, backend)?;
        for some in self.sights.chunks(AT_ONCE) {
            let mut by_moment: BTreeMap<usize, Vec<ShownPoses>> = BTreeMap::new();
            some.iter().for_each(|sight| by_moment.entry(sight.moment).or_default().push(*sight));
            let mut looked = BTreeMap::new();
            for (moment, sights_then) in by_moment {
                progress.check_stop()?;
                let choice = |sight: &ShownPoses| {
                    let Series { combination, representation } = rankings[sight.series].series;
                    Choice { combination, choice: sight.choice, representation, repeat: 0 }
                };
                let choices: Vec<Choice> = sights_then.iter().map(choice).collect();
                let views = viewer.view_regions(&worlds[moment], &choices)?;
                let look =
                    |(sight, view): (&ShownPoses, View)| (*sight, LookedAt::new(*sight, &view, &self.asked));
                looked.par_extend(sights_then.par_iter().zip(views).map(look));
                progress.advance(sights_then.len() as u64);
            }
            for (sight, looked) in some.iter().filter_map(|sight| looked.remove_entry(sight)) {
                if cells.bytes.len() > MOST_BYTES {
                    return Ok(cells);
                }
                cells.put_moment(worlds, sight.moment);
                cells.put_labels(sight, looked);
            }
        }
        Ok(cells)
    }
}

/// The contents of a view, before it is added.
struct LookedAt {
    /// Run-length encoded.
    labels: Vec<u8>,
    causes: Vec<CauseData>,
    explained: Vec<(ExplainedVoxels, Explained)>,
}

impl LookedAt {
    /// The labels in all regions, and the explanation of the unknown voxels.
    fn new(sight: ShownPoses, view: &View, asked: &[ToExplain]) -> LookedAt {
        let missed = view.why_in_regions();
        let window = view.labels.occupied.window();
        let place = |voxel: [i32; 3]| {
            let [x, y, z] = std::array::from_fn(|r| (voxel[r] - window.min[r]) as usize);
            x + window.size[0] as usize * (y + window.size[1] as usize * z)
        };
        let mut classes = vec![0u16; window.size.iter().map(|&n| n as usize).product()];
        let unknown = missed.iter().zip(2..).map(|(missed, class)| (&missed.voxels, class));
        for (voxels, class) in [(&view.labels.occupied, 1)].into_iter().chain(unknown) {
            voxels.voxels().for_each(|voxel| classes[place(voxel)] = class);
        }
        let mut labels = Vec::new();
        let in_regions = view.world.region_voxels();
        let each = in_regions.voxels().map(|voxel| usize::from(classes[place(voxel)]));
        put_runs(each, 2 + missed.len(), &mut labels);
        let cause = |Missed { cause, .. }: &Missed| CauseData {
            reason: cause.reason.name(),
            words: phrase(view, cause),
            monitored: cause.reason.is_monitored(),
        };
        let here = asked.iter().filter(|asked| asked.sight == sight);
        let explained = here.map(|&ToExplain { asked, region, .. }| {
            (asked, explain(view, &view.counts(region), view.tally(&missed, region)))
        });
        let (causes, explained) = (missed.iter().map(cause).collect(), explained.collect());
        LookedAt { labels, causes, explained }
    }
}

/// The number of views of the best by human_seen and by parts_detected, for this number by F1.
fn share_of_safety(most: usize) -> usize {
    most.div_ceil(5)
}

/// The views to compute: the recommended choice at every moment, the worst of each scene first; then the best choices,
/// each in every scene at its worst moment, then at the scene's first.
fn sights(
    results: &Results,
    rankings: &[Ranking],
    recommended: Option<&Recommended>,
    most: usize,
) -> Result<Vec<ShownPoses>> {
    let (mut known, mut sights) = (BTreeSet::new(), Vec::new());
    if let Some(&Recommended { series, choice, ref moments, .. }) = recommended {
        // All moments, worst first, so that moving scenes can be played.
        let all = moments.iter().copied().chain(results.moments());
        let all = all.map(|moment| ShownPoses { series, choice, moment });
        sights.extend(all.filter(|&sight| known.insert(sight)));
    }
    for rank in 0..most {
        for (series, ranking) in rankings.iter().enumerate() {
            for (best, score) in BESTS.into_iter().enumerate() {
                if score != Score::F1 && rank >= share_of_safety(most) {
                    continue;
                }
                for (region, list) in ranking.choices_by(best).iter().enumerate() {
                    let Some(&(choice, _)) = list.get(rank) else { continue };
                    let key = ranking.series.key(choice, region);
                    for scene in &results.scenes {
                        let moments = [worst(results, scene, key, score)?, scene.moments.start];
                        let all = moments.into_iter().map(|moment| ShownPoses { series, choice, moment });
                        sights.extend(all.filter(|&sight| known.insert(sight)));
                    }
                }
            }
        }
    }
    Ok(sights)
}

/// The moment with the lowest score of a choice; the first of the scene if it never has a value.
fn worst(results: &Results, scene: &SceneResults, key: RowKey, score: Score) -> Result<usize> {
    Ok(scene.moments.start + worst_snapshot(results, scene, key, score)?.unwrap_or(0))
}

/// The explained choice of a view, and its region.
#[derive(Debug)]
struct ToExplain {
    sight: ShownPoses,
    asked: ExplainedVoxels,
    region: usize,
}

/// The misses of the recommended choice in each scene at its worst moment, and of the best choices in each region.
fn explained_moments(
    results: &Results,
    rankings: &[Ranking],
    recommended: Option<&Recommended>,
) -> Result<Vec<ToExplain>> {
    let mut all = Vec::new();
    if let Some(&Recommended { series, choice, region, ref moments, .. }) = recommended {
        let sights = moments.iter().map(|&moment| ShownPoses { series, choice, moment });
        all.extend(sights.map(|sight| ToExplain { sight, asked: ExplainedVoxels::Recommended, region }));
    }
    for (best, score) in BESTS.into_iter().enumerate() {
        for region in 0..results.regions.len() {
            let Some(&(series, (choice, _))) = firsts(rankings, region, best).first() else { continue };
            let key = rankings[series].series.key(choice, region);
            for scene in &results.scenes {
                let moment = worst(results, scene, key, score)?;
                let asked = ExplainedVoxels::Best { best, region };
                all.push(ToExplain { sight: ShownPoses { series, choice, moment }, asked, region });
            }
        }
    }
    Ok(all)
}

impl Cells {
    /// Adds the contents of a view.
    fn put_labels(&mut self, sight: ShownPoses, looked: LookedAt) {
        let ShownPoses { series, choice, moment } = sight;
        let LookedAt { labels, causes, explained } = looked;
        let begin = self.bytes.len();
        self.bytes.extend(labels);
        let labels = [begin, self.bytes.len()];
        self.labels.push(CellLabels { series, choice, moment, labels, causes, explained });
    }

    /// Adds the scene at a moment, once.
    fn put_moment(&mut self, worlds: &[World], moment: usize) {
        if self.moments.iter().any(|known| known.moment == moment) {
            return;
        }
        let (truth, grid) = (&worlds[moment].truth(), worlds[moment].grid);
        let voxels = || BitGrid::full(grid.window());
        let role = |voxel| match () {
            _ if truth.ignored.get(voxel) => 4,
            _ if !truth.occupied.get(voxel) => 0,
            _ if truth.human.get(voxel) => 3,
            _ if truth.robot.get(voxel) => 2,
            _ => 1,
        };
        let truth = self.put(voxels().voxels().map(role), 5);
        let regions = &worlds[moment].regions;
        let regions =
            regions.iter().map(|r| self.put(voxels().voxels().map(|voxel| r.voxels.get(voxel).into()), 2));
        let regions = regions.collect();
        self.moments.push(CellMoment { moment, origin: grid.origin, size: grid.size, truth, regions });
    }

    fn put(&mut self, classes: impl Iterator<Item = usize>, kinds: usize) -> ByteRange {
        let begin = self.bytes.len();
        put_runs(classes, kinds, &mut self.bytes);
        [begin, self.bytes.len()]
    }
}
