//! How many random cases a test tries: some in the gate, all in the nightly.

/// `all` if `PERIROBOT_THOROUGH=1`, else `some`.
pub(crate) fn cases<T>(some: T, all: T) -> T {
    if std::env::var("PERIROBOT_THOROUGH").is_ok_and(|value| value == "1") { all } else { some }
}
