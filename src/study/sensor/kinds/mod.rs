//! The kinds of sensors, a file each: its keys, what it does, and what pages say of it.
//!
//! | sensor | type | naive | volume | feature |
//! |---|---|---|---|---|
//! | RGB-D camera (`rgbd`) | range | `points` | | `spheres`, `cylinders`, `box` |
//! | RGB camera (`rgb`) | zone | | | `zone` |
//! | LIDAR, safety scanner (`lidar`) | range | `points` | `field` | |
//! | rays from a table (`rays`) | range | `points` | | |
//! | pressure pad (`pad`) | area | | `volume` | |
//! | light curtain (`gate`) | zone | | `volume` | |
//! | radar (`radar`) | zone | | `volume` | |
//! | proximity cover (`cover`) | range | `naive` | | |
//! | known robot pose (`known_robot`) | | | `volume` | |
//! | a real sensor's map or cloud (`recorded`) | range | `map` | | |
//!
//! (Paper, table I.) `src/guide/change_it.md` lists the files of a new kind. The schema of studies, the error that names the
//! known kinds and tables of pages are made from [`KINDS`].

pub(crate) mod cover;
pub(crate) mod gate;
pub(crate) mod known_robot;
pub(crate) mod lidar;
pub(crate) mod pad;
#[cfg(test)]
mod pages;
pub(crate) mod radar;
pub(crate) mod rays;
pub mod recorded;
pub(crate) mod rgb;
pub mod rgbd;
pub(crate) mod shared;

use std::fmt;
use std::sync::Arc;

use serde::de::{DeserializeOwned, Deserializer, EnumAccess, Visitor};
use serde::{Deserialize, de};
use toml::Table;

use super::Kind;
use crate::diagnostics::{Place, Unreadable, read};
#[cfg(test)]
use pages::{EvidenceWords, POINTS, Page};
use perirobot_march::{Error, Result};
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::source::Sources;

/// Lists the kinds by the structs of their keys.
macro_rules! kinds {
    ($($file:ty),+ $(,)?) => {
        /// The names of all kinds, as studies have them.
        pub const NAMES: &[&str] = &[$(<$file>::NAME),+];

        /// All kinds, in the order of [`NAMES`].
        pub(crate) static KINDS: &[KindEntry] = &[$(KindEntry {
            name: <$file>::NAME,
            read: read_kind::<$file>,
            #[cfg(test)]
            schema: <$file as schemars::JsonSchema>::json_schema,
            #[cfg(test)]
            page: <$file>::PAGE,
        }),+];
    };
}

kinds![
    rgbd::RgbdFile,
    rgb::RgbFile,
    lidar::LidarFile,
    rays::RaysFile,
    pad::PadFile,
    gate::GateFile,
    radar::RadarFile,
    cover::CoverFile,
    known_robot::KnownRobotFile,
    recorded::RecordedFile,
];

/// Examples of keys whose form is not obvious.
pub(crate) const EXAMPLES: [&str; 14] = [
    "name = \"camera\"",
    "kind = \"rgbd\"",
    "fov_deg = [87, 58], horizontal and vertical",
    "resolution_px = [1280, 720]",
    "resolution_deg = [0.5, 2], horizontal and vertical, or one for both",
    "rings = 16, from one end of elevation_deg to the other",
    "beams = 1081, from one end of fov_deg to the other",
    "range_m = [0.3, 6]",
    "min_speed_m_s = 0.1, the slowest that a radar detects",
    "size_m = [1, 0.75]",
    "inflation_m = [0.1, 0.2]",
    "directions = \"rays.csv\", a table with the columns x,y,z",
    "box = { min_m = [0, 0, 0.3], max_m = [0.1, 1, 2] }",
    "zone = { min_m = [0, -1, 0], max_m = [2, 1, 2] }",
];

/// The largest plausible lengths, in metres: several times what is built, or what a person needs.
pub(crate) const LARGEST_M: [(&str, f64); 6] = [
    ("spheres_radius_m", 2.0),
    ("cylinders_radius_m", 2.0),
    ("keypoint_tolerance_m", 2.0),
    ("near_ignore_m", 2.0),
    ("size_m", 50.0),
    ("height_m", 50.0),
];

/// The keys of a kind, as a study has them.
pub(crate) trait KindFile: DeserializeOwned {
    /// What a study calls the kind.
    const NAME: &'static str;

    /// What pages say of it.
    #[cfg(test)]
    const PAGE: Page;

    /// Replaces or refuses keys before they are read; returns warnings.
    fn prepare(_: &Place, _: &mut Table, _: &Sources) -> Result<Vec<String>> {
        Ok(Vec::new())
    }

    /// The sensor that the keys describe.
    fn check(self, at: &Place, context: &Context) -> Result<Checked>;
}

/// What the keys of a kind are checked with.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    /// Whether noise is switched off.
    pub(crate) noiseless: bool,
    /// The sources through which files are read.
    pub(crate) sources: &'a Sources,
    /// The study's scenes that could be read, and whether those are all.
    pub(crate) scenes: &'a [SceneSpec],
    pub(crate) has_all_scenes: bool,
    /// The robot that carries the sensor, if one does.
    pub(crate) carrier: Option<&'a str>,
}

/// A checked sensor, and what its user may not expect.
pub(crate) struct Checked {
    pub(crate) kind: Arc<dyn Kind>,
    pub(crate) warnings: Vec<String>,
}

impl<K: Kind + 'static> From<K> for Checked {
    fn from(kind: K) -> Checked {
        Checked { kind: Arc::new(kind), warnings: Vec::new() }
    }
}

/// Words the error of keys that cannot be read.
type Explain<'a> = &'a dyn Fn(Unreadable) -> Error;

/// A kind of the list.
pub(crate) struct KindEntry {
    /// What a study calls it.
    pub(crate) name: &'static str,
    /// Reads and checks its keys.
    pub(crate) read: fn(&Place, Table, &Context, Explain) -> Result<Checked>,
    /// The schema of its keys.
    #[cfg(test)]
    pub(crate) schema: fn(&mut schemars::SchemaGenerator) -> schemars::Schema,
    /// What pages say of it.
    #[cfg(test)]
    page: Page,
}

fn read_kind<K: KindFile>(
    at: &Place,
    mut keys: Table,
    context: &Context,
    explain: Explain,
) -> Result<Checked> {
    let mut warnings = K::prepare(at, &mut keys, context.sources)?;
    let file: K = read(keys).map_err(explain)?;
    let checked = file.check(at, context)?;
    warnings.extend(checked.warnings);
    Ok(Checked { kind: checked.kind, warnings })
}

/// A kind by its name.
impl<'de> Deserialize<'de> for &'static KindEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameVisitor;
        impl<'de> Visitor<'de> for NameVisitor {
            type Value = &'static KindEntry;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a kind of sensor")
            }
            fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<Self::Value, A::Error> {
                let (name, _) = data.variant::<String>()?;
                let found = KINDS.iter().find(|kind| kind.name == name);
                found.ok_or_else(|| de::Error::unknown_variant(&name, NAMES))
            }
        }
        deserializer.deserialize_enum("KindName", NAMES, NameVisitor)
    }
}
