//! The numbering of result rows: by moment, repeat, combination, choice of poses, representation and region, in study
//! order. The journal, the shards and the tables use it.

use std::ops::Range;

use super::journal::Shard;
use perirobot_study::input::{Combination, Study};

/// A row within a moment and repeat: one choice of poses in one representation and region. Indices are those of the
/// study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowKey {
    /// Index of the combination.
    pub combination: usize,
    /// Index of the choice of poses ([`perirobot_study::input::Combination::choice`]).
    pub choice: usize,
    /// Index of the choice of representations ([`perirobot_study::input::Combination::representations`]).
    pub representation: usize,
    /// Index of the region.
    pub region: usize,
}

/// A choice of poses to score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoseChoice {
    /// Index of the combination.
    pub combination: usize,
    /// Index of the choice of poses.
    pub choice: usize,
}

/// The numbers of choices of a combination: poses and representations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CombinationSize {
    /// The number of choices of poses.
    pub choices: usize,
    /// The number of choices of representations.
    pub representations: usize,
}

/// The numbering of all rows. A block is one repeat of one moment (a snapshot of a scene, counted through all scenes);
/// every block has the same rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowLayout {
    moments: usize,
    repeats: usize,
    sizes: Vec<CombinationSize>,
    regions: usize,
}

impl RowLayout {
    /// The layout for these numbers; `sizes` are those of the combinations.
    pub(crate) fn new(
        moments: usize,
        repeats: usize,
        sizes: Vec<CombinationSize>,
        regions: usize,
    ) -> RowLayout {
        RowLayout { moments, repeats, sizes, regions }
    }

    /// The number of blocks.
    pub fn blocks(&self) -> usize {
        self.moments * self.repeats
    }

    /// The block of a repeat of a moment.
    pub(crate) fn block(&self, moment: usize, repeat: usize) -> usize {
        moment * self.repeats + repeat
    }

    /// The number of rows in each block.
    pub(crate) fn block_rows(&self) -> u64 {
        self.sizes.iter().map(|size| self.rows_of(size)).sum()
    }

    /// The number of all rows.
    pub fn rows(&self) -> u64 {
        self.blocks() as u64 * self.block_rows()
    }

    /// The number of scored choices in each block.
    pub fn pose_choices(&self) -> usize {
        self.sizes.iter().map(|size| size.choices).sum()
    }

    /// All choices, in study order.
    pub fn all_choices(&self) -> impl Iterator<Item = PoseChoice> + '_ {
        let pose_choices = |(combination, size): (usize, &CombinationSize)| {
            (0..size.choices).map(move |choice| PoseChoice { combination, choice })
        };
        self.sizes.iter().enumerate().flat_map(pose_choices)
    }

    /// The place of a choice among all in a block.
    pub(crate) fn place(&self, pose_choice: &PoseChoice) -> usize {
        self.sizes[..pose_choice.combination].iter().map(|size| size.choices).sum::<usize>()
            + pose_choice.choice
    }

    /// The rows of one choice within a block: each representation, each region.
    pub(crate) fn rows_of_choice(&self, pose_choice: &PoseChoice) -> Range<u64> {
        let before: u64 = self.sizes[..pose_choice.combination].iter().map(|size| self.rows_of(size)).sum();
        let each = (self.sizes[pose_choice.combination].representations * self.regions) as u64;
        let first = before + pose_choice.choice as u64 * each;
        first..first + each
    }

    /// The rows of consecutive choices, within a block.
    pub(crate) fn rows_of_choices(&self, places: &Range<usize>) -> Range<u64> {
        self.first_row(places.start)..self.first_row(places.end)
    }

    /// The number of a row.
    pub(crate) fn row(&self, moment: usize, repeat: usize, key: &RowKey) -> u64 {
        let of_choice = self.rows_of_choice(&PoseChoice { combination: key.combination, choice: key.choice });
        let within = of_choice.start + (key.representation * self.regions + key.region) as u64;
        self.block(moment, repeat) as u64 * self.block_rows() + within
    }

    fn rows_of(&self, size: &CombinationSize) -> u64 {
        size.choices as u64 * (size.representations * self.regions) as u64
    }

    /// The first row, within a block, of the choice at a place, or the end of all choices.
    fn first_row(&self, mut place: usize) -> u64 {
        let mut rows = 0;
        for size in &self.sizes {
            let some = place.min(size.choices);
            rows += (some * size.representations * self.regions) as u64;
            place -= some;
        }
        rows
    }
}

/// The numbering of a study's rows.
pub fn layout_of(study: &Study) -> RowLayout {
    let size = |c: &Combination| CombinationSize {
        choices: c.choices(),
        representations: c.representation_count(&study.sensors),
    };
    let moments = study.scenes.iter().map(|scene| scene.snapshots).sum();
    let sizes = study.combinations.iter().map(size).collect();
    RowLayout::new(moments, study.repeats as usize, sizes, study.regions.len())
}

/// The number of scored choices, in each snapshot and repeat.
pub fn jobs(study: &Study) -> u64 {
    let layout = layout_of(study);
    layout.blocks() as u64 * layout.pose_choices() as u64
}

/// The choices of a shard, by their places among all. Every choice is in exactly one shard.
pub fn places_of(layout: &RowLayout, shard: Shard) -> Range<usize> {
    let at =
        |number: u32| (layout.pose_choices() as u128 * u128::from(number) / u128::from(shard.of)) as usize;
    at(shard.number)..at(shard.number + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two moments, three repeats; combinations of 3 × 1 and 2 × 4; two regions: blocks of 6 + 16 rows.
    fn layout() -> RowLayout {
        RowLayout::new(
            2,
            3,
            vec![
                CombinationSize { choices: 3, representations: 1 },
                CombinationSize { choices: 2, representations: 4 },
            ],
            2,
        )
    }

    #[test]
    fn rows_are_numbered_in_study_order() {
        let layout = layout();
        assert_eq!(
            (layout.blocks(), layout.block_rows(), layout.rows(), layout.pose_choices()),
            (6, 22, 132, 5)
        );
        let mut expected = 0;
        for moment in 0..2 {
            for repeat in 0..3 {
                for pose_choice in layout.all_choices() {
                    for representation in 0..[1, 4][pose_choice.combination] {
                        for region in 0..2 {
                            let PoseChoice { combination, choice } = pose_choice;
                            let key = RowKey { combination, choice, representation, region };
                            assert_eq!(
                                layout.row(moment, repeat, &key),
                                expected,
                                "{moment} {repeat} {key:?}"
                            );
                            expected += 1;
                        }
                    }
                }
            }
        }
        assert_eq!(expected, 132);
    }

    #[test]
    fn choices_that_follow_each_other_have_rows_that_do() {
        let layout = layout();
        let mut next = 0;
        for (place, pose_choice) in layout.all_choices().enumerate() {
            let rows = layout.rows_of_choice(&pose_choice);
            assert_eq!((layout.place(&pose_choice), rows.start), (place, next), "{pose_choice:?}");
            assert_eq!(layout.rows_of_choices(&(place..place + 1)), rows, "{pose_choice:?}");
            next = rows.end;
        }
        assert_eq!(layout.rows_of_choices(&(2..4)), 4..14);
        assert_eq!(layout.rows_of_choices(&(0..5)), 0..22);
        assert_eq!(layout.rows_of_choices(&(5..5)), 22..22);
    }
}
