//! `camera_info = "left.yaml"`: takes resolution and field of view of a camera from its ROS calibration. The
//! camera that is cast is an ideal pinhole whose axis passes the middle of its image, so the difference from
//! the real camera is measured here, and warned of.

use std::path::Path;

use serde::Deserialize;
use serde_json::Value as Json;
use serde_saphyr::options::NonFiniteFloatPolicy;
use toml::{Table, Value};

use crate::diagnostics::{self, Place};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::source::Sources;

/// The key that names the file.
pub(crate) const KEY: &str = "camera_info";

/// The keys that it stands for.
pub(crate) const GIVES: [&str; 2] = ["fov_deg", "resolution_px"];

/// Pixels may be off by up to this part of the image's width without a warning.
const NEGLIGIBLE: f64 = 0.01;
/// If pixels are off by more than this part, a pinhole cannot stand for the camera.
const TOO_FAR: f64 = 0.10;

/// Most bytes of a file: the parser may take some two hundred bytes of memory for each.
const LARGEST: usize = 1 << 20;
/// Most values that aliases may copy. The parser's own limits bound the nesting depth (64) and the number of values.
const MOST_COPIED: usize = 10_000;

/// What helps with a camera that is no pinhole.
const CURE: &str =
    "name the camera_info of the rectified image, or cast its rays one by one with kind = \"rays\"";

/// A `sensor_msgs/CameraInfo`, as `camera_calibration` writes it and as `ros2 topic echo` prints it.
#[derive(Deserialize)]
struct CameraInfoFile {
    #[serde(alias = "width")]
    image_width: u32,
    #[serde(alias = "height")]
    image_height: u32,
    #[serde(alias = "K", alias = "k")]
    camera_matrix: Vec<f64>,
    distortion_model: Option<String>,
    #[serde(default, alias = "D", alias = "d")]
    distortion_coefficients: Vec<f64>,
    #[serde(default)]
    binning_x: u32,
    #[serde(default)]
    binning_y: u32,
    #[serde(default)]
    roi: Roi,
}

/// The part of the sensor that the image is; all zero means the whole.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Roi {
    width: u32,
    height: u32,
}

/// The pinhole of a file.
struct Pinhole {
    size_px: [f64; 2],
    focal_px: [f64; 2],
    center_px: [f64; 2],
}

/// Replaces `camera_info` in the keys of a camera by the keys that it stands for; returns warnings about
/// differences.
pub(crate) fn resolve(at: &Place, keys: &mut Table, sources: &Sources) -> Result<Vec<String>> {
    let Some(written) = keys.remove(KEY) else { return Ok(Vec::new()) };
    let Some(name) = written.as_str() else {
        return Err(at.wrong(KEY, written, "must be a file, as in camera_info = \"left.yaml\""));
    };
    if let Some(twice) = GIVES.iter().find(|key| keys.contains_key(**key)) {
        let both = Issue::says(format!("both {KEY} and {twice}"));
        return Err(at.wrap(both.with_advice("the file gives it; take one away")));
    }
    let path = at.folder().join(name);
    let wrong = |error: Error| at.wrap(error.with_place(KEY));
    let info = read(&path, sources).map_err(wrong)?;
    let pinhole = pinhole(&info).map_err(|issue| wrong(issue.with_place(&path).into()))?;
    let odd = oddities(&info, &pinhole).map_err(|issue| wrong(issue.with_place(&path).into()))?;
    let angle = |axis: usize| {
        Value::from(2.0 * libm::atan(pinhole.size_px[axis] / 2.0 / pinhole.focal_px[axis]).to_degrees())
    };
    keys.insert("fov_deg".into(), Value::Array(vec![angle(0), angle(1)]));
    let pixels = [info.image_width, info.image_height].map(|pixels| Value::from(i64::from(pixels)));
    keys.insert("resolution_px".into(), Value::Array(pixels.to_vec()));
    Ok(odd.into_iter().map(|what| format!("{KEY} = {name:?}: {what}")).collect())
}

fn read(path: &Path, sources: &Sources) -> Result<CameraInfoFile> {
    let keys = "a camera_info has image_width, image_height and camera_matrix (or width, height and k)";
    let wrong = |issue: Issue| issue.cure(keys).with_place(path);
    let text = sources.text(path)?;
    if text.len() > LARGEST {
        let large = Issue::too_large(format!("has {} bytes", text.len()));
        return Err(wrong(large.with_advice(format!("must have at most {LARGEST}"))).into());
    }
    let mut table = first_document(&text).map_err(wrong)?;
    // Numbers stand as a list, or as a matrix with its size.
    for (_, value) in table.iter_mut() {
        if let Some(data) = value.as_table_mut().and_then(|matrix| matrix.remove("data")) {
            *value = data;
        }
    }
    let info = diagnostics::read(table).map_err(|e| {
        let issue = Issue::damaged(e.message.as_str());
        wrong(if e.keys().is_empty() { issue } else { issue.with_place(e.keys().join(".")) })
    })?;
    Ok(info)
}

/// The first document of a YAML file that is not empty, as a table: `ros2 topic echo` ends each message with the mark of
/// a new document. Later documents are not read.
fn first_document(text: &str) -> Result<Table, Issue> {
    let options = serde_saphyr::options! {
        with_snippet: false,
        // A text, which is refused where a number is wanted, with the text in the message.
        non_finite_float_policy: NonFiniteFloatPolicy::AsString,
        // Copies made by aliases count as well, so a file cannot grow to more than its double.
        budget: serde_saphyr::budget! { max_total_scalar_bytes: 2 * LARGEST },
        alias_limits: serde_saphyr::alias_limits! { max_total_replayed_events: MOST_COPIED },
    };
    let mut bytes = text.as_bytes();
    let mut documents = serde_saphyr::read_with_options::<_, Json>(&mut bytes, options);
    let first = documents.next().ok_or_else(|| Issue::damaged("is empty"))?;
    let syntax = |e: serde_saphyr::Error| e.render_with_formatter(&serde_saphyr::UserMessageFormatter);
    match first.map(value_of).map_err(|e| Issue::damaged(syntax(e)))? {
        Some(Value::Table(table)) => Ok(table),
        _ => Err(Issue::damaged("is not a table of keys")),
    }
}

/// The value in the types that studies are read from. An empty value is the same as a missing key; in a list it is an
/// empty text, so that the other entries keep their places.
fn value_of(json: Json) -> Option<Value> {
    Some(match json {
        Json::Null => return None,
        Json::Bool(is) => Value::Boolean(is),
        Json::Number(number) => match (number.as_i64(), number.as_f64()) {
            (Some(whole), _) => Value::Integer(whole),
            (None, fraction) => Value::Float(fraction?),
        },
        Json::String(text) => Value::String(text),
        Json::Array(list) => {
            Value::Array(list.into_iter().map(|entry| value_of(entry).unwrap_or("".into())).collect())
        }
        Json::Object(table) => {
            Value::Table(table.into_iter().filter_map(|(key, value)| Some((key, value_of(value)?))).collect())
        }
    })
}

fn pinhole(info: &CameraInfoFile) -> Result<Pinhole, Issue> {
    let [fx, skew, cx, _, fy, cy, _, _, _] = info.camera_matrix[..] else {
        return Err(Issue::says(format!("camera_matrix has {} numbers", info.camera_matrix.len()))
            .with_advice("must have 9"));
    };
    let size_px = [info.image_width, info.image_height].map(f64::from);
    if [info.image_width, info.image_height].contains(&0) {
        let [x, y] = size_px;
        return Err(Issue::says(format!("image_width and image_height are {x} and {y}"))
            .with_advice("must be above 0"));
    }
    // The reader lets no number in that is not finite.
    if !(fx > 0.0 && fy > 0.0) {
        return Err(Issue::says(format!("camera_matrix has fx = {fx}, fy = {fy}"))
            .with_advice("focal lengths must be above 0; a camera that was never calibrated has zeros"));
    }
    if skew != 0.0 {
        return Err(Issue::value("camera_matrix[1]", skew, format!("must be 0; {CURE}")));
    }
    if info.binning_x > 1 || info.binning_y > 1 {
        let (x, y) = (info.binning_x, info.binning_y);
        return Err(Issue::says(format!("binning_x = {x}, binning_y = {y}"))
            .with_advice("must be 0 or 1; give the numbers of the binned image"));
    }
    let whole = |part: u32, all: u32| part == 0 || part == all;
    if !whole(info.roi.width, info.image_width) || !whole(info.roi.height, info.image_height) {
        let (x, y) = (info.roi.width, info.roi.height);
        return Err(Issue::says(format!("roi is {x} x {y}"))
            .with_advice("must be the whole image; give the numbers of the part"));
    }
    Ok(Pinhole { size_px, focal_px: [fx, fy], center_px: [cx, cy] })
}

/// How the camera differs from an ideal pinhole, where that is worth a warning.
fn oddities(info: &CameraInfoFile, pinhole: &Pinhole) -> Result<Vec<String>, Issue> {
    let Pinhole { size_px: [width, _], .. } = pinhole;
    let mut odd = Vec::new();
    // ROS counts pixels by their centres.
    let off: [f64; 2] = std::array::from_fn(|r| pinhole.center_px[r] - (pinhole.size_px[r] - 1.0) / 2.0);
    let angle: [f64; 2] = std::array::from_fn(|r| libm::atan(off[r] / pinhole.focal_px[r]).to_degrees());
    let said = format!(
        "the principal point is {:+.1} px across and {:+.1} px down from the centre of the image, so the view that is cast \
         is turned by {:.1} and {:.1} degrees from the camera's",
        off[0], off[1], angle[0], angle[1]
    );
    judge(off[0].abs().max(off[1].abs()) / width, said, &mut odd)?;
    let moved = distortion(info, pinhole)?;
    let said = format!(
        "the lens moves pixels by up to {moved:.1} px ({:.1} % of the width), which \
                the pinhole that is cast does not",
        100.0 * moved / width
    );
    judge(moved / width, said, &mut odd)?;
    Ok(odd)
}

/// Passes over, says, or refuses, by the part of the width.
fn judge(part: f64, said: String, odd: &mut Vec<String>) -> Result<(), Issue> {
    match part {
        part if part <= NEGLIGIBLE => Ok(()),
        part if part <= TOO_FAR => {
            odd.push(said);
            Ok(())
        }
        _ => Err(Issue::too_large(said)
            .with_advice(format!("more than {:.0} % of the width is too far; {CURE}", 100.0 * TOO_FAR))),
    }
}

/// The farthest that the lens moves a pixel on the border of the image, where it moves them most.
fn distortion(info: &CameraInfoFile, pinhole: &Pinhole) -> Result<f64, Issue> {
    let given = &info.distortion_coefficients;
    let model = info.distortion_model.as_deref().unwrap_or("plumb_bob");
    if !["", "none", "plumb_bob", "rational_polynomial"].contains(&model) {
        return Err(Issue::value("distortion_model", format!("{model:?}"), format!("is no pinhole; {CURE}")));
    }
    if given.len() > 8 && given[8..].iter().any(|&coefficient| coefficient != 0.0) {
        return Err(Issue::too_large(format!("distortion_coefficients has {} numbers", given.len()))
            .with_advice(format!("at most 8 are known; {CURE}")));
    }
    let [k1, k2, p1, p2, k3, k4, k5, k6] = std::array::from_fn(|i| given.get(i).copied().unwrap_or_default());
    let moved = |u: f64, v: f64| {
        let [x, y] = [(u, 0), (v, 1)].map(|(pixel, r)| (pixel - pinhole.center_px[r]) / pinhole.focal_px[r]);
        let r2 = x * x + y * y;
        let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        let dx = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) - x;
        let dy = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y - y;
        (dx * pinhole.focal_px[0]).hypot(dy * pinhole.focal_px[1])
    };
    let [right, bottom] = pinhole.size_px.map(|size| size - 1.0);
    let along = (0..=16).map(|step| f64::from(step) / 16.0);
    let border = along.flat_map(|part| {
        let (u, v) = (part * right, part * bottom);
        [(u, 0.0), (u, bottom), (0.0, v), (right, v)]
    });
    let most = border
        .map(|(u, v)| moved(u, v))
        .fold(0.0, |most: f64, one| if one > most || one.is_nan() { one } else { most });
    Ok(most)
}

#[cfg(test)]
mod tests;
