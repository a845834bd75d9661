//! What at least two sensors of a set see, whatever they say of it: for redundancy, and for calibrating one against the
//! other. It does not depend on the rule of fusion.

/// How much of a region at least two sensors see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Overlap {
    /// Voxels that at least two sensors label, each occupied or free.
    pub twice: u64,
    /// People's voxels that at least two sensors hit or feel.
    pub hit_human_twice: u64,
}

/// How many counters an [`Overlap`] has.
pub const OVERLAP_COUNTERS: usize = 2;

impl Overlap {
    /// The counters: `twice`, `hit_human_twice`.
    pub fn counts(&self) -> [u64; OVERLAP_COUNTERS] {
        [self.twice, self.hit_human_twice]
    }

    /// The inverse of [`Overlap::counts`].
    pub fn from_counts([twice, hit_human_twice]: [u64; OVERLAP_COUNTERS]) -> Overlap {
        Overlap { twice, hit_human_twice }
    }

    /// Counter by counter.
    pub(crate) fn plus(&self, other: &Overlap) -> Overlap {
        let (a, b) = (self.counts(), other.counts());
        Overlap::from_counts(std::array::from_fn(|i| a[i] + b[i]))
    }
}
