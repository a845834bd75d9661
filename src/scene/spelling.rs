//! How words are spelled: suggests the name that was meant by an unknown one ("did you mean"), and reads numbers as
//! other programs print them.

/// Names that are so near to what was written that they may be meant, from 0 (nothing alike) to 1 (the same).
const NEAR: f64 = 0.6;

/// The name that is nearest to a word, if one is near enough; the first of several.
pub fn nearest<'a>(written: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
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

/// A number of things: `1 node`, `2 nodes`.
pub(crate) fn plural(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// A number. Infinities and what is not a number may be as Microsoft's compilers print them: `-nan(ind)`, `1.#QNAN`,
/// `-1.#INF`.
pub(crate) fn number(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| {
        let plain = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
        match () {
            () if plain.starts_with("1.#inf") => Some(f64::INFINITY),
            () if plain.starts_with("1.#") || plain.starts_with("nan(") => Some(f64::NAN),
            () => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_compilers_print_them() {
        for word in ["nan", "-NaN", "nan(ind)", "-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND", "-1.#IND00"] {
            assert!(number(word).is_some_and(f64::is_nan), "{word}");
        }
        assert!(
            ["inf", "-inf", "1.#INF", "-1.#INF"]
                .iter()
                .all(|word| number(word).is_some_and(f64::is_infinite))
        );
        assert_eq!((number("-1.5e3"), number("1,5"), number("nano")), (Some(-1500.0), None, None));
        assert_eq!((number(""), number("one")), (None, None));
    }

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
