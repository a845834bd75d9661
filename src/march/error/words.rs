//! Sentences that name arguments. An argument is a value in them, so that each front end of perirobot writes
//! it in its own way: the library by its plain name, the command line as a flag.

use std::fmt;
use std::ops::Add;

/// An argument of the program by its plain name, such as "voxel size".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument(pub &'static str);

impl Argument {
    /// The argument with a value.
    pub fn with_value(self, value: impl fmt::Display) -> Words {
        Words::from(self) + format!(" {value}")
    }

    /// The same between backticks.
    pub fn quote(self, value: impl fmt::Display) -> Words {
        Words::from("`") + self.with_value(value) + "`"
    }
}

/// How a front end of perirobot writes an argument.
pub type NameOf<'n> = &'n dyn Fn(Argument) -> String;

/// A sentence, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Words(Vec<WordPiece>);

#[derive(Clone, Debug, PartialEq)]
enum WordPiece {
    Text(String),
    Argument(Argument),
}

impl Words {
    /// The sentence, its arguments written by `name_of`.
    pub fn to_text(&self, name_of: NameOf) -> String {
        let piece = |piece: &WordPiece| match piece {
            WordPiece::Text(text) => text.clone(),
            WordPiece::Argument(argument) => name_of(*argument),
        };
        self.0.iter().map(piece).collect()
    }
}

impl From<&str> for Words {
    fn from(text: &str) -> Words {
        text.to_string().into()
    }
}

impl From<String> for Words {
    fn from(text: String) -> Words {
        Words(vec![WordPiece::Text(text)])
    }
}

impl From<Argument> for Words {
    fn from(argument: Argument) -> Words {
        Words(vec![WordPiece::Argument(argument)])
    }
}

impl<W: Into<Words>> Add<W> for Words {
    type Output = Words;

    fn add(mut self, more: W) -> Words {
        self.0.extend(more.into().0);
        self
    }
}

impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.to_text(&|argument| argument.0.into()))
    }
}
