//! Converts STEP files to glTF by the Python package cascadio (OpenCASCADE), if the user allows it. No Rust library
//! makes triangles of assemblies of curved faces yet, and a CAD kernel in this program would be in every build.

mod layers;
mod part21;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, PoisonError};

use wildmatch::WildMatch;

use super::folder::{TemporaryFolder, output_end};
use super::{MOST_BYTES_OF_DATA, Sources, ending, formats, sha256};
use perirobot_march::Result;
use perirobot_march::error::{Argument, Issue, Words};

/// The glTF of each STEP file, by the hash of its bytes.
pub(super) type Converted = BTreeMap<String, Arc<[u8]>>;

/// Parts of a STEP file that are alike to the rules of an object.
pub(crate) struct Layered {
    /// All layers that its parts are on.
    pub(crate) layers: Vec<String>,
    /// Its binary glTF, as [`Sources::convert_step`] makes it.
    pub(crate) glb: Arc<[u8]>,
}

/// The program of the interpreter: a chord error of at most 1 mm, a tenth of the smallest usual voxel.
const STEP_TO_GLB: &str = include_str!("step_to_glb.py");
/// The exit code if a package is missing.
const MISSING: i32 = 77;

/// Whether a file is STEP by the ending of its name.
pub(crate) fn is_step(path: &Path) -> bool {
    ["step", "stp", "p21"].contains(&ending(path).as_str())
}

impl Sources {
    /// And STEP files, converted by the package cascadio of this Python.
    #[must_use]
    pub fn allow_step(self, python: &Path) -> Sources {
        Sources { step_python: Some(python.into()), ..self }
    }

    /// The binary glTF (GLB) of a STEP file: metres, in the axes of the STEP file. A file is converted once.
    ///
    /// # Errors
    /// When it may not be converted, cannot be read, or the conversion fails or gives another result than before.
    pub(crate) fn convert_step(&self, path: &Path) -> Result<Arc<[u8]>> {
        let bytes = self.bytes(path)?;
        self.convert(path, &bytes, "")
    }

    /// The same of the parts of a file in groups: in each, all parts are on layers that the same patterns match.
    ///
    /// # Errors
    /// Those of [`Sources::convert_step`].
    pub(crate) fn convert_step_layers(&self, path: &Path, patterns: &[WildMatch]) -> Result<Vec<Layered>> {
        let bytes = self.bytes(path)?;
        let (groups, remarks) = layers::split(&bytes, patterns);
        remarks.iter().for_each(|remark| self.remark(path, remark));
        if groups.is_empty() {
            return Ok(vec![Layered { layers: Vec::new(), glb: self.convert(path, &bytes, "")? }]);
        }
        let is_split = groups.len() > 1;
        let convert = |group: layers::Group| {
            let words = patterns.iter().zip(&group.matched);
            let words = words.map(|(pattern, is_on)| {
                format!(", {} layer {:?}", if *is_on { "on" } else { "not on" }, pattern.pattern())
            });
            let name = if is_split { words.collect() } else { String::new() };
            Ok(Layered { glb: self.convert(path, &group.step, &name)?, layers: group.layers })
        };
        groups.into_iter().map(convert).collect()
    }

    /// The glTF of bytes of a file, recorded with words that name these bytes.
    fn convert(&self, path: &Path, step: &[u8], words: &str) -> Result<Arc<[u8]>> {
        let Some(python) = &self.step_python else { return Err(refusal(path).with_place(path).into()) };
        let hash = sha256([step]);
        let known = self.record.lock().unwrap_or_else(PoisonError::into_inner).converted.get(&hash).cloned();
        let glb = match known {
            Some(known) => known,
            None => {
                let glb: Arc<[u8]> =
                    convert(python, step).map_err(|issue| issue.with_place("STEP").with_place(path))?.into();
                log::info!("converted {}{words}: {} bytes", path.display(), glb.len());
                glb
            }
        };
        let mut record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        // Another version of the converter may make other triangles of the same file.
        record.by_name.insert(format!("{} (converted{words})", self.name(path)), sha256([&glb]));
        record.converted.insert(hash, glb.clone());
        Ok(glb)
    }
}

/// What to do with a STEP file.
fn refusal(path: &Path) -> Issue {
    Issue::unsupported("is a STEP file")
        .with_advice(formats::converter(path).unwrap_or_default())
        .cure(Words::from("or read it with ") + Argument("step") + ", which runs cascadio")
}

/// Runs cascadio in a folder of its own, so that no module beside the scene is imported.
fn convert(python: &Path, step: &[u8]) -> Result<Vec<u8>, Issue> {
    let no_folder = |e| Issue::says(format!("no temporary folder can be used: {e}"));
    let folder = TemporaryFolder::new().map_err(no_folder)?;
    let place = |name: &str| folder.path().join(name);
    std::fs::write(place("mesh.step"), step).map_err(no_folder)?;
    let output = File::create(place("output")).map_err(no_folder)?;
    let errors = output.try_clone().map_err(no_folder)?;
    let mut command = Command::new(python);
    command.args(["-c", STEP_TO_GLB]).current_dir(folder.path());
    let status = command.stdin(Stdio::null()).stdout(output).stderr(errors).status();
    let install = format!("run `{} -m pip install cascadio numpy`", python.display());
    let status = status.map_err(|e| match e.kind() {
        ErrorKind::NotFound => Issue::says(format!("the program {} cannot be found", python.display()))
            .with_advice("install Python 3 and its packages cascadio and numpy"),
        _ => Issue::says(format!("the program {} cannot be run: {e}", python.display())),
    })?;
    if !status.success() {
        let output = std::fs::read(place("output")).map_err(no_folder)?;
        let output = without_colours(&output_end(&output));
        return Err(match status.code() {
            Some(MISSING) => Issue::says(output).with_advice(install),
            _ => Issue::says(format!("cascadio failed and says: {output}"))
                .with_advice("export the file again, or convert it in FreeCAD"),
        });
    }
    let unreadable = |e| Issue::says(format!("the result of cascadio cannot be read: {e}"));
    let mut glb = Vec::new();
    let file = File::open(place("mesh.glb")).map_err(unreadable)?;
    file.take(MOST_BYTES_OF_DATA + 1).read_to_end(&mut glb).map_err(unreadable)?;
    match glb.len() as u64 > MOST_BYTES_OF_DATA {
        true => {
            Err(Issue::too_large(format!("gives more than {} MiB of triangles", MOST_BYTES_OF_DATA >> 20))
                .with_advice("export fewer parts"))
        }
        false => Ok(glb),
    }
}

/// A text in one line without the colours that OpenCASCADE gives it for a terminal.
fn without_colours(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_string();
    let plain = parts.fold(first, |all, part| all + part.split_once('m').map_or(part, |(_, rest)| rest));
    plain.replace('*', "").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_a_terminal_are_left_out() {
        let text = "\u{1b}[31;1m**** ERR StepFile : Line 3:   wrong    ****\n\u{1b}[0m\nError: no";
        assert_eq!(without_colours(text), "ERR StepFile : Line 3: wrong Error: no");
        assert_eq!(without_colours("plain\u{1b}[cut"), "plaincut");
    }
}
