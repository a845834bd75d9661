//! Makes the schemas from the structs that read the files, and compares them with those that ship.
//!
//! `PERIROBOT_REGENERATE=1 cargo test --lib schema` writes the files instead.

use std::path::Path;

use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform};
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use crate::input::file::StudyFile;
use crate::input::scene_file::SceneFile;

/// The schemas of a study and of a scene.
fn make_schemas() -> [String; 2] {
    [text::<StudyFile>("perirobot study"), text::<SceneFile>("perirobot scene")]
}

/// A schema, as text with a line break at its end.
fn text<T: JsonSchema>(title: &str) -> String {
    // Draft 7, and no references: what the readers of TOML editors know best.
    let mut settings = SchemaSettings::draft07();
    settings.inline_subschemas = true;
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    RecursiveTransform(remove_null).transform(&mut schema);
    schema.insert("title".into(), title.into());
    format!("{:#}\n", schema.as_value())
}

/// A key that may be left out may be null to JSON; TOML has no null.
fn remove_null(schema: &mut Schema) {
    let null = Value::from("null");
    let no_type = |value: &Value| value.get("type") == Some(&null);
    if let Some(Value::Array(types)) = schema.get_mut("type") {
        types.retain(|name| *name != null);
        if let [only] = types.as_slice() {
            let only = only.clone();
            schema.insert("type".into(), only);
        }
    }
    if schema.get("default").is_some_and(Value::is_null) {
        schema.remove("default");
    }
    if let Some(Value::Array(values)) = schema.get_mut("enum") {
        values.retain(|value| !value.is_null());
    }
    let Some(Value::Array(choices)) = schema.get_mut("anyOf") else { return };
    choices.retain(|choice| !no_type(choice));
    if let [Value::Object(only)] = choices.as_slice() {
        let only = only.clone();
        schema.remove("anyOf");
        for (key, value) in only {
            // The description of a key takes precedence over that of its type.
            if schema.get(&key).is_none() {
                schema.insert(key, value);
            }
        }
    }
}

#[test]
fn the_schemas_that_ship_are_those_of_the_structs() {
    let [study, scene] = make_schemas();
    for (name, ships, made) in [("study", super::study(), study), ("scene", super::scene(), scene)] {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
            .join(format!("scenes/schemas/{name}.schema.json"));
        if std::env::var("PERIROBOT_REGENERATE").is_ok_and(|value| value == "1") {
            std::fs::write(&path, made).unwrap();
            continue;
        }
        let cure = "see the top of src/study/input/schema/made.rs for how to write it anew";
        assert!(ships == made, "{} is not what the structs say; {cure}", path.display());
    }
}

#[test]
fn keys_may_be_left_out_and_are_never_null() {
    for text in make_schemas() {
        assert!(!text.contains("null"), "{text}");
        assert!(!text.contains("$ref"), "{text}");
    }
}

#[test]
fn every_key_is_explained() {
    fn find_unexplained(place: &str, schema: &Value, found: &mut Vec<String>) {
        if let Some(Value::Object(properties)) = schema.get("properties") {
            for (key, value) in properties {
                let short = ["start", "stop", "step", "w", "x", "y", "z"].contains(&key.as_str());
                if value.get("description").is_none() && !short {
                    found.push(format!("{place}.{key}"));
                }
            }
        }
        match schema {
            Value::Object(map) => {
                map.iter().for_each(|(k, v)| find_unexplained(&format!("{place}.{k}"), v, found))
            }
            Value::Array(list) => list.iter().for_each(|value| find_unexplained(place, value, found)),
            _ => {}
        }
    }
    for text in make_schemas() {
        let mut found = Vec::new();
        find_unexplained("", &serde_json::from_str(&text).unwrap(), &mut found);
        assert_eq!(found, Vec::<String>::new());
    }
}
