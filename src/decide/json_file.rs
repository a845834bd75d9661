//! A JSON file next to a command's tables, for other commands to read instead of them. It begins with its format
//! number.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_sweep::results::files::{json_issue, read_regular, write_whole};

/// A kind of JSON file.
pub(crate) struct JsonFile {
    /// The name in a folder.
    pub name: &'static str,
    /// The format that is written and read.
    pub format: u32,
    /// The table next to it; an older program wrote only the table.
    pub table: &'static str,
    /// The command that writes both again.
    pub again: &'static str,
}

/// The first difference of two values.
pub(crate) struct Difference {
    /// Its path, as in `steps[0].best.score`.
    pub(crate) place: String,
    pub(crate) own: Value,
    pub(crate) other: Value,
}

/// The first difference of two values; paths begin with `place`.
pub(crate) fn first_difference(place: String, own: &Value, other: &Value) -> Option<Difference> {
    match (own, other) {
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let mut each = a.iter().zip(b).enumerate();
            each.find_map(|(number, (a, b))| first_difference(format!("{place}[{number}]"), a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            let none = &Value::Null;
            let mut each = keys.map(|key| (key, a.get(key).unwrap_or(none), b.get(key).unwrap_or(none)));
            let dot = if place.is_empty() { "" } else { "." };
            each.find_map(|(key, a, b)| first_difference(format!("{place}{dot}{key}"), a, b))
        }
        _ if own == other => None,
        _ => Some(Difference { place, own: own.clone(), other: other.clone() }),
    }
}

/// The head of a file, read first.
#[derive(Deserialize)]
struct Head {
    format: u32,
}

impl JsonFile {
    /// Writes the file atomically.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn write(&self, folder: &Path, content: &impl Serialize) -> Result<()> {
        let mut json = serde_json::to_vec_pretty(content).expect("names and numbers make JSON");
        json.push(b'\n');
        write_whole(&folder.join(self.name), &json)
    }

    /// Reads the file; `None` if the folder has neither it nor its table.
    ///
    /// # Errors
    /// `Error::Input` that names the file and the command that writes it again: if the file is damaged or in another
    /// format, or if the folder has only the table of an older program.
    pub(crate) fn read<T: DeserializeOwned>(&self, folder: &Path) -> Result<Option<T>> {
        let (path, table) = (folder.join(self.name), folder.join(self.table));
        let again = self.again;
        if !path.exists() {
            let what = format!("was written by an older perirobot without {}", self.name);
            let old = Issue::unsupported(what).with_advice(again).with_place(&table);
            return if table.exists() { Err(old.into()) } else { Ok(None) };
        }
        let bytes = read_regular(&path)?;
        let Head { format } = self.parse(&bytes, &path)?;
        if format != self.format {
            let what = format!("has format {format}, but this perirobot reads format {}", self.format);
            return Err(Issue::unsupported(what).with_advice(again).with_place(&path).into());
        }
        self.parse(&bytes, &path).map(Some)
    }

    fn parse<T: DeserializeOwned>(&self, bytes: &[u8], path: &Path) -> Result<T> {
        serde_json::from_slice(bytes)
            .map_err(|e| json_issue(&e).cure(self.again.to_string()).with_place(path).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const FILE: JsonFile =
        JsonFile { name: "list.json", format: 3, table: "list.csv", again: "run `perirobot list` again" };

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct SampleList {
        format: u32,
        numbers: Vec<f64>,
    }

    #[test]
    fn files_are_read_whole_or_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (path, table) = (folder.path().join(FILE.name), folder.path().join(FILE.table));
        let read = || FILE.read::<SampleList>(folder.path());
        let refused = |words: &str| {
            let error = read().unwrap_err().to_string();
            assert!(error.contains(words) && error.contains("run `perirobot list` again"), "{error}");
        };
        assert_eq!(read().unwrap(), None);
        fs::write(&table, "number\n").unwrap();
        refused("list.csv: was written by an older perirobot without list.json");
        let list = SampleList { format: 3, numbers: vec![0.1 + 0.2, 1e300, -0.0, 5e-324] };
        FILE.write(folder.path(), &list).unwrap();
        assert_eq!(read().unwrap().unwrap(), list);
        // Files of a newer program may have unknown contents.
        fs::write(&path, "{\"format\": 4, \"lists\": []}").unwrap();
        refused("list.json: has format 4, but this perirobot reads format 3");
        for (text, words) in [
            ("", "list.json: is cut off"),
            ("{\"format\": 3, \"numbers\": [1", "list.json: is cut off"),
            ("{\"format\": 3, \"numbers\": [\"1\"]}", "list.json: is not as it was written: invalid type"),
            ("{\"numbers\": []}", "list.json: is not as it was written: missing field `format`"),
            ("[3]", "list.json: is not as it was written"),
        ] {
            fs::write(&path, text).unwrap();
            refused(words);
        }
    }
}
