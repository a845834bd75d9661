//! Suggests the name that was meant by an unknown one ("did you mean").

/// Names that are so near to what was written that they may be meant, from 0 (nothing alike) to 1 (the same).
const NEAR: f64 = 0.6;

/// The name that is nearest to a word, if one is near enough; the first of several.
pub(crate) fn nearest<'a>(written: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let written = written.to_lowercase();
    let alike = |name: &str| {
        let name = name.to_lowercase();
        // Units are forgotten more often than letters are mistyped.
        let is_begun = written.len() > 1 && name.starts_with(&format!("{written}_"));
        let alike = strsim::normalized_damerau_levenshtein(&name, &written);
        if is_begun { 1.0 + alike } else { alike }
    };
    let rated = names.map(|name| (alike(name), name)).filter(|(alike, _)| *alike >= NEAR);
    rated.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_may_be_meant() {
        let near = |written| nearest(written, ["fov_deg", "range_m", "resolution_px", "name"].into_iter());
        for (written, expected) in [
            ("fov", Some("fov_deg")),
            ("fov_dge", Some("fov_deg")),
            ("Range_m", Some("range_m")),
            ("resolution", Some("resolution_px")),
            ("nme", Some("name")),
            ("colour", None),
            ("x", None),
            ("", None),
        ] {
            assert_eq!(near(written), expected, "{written:?}");
        }
    }
}
