//! JSON schemas of study and scene files, by which editors complete and check keys. They know spelling and types; other
//! rules are checked when a file is read. They are text that ships; a test makes it from the structs that read these
//! files, and compares.

#[cfg(test)]
pub(super) mod counted;
#[cfg(test)]
mod made;

/// The schema of a study file, with a line break at its end.
pub fn study() -> &'static str {
    perirobot_shipped::STUDY_SCHEMA
}

/// The schema of a scene file, with a line break at its end.
pub fn scene() -> &'static str {
    perirobot_shipped::SCENE_SCHEMA
}
