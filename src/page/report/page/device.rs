//! The device of a sensor in a study: as its keys, and as an order.

use perirobot_study::input::Study;
use perirobot_study::input::catalogue::models;
use toml::{Table, Value};

/// The keys of a sensor in a study's text, except its name, kind and places.
pub(super) fn keys_of(study: &Study, name: &str) -> String {
    let keys = table_of(study, name).into_iter();
    let keys = keys.filter(|(key, _)| !["name", "kind", "poses"].contains(&key.as_str()));
    let cost = cost_of(study, name);
    let value = |key: &str, value: &Value| match &cost {
        Some(cost) if key == "cost" => cost.clone(),
        _ => value.to_string(),
    };
    keys.map(|(key, content)| format!("{key} = {}", value(&key, &content))).collect::<Vec<_>>().join(", ")
}

/// A device for an order: its maker's name if the study names a model, its field of view, pixels and range, and its
/// cost.
pub(super) fn describe_device(study: &Study, name: &str) -> String {
    let written = table_of(study, name);
    let model = written.get("model").and_then(Value::as_str);
    let model = model.and_then(|model| study.models.iter().chain(models()).find(|known| known.name == model));
    let text = |key: &str| {
        let own = written.get(key).or_else(|| model?.keys.get(key));
        own.and_then(Value::as_array).map(|numbers| numbers.iter().map(Value::to_string).collect::<Vec<_>>())
    };
    let title = model.map(|known| format!("{} ({})", known.title, known.name));
    let facts = [
        title,
        text("fov_deg").map(|sides| format!("field of view {}°", sides.join("° × "))),
        text("resolution_px").map(|sides| format!("{} pixels", sides.join(" × "))),
        text("range_m").map(|ends| format!("range {} m", ends.join(" to "))),
        cost_of(study, name),
    ];
    facts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The table of a sensor in the text of a study.
fn table_of(study: &Study, name: &str) -> Table {
    let written: Table = toml::from_str(&study.text).unwrap_or_default();
    let all = written.get("sensor").and_then(Value::as_array).into_iter().flatten();
    let mut tables = all.filter_map(Value::as_table);
    tables.find(|table| table.get("name").and_then(Value::as_str) == Some(name)).cloned().unwrap_or_default()
}

fn cost_of(study: &Study, name: &str) -> Option<String> {
    let sensor = study.sensors.iter().find(|sensor| sensor.name == name)?;
    let cost = sensor.terms.cost?.to_text(study.currency.as_deref());
    Some(match &sensor.list_price {
        Some(price) => format!("{cost} (list price of {}, to be checked)", price.date),
        None => cost,
    })
}
