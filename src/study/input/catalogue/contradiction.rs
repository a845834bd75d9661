//! Keys of a sensor beside `model` that its device contradicts, and how many of the device's rays it casts.

use toml::{Table, Value};

use super::{DeviceModel, models};

/// Sides of an image that are thinned alike differ by no more than this share.
const ALIKE: f64 = 0.1;

/// A device that spins more slowly, or is listened to for longer, has steps that are smaller by less than this factor.
const FINEST: f64 = 2.5;

/// The keys that are compared.
const COMPARED: [&str; 6] = ["fov_deg", "resolution_px", "range_m", "beams", "rings", "resolution_deg"];

/// Sentences about the keys that a study writes of a device and that the device contradicts: swapped, those of another mode,
/// or more than it has.
pub(super) fn contradictions(model: &DeviceModel, written: &Table) -> Vec<String> {
    let compared = COMPARED.iter().filter_map(|key| contradiction(model, key, written.get(*key)?));
    compared.chain(wider(model, written)).chain(distance_mismatch(model, written)).collect()
}

/// Rings above or below those of the device.
fn wider(model: &DeviceModel, written: &Table) -> Option<String> {
    let rings = |keys: &Table| {
        ["elevation_deg", "rings_deg"].into_iter().find_map(|key| {
            let value = keys.get(key)?;
            let all = numbers(value)?;
            let ends = [all.iter().copied().reduce(f64::min)?, all.into_iter().reduce(f64::max)?];
            Some((format!("{key} = {value}"), ends))
        })
    };
    let ((own, [own_low, own_high]), (here, [low, high])) = (rings(&model.keys)?, rings(written)?);
    (low < own_low || high > own_high).then(|| format!("{here}: more than it has; {} has {own}", model.name))
}

/// Distances that are measured along something else.
fn distance_mismatch(model: &DeviceModel, written: &Table) -> Option<String> {
    let [own, here] = [&model.keys, written].map(|keys| keys.get("range_along"));
    let (own, here) = (own?, here?);
    (own != here)
        .then(|| format!("range_along = {here}: not what its data sheet gives; {} has {own}", model.name))
}

fn contradiction(model: &DeviceModel, key: &str, written: &Value) -> Option<String> {
    let own_value = model.keys.get(key)?;
    let (own, here) = (numbers(own_value)?, numbers(written)?);
    if own == here {
        return None;
    }
    let said = |what: String| Some(format!("{key} = {written}: {what}; {} has {own_value}", model.name));
    let swapped = own.len() == 2 && here == [own[1], own[0]];
    if swapped {
        return said("swapped".into());
    }
    let maker = |name: &str| name.split('-').next().map(str::to_string);
    let is_other = |other: &&DeviceModel| {
        other.name != model.name
            && other.kind() == model.kind()
            && maker(&other.name) == maker(&model.name)
            && other.keys.get(key).and_then(numbers).as_ref() == Some(&here)
    };
    if let Some(other) = models().iter().find(is_other) {
        return said(format!("that of {}: write model = {:?} if it is meant", other.name, other.name));
    }
    let more = here.iter().zip(&own).any(|(here, own)| here > own);
    match key {
        "range_m" if here.first()? < own.first()? => said("nearer than it measures".into()),
        "range_m" if here.get(1)? > own.get(1)? => said("farther than it measures".into()),
        "range_m" => None,
        "resolution_px" if more => said("more pixels than it has, or another mode of it".into()),
        "resolution_px" => {
            let [across, down] = [own.first()? / here.first()?, own.get(1)? / here.get(1)?];
            let is_alike = (across / down - 1.0).abs() <= ALIKE;
            if is_alike { None } else { said("pixels of another shape".into()) }
        }
        "resolution_deg" => {
            let finer = here.iter().zip(&own).any(|(here, own)| here * FINEST < *own);
            if finer { said("finer than it measures".into()) } else { None }
        }
        _ if more => said("more than it has".into()),
        _ => None,
    }
}

/// That a sensor casts fewer rays than its device has, in words.
pub(super) fn describe_thinning(model: &DeviceModel, written: &Table) -> Option<String> {
    let value = |keys: &Table, key: &str| keys.get(key).and_then(numbers);
    let first = |keys: &Table, key: &str| value(keys, key)?.first().copied();
    let [fov, own_fov] = [written, &model.keys].map(|keys| first(keys, "fov_deg"));
    // Degrees from ray to ray about the axis, and from ring to ring.
    let around = |keys: &Table, fov: Option<f64>| {
        first(keys, "resolution_deg").or_else(|| Some(fov? / first(keys, "beams")?))
    };
    let across = |keys: &Table| match ["rings", "rings_deg"].iter().any(|key| keys.contains_key(*key)) {
        true => None,
        false => value(keys, "resolution_deg")?.last().copied(),
    };
    let ratio = |here: Option<f64>, own: Option<f64>| here.zip(own).map(|(here, own)| here / own);
    let pixels = |keys: &Table| Some(value(keys, "resolution_px")?.iter().product::<f64>());
    // One ray in so many.
    let one_in = ratio(pixels(&model.keys), pixels(written)).unwrap_or_else(|| {
        let around = ratio(around(written, fov.or(own_fov)), around(&model.keys, own_fov));
        let rings = ratio(first(&model.keys, "rings"), first(written, "rings"));
        let across = ratio(across(written), across(&model.keys)).or(rings);
        around.unwrap_or(1.0) * across.unwrap_or(1.0)
    });
    (one_in > 1.0 + ALIKE).then(|| format!("casts about one in {one_in:.1} of the rays of {}", model.name))
}

/// A number or a list of numbers.
fn numbers(value: &Value) -> Option<Vec<f64>> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
    match value {
        Value::Array(all) => all.iter().map(number).collect(),
        one => Some(vec![number(one)?]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(model: &str, keys: &str) -> (String, String) {
        let model = models().iter().find(|known| known.name == model).unwrap();
        let written: Table = toml::from_str(keys).unwrap();
        (contradictions(model, &written).join("; "), describe_thinning(model, &written).unwrap_or_default())
    }

    #[test]
    fn what_contradicts_a_device_is_named_and_what_it_can_do_is_not() {
        for (model, keys, expected) in [
            ("realsense-d435", "range_m = [0.3, 3.0]", ""),
            ("realsense-d435", "range_m = [0.5, 2.0]", ""),
            ("realsense-d435", "range_m = [0.1, 2.0]", "range_m = [0.1, 2.0]: nearer than it measures"),
            (
                "realsense-d435",
                "range_m = [0.3, 9]",
                "farther than it measures; realsense-d435 has [0.3, 3.0]",
            ),
            (
                "realsense-d435",
                "fov_deg = [58, 87]",
                "fov_deg = [58, 87]: swapped; realsense-d435 has [87, 58]",
            ),
            ("realsense-d435", "fov_deg = [65, 40]", "that of realsense-d415"),
            ("realsense-d435", "fov_deg = [60, 40]", ""),
            ("realsense-d435", "fov_deg = [100, 40]", "more than it has"),
            ("realsense-d435", "resolution_px = [480, 848]", "swapped"),
            ("realsense-d435", "resolution_px = [212, 120]", ""),
            ("realsense-d435", "resolution_px = [212, 240]", "pixels of another shape"),
            ("realsense-d435", "resolution_px = [1920, 1080]", "more pixels than it has"),
            ("azure-kinect-nfov", "resolution_px = [320, 288]", "that of azure-kinect-nfov-binned"),
            ("hokuyo-utm-30lx", "beams = 2000", "beams = 2000: more than it has"),
            ("ouster-os0-32", "rings = 64", "that of ouster-os0-64"),
            (
                "velodyne-vlp-16",
                "resolution_deg = 0.05",
                "0.05: finer than it measures; velodyne-vlp-16 has 0.2",
            ),
            ("velodyne-vlp-16", "resolution_deg = 0.4", ""),
            (
                "velodyne-vlp-16",
                "elevation_deg = [-40, 10]",
                "= [-40, 10]: more than it has; velodyne-vlp-16 has rings_deg",
            ),
            ("ouster-os1-64", "rings_deg = [-10, 0, 30]", "has elevation_deg = [-21.2, 21.2]"),
            ("ouster-os1-64", "rings_deg = [-10, 0, 10]", ""),
            ("ifm-o3d303", "range_along = \"axis\"", "range_along = \"axis\": not what its data sheet gives"),
            ("ifm-o3d303", "range_along = \"ray\"", ""),
        ] {
            let (found, _) = messages(model, keys);
            assert!(
                if expected.is_empty() { found.is_empty() } else { found.contains(expected) },
                "{keys}: {found}"
            );
        }
    }

    #[test]
    fn a_thinned_table_of_rays_is_told() {
        for (model, keys, expected) in [
            ("realsense-d435", "resolution_px = [424, 240]", "one in 4.0 of the rays of realsense-d435"),
            ("realsense-d435", "fov_deg = [60, 40]", ""),
            ("velodyne-vlp-16", "resolution_deg = 0.4", "one in 2.0 "),
            ("ouster-os0-128", "rings = 32\nbeams = 512", "one in 8.0 "),
            ("hokuyo-utm-30lx", "resolution_deg = 1", "one in 4.0 "),
            ("hokuyo-utm-30lx", "fov_deg = 180\nbeams = 721", ""),
            ("velodyne-vlp-16", "beams = 180", "one in 10.0 "),
        ] {
            let (_, found) = messages(model, keys);
            assert!(
                if expected.is_empty() { found.is_empty() } else { found.contains(expected) },
                "{keys}: {found}"
            );
        }
    }
}
