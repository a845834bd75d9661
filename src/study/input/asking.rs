//! A study with another question than the one in its file.

use super::file::StudyFile;
use super::{Study, choose};
use crate::diagnostics::{IN_MEMORY, Place, parse, top_keys};
use perirobot_march::{Error, Result};

impl Study {
    /// The same with some keys of `[choose]` instead of those that its text has, which stays as it was read. No file is read
    /// again.
    ///
    /// # Errors
    /// What is wrong with the keys.
    pub fn asking(&self, keys: toml::Table) -> Result<Study> {
        let mut whole = top_keys(&self.text);
        let asked = whole.entry("choose").or_insert_with(|| toml::Table::new().into());
        if let Some(asked) = asked.as_table_mut() {
            asked.extend(keys);
        }
        let text = toml::to_string(&whole).map_err(|e| Error::input("choose", e.to_string()))?;
        let text = format!("{IN_MEMORY}{text}");
        let file: StudyFile = parse(&self.path, &text).map_err(|(shown, _)| shown)?;
        let at = Place::new(&self.path);
        let known = choose::ChooseNames {
            fusion: file.fusion,
            currency: self.currency.as_deref(),
            regions: &self.regions,
            sensors: &self.sensors,
            has_requirements: !self.requirements.is_empty(),
            has_stopping: self.stopping.is_some(),
        };
        let choose = file.choose.map(|file| choose::check(&at, file, &known)).transpose();
        Ok(Study { choose: choose.map_err(Error::first)?, ..self.clone() })
    }
}
