//! `perirobot sensors`: the device catalogue, with values and sources. It is in `input::catalogue`.

use std::process::ExitCode;

use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_study::input::catalogue::{DeviceModel, Stereo, models};
use perirobot_study::sensor::noise::Deviation;
use toml::Value;

/// List the devices that a study may name, with sources
///
/// A [[sensor]] with `model = "realsense-d435"` has the keys of that device; keys in the study itself take precedence.
/// Values are the makers' if available; values that could not be checked against a maker's own document are marked.
/// Check the data sheet of your device before you rely on any.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot sensors                      all devices, a line each
  perirobot sensors realsense-d435       one device: its keys, source and notes
  perirobot sensors ouster sick          all devices with these in their names")]
pub(super) struct Args {
    /// Only devices with one of these in their names, with all their data
    #[arg(value_name = "NAME")]
    names: Vec<String>,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    if args.names.is_empty() {
        let lines = models().iter().map(line);
        let more = "\n`perirobot sensors NAME` prints values and sources; in a study: model = \"NAME\"\n\
                    list prices are those of public shops, to be checked; cost = \"list\" takes one\n";
        super::print(&(HEAD.to_string() + &lines.collect::<String>() + more))?;
        return Ok(ExitCode::SUCCESS);
    }
    for name in &args.names {
        let found: Vec<_> =
            models().iter().filter(|model| model.name.contains(&name.to_lowercase())).collect();
        if found.is_empty() {
            let what = format!("no device has {name:?} in its name: `perirobot sensors` lists all");
            return Err(Issue::says(what).into());
        }
        found.into_iter().try_for_each(|model| super::print(&describe(model)))?;
    }
    Ok(ExitCode::SUCCESS)
}

const HEAD: &str = "\
model                         kind  field (deg)  resolution     range (m)  noise at 2 m  list price
";

/// A device as one line: field of view, resolution, range and noise.
fn line(model: &DeviceModel) -> String {
    let key = |key: &str| model.keys.get(key);
    let numbers = |value: &Value| match value {
        Value::Array(all) => all.iter().map(plain).collect::<Vec<_>>().join(" x "),
        one => plain(one),
    };
    let field = match (key("fov_deg"), key("rings_deg"), key("elevation_deg")) {
        (Some(around), Some(Value::Array(rings)), _) => format!("{} x {}", plain(around), spread(rings)),
        (Some(around), _, Some(Value::Array(rise))) => format!("{} x {}", plain(around), spread(rise)),
        (around, ..) => around.map_or_else(String::new, numbers),
    };
    let around =
        key("beams").map(plain).or(key("resolution_deg").map(|step| format!("{} deg", numbers(step))));
    let resolution = match (key("resolution_px"), around, key("rings")) {
        (Some(pixels), ..) => format!("{} px", numbers(pixels)),
        (None, Some(around), Some(rings)) => format!("{around} x {}", plain(rings)),
        (None, Some(around), None) if key("beams").is_some() => format!("{around} beams"),
        (None, around, _) => around.unwrap_or_default(),
    };
    let range = match key("range_m") {
        Some(Value::Array(range)) => range.iter().map(plain).collect::<Vec<_>>().join("-"),
        _ => String::new(),
    };
    let line = format!(
        "{:<29} {:<5} {field:<12} {resolution:<14} {range:<10} {:<13} {}",
        model.name,
        model.kind(),
        model.keys.get("noise").map_or_else(String::new, noise),
        model.price.as_ref().map_or_else(String::new, |price| format!("{} {}", price.amount, price.currency))
    );
    line.trim_end().to_string() + "\n"
}

/// The standard deviation at 2 m.
fn noise(said: &Value) -> String {
    let term = |key: &str| said.get(key).and_then(Value::as_float).unwrap_or(0.0);
    match said {
        Value::Table(_) => {
            let deviation = Deviation { std_m: term("std_m"), per_m: term("per_m"), per_m2: term("per_m2") };
            format!("{:.1} cm", 100.0 * deviation.at_m(2.0))
        }
        word => plain(word),
    }
}

/// A number with at most two decimals, or a word.
fn plain(value: &Value) -> String {
    let short = |number: f64| {
        let text = format!("{number:.2}");
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    };
    match value {
        Value::Float(number) => short(*number),
        Value::String(word) => word.clone(),
        other => other.to_string(),
    }
}

/// The range of some angles.
fn spread(angles: &[Value]) -> String {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
    let angles = angles.iter().filter_map(number);
    let (low, high) = angles.fold((f64::MAX, f64::MIN), |(low, high), a| (low.min(a), high.max(a)));
    plain(&Value::Float(high - low))
}

/// All data of a device, as lines to paste into a study.
fn describe(model: &DeviceModel) -> String {
    let mut text = format!("# {}\n# source: {}\n#         {}\n", model.title, model.source, model.url);
    text += &format!("# {}\n", model.note);
    if let Some(unconfirmed) = &model.unconfirmed {
        text += &format!("# not checked against the maker's document: {unconfirmed}\n");
    }
    if !model.resolutions_mm.is_empty() {
        let all: Vec<String> = model.resolutions_mm.iter().map(f64::to_string).collect();
        text += &format!("# its field can be set to a resolution of {} mm, to be checked\n", all.join(", "));
    }
    if let Some(price) = &model.price {
        text += &format!("# list price, to be checked: {}; cost = \"list\" takes it\n", price.to_text());
    }
    if let Some(Stereo { baseline_m, subpixel_px }) = model.stereo {
        text += &format!(
            "# noise: {subpixel_px} pixels of disparity, lenses {baseline_m} m apart: subpixel * z^2 / (focal length * baseline)\n"
        );
    }
    let keys = model.keys.iter().map(|(key, value)| format!("{key} = {value}\n"));
    format!(
        "{text}model = {:?}\n# equivalent to\n{}\n",
        model.name,
        keys.map(|line| format!("#   {line}")).collect::<String>()
    )
}
