//! The way to a value of a TOML file: `sensor[2].poses`.

use std::fmt;

use toml_edit::Item;

/// A step on the way to a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Key(String),
    Entry(usize),
}

/// The way to a value, from the whole file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Path(pub(super) Vec<Step>);

impl Path {
    /// A key of the whole file.
    pub(super) fn new(key: &str) -> Path {
        Path::default().key(key)
    }

    pub(super) fn key(&self, key: &str) -> Path {
        Path([self.0.as_slice(), &[Step::Key(key.into())]].concat())
    }

    pub(super) fn entry(&self, index: usize) -> Path {
        Path([self.0.as_slice(), &[Step::Entry(index)]].concat())
    }

    /// What it leads to.
    pub(super) fn find<'d>(&self, root: &'d Item) -> Option<&'d Item> {
        self.0.iter().try_fold(root, |item, step| match step {
            Step::Key(key) => item.get(key.as_str()),
            Step::Entry(index) => item.get(*index),
        })
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (i, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if i == 0 => write!(f, "{key}")?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Entry(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}
