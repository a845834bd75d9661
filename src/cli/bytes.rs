//! `--memory`: so many bytes, as people write them. Who shares them is the backend's affair.

/// What a number may be followed by, and what it then counts.
const UNITS: [(&str, u64); 4] = [("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10), ("", 1)];

/// The least that is worth asking for.
const LEAST: u64 = 1 << 20;

/// Reads `512MiB`, `1GiB`, `1.5 GiB` or a plain number of bytes.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || "must be a number and KiB, MiB or GiB, at least 1MiB, as in 512MiB or 1GiB".to_string();
    let split = UNITS.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size)));
    let (number, size) = split.ok_or_else(wrong)?;
    let number: f64 = number.trim_end().parse().map_err(|_| wrong())?;
    let bytes = number * size as f64;
    if bytes.is_finite() && bytes >= LEAST as f64 { Ok(bytes as u64) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn bytes_as_people_write_them() {
        for (text, expected) in [
            ("512MiB", 512 << 20),
            ("1GiB", 1 << 30),
            ("1.5 GiB", 3 << 29),
            ("2048KiB", 2 << 20),
            ("1048576", 1 << 20),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in ["", "GiB", "much", "1GB", "-1GiB", "1023KiB", "nan", "inf GiB", "0"] {
            assert!(bytes(text).unwrap_err().contains("512MiB or 1GiB"), "{text}");
        }
    }
}
