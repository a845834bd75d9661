//! Of which counts a score is, where there are several.

/// Of which counts a score is, where there are several scenes, snapshots and repeats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Across {
    /// Of all of them added up.
    #[default]
    Pooled,
    /// The worst of theirs.
    Worst,
    /// The mean of theirs.
    Mean,
}

impl Across {
    /// As in a study.
    pub fn name(self) -> &'static str {
        match self {
            Across::Pooled => "pooled",
            Across::Worst => "worst",
            Across::Mean => "mean",
        }
    }
}
