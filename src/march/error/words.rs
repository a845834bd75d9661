//! Sentences that name arguments. An argument is a value in them, so that each front end of perirobot writes
//! it in its own way: the library by its plain name, the command line as a flag.

use std::fmt;
use std::ops::Add;

macro_rules! arguments {
    ($($argument:ident $name:literal),* $(,)?) => {
        /// The arguments of the program.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs, reason = "each is the program's flag of that name")]
        pub enum Argument {
            $($argument),*
        }

        impl Argument {
            /// All of them.
            pub const ALL: &[Argument] = &[$(Argument::$argument),*];

            /// Its plain name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Argument::$argument => $name),*
                }
            }
        }
    };
}

arguments! {
    Adapter "adapter",
    AllowOutside "allow outside",
    Backend "backend",
    Colour "colour",
    Combination "combination",
    CutAbove "cut above",
    Dead "dead",
    Draw "draw",
    FovDeg "fov deg",
    From "from",
    LookAt "look at",
    Memory "memory",
    Noiseless "noiseless",
    OnlyRegion "only region",
    Out "out",
    Package "package",
    Pose "pose",
    Posture "posture",
    Region "region",
    Repeat "repeat",
    Representation "representation",
    Restart "restart",
    Scene "scene",
    Shard "shard",
    Size "size",
    Snapshot "snapshot",
    Topic "topic",
    VoxelSize "voxel size",
    Xacro "xacro",
}

impl Argument {
    /// The argument with a value.
    pub fn to(self, value: impl fmt::Display) -> Words {
        Words::from(self) + format!(" {value}")
    }

    /// The same between backticks.
    pub fn quoted(self, value: impl fmt::Display) -> Words {
        Words::from("`") + self.to(value) + "`"
    }
}

/// How a front end of perirobot writes an argument.
pub type NameOf<'n> = &'n dyn Fn(Argument) -> String;

/// A sentence, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Words(Vec<Piece>);

#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    Argument(Argument),
}

impl Words {
    /// The sentence, its arguments written by `name_of`.
    pub fn told(&self, name_of: NameOf) -> String {
        let piece = |piece: &Piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Argument(argument) => name_of(*argument),
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
        Words(vec![Piece::Text(text)])
    }
}

impl From<Argument> for Words {
    fn from(argument: Argument) -> Words {
        Words(vec![Piece::Argument(argument)])
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
        f.write_str(&self.told(&|argument| argument.name().into()))
    }
}
