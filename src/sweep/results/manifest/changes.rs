//! Describes the differences of two manifests in words.

use serde_json::{Map, Value};

/// Keys written by the user; all others follow from these and from the program.
const CAUSES: [&str; 7] =
    ["semantics_version", "study", "scene_files", "files", "seed", "voxel_size_m", "noiseless"];

/// Most reported differences; one is enough to refuse.
const MOST_REPORTED: usize = 6;

/// Longest text with both old and new shown.
const SHORT: usize = 60;

/// The differences that affect the counts; effects only if there is no cause.
pub fn changes(was: &Map<String, Value>, is: &Map<String, Value>) -> Vec<String> {
    let mut changes = Vec::new();
    let mut tell = |key: &str| differences(key, get(was, key), get(is, key), &mut changes);
    CAUSES.iter().for_each(|key| tell(key));
    if changes.is_empty() {
        let effects = is.keys().filter(|key| !CAUSES.contains(&key.as_str()));
        effects.for_each(|key| differences(key, get(was, key), get(is, key), &mut changes));
    }
    changes
}

fn get<'a>(map: &'a Map<String, Value>, key: &str) -> &'a Value {
    map.get(key).unwrap_or(&Value::Null)
}

/// Adds the differences of two values, up to the limit.
fn differences(place: &str, was: &Value, is: &Value, told: &mut Vec<String>) {
    match (was, is) {
        _ if told.len() == MOST_REPORTED || was == is => {}
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            for key in keys {
                differences(&format!("{place}.{key}"), get(a, key), get(b, key), told);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() && a.iter().any(|v| v.is_object()) => {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                differences(&format!("{place}[{i}]"), a, b, told);
            }
        }
        _ => {
            let (was, is) = (was.to_string(), is.to_string());
            let long = was.len().max(is.len()) > SHORT;
            told.push(if long { format!("{place} differs") } else { format!("{place} was {was}, is {is}") });
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn describe_changes(was: Value, is: Value) -> Vec<String> {
        let [was, is] = [was, is].map(|json| json.as_object().unwrap().clone());
        changes(&was, &is)
    }

    #[test]
    fn changes_name_the_key_and_both_values() {
        let was = json!({ "seed": 7, "study": { "sensor": [{ "fov_deg": [60, 40], "name": "a" }] } });
        let is = json!({ "seed": 8, "study": { "sensor": [{ "fov_deg": [70, 40], "name": "a" }] } });
        assert_eq!(
            describe_changes(was, is),
            ["study.sensor[0].fov_deg was [60,40], is [70,40]", "seed was 7, is 8"]
        );
        assert_eq!(
            describe_changes(
                json!({ "files": { "a.stl": "0".repeat(64) } }),
                json!({ "files": { "a.stl": "1".repeat(64) } })
            ),
            ["files.a.stl differs"]
        );
        assert_eq!(
            describe_changes(json!({ "study": { "a": 1 } }), json!({ "study": { "b": true } })),
            ["study.a was 1, is null", "study.b was null, is true"]
        );
        // Lengths differ: the array is reported as a whole.
        assert_eq!(
            describe_changes(json!({ "sensors": [] }), json!({ "sensors": [{}] })),
            ["sensors was [], is [{}]"]
        );
    }

    #[test]
    fn some_of_many_changes_are_told() {
        let all = |value: u32| (0..1000).map(|i| (format!("key{i:04}"), json!(value))).collect::<Map<_, _>>();
        let changes =
            describe_changes(json!({ "files": all(1), "seed": 1 }), json!({ "files": all(2), "seed": 2 }));
        assert_eq!(changes.len(), MOST_REPORTED);
        assert_eq!(changes[5], "files.key0005 was 1, is 2");
    }
}
