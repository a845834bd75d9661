//! Numbers that look as if they were written in another unit: radians where degrees are wanted, millimetres or
//! centimetres where metres are. They are warned of, and used as written.

use perirobot_march::lengths::describe_length;
use std::f64::consts::PI;

use toml::de::DeTable;
use toml::{Table, Value};

use super::unreadable::Step;
use super::written::{IN_MEMORY, line_at, place_of};

/// Positions and sizes of robot cells are smaller, in metres.
const LARGE_M: f64 = 100.0;
/// Sensors of a cell do not measure as far, in metres.
pub(crate) const FAR_M: f64 = 500.0;
/// Recordings in the coordinates of a map are that far from its origin, in metres.
const MAP_M: f64 = 1e5;
/// Spreads and gaps of sensors are smaller, in metres.
const WIDE_M: f64 = 5.0;
/// Cameras have a wider field of view than so many degrees, which as radians is nearly all around.
const NARROW_DEG: f64 = 3.2;
/// Slips that are told of a file; the others are counted.
const MOST_TOLD: usize = 5;

/// What looks like a slip in a study or a scene file, each with its line; nothing of a file that cannot be
/// read.
pub(crate) fn warnings(text: &str) -> Vec<String> {
    let (Ok(file), Ok(places)) = (toml::from_str::<Table>(text), DeTable::parse(text)) else {
        return Vec::new();
    };
    let mut slips = Vec::new();
    search_table(&file, &mut Vec::new(), &mut slips);
    let mut slips: Vec<(usize, String)> = slips
        .into_iter()
        .map(|(steps, what)| (place_of(places.get_ref(), &steps).unwrap_or(0), what))
        .collect();
    slips.sort();
    let more = slips.len().saturating_sub(MOST_TOLD);
    let line = |at| match text.starts_with(IN_MEMORY) {
        true => String::new(),
        false => format!("line {}: ", line_at(text, at)),
    };
    let told = slips.iter().take(MOST_TOLD).map(|(at, what)| format!("{}{what}", line(*at)));
    let rest =
        (more > 0).then(|| format!("{more} more numbers look like radians, millimetres or centimetres"));
    told.chain(rest).collect()
}

/// Where a number stands, and what it looks like.
type Slip = (Vec<Step>, String);

fn search_table(table: &Table, steps: &mut Vec<Step>, slips: &mut Vec<Slip>) {
    for (key, value) in table {
        steps.push(Step::Key(key.clone()));
        let mut numbers = Vec::new();
        let looks_like = match key.rsplit_once('_').map(|(_, unit)| unit) {
            Some("deg") => {
                all_numbers(value, &mut numbers);
                radians(key, &numbers)
            }
            Some("m") => {
                all_numbers(value, &mut numbers);
                let is_map = steps.contains(&Step::Key("recording".into()))
                    && numbers.iter().any(|number| number.abs() >= MAP_M);
                if is_map { None } else { not_metres(key, &numbers) }
            }
            _ => None,
        };
        if let Some(what) = looks_like {
            let value = value.to_string();
            let value = if value.len() > 60 { String::new() } else { format!(" = {value}") };
            slips.push((steps.clone(), format!("{key}{value} {what}")));
        } else if numbers.is_empty() {
            each_table(value, steps, slips);
        }
        steps.pop();
    }
}

fn each_table(value: &Value, steps: &mut Vec<Step>, slips: &mut Vec<Slip>) {
    match value {
        Value::Table(table) => search_table(table, steps, slips),
        Value::Array(list) => {
            for (number, entry) in list.iter().enumerate() {
                steps.push(Step::Entry(number));
                each_table(entry, steps, slips);
                steps.pop();
            }
        }
        _ => {}
    }
}

/// Every number of a value, with those of its lists and tables.
fn all_numbers(value: &Value, numbers: &mut Vec<f64>) {
    match value {
        Value::Integer(number) => numbers.push(*number as f64),
        Value::Float(number) => numbers.push(*number),
        Value::Array(list) => list.iter().for_each(|entry| all_numbers(entry, numbers)),
        Value::Table(table) => table.values().for_each(|entry| all_numbers(entry, numbers)),
        _ => {}
    }
}

/// What degrees look like that may be radians: a round angle to at least three places, a robot whose joints
/// hardly move, or a camera that sees hardly anything.
fn radians(key: &str, numbers: &[f64]) -> Option<String> {
    let degrees = |number: f64| format!("{number} rad are {:.4}°", number.to_degrees());
    let degrees = |number: f64| degrees(number).replace(".0000°", "°");
    if key == "resolution_deg"
        || key == "angle_deg"
        || numbers.iter().any(|number| number.abs() > 2.0 * PI + 1e-3)
    {
        return None;
    }
    let round = numbers.iter().find(|&&number| is_round_in_radians(number));
    let whole = |number: &f64| number.fract() == 0.0;
    let narrow = numbers
        .first()
        .filter(|first| key == "fov_deg" && (0.3..NARROW_DEG).contains(*first) && !whole(first));
    let moved: Vec<f64> = numbers.iter().copied().filter(|number| *number != 0.0).collect();
    let still = key == "joints_deg" && moved.len() >= 3 && !moved.iter().any(whole);
    let widest = moved.into_iter().reduce(|a, b| if b.abs() > a.abs() { b } else { a });
    let widest = widest.filter(|widest| still && widest.abs() >= 0.5);
    let number = round.or(narrow).copied().or(widest)?;
    Some(format!("looks like radians, and degrees are wanted: {}", degrees(number)))
}

/// Whether a number is a multiple of 15° in radians, written to four places or more, or of 45° to two or
/// three.
fn is_round_in_radians(number: f64) -> bool {
    let places = |n: i32| (number * 10f64.powi(n)).round() / 10f64.powi(n) == number;
    let near = |step: f64, tolerance: f64| {
        let times = (number / step).round();
        times != 0.0 && (number - times * step).abs() <= tolerance
    };
    match (places(1), places(2), places(3)) {
        (true, ..) => false,
        (_, true, _) => near(PI / 2.0, 4e-3),
        (_, _, true) => near(PI / 4.0, 6e-4),
        _ => near(PI / 12.0, 1e-4),
    }
}

/// What metres look like that may be millimetres or centimetres: larger than a cell, or than anything that a sensor
/// has. The likelier unit comes first.
fn not_metres(key: &str, numbers: &[f64]) -> Option<String> {
    let least = match key {
        "range_m" => FAR_M,
        "noise_std_m" | "std_m" | "near_ignore_m" | "inflation_m" | "keypoint_tolerance_m" | "per_m" => {
            WIDE_M
        }
        _ => LARGE_M,
    };
    let largest = numbers.iter().copied().reduce(|a, b| if b.abs() > a.abs() { b } else { a });
    let largest = largest.filter(|largest| largest.abs() >= least && largest.is_finite())?;
    let in_metres =
        |unit: &str, per_m: f64| format!("{largest} {unit} are {}", describe_length(largest / per_m));
    let [mm, cm] = [in_metres("mm", 1e3), in_metres("cm", 1e2)];
    Some(match largest.abs() {
        // In centimetres it would be farther than any cell, or than anything that a sensor has.
        all if all / 1e2 > least.min(LARGE_M) || least == WIDE_M => {
            format!("looks like millimetres, and metres are wanted: {mm}")
        }
        all if all >= 1e3 => {
            format!("looks like millimetres or centimetres, and metres are wanted: {mm}, {cm}")
        }
        _ => format!("looks like centimetres or millimetres, and metres are wanted: {cm}, {mm}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn assert_message(line: &str, expected: &str) {
        let found = warnings(line);
        assert!(found.len() == 1 && found[0].contains(expected), "{line}: {found:?}");
    }

    #[track_caller]
    fn silent(line: &str) {
        assert_eq!(warnings(line), [""; 0], "{line}");
    }

    #[test]
    fn radians_are_told_with_their_degrees() {
        assert_message(
            "rpy_deg = [0, 1.5708, 3.14159]",
            "line 1: rpy_deg = [0, 1.5708, 3.14159] looks like radians",
        );
        assert_message("rpy_deg = [0, 0, 1.57]", "1.57 rad are 89.9544°");
        assert_message("rpy_deg = [0.785, 0, 0]", "looks like radians");
        assert_message("rpy_deg = [0, 0, -0.5235988]", "-0.5235988 rad are -30°");
        assert_message("fov_deg = [1.518, 1.012]", "1.518 rad are 86.9750°");
        assert_message("fov_deg = 6.2832", "looks like radians");
        assert_message("joints_deg = { a = 0.31, b = -1.27, c = 2.11, d = 0 }", "2.11 rad are 120.8941°");
        assert_message(
            "[[p]]\nx = 1\norientations_deg = [{ pan = 0.7854, tilt = 0 }]",
            "line 3: orientations_deg",
        );
        assert_message(
            "random = { pan_deg = [-3.14159, 3.14159] }",
            "pan_deg = [-3.14159, 3.14159] looks like radians",
        );
    }

    #[test]
    fn degrees_are_not_told() {
        for line in [
            "rpy_deg = [0, 90, 180]",
            "rpy_deg = [0.5, 1.5, 3.0]",
            "rpy_deg = [0, 1.57, 45]",
            "rpy_deg = [0, 0, 0.79]",
            "resolution_deg = 0.2618",
            "rings_deg = [-1, 0, 1]",
            "fov_deg = 3",
            "fov_deg = [69.4, 42.5]",
            "joints_deg = { a = -5, b = 3, c = 2 }",
            "joints_deg = { a = 0.31, b = -91.5, c = 2.11 }",
            "joints_deg = { a = 0.01, b = 0.02, c = 0.03 }",
            "calibration = { position_m = 0.01, angle_deg = 0.2618 }",
        ] {
            silent(line);
        }
    }

    #[test]
    fn millimetres_are_told_with_their_metres() {
        assert_message(
            "position_m = [1200, -300, 800]",
            "millimetres or centimetres, and metres are wanted: 1200 mm are 1.2 m, 1200 cm",
        );
        assert_message(
            "z_m = [250]",
            "looks like centimetres or millimetres, and metres are wanted: 250 cm are 2.5 m, 250 mm",
        );
        assert_message(
            "position_m = [-90000, 0, 0]",
            "looks like millimetres, and metres are wanted: -90000 mm are -90 m",
        );
        assert_message("range_m = [300, 6000]", "6000 mm are 6 m");
        assert_message("x_m = { start = 0, stop = -4000, step = 500 }", "-4000 mm are -4 m");
        assert_message("near_ignore_m = 50", "50 mm are 0.05 m");
        assert_message("noise = { std_m = 10 }", "10 mm are 0.01 m");
        assert_message("box = { size_m = [400, 400, 400] }", "400 mm are 0.4 m");
        silent("range_m = [0.5, 200]");
        silent("position_m = [99, -20, 0]");
        silent("voxel_size_m = 0.05");
        silent("size_mm = 400");
        silent("not toml");
    }

    #[test]
    fn many_slips_are_counted() {
        let found = warnings(&"[[o]]\nposition_m = [1000, 0, 0]\n".repeat(8));
        assert_eq!(found.len(), 6);
        assert_eq!(found[5], "3 more numbers look like radians, millimetres or centimetres");
        assert!(found[4].starts_with("line 10: "), "{found:?}");
    }
}
