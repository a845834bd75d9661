//! Text that is safe in any script, and how each kind of script quotes it.

use std::fmt;
use std::str::FromStr;

use perirobot_march::error::Issue;
use perirobot_scene::shell::is_hidden;

/// A text on one line, not empty, every character of it visible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct VisibleWord(String);

impl FromStr for VisibleWord {
    type Err = Issue;

    fn from_str(text: &str) -> Result<VisibleWord, Issue> {
        if text.is_empty() {
            return Err(Issue::says("is empty"));
        }
        // YAML also ends lines at U+2028 and U+2029.
        if let Some(hidden) = text.chars().find(|c| is_hidden(*c)) {
            let what = format!("has an invisible character ({})", hidden.escape_unicode());
            return Err(
                Issue::says(what).with_advice("a script would hide it: rename the file or the folder")
            );
        }
        Ok(VisibleWord(text.into()))
    }
}

impl fmt::Display for VisibleWord {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl VisibleWord {
    /// The text as it was given.
    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// From text of this program, or made of words.
    pub(super) fn from_known(text: &str) -> VisibleWord {
        debug_assert!(text.parse::<VisibleWord>().is_ok(), "{text:?}");
        VisibleWord(text.into())
    }

    /// As a POSIX shell reads it: plain where that is safe, else between single quotes.
    pub(crate) fn shell(&self) -> String {
        perirobot_scene::shell::quote(&self.0)
    }

    /// As YAML reads it: a string in double quotes, which are those of JSON.
    pub(crate) fn yaml(&self) -> String {
        serde_json::Value::from(self.0.as_str()).to_string()
    }

    /// As an argument of a container, in YAML: Kubernetes puts variables in place of `$(NAME)`, and `$` for
    /// `$$`.
    pub(crate) fn container_argument(&self) -> String {
        VisibleWord(self.0.replace('$', "$$")).yaml()
    }
}
