//! What two manifests differ in, told so that a user finds it.

use super::*;

fn of(json: Value) -> Manifest {
    Manifest(object(json))
}

fn told(was: Value, is: Value) -> Vec<String> {
    let (was, is) = (of(was), of(is));
    assert_eq!(was.fingerprint() == is.fingerprint(), was.changes(&is).is_empty());
    was.changes(&is)
}

#[test]
fn changes_name_the_key_and_both_values() {
    let was =
        json!({ "seed": 7, "study": { "sensor": [{ "fov_deg": [60, 40], "name": "a" }] }, "runs": [1] });
    let is = json!({ "seed": 8, "study": { "sensor": [{ "fov_deg": [70, 40], "name": "a" }] }, "runs": [] });
    assert_eq!(told(was, is), ["study.sensor[0].fov_deg was [60,40], is [70,40]", "seed was 7, is 8"]);
    assert_eq!(
        told(
            json!({ "files": { "a.stl": "0".repeat(64) } }),
            json!({ "files": { "a.stl": "1".repeat(64) } })
        ),
        ["files.a.stl is another"]
    );
    assert_eq!(
        told(json!({ "study": { "a": 1 } }), json!({ "study": { "b": true } })),
        ["study.a was 1, is null", "study.b was null, is true"]
    );
    // Numbers of sensors differ: the array is told as a whole.
    assert_eq!(told(json!({ "sensors": [] }), json!({ "sensors": [{}] })), ["sensors was [], is [{}]"]);
}

#[test]
fn some_of_many_changes_are_told() {
    let all = |value: u32| (0..1000).map(|i| (format!("key{i:04}"), json!(value))).collect::<Map<_, _>>();
    let changes = told(json!({ "files": all(1), "seed": 1 }), json!({ "files": all(2), "seed": 2 }));
    assert_eq!(changes.len(), MOST_TOLD);
    assert_eq!(changes[5], "files.key0005 was 1, is 2");
}

#[test]
fn what_decides_nothing_changes_nothing() {
    let was = json!({ "seed": 7, "about": 1, "shard": 2, "runs": [], "fingerprint": "x" });
    assert_eq!(told(was, json!({ "seed": 7 })), [""; 0]);
}

#[test]
fn comments_and_order_of_keys_say_nothing() {
    assert_eq!(says("a = 1\nb = 2 # much"), says("b = 2\n\na = 1"));
    assert_ne!(says("a = 1"), says("a = 1.5"));
}

#[test]
fn candidates_are_told_as_ranges() {
    assert_eq!(ranges(&[0, 1, 2, 5, 7, 8]), [[0, 3], [5, 6], [7, 9]]);
    assert_eq!(ranges(&[]), [[0; 2]; 0]);
}
