//! What is wrong in a file that is not TOML, in our words where the parser's do not say what to write.

/// What is wrong in a file that is not TOML and what to write, by a fragment of the parser's message; the first counts.
const CURES: [(&str, &str); 14] = [
    ("escaped value", BACKSLASHES),
    ("unicode value", BACKSLASHES),
    ("hexadecimal value", BACKSLASHES),
    (
        "string values must be quoted",
        "not a value: write text between plain quotes, as in \"abc\", numbers with a point, as in 1.5, and a comma between two \
         values",
    ),
    ("invalid mantissa", "a number begins with a digit, as in 0.5"),
    ("invalid fraction", "a digit follows the point, as in 5.0"),
    ("leading zero", "a number has no zeros before it, as in 5"),
    ("expected newline", "a number has a decimal point, as in 1.5, and each key a line of its own"),
    ("expected `nan`", "not a number: write digits, as in 1.5 (TOML itself writes nan in small letters)"),
    ("invalid float", "a number stands alone, as in 5: the key has the unit, as in fov_deg"),
    ("invalid boolean", "write true or false, in small letters"),
    ("key with no value", "write = between a key and its value, as in a = 5"),
    ("invalid basic string", "the closing quote is missing: write text between two quotes, as in \"abc\""),
    ("invalid literal string", "the closing quote is missing: write text between two quotes, as in 'abc'"),
];
const BACKSLASHES: &str = "between \" a backslash begins an escape: write paths with /, as in \"C:/cell/part.stl\", or between \
                           single quotes, as in 'C:\\cell\\part.stl'";

/// An error of the TOML parser as it shows it: below the line of the file what is wrong, in our words where it has none.
pub(crate) fn show(error: &toml::de::Error) -> String {
    let (shown, message) = (error.to_string(), error.message());
    let cure = CURES.iter().find(|(fragment, _)| message.contains(fragment));
    let replaced =
        cure.and_then(|(_, cure)| Some(format!("{}{cure}", shown.trim_end().strip_suffix(message)?)));
    replaced.unwrap_or(shown)
}

#[cfg(test)]
mod tests {
    use toml::Table;

    use super::*;

    #[test]
    fn what_is_not_toml_is_told_in_our_words() {
        for (value, expected) in [
            ("5deg", "a number stands alone, as in 5"),
            ("True", "write true or false"),
            ("NaN", "not a number: write digits"),
            ("\"cell.toml", "the closing quote is missing"),
            ("'cell.toml", "the closing quote is missing"),
            ("cell.toml", "not a value: write text between plain quotes"),
            ("\"C:\\Users\\me\"", "between \" a backslash begins an escape"),
            ("5.", "a digit follows the point"),
        ] {
            let text = format!("a = {value}\n");
            let shown = show(&toml::from_str::<Table>(&text).unwrap_err());
            let (line, said) = shown.rsplit_once('\n').unwrap();
            assert!(line.contains(value) && said.starts_with(expected), "{value}: {shown}");
        }
        let shown = show(&toml::from_str::<Table>("a: 5").unwrap_err());
        assert!(shown.ends_with("write = between a key and its value, as in a = 5"), "{shown}");
    }
}
