//! Templates of typical cells. Their studies, cells and special robots are in the folders next to this file; people and
//! the arm are the shipped ones.

use super::schemas;

/// A typical cell with people at several moments, entries, prices and requirements, and a planned set of sensors that
/// misses some of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(in crate::cli) enum Template {
    /// A person works at a table with an arm
    Assembly,
    /// A conveyor, pallets, and a forklift that fetches them
    Palletiser,
    /// A robot behind sheet metal, with a door and a jig
    Welding,
    /// A mobile robot hands a part to a person
    Handover,
    /// A small arm on a laboratory bench
    Laboratory,
}

/// The study, the cell and the robot of a template.
macro_rules! texts {
    ($name:literal) => {
        texts!($name, include_str!(concat!($name, "/robot.urdf")))
    };
    ($name:literal, $robot:expr) => {
        [include_str!(concat!($name, "/study.toml")), include_str!(concat!($name, "/cell.toml")), $robot]
    };
}

impl Template {
    /// The weakness of its plan.
    #[cfg(feature = "report")]
    pub(in crate::cli) fn to_improve(self) -> &'static str {
        match self {
            Template::Assembly => {
                "One camera is planned: it sees 4 of 10 body parts of the operator, and nothing if it fails."
            }
            Template::Palletiser => {
                "Two domes are planned: they see half of the operator's body parts, and no dome may fail."
            }
            Template::Welding => {
                "A light curtain at the door is planned: it does not detect a person who is still inside."
            }
            Template::Handover => {
                "Only the robot's own lidar is planned: it sees few body parts, and people come near unnoticed."
            }
            Template::Laboratory => {
                "One camera on the shelf is planned: it sees people, but much near the arm stays unknown."
            }
        }
    }

    /// The names and texts of its files.
    pub(in crate::cli) fn files(self) -> Vec<(String, &'static str)> {
        let [study, cell, robot] = match self {
            Template::Assembly => texts!("assembly", perirobot_shipped::UR10),
            Template::Palletiser => texts!("palletiser", perirobot_shipped::UR10),
            Template::Welding => texts!("welding", perirobot_shipped::UR10),
            Template::Handover => texts!("handover"),
            Template::Laboratory => texts!("laboratory"),
        };
        let own = [("study.toml", study), ("cell.toml", cell), ("robot.urdf", robot)];
        let own = own.into_iter().chain(schemas()).map(|(name, text)| (String::from(name), text));
        let people = perirobot_shipped::PEOPLE.iter();
        let people = people.map(|person| (format!("people/{}.csv", person.name), person.joints));
        own.chain(people.filter(|(name, _)| cell.contains(&format!("{name:?}")))).collect()
    }
}
