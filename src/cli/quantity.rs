//! Quantities with units: `--memory` in bytes, `--max-time` in seconds.

use std::time::Duration;

/// The units of memory in bytes.
const UNITS: [(&str, u64); 4] = [("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10), ("", 1)];

/// The least memory.
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

/// The units of time in seconds.
const TIMES: [(&str, f64); 5] = [("s", 1.0), ("m", 60.0), ("h", 3600.0), ("d", 86400.0), ("", 1.0)];

/// Reads `90s`, `30m`, `1.5h`, `2d` or a plain number of seconds.
pub(super) fn time(text: &str) -> Result<Duration, String> {
    let wrong = || "must be a number of seconds, or one with m, h or d, as in 90s, 30m or 1.5h".to_string();
    let split = TIMES.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size)));
    let (number, size) = split.ok_or_else(wrong)?;
    let number: f64 = number.trim_end().parse().map_err(|_| wrong())?;
    Duration::try_from_secs_f64(number * size).map_err(|_| wrong())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_as_people_write_them() {
        for (text, seconds) in
            [("90s", 90), ("30m", 1800), ("1.5h", 5400), ("2 d", 172_800), ("7", 7), ("0", 0)]
        {
            assert_eq!(time(text), Ok(Duration::from_secs(seconds)), "{text}");
        }
        for text in ["", "h", "soon", "-1s", "1w", "nan", "inf", "1e300d"] {
            assert!(time(text).unwrap_err().contains("90s, 30m or 1.5h"), "{text}");
        }
    }

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
