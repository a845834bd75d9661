//! JSON schemas of study and scene files, by which editors complete and check keys. They know spelling and types; other
//! rules are checked when a file is read. They are made from the structs that read these files: by a test, which holds
//! them against the ones that ship, so that the program carries text only.

/// The schema of a study file, with a line break at its end.
pub fn study() -> &'static str {
    include_str!("../../scenes/schemas/study.schema.json")
}

/// The schema of a scene file, with a line break at its end.
pub fn scene() -> &'static str {
    include_str!("../../scenes/schemas/scene.schema.json")
}

#[cfg(test)]
mod made;
