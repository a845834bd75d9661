//! Files inside the program, as text: people, schemas, a first study, and two pages of the guide, [`own_cell`] and
//! [`every_key`].

/// Makes a constant of each file of this folder.
macro_rules! texts {
    ($($name:ident = $file:literal;)*) => {
        $(
            #[doc = concat!("`scenes/", $file, "`")]
            pub const $name: &str = include_str!($file);
        )*
    };
}

texts! {
    OPERATOR = "paper/scene1_operator.csv";
    SCENE_SCHEMA = "schemas/scene.schema.json";
    STUDY_SCHEMA = "schemas/study.schema.json";
    UR10 = "paper/ur10.urdf";
}

/// A person: the joints of a mannequin that faces +x, at the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Person {
    /// The name, as that of the file in `scenes/people`.
    pub name: &'static str,
    /// The text of that file.
    pub joints: &'static str,
}

macro_rules! people {
    ($($name:literal),* $(,)?) => {
        [$(Person { name: $name, joints: include_str!(concat!("people/", $name, ".csv")) }),*]
    };
}

/// Adults in several postures, a small one and a tall one.
pub const PEOPLE: [Person; 10] = people![
    "standing",
    "reaching",
    "bent",
    "crouching",
    "kneeling",
    "lying",
    "small",
    "tall",
    "sitting",
    "carrying",
];

/// Makes a module of a page. The guide shows it, so links lead to its other pages; of two definitions of a link the
/// first counts, and on a forge those at the end of the page do.
macro_rules! page {
    ($name:ident, $file:literal, [$($subject:literal),*]) => {
        $(#[doc(alias = $subject)])*
        #[doc = "[own cell]: ../own_cell/index.html"]
        #[doc = "[plan a cell]: ../plan_a_cell/index.html"]
        #[doc = "[results]: ../results/index.html"]
        #[doc = "[sensors]: ../sensors/index.html"]
        #[doc = "[choose]: ../choose/index.html"]
        #[doc = "[approach]: ../approach/index.html"]
        #[doc = "[review]: ../review/index.html"]
        #[doc = "[recorded]: ../recorded/index.html"]
        #[doc = "[every key]: ../every_key/index.html"]
        #[doc = "[python]: ../python/index.html"]
        #[doc = ""]
        #[doc = include_str!($file)]
        pub mod $name {}
    };
}

page!(every_key, "README.md", ["keys", "region", "snapshots", "poses", "combination", "candidate"]);
page!(own_cell, "tutorial/README.md", ["tutorial", "glTF", "URDF", "STL"]);
