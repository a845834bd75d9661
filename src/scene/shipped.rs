//! The people that ship with the program, by their names: adults in several postures, a small one and a tall one.

/// A person that ships: the joints of a mannequin that faces +x, at the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shipped {
    /// The name, as that of the file in `scenes/people`.
    pub name: &'static str,
    /// The text of that file.
    pub(super) joints: &'static str,
}

macro_rules! people {
    ($($name:literal),* $(,)?) => {
        [$(Shipped { name: $name, joints: include_str!(concat!("../../scenes/people/", $name, ".csv")) }),*]
    };
}

/// All of them.
pub(crate) const PEOPLE: [Shipped; 8] =
    people!["standing", "reaching", "bent", "crouching", "kneeling", "lying", "small", "tall"];
