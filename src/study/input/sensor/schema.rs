//! The schema of a `[[sensor]]`: of each kind the keys of all and its own, what a model gives being left to the model.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};

use super::CommonFile;
use crate::input::catalogue::models;
use crate::sensor::kinds::KINDS;
use crate::sensor::kinds::shared::camera_info;

/// A sensor of any kind, to the schema.
pub(crate) struct AnySensor;

impl JsonSchema for AnySensor {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Sensor".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let common = CommonFile::json_schema(generator);
        let all: Vec<Value> =
            KINDS.iter().map(|kind| kind_schema(kind.name, &(kind.schema)(generator), &common)).collect();
        json_schema!({ "anyOf": all })
    }
}

/// An amount of money, or the list price.
pub(super) fn cost(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "anyOf": [{ "type": "number" }, { "const": "list" }] })
}

fn kind_schema(kind: &str, own: &Schema, common: &Schema) -> Value {
    let keys = |schema: &Schema| schema.get("properties").and_then(Value::as_object).cloned();
    let mut properties: Map<String, Value> = keys(common).unwrap_or_default();
    properties.extend(keys(own).unwrap_or_default());
    properties.insert("kind".into(), json!({ "const": kind, "description": "What it is." }));
    let mut ways = vec![required_keys(own, &[], &["name", "kind"])];
    if camera_info::GIVES.iter().all(|key| properties.contains_key(*key)) {
        let about = "A sensor_msgs/CameraInfo of ROS as YAML, instead of fov_deg and resolution_px.";
        properties.insert(camera_info::KEY.into(), json!({ "type": "string", "description": about }));
        ways.push(required_keys(own, &camera_info::GIVES, &["name", "kind", camera_info::KEY]));
    }
    let devices: Vec<_> = models().iter().filter(|model| model.kind() == kind).collect();
    if !devices.is_empty() {
        let names: Vec<&str> = devices.iter().map(|model| model.name.as_str()).collect();
        let about =
            "A device of the catalogue (`perirobot sensors`), which gives all keys that are not written.";
        properties.insert("model".into(), json!({ "enum": names, "description": about }));
        let given: Vec<&str> = devices[0].keys.keys().map(String::as_str).collect();
        ways.push(required_keys(own, &given, &["name", "model"]));
    }
    let mut schema = json!({
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "anyOf": ways,
    });
    if let Some(about) = own.get("description") {
        schema["description"] = about.clone();
    }
    schema
}

/// The keys that must be there: those of the kind, without what is given otherwise, and some more.
fn required_keys(own: &Schema, given: &[&str], more: &[&str]) -> Value {
    let own = own.get("required").and_then(Value::as_array).into_iter().flatten();
    let own = own.filter(|key| !given.iter().any(|given| *key == given)).cloned();
    let more = more.iter().map(|key| Value::from(*key));
    json!({ "required": more.chain(own).collect::<Vec<_>>() })
}
