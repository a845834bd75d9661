//! Scanners that switch between fields: counts are those of studies with one field each, snapshot by snapshot, on every
//! backend; and what a user can get wrong about cases.

use std::collections::HashMap;
use std::fs;

use crate::common::on_adapter;
use crate::common::program::{Edit, Folder, perirobot, refused, rows, text};

/// A vehicle goes through a corridor past a person who walks the other way.
const CELL: &str = r#"[[object]]
name = "floor"
plane = { size_m = [8, 4] }
[[object]]
name = "wall"
box = { size_m = [7.8, 0.2, 1.8] }
position_m = [0, 1.8, 0.9]
[[object]]
name = "vehicle"
role = "robot"
urdf = "vehicle.urdf"
position_m = [-3, 0, 0]
[object.snapshots]
position_m = [[-3, 0, 0], [-2.8, 0, 0], [-2.4, 0, 0], [-1.8, 0, 0], [-1.2, 0, 0], [-1, 0, 0]]
speed_m_s = [0, 0.2, 0.5, 1.2, 1.2, 0.3]
[[object]]
name = "person"
role = "human"
box = { size_m = [0.4, 0.4, 1.7] }
position_m = [1.5, 0, 0.95]
[object.snapshots]
position_m = [[1.5, -1, 0.95], [-1.6, 0, 0.95], [0.2, 0, 0.95], [0.5, 0.2, 0.95], [-0.4, 0.1, 0.95], [-0.5, 0, 0.95]]
"#;

const VEHICLE: &str = r#"<robot name="vehicle"><link name="base"><collision><origin xyz="-0.4 0 0.15"/><geometry>
<box size="0.6 0.4 0.3"/></geometry></collision></link></robot>"#;

const STUDY: &str = r#"seed = 3
repeats = 2
min_hits = 1
[grid]
voxel_size_m = 0.1
bounds_m = { min = [-4, -2, 0], max = [4, 2, 2] }
[[scene]]
file = "cell.toml"
[[region]]
name = "corridor"
box = { min_m = [-4, -2, 0.1], max_m = [4, 1.6, 1.6] }
[[sensor]]
name = "scanner"
kind = "lidar"
fov_deg = 270
beams = 181
rings_deg = [0]
range_m = [0.05, 5]
noise = { std_m = 0.02 }
dropout = 0.1
representations = ["points", "field"]
on = { object = "vehicle", link = "base" }
# fields
[[sensor.poses]]
name = "front"
list = [{ position_m = [0, 0, 0.23], facing = [1, 0, 0] }]
"#;

/// The usual field, and those of the cases, which name the snapshots at which each counts.
const FIELDS: [(&str, &[usize]); 3] = [
    ("polygon_m = [[0, -0.5], [0.8, -0.5], [0.8, 0.5], [0, 0.5]]\nheight_m = 1.2", &[0, 1, 5]),
    (
        "polygon_m = [[0, -0.3], [0.5, -0.8], [0.5, 1.2], [0, 0.3]]\nheight_m = 0.5\notherwise = \"unknown\"",
        &[4],
    ),
    ("polygon_m = [[0, -0.6], [2.4, -0.6], [2.4, 0.6], [0, 0.6]]", &[2, 3]),
];

fn field(keys: &str) -> String {
    let height = if keys.contains("height_m") { "" } else { "\nheight_m = 1.2" };
    format!("field = {{ {}{} }}", keys.replace('\n', ", "), height.replace('\n', ", "))
}

/// All three; the conditions of the cases both hold at snapshot 4.
fn all_fields() -> String {
    let [usual, turn, fast] = FIELDS.map(|(keys, _)| keys);
    format!(
        "{}\n[[sensor.field_cases]]\nname = \"turn\"\nat = [4]\n{turn}\n\
         [[sensor.field_cases]]\nname = \"fast\"\nspeed_m_s = [0.5, 2]\n{fast}",
        field(usual)
    )
}

fn folder(fields: &str) -> Folder {
    let folder = Folder::new();
    folder.write("study.toml", STUDY.replace("# fields", fields));
    folder.write("cell.toml", CELL);
    folder.write("vehicle.urdf", VEHICLE);
    folder
}

type Row = HashMap<String, String>;

/// The rows of a sweep, by representation and snapshot.
fn swept(folder: &Folder, backend: &[&str]) -> HashMap<(String, usize), Vec<Row>> {
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let outcome = perirobot(&[&["sweep", text(&study), "--out", text(&out)], backend].concat());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let mut all: HashMap<_, Vec<Row>> = HashMap::new();
    for row in rows(&out.join("results.csv")) {
        let key = (row["representation"].clone(), row["snapshot"].parse().unwrap());
        all.entry(key).or_default().push(row);
    }
    fs::remove_dir_all(out).unwrap();
    all
}

#[test]
fn counts_are_those_of_one_field_each() {
    // The same scanner, standing beside the vehicle's way, with the speed of the vehicle.
    let aside = |fields: &str| {
        let folder = folder(&fields.replace("speed_m_s =", "of = \"vehicle\"\nspeed_m_s ="));
        folder.edit("study.toml", "on = { object = \"vehicle\", link = \"base\" }\n", "");
        folder.edit(
            "study.toml",
            "position_m = [0, 0, 0.23], facing = [1, 0, 0]",
            "position_m = [-1.5, -1.2, 0.23], facing = [0.5, 1, 0]",
        );
        folder
    };
    let mut backends = vec![vec!["--backend", "oracle"], vec!["--backend", "cpu"]];
    backends.extend(on_adapter().map(|adapter| adapter.to_vec()));
    for is_carried in [true, false] {
        let make = |fields: &str| if is_carried { folder(fields) } else { aside(fields) };
        let single: Vec<_> =
            FIELDS.iter().map(|(keys, _)| swept(&make(&field(keys)), &["--backend", "oracle"])).collect();
        let together = make(&all_fields());
        for backend in &backends {
            let found = swept(&together, backend);
            assert_eq!(found.len(), 12, "two representations at six snapshots");
            for (own, (_, snapshots)) in FIELDS.iter().enumerate() {
                for &snapshot in *snapshots {
                    let key = ("field".to_string(), snapshot);
                    assert_eq!(found[&key], single[own][&key], "{backend:?}, snapshot {snapshot}");
                    let others = single.iter().enumerate().filter(|(number, _)| *number != own);
                    others.for_each(|(_, other)| assert!(found[&key] != other[&key], "snapshot {snapshot}"));
                    let points = ("points".to_string(), snapshot);
                    assert_eq!(found[&points], single[0][&points], "fields change no points");
                }
            }
        }
    }
}

#[test]
fn cases_that_cannot_be_are_refused() {
    let turn = "name = \"turn\"\nat = [4]";
    let fast = "name = \"fast\"\nspeed_m_s = [0.5, 2]";
    let place = "sensor \"scanner\".field_cases ";
    let carried = "on = { object = \"vehicle\", link = \"base\" }\n";
    let cases: &[(&[Edit], &[&str])] = &[
        (&[("study.toml", turn, "name = \"turn\"")], &[place, "\"turn\"", "has no condition: write at ="]),
        (&[("study.toml", turn, "name = \"fast\"\nat = [4]")], &["two field cases are named \"fast\""]),
        (&[("study.toml", turn, "at = [4]")], &["missing field `name`"]),
        (
            &[("study.toml", "at = [4]", "at = [4, 6]")],
            &["at = [6]: must be snapshots of a scene, from 0 to 5"],
        ),
        (&[("study.toml", "at = [4]", "at = []")], &["\"turn\"", "no at"]),
        (
            &[("study.toml", "at = [4]", "scenes = [\"hall\"]")],
            &["scenes = \"hall\": must be names of scenes: [\"cell\"]"],
        ),
        (
            &[("study.toml", "[0.5, 2]", "[2, 0.5]")],
            &["speed_m_s = [2, 0.5]: must be [from, to] in m/s", "the slower first"],
        ),
        (&[("study.toml", "[0.5, 2]", "[-1, 2]")], &["speed_m_s = [-1, 2]: must be [from, to]"]),
        (&[("study.toml", "[0.5, 2]", "[0, nan]")], &["speed_m_s = [0, NaN]: must be"]),
        (
            &[("study.toml", fast, &format!("{fast}\nof = \"vehicel\""))],
            &["of = \"vehicel\"", "did you mean \"vehicle\""],
        ),
        (
            &[("study.toml", fast, &format!("{fast}\nof = \"person\""))],
            &["of = \"person\": must not be a person"],
        ),
        (
            &[("study.toml", fast, &format!("{fast}\nof = \"wall\""))],
            &["of = \"wall\": has no known speed in scene \"cell\"", "0 if it stands still"],
        ),
        (
            &[("cell.toml", "speed_m_s = [0, 0.2, 0.5, 1.2, 1.2, 0.3]\n", "")],
            &["speed_m_s = \"vehicle\": has no known speed in scene \"cell\""],
        ),
        (&[("study.toml", carried, "")], &["speed_m_s without an object: write of ="]),
        (
            &[("study.toml", turn, &format!("{turn}\nof = \"vehicle\""))],
            &["of = \"vehicle\": belongs to speed_m_s"],
        ),
        (
            &[("study.toml", "[0.5, -0.8], [0.5, 1.2]", "[0.5, 0.9], [0.5, -1.2]")],
            &["\"turn\"", "polygon_m", "cross"],
        ),
        (
            &[("study.toml", "height_m = 0.5", "height_m = 0")],
            &["\"turn\"", "height_m = 0: must be a length"],
        ),
        (&[("study.toml", "height_m = 0.5", "heigth_m = 0.5")], &["unknown field `heigth_m`"]),
        (
            &[
                ("study.toml", &field(FIELDS[0].0), ""),
                ("study.toml", "[\"points\", \"field\"]", "[\"points\"]"),
            ],
            &["field_cases without field: write field ="],
        ),
        (
            &[("study.toml", "[0.5, -0.8], [0.5, 1.2], [0, 0.3]]", "[0.01, -0.3], [0.01, 0.3]]")],
            &["field case \"turn\": has a field without a voxel"],
        ),
    ];
    for (edits, expected) in cases {
        let folder = folder(&all_fields());
        edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
        refused(&folder, &[], expected);
    }
}

#[test]
fn cases_that_never_count_are_warned_of() {
    let said = |edits: &[Edit]| {
        let folder = folder(&all_fields());
        edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
        let outcome = perirobot(&["check", text(&folder.path("study.toml")), "--all"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome.stdout + &outcome.stderr
    };
    let plain = said(&[]);
    assert!(!plain.contains("field case"), "{plain}");
    let slow = said(&[("study.toml", "[0.5, 2]", "[1.3, 2]")]);
    assert!(
        slow.contains("sensor \"scanner\": field case \"fast\" applies at no moment of any scene"),
        "{slow}"
    );
    let hidden = said(&[("study.toml", "at = [4]", "at = [2, 3, 4]")]);
    let never = "field case \"fast\" never counts, since an earlier one always applies, too: put it before [\"turn\"]";
    assert!(hidden.contains(never), "{hidden}");
    // A scene in which no case applies.
    let scenes = said(&[("study.toml", "at = [4]", "scenes = [\"cell\"]\nat = [4]")]);
    assert!(!scenes.contains("field case"), "{scenes}");
}

/// A PSENscan's configuration of two zone sets for two ranges of speed: a sector ahead to the right, and two sectors.
fn configuration() -> String {
    let reach = |set: usize, azimuth_deg: f64| match set {
        0 if (-60.0..=0.0).contains(&azimuth_deg) => 1200_u16,
        1 if (-20.0..=10.0).contains(&azimuth_deg) || (80.0..=90.0).contains(&azimuth_deg) => 2003,
        _ => 0,
    };
    let set = |set: usize| {
        // From the left to the right.
        let values = (0..550).map(|value| reach(set, 137.5 - 0.5 * f64::from(value)).swap_bytes());
        let ro: String = values.map(|value| format!("{value:04X}")).collect();
        format!("<zoneSetInfo><zoneSetDetail><type>roOSSD1</type><ro>{ro}</ro></zoneSetDetail></zoneSetInfo>")
    };
    let selector = |[low, high]: [i32; 2]| {
        let range = format!("<minSpeed>{low}</minSpeed><maxSpeed>{high}</maxSpeed>");
        format!("<zoneSetSelector><zoneSetSpeedRange>{range}</zoneSetSpeedRange></zoneSetSelector>")
    };
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-16\"?>\n<MIB xmlns=\"http://tempuri.org/Mib.xsd\"><clusterDescr>\
         <zoneSetConfiguration><zoneSetSelCode>{}{}</zoneSetSelCode><encEnable>true</encEnable></zoneSetConfiguration>\
         </clusterDescr><scannerDescr><zoneSetDefinition>{}{}</zoneSetDefinition></scannerDescr></MIB>",
        selector([-10, 49]),
        selector([50, 200]),
        set(0),
        set(1),
    )
}

/// The same polygons, written out from the right to the left.
fn sectors() -> [String; 2] {
    let arc = |from: i32, to: i32, reach_m: f64| {
        (2 * from..=2 * to).map(move |half| {
            let (sin, cos) = (f64::from(half) / 2.0).to_radians().sin_cos();
            format!("[{}, {}]", cos * reach_m, sin * reach_m)
        })
    };
    let origin = || std::iter::once("[0, 0]".to_string());
    let first: Vec<String> = arc(-60, 0, 1.2).chain(origin()).collect();
    let between = (21..160).map(|half| {
        let (sin, cos) = (f64::from(half) / 2.0).to_radians().sin_cos();
        format!("[{}, {}]", cos * 0.02, sin * 0.02)
    });
    let second: Vec<String> =
        arc(-20, 10, 2.003).chain(between).chain(arc(80, 90, 2.003)).chain(origin()).collect();
    [first, second].map(|corners| format!("polygon_m = [{}]", corners.join(", ")))
}

fn two_fields([usual, fast]: &[String; 2], range: &str) -> String {
    let case = format!("[[sensor.field_cases]]\nname = \"fast\"\nspeed_m_s = {range}\n{fast}");
    format!("{}\n{case}", field(usual))
}

#[test]
fn zones_of_a_configuration_are_fields() {
    let zones = [
        "psenscan = { file = \"scanner.xml\", zone_set = 1 }",
        "psenscan = { file = \"scanner.xml\", zone_set = 2, zone = \"roOSSD1\" }",
    ]
    .map(String::from);
    let cpu = ["--backend", "cpu"];
    let expected = swept(&folder(&two_fields(&sectors(), "[0.5, 2]")), &cpu);
    let utf16: Vec<u8> =
        format!("\u{feff}{}", configuration()).encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [configuration().into_bytes(), utf16] {
        let folder = folder(&two_fields(&zones, "[0.5, 2]"));
        folder.write("scanner.xml", bytes);
        assert_eq!(swept(&folder, &cpu), expected);
        let checked = perirobot(&["check", text(&folder.path("study.toml")), "--all"]);
        let said = checked.stdout + &checked.stderr;
        assert!(!said.contains("cm/s"), "{said}");
    }
    let with = |file: &str, zones: &[String; 2], range: &str| {
        let folder = folder(&two_fields(zones, range));
        folder.write("scanner.xml", file);
        folder
    };
    let slower = with(&configuration(), &zones, "[0.3, 2]");
    let checked = perirobot(&["check", text(&slower.path("study.toml")), "--all"]);
    let said = checked.stdout + &checked.stderr;
    let warning =
        "field_cases \"fast\": speed_m_s = [0.3, 2], but its file has this zone set for 50 to 200 cm/s";
    assert!(said.contains(warning), "{said}");
    let third = [zones[0].clone(), zones[1].replace("zone_set = 2", "zone_set = 3")];
    let place = "study.toml: sensor \"scanner\".field_cases \"fast\".psenscan: ";
    refused(
        &with(&configuration(), &third, "[0.5, 2]"),
        &[],
        &[place, "scanner.xml: has no zone set 3: there are 2"],
    );
    refused(&with("x_m,y_m\n0,0\n", &zones, "[0.5, 2]"), &[], &["scanner.xml", "is no XML"]);
    let empty = configuration().replace("B004", "0000");
    refused(
        &with(&empty, &zones, "[0.5, 2]"),
        &[],
        &["zone set 1 has an empty zone \"roOSSD1\": choose another"],
    );
}
