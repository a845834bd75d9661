//! Computes scores from counts: F1, Cohen's κ and what a safety review asks first. All are pure functions of
//! integers; each score is one division in f64, so equal counts give equal scores everywhere.

mod across;
mod detection;
mod overlap;
mod ratio;
mod score;

pub use across::Across;
pub use detection::{BODY_PARTS, BodyPart, DETECTION_COUNTERS, Detection, PartTally};
pub use overlap::{OVERLAP_COUNTERS, Overlap};
pub use ratio::Ratio;
pub use ratio::gcd;
pub use score::{SCORES, Score};

/// True positives, false negatives and unknowns among the voxels of one role (the human's, the robot's).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RoleCounts {
    /// Truly occupied, labelled occupied.
    pub tp: u64,
    /// Truly occupied, labelled free.
    pub fn_: u64,
    /// Truly occupied, unknown.
    pub uo: u64,
}

/// What one pose got right and wrong in one region, in voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Confusion {
    /// Truly occupied, labelled occupied.
    pub tp: u64,
    /// Truly free, labelled occupied.
    pub fp: u64,
    /// Truly occupied, labelled free.
    pub fn_: u64,
    /// Truly free, labelled free.
    pub tn: u64,
    /// Truly occupied, unknown.
    pub uo: u64,
    /// Truly free, unknown.
    pub uf: u64,
    /// The human's voxels alone.
    pub human: RoleCounts,
    /// The robot's voxels alone.
    pub robot: RoleCounts,
    /// Which people are detected.
    pub detection: Detection,
    /// What at least two sensors see. Manifests of older versions have none.
    #[serde(default)]
    pub overlap: Overlap,
}

/// How many counters of labels a [`Confusion`] has, in the order of [`Confusion::from_counts`].
pub const COUNTERS: usize = 12;

impl Confusion {
    /// From counters in the order tp, fp, fn, tn, uo, uf, human tp, fn, uo, robot tp, fn, uo.
    pub fn from_counts(c: [u64; COUNTERS]) -> Self {
        let role = |at: usize| RoleCounts { tp: c[at], fn_: c[at + 1], uo: c[at + 2] };
        Confusion {
            tp: c[0],
            fp: c[1],
            fn_: c[2],
            tn: c[3],
            uo: c[4],
            uf: c[5],
            human: role(6),
            robot: role(9),
            detection: Detection::default(),
            overlap: Overlap::default(),
        }
    }

    /// The inverse of [`Confusion::from_counts`]: all but the detection and the overlap.
    pub fn counts(&self) -> [u64; COUNTERS] {
        let (h, r) = (self.human, self.robot);
        [self.tp, self.fp, self.fn_, self.tn, self.uo, self.uf, h.tp, h.fn_, h.uo, r.tp, r.fn_, r.uo]
    }

    /// All numbers: the counters of labels, those of the detection, in how many rows each part is missed, and the
    /// counters of the overlap.
    pub fn numbers(&self) -> Vec<u64> {
        let Confusion { detection, overlap, .. } = self;
        [&self.counts()[..], &detection.counts(), &detection.missed, &overlap.counts()].concat()
    }

    /// The same labels with a detection.
    pub fn with_detection(self, detection: Detection) -> Self {
        Confusion { detection, ..self }
    }

    /// The same labels with an overlap.
    pub fn with_overlap(self, overlap: Overlap) -> Self {
        Confusion { overlap, ..self }
    }

    /// Counter by counter.
    pub fn plus(&self, other: &Confusion) -> Confusion {
        let (a, b) = (self.counts(), other.counts());
        let labels = Confusion::from_counts(std::array::from_fn(|i| a[i] + b[i]));
        let detection = self.detection.plus(&other.detection);
        labels.with_detection(detection).with_overlap(self.overlap.plus(&other.overlap))
    }

    /// Voxels of the region.
    pub fn total(&self) -> u64 {
        self.counts()[..6].iter().sum()
    }

    /// 2TP / (2TP + FP + FN + UF + UO); `None` where the denominator is zero.
    pub fn f1(&self) -> Option<f64> {
        let twice_tp = 2 * self.tp as i128;
        let wrong = (self.fp + self.fn_ + self.uf + self.uo) as i128;
        ratio(twice_tp, twice_tp + wrong)
    }

    /// Cohen's κ over the classes occupied, free, unknown; the truth has no unknown. `None` where chance
    /// alone would agree on everything.
    pub fn kappa(&self) -> Option<f64> {
        let [tp, fp, fn_, tn, uo, uf] =
            [self.tp, self.fp, self.fn_, self.tn, self.uo, self.uf].map(|n| n as i128);
        let s = tp + fp + fn_ + tn + uo + uf;
        let chance = (tp + fp) * (tp + fn_ + uo) + (fn_ + tn) * (fp + tn + uf);
        ratio(s * (tp + tn) - chance, s * s - chance)
    }

    /// People's voxels of the region.
    pub fn people_voxels(&self) -> u64 {
        self.human.tp + self.human.fn_ + self.human.uo
    }

    /// The share of people's voxels that are hit, or that a presence sensor feels.
    pub fn human_seen(&self) -> Option<f64> {
        ratio(self.detection.hit_human as i128, self.people_voxels() as i128)
    }

    /// The share of people's voxels that are labelled occupied.
    pub fn human_claimed(&self) -> Option<f64> {
        ratio(self.human.tp as i128, self.people_voxels() as i128)
    }

    /// The share of people that are detected.
    pub(crate) fn people_detected(&self) -> Option<f64> {
        ratio(self.detection.people_detected as i128, self.detection.people as i128)
    }

    /// The share of people's parts that are detected.
    pub fn parts_detected(&self) -> Option<f64> {
        ratio(self.detection.parts_detected as i128, self.detection.parts as i128)
    }

    /// The share of the region that stays unknown.
    pub fn unknown(&self) -> Option<f64> {
        ratio((self.uo + self.uf) as i128, self.total() as i128)
    }

    /// The share of the free voxels with a label that are called occupied.
    pub fn false_alarm(&self) -> Option<f64> {
        ratio(self.fp as i128, (self.fp + self.tn) as i128)
    }

    /// The share of the region that at least two sensors label.
    pub fn seen_twice(&self) -> Option<f64> {
        ratio(self.overlap.twice as i128, self.total() as i128)
    }
}

/// One division; no score for a zero denominator.
fn ratio(numerator: i128, denominator: i128) -> Option<f64> {
    (denominator != 0).then(|| numerator as f64 / denominator as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(tp: u64, fp: u64, fn_: u64, tn: u64, uo: u64, uf: u64) -> Confusion {
        Confusion { tp, fp, fn_, tn, uo, uf, ..Default::default() }
    }

    #[test]
    fn tables_worked_by_hand() {
        // 2·20 / (40 + 5 + 10 + 15 + 20) = 40/90
        let t = table(20, 5, 10, 30, 20, 15);
        assert_eq!(t.f1(), Some(40.0 / 90.0));
        // s = 100, agreed 50; occupied 25·50, free 40·50: (5000 − 3250) / (10000 − 3250)
        assert_eq!(t.kappa(), Some(1750.0 / 6750.0));
        assert_eq!(t.unknown(), Some(0.35));
        assert_eq!(t.false_alarm(), Some(5.0 / 35.0));
        // A classic two-class table without unknowns: po 0.7, pe 0.5, κ 0.4.
        assert_eq!(table(20, 10, 5, 15, 0, 0).kappa(), Some(0.4));
    }

    #[test]
    fn empty_and_blind_regions_have_no_false_scores() {
        let empty = Confusion::default();
        assert_eq!((empty.f1(), empty.kappa(), empty.human_seen()), (None, None, None));
        assert_eq!(
            (empty.human_claimed(), empty.people_detected(), empty.parts_detected()),
            (None, None, None)
        );
        assert_eq!((empty.unknown(), empty.false_alarm(), empty.seen_twice()), (None, None, None));
        let blind = table(0, 0, 0, 0, 10, 90);
        assert_eq!(blind.f1(), Some(0.0));
        assert_eq!(blind.kappa(), Some(0.0), "knowing nothing is no better than chance");
        assert_eq!((blind.unknown(), blind.seen_twice()), (Some(1.0), Some(0.0)));
        let all_free_and_right = table(0, 0, 0, 100, 0, 0);
        assert_eq!(all_free_and_right.kappa(), None, "chance agrees on everything");
        assert_eq!(all_free_and_right.f1(), None);
    }

    #[test]
    fn perfect_is_one_and_counts_survive_the_round_trip() {
        let perfect = table(10, 0, 0, 90, 0, 0);
        assert_eq!((perfect.f1(), perfect.kappa()), (Some(1.0), Some(1.0)));
        let counts: [u64; COUNTERS] = std::array::from_fn(|i| i as u64 + 1);
        assert_eq!(Confusion::from_counts(counts).counts(), counts);
        assert_eq!(Confusion::from_counts(counts).total(), 21);
        let detection = Detection {
            hit_human: 5,
            people: 4,
            people_detected: 3,
            parts: 20,
            parts_detected: 11,
            ..Default::default()
        };
        let overlap = Overlap { twice: 7, hit_human_twice: 2 };
        let of = Confusion::from_counts(counts).with_detection(detection).with_overlap(overlap);
        assert_eq!((of.human_claimed(), of.human_seen()), (Some(7.0 / 24.0), Some(5.0 / 24.0)));
        assert_eq!((of.people_detected(), of.parts_detected()), (Some(0.75), Some(0.55)));
        assert_eq!(of.seen_twice(), Some(7.0 / 21.0));
        assert_eq!(of.plus(&of).detection.counts(), detection.counts().map(|n| 2 * n));
        assert_eq!(of.plus(&of).overlap.counts(), [14, 4]);
        assert_eq!(of.numbers().len(), COUNTERS + DETECTION_COUNTERS + BODY_PARTS + OVERLAP_COUNTERS);
    }

    #[test]
    fn the_largest_grid_does_not_overflow() {
        let n = 1023u64.pow(3);
        assert_eq!(table(n, 0, 0, n, 0, 0).kappa(), Some(1.0));
    }
}
