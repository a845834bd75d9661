//! Reads TOML and says what is wrong with it: file, line, key, value, and what to write instead.
//!
//! The reader is our own, since the errors of the `toml` crate are sentences in the words of Rust, whatever finds their keys
//! (`serde_path_to_error` and their spans do): `found "1", wanted a number` would be `invalid type: string "1", expected f64`,
//! and `wanted one of ...` of a number `wanted string or table`. A word that is near to the written one (`did you mean`) and
//! the keys that are left out to check the rest need the error as a value, which it is not. And the crate reads without an
//! error what no file means: the first two of `pair = [1, 2, 3]`, `kind = { flat = {} }`, or a list as a table.

mod place;
mod problems;
mod reader;
mod syntax;
mod units;
mod unreadable;
mod written;

use std::path::Path;

use serde::de::DeserializeOwned;
use toml::Table;

pub(crate) use place::{FARTHEST_M, Place, only_one};
pub(crate) use problems::{List, Problems, parse_in_parts, wrong_with};
pub(crate) use reader::read;
pub(crate) use units::{FAR_M, warnings};
pub(crate) use unreadable::{Step, Unread, Unreadable};
pub use written::IN_MEMORY;
pub(crate) use written::{LineOf, Written, describe};

use perirobot_march::{Error, Result};

/// Reads TOML. The error shows the line; with it comes the message without the line, if the file is valid
/// TOML.
pub(crate) fn parse<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, (Error, Option<String>)> {
    let table: Table = toml::from_str(text)
        .map_err(|e| (Error::input(path, written::narrow(syntax::show(&e).trim_end())), None))?;
    // All is read from the table, here as where it is read in parts, so that the code for it is compiled once.
    read(table).map_err(|why| {
        let shown = Written::new(text).show(&why);
        (Error::input(path, shown), Some(why.message))
    })
}

/// The top-level keys of a file; none if it cannot be read as TOML.
pub(crate) fn top_keys(text: &str) -> Table {
    toml::from_str(text).unwrap_or_default()
}

/// Refuses a folder where a file of some kind is wanted.
pub(crate) fn refuse_folder(path: &Path, wanted: &str) -> Result<()> {
    match path.is_dir() {
        true => Err(Error::input(path, "is a folder").with_advice(format!("name {wanted} (.toml)"))),
        false => Ok(()),
    }
}
