//! The evidence of `choose`, kept in the folder of the answer: another question casts nothing, a run that was ended goes
//! on, and what is torn, damaged or of another study is never taken for what was cast.

use crate::common;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::common::program::{self, Folder, choose, perirobot, text};
use perirobot_cover::CandidateEvidence;
use perirobot_cover::layout::WantedCounts;
use perirobot_decide::choose::{Casting, EVIDENCE, cast_evidence, wanted_counts};
use perirobot_march::Error;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::metrics::Score;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

const STUDY: &str = "study.toml";

const CHOOSE: &str = r#"
[choose]
objective = "f1"
region = "box"
at_most = 2
"#;

/// The files of an answer.
const ANSWER: [&str; 3] = ["front.csv", "sets.csv", "choose.json"];

const NOTHING_CAST: &str = "nothing is cast";
const DAMAGED: &str = "evidence.journal: damaged in ";

/// The small study, and what is looked for: 11 poses of which two cameras have noise, drawn twice.
fn folder() -> Folder {
    let folder = Folder::new();
    let noisy = "near_ignore_m = 0.05\nnoise = { std_m = 0.05 }";
    folder.edit(STUDY, "near_ignore_m = 0.05", noisy);
    folder.edit(STUDY, "seed = 7", "seed = 7\nrepeats = 2");
    folder.edit(STUDY, "", CHOOSE);
    folder
}

/// Whether something was cast.
fn has_cast(said: &str) -> bool {
    said.matches("running on").count() == 1 && !said.contains(NOTHING_CAST)
}

/// It must end well; gives what it said, and the answer.
#[track_caller]
fn chosen(folder: &Folder, out: &str, more: &[&str]) -> (String, [String; 3]) {
    let outcome = choose(folder, out, more);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    (outcome.stderr, answer(&folder.path(out)))
}

fn answer(out: &Path) -> [String; 3] {
    ANSWER.map(|name| fs::read_to_string(out.join(name)).unwrap())
}

/// It must be refused before anything is cast, in words that hold all of `expected`.
#[track_caller]
fn refused(folder: &Folder, more: &[&str], code: i32, expected: &[&str]) {
    let outcome = choose(folder, "out", more);
    assert_eq!(outcome.code, Some(code), "{}{}", outcome.stdout, outcome.stderr);
    for fragment in expected {
        assert!(outcome.stderr.contains(fragment), "no {fragment:?} in {}", outcome.stderr);
    }
    assert!(
        !outcome.stderr.contains("running on") && !outcome.stderr.contains("panicked"),
        "{}",
        outcome.stderr
    );
}

fn journal(folder: &Folder) -> Vec<u8> {
    fs::read(folder.path("out").join(EVIDENCE)).unwrap()
}

/// Where the first record begins.
fn first_record(journal: &[u8]) -> usize {
    60 + u64::from_le_bytes(std::array::from_fn(|i| journal[12 + i])) as usize
}

fn write_journal(folder: &Folder, bytes: &[u8]) {
    fs::write(folder.path("out").join(EVIDENCE), bytes).unwrap();
}

#[test]
fn another_question_casts_nothing_and_has_the_answer_of_a_fresh_folder() {
    let folder = folder();
    let (said, first) = chosen(&folder, "out", &[]);
    assert!(has_cast(&said), "{said}");
    let cast = journal(&folder);
    let (said, again) = chosen(&folder, "out", &[]);
    assert!(said.contains("evidence of 19 scene-poses found in ") && said.contains(NOTHING_CAST), "{said}");
    assert_eq!(again, first);
    // Costs, limits, the score, its region and what is required decide nothing of it; nor does who would cast.
    folder.edit(STUDY, "name = \"camera\"", "name = \"camera\"\ncost = 250.0");
    folder.edit(STUDY, "name = \"lidar\"", "name = \"lidar\"\ncost = 499.5\nat_most = 1");
    let questions = [
        ("objective = \"f1\"", "objective = \"kappa\"\nover = \"worst\"\nbudget = 800.0"),
        (
            "objective = \"kappa\"\nover = \"worst\"\nbudget = 800.0",
            "objective = \"human_seen\"\napart_m = 0.5",
        ),
        ("region = \"box\"", "region = \"human\""),
        (
            "human_box = { object = \"operator\", margin_m = 0.2 }",
            "sphere = { center_m = [0, 0, 0.8], radius_m = 3 }",
        ),
        ("objective = \"human_seen\"", "objective = \"parts_detected\"\nalways = [\"lidar:posts/upright\"]"),
        ("seed = 7", "seed = 7\nmin_hits = 1"),
        (
            "objective = \"parts_detected\"\n",
            "objective = \"f1\"\nrequire = [{ score = \"human_seen\", at_least = 0.01 }]\n",
        ),
    ];
    for (number, (asked, question)) in questions.into_iter().enumerate() {
        folder.edit(STUDY, asked, question);
        let (said, found) = chosen(&folder, "out", &["--backend", "oracle"]);
        assert!(said.contains(NOTHING_CAST) && !has_cast(&said), "{question}: {said}");
        let (said, fresh) = chosen(&folder, &format!("fresh{number}"), &[]);
        assert!(has_cast(&said), "{said}");
        assert_eq!(found, fresh, "{question}");
        assert_ne!(found[0], first[0], "{question}");
    }
    assert!(journal(&folder) == cast, "nothing was added");
}

#[test]
fn a_file_that_ends_anywhere_is_gone_on_with_on_every_backend() {
    let folder = folder();
    let (_, expected) = chosen(&folder, "out", &["--threads", "1"]);
    let whole = journal(&folder);
    let mut backends = vec![vec!["--backend", "oracle"], vec!["--threads", "1"], vec!["--threads", "2"]];
    backends.extend(common::on_adapter().map(Vec::from));
    let (mut found, records) = (0, first_record(&whole));
    // Before and within what decides the evidence, and within records.
    let within = (0..8).map(|part| records + (whole.len() - records) * part / 8);
    let cuts = within.chain([0, 1, 30, 59, 60, records - 1, whole.len() - 1]);
    for (number, cut) in cuts.enumerate() {
        write_journal(&folder, &whole[..cut]);
        let (said, answer) = chosen(&folder, "out", &backends[number % backends.len()]);
        assert_eq!(answer, expected, "{cut} of {}", whole.len());
        assert!(has_cast(&said) && !said.contains(DAMAGED), "{cut}: {said}");
        found += usize::from(said.contains(" of 19 scene-poses found in "));
        assert_eq!(journal(&folder).len(), whole.len(), "each is there once");
        let (said, _) = chosen(&folder, "out", &[]);
        assert!(said.contains(NOTHING_CAST), "{cut}: {said}");
    }
    assert!(found >= 7, "{found} runs found a part");
}

#[test]
fn damaged_bytes_are_found_and_cast_again() {
    let folder = folder();
    let (_, expected) = chosen(&folder, "out", &[]);
    let whole = journal(&folder);
    let records = first_record(&whole);
    // Within the header of the first record, its words, and somewhere behind.
    for at in [0, 4, 8, 12, 16, 24, 28, 35, 36, 43, 44, 100]
        .map(|at| records + at)
        .into_iter()
        .chain([(records + whole.len()) / 2, whole.len() - 1])
    {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        write_journal(&folder, &bytes);
        let (said, answer) = chosen(&folder, "out", &[]);
        assert!(
            said.contains("evidence.journal: damaged in 1 places; the lost evidence is cast again"),
            "{at}: {said}"
        );
        assert_eq!(answer, expected, "byte {at}");
        let (said, answer) = chosen(&folder, "out", &[]);
        assert!(said.contains(NOTHING_CAST) && !said.contains(DAMAGED), "{at}: {said}");
        assert_eq!(answer, expected, "byte {at}");
    }
    let before = |at: usize, expected: &[&str]| {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        write_journal(&folder, &bytes);
        refused(&folder, &[], 2, expected);
        assert!(journal(&folder) == bytes, "it is left as it was");
    };
    before(
        0,
        &["evidence.journal: is not an evidence file of perirobot", "name another folder, or move it away"],
    );
    before(8, &["has evidence of format 6, but this perirobot writes 2", "--restart"]);
    for at in [12, 20, 40, 59, 60, records - 1] {
        before(at, &["evidence.journal: has a damaged beginning", "--restart starts over"]);
    }
    assert_eq!(chosen(&folder, "out", &["--restart"]).1, expected);
    assert!(journal(&folder) == whole);
}

#[test]
fn evidence_of_another_study_is_refused_until_it_may_be_lost() {
    let folder = folder();
    chosen(&folder, "out", &[]);
    for (from, to, expected) in [
        ("seed = 7", "seed = 8", "seed was 7, is 8"),
        ("std_m = 0.05", "std_m = 0.06", "study.sensor[0].noise.std_m was 0.05, is 0.06"),
        ("count = 2", "count = 3", "study.sensor[0].poses[1].random.count was 2, is 3"),
        ("voxel_size_m = 0.1", "voxel_size_m = 0.125", "voxel_size_m was 0.1, is 0.125"),
    ] {
        let (study, cast) = (fs::read_to_string(folder.path(STUDY)).unwrap(), journal(&folder));
        folder.edit(STUDY, from, to);
        let cure = "or start over with --restart (which discards its evidence)";
        refused(&folder, &[], 2, &["evidence.journal: contains evidence of another study: ", expected, cure]);
        assert!(journal(&folder) == cast, "it is left as it was");
        let (_, found) = chosen(&folder, "out", &["--restart"]);
        fs::remove_dir_all(folder.path("fresh")).unwrap_or_default();
        assert_eq!(found, chosen(&folder, "fresh", &[]).1, "{to}");
        folder.write(STUDY, study);
        refused(&folder, &[], 2, &["contains evidence of another study: "]);
        chosen(&folder, "out", &["--restart"]);
    }
    // Records of another study under a header of this one are damaged, not taken.
    let (_, expected) = chosen(&folder, "out", &[]);
    let here = journal(&folder);
    folder.edit(STUDY, "seed = 7", "seed = 8");
    chosen(&folder, "other", &[]);
    folder.edit(STUDY, "seed = 8", "seed = 7");
    let there = fs::read(folder.path("other").join(EVIDENCE)).unwrap();
    write_journal(&folder, &[&here[..first_record(&here)], &there[first_record(&there)..]].concat());
    let (said, found) = chosen(&folder, "out", &[]);
    assert!(said.contains("damaged in 1 places"), "{said}");
    assert_eq!(found, expected);
}

/// Changes of the small study of which nothing is cast, each with the key that it is of, what it replaces, and by what.
const NOT_DECIDING: &[(&str, &str, &str)] = &[
    ("choose", "objective = \"f1\"", "objective = \"human_seen\""),
    ("choose", "region = \"box\"", "region = \"human\""),
    ("choose", "at_most = 2", "at_most = 1\nover = \"worst\"\napart_m = 0.5\nrefine = true"),
    ("sensor", "name = \"camera\"", "name = \"camera\"\nemits = \"tof\""),
    ("choose", "at_most = 2", "at_most = 2\nalways = [\"lidar:posts/upright\"]"),
    ("choose", "at_most = 2", "at_most = 2\nrequire = [{ score = \"human_seen\", at_least = 0.5 }]"),
    ("sensor", "[[sensor.poses]]\nname = \"posts\"", "at_most = 1\n[[sensor.poses]]\nname = \"posts\""),
    ("region", "radius_m = 0.6", "radius_m = 2.0"),
    ("region", "name = \"human\"\n", "name = \"people\"\n"),
    ("region", "[[sensor]]", "[[region]]\nname = \"block\"\nmesh = \"block.stl\"\n[[sensor]]"),
    (
        "stopping",
        "[[sensor]]",
        "[[region]]\nname = \"near\"\nseparation = {}\n[stopping]\nformula = \"speed_and_separation\"\n\
         robot_speeds_m_s = [0.25, 0.5]\nsensor_reaction_s = 0.1\ncontrol_reaction_s = 0.05\n\
         robot_deceleration_m_s2 = 2.0\nperson_uncertainty_m = 0.1\nrobot_uncertainty_m = 0.01\n[[sensor]]",
    ),
    ("min_hits", "seed = 7", "seed = 7\nmin_hits = 1"),
    ("fusion", "seed = 7", "seed = 7\nfusion = \"octomap\""),
    ("currency", "seed = 7", "seed = 7\ncurrency = \"EUR\""),
    ("mixed_noise", "seed = 7", "seed = 7\nmixed_noise = true"),
    ("combination", "", "[[combination]]\nsensors = [\"camera\"]"),
    (
        "require",
        "",
        "[[require]]\nname = \"seen\"\nscore = \"parts_detected\"\nregion = \"box\"\nat_least = 0.8",
    ),
    ("mounting_error", "", "[mounting_error]\ndraws = 2\nposition_m = 0.01\nangle_deg = 1.0"),
    ("postures", "", "[postures]\npeople = [\"standing\"]\nspots = [[0.0, 0.0, 0.0]]"),
    ("approach", "", "[approach]\nfloor_m = 0.1\nmin_voxels = 2"),
];

/// Changes with which it is refused, and what is said of each.
const DECIDING: &[(&str, &str, &str, &str)] = &[
    ("seed", "seed = 7", "seed = 8", "seed was 7, is 8"),
    ("repeats", "repeats = 2", "repeats = 3", "study.repeats was 2, is 3"),
    ("grid", "voxel_size_m = 0.1", "voxel_size_m = 0.125", "voxel_size_m was 0.1, is 0.125"),
    (
        "grid",
        "voxel_size_m = 0.1",
        "voxel_size_m = 0.1\noutside = \"backdrop\"",
        "study.grid.outside was null",
    ),
    ("scene", "file = \"cell.toml\"", "file = \"cell.toml\"\nname = \"two\"", "study.scene[0].name was null"),
    ("candidate", "", "[[candidate]]\nobject = \"crate\"\nx_m = 0.6\ny_m = 0.4", "study.candidate was null"),
    ("sensor", "fov_deg = [87, 58]", "fov_deg = [80, 58]", "study.sensor[0].fov_deg was [87,58], is [80,58]"),
    ("catalogue", "seed = 7", "seed = 7\ncatalogue = \"ours.toml\"", "study.catalogue was null"),
    ("sensor", "std_m = 0.05", "std_m = 0.06", "study.sensor[0].noise.std_m was 0.05, is 0.06"),
    ("sensor", "count = 2", "count = 3", "study.sensor[0].poses[1].random.count was 2, is 3"),
    (
        "choose",
        "at_most = 2",
        "at_most = 2\nrepresentation = { scanner = \"field\" }",
        "choose.representation.scanner was \"points\", is \"field\"",
    ),
];

/// A sensor that can be taken to say two things.
const SCANNER: &str = r#"
[[sensor]]
name = "scanner"
kind = "lidar"
fov_deg = 270
rings_deg = [0]
beams = 28
range_m = [0.1, 5]
representations = ["points", "field"]
field = { polygon_m = [[0, -0.4], [0.4, -0.4], [0.4, 0.4], [0, 0.4]], height_m = 0.5 }
[[sensor.poses]]
name = "floor"
list = [{ position_m = [-0.9, -0.5, 0.2], facing = [1, 0, 0] }]
"#;

/// A closed surface in the small cell.
const BLOCK: &str = "solid block
facet normal 0 0 0\nouter loop\nvertex 0 0 0.2\nvertex 0 0.8 0.2\nvertex 0.8 0 0.2\nendloop\nendfacet
facet normal 0 0 0\nouter loop\nvertex 0 0 0.2\nvertex 0.8 0 0.2\nvertex 0 0 1\nendloop\nendfacet
facet normal 0 0 0\nouter loop\nvertex 0 0 0.2\nvertex 0 0 1\nvertex 0 0.8 0.2\nendloop\nendfacet
facet normal 0 0 0\nouter loop\nvertex 0.8 0 0.2\nvertex 0 0.8 0.2\nvertex 0 0 1\nendloop\nendfacet
endsolid block
";

#[test]
fn each_key_of_a_study_decides_evidence_or_does_not() {
    let folder = folder();
    folder.edit(STUDY, "", SCANNER);
    folder.write("block.stl", BLOCK);
    folder.write("ours.toml", "[[model]]\nname = \"ours\"\nkeys = { kind = \"pad\" }\n");
    chosen(&folder, "out", &[]);
    let (cast, study, out) = (journal(&folder), fs::read(folder.path(STUDY)).unwrap(), folder.path("out"));
    let left_of = |overrides: Overrides| {
        let study = Study::load(&folder.path(STUDY), &overrides).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        begin(&study, &worlds, 1 << 30, Some((&out, false))).map(|casting| casting.remaining())
    };
    let left = || left_of(Overrides::default());
    let said = left_of(Overrides { noiseless: true, ..Default::default() }).unwrap_err().to_string();
    assert!(said.contains("noiseless was false, is true"), "{said}");
    for (key, from, to) in NOT_DECIDING {
        folder.edit(STUDY, from, to);
        assert_eq!(left().unwrap_or_else(|e| panic!("{key}: {e}")), 0, "{key}: {to}");
        folder.write(STUDY, &study);
    }
    for (key, from, to, expected) in DECIDING {
        folder.edit(STUDY, from, to);
        let said = left().expect_err(key).to_string();
        assert!(
            said.contains("contains evidence of another study: ") && said.contains(expected),
            "{key}: {said}"
        );
        folder.write(STUDY, &study);
    }
    folder.edit("cell.toml", "position_m = [0.7, 0.4, 0.25]", "position_m = [0.6, 0.4, 0.25]");
    let said = left().unwrap_err().to_string();
    assert!(said.contains("scene_files[0].says.object[1].position_m was [0.7,0.4,0.25]"), "{said}");
    assert!(journal(&folder) == cast, "it is left as it was");
    // A new key of a study must be listed here as one or the other.
    let schema = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/schemas/study.schema.json");
    let schema: serde_json::Value = serde_json::from_slice(&fs::read(schema).unwrap()).unwrap();
    let known: BTreeSet<&str> =
        schema["properties"].as_object().unwrap().keys().map(String::as_str).collect();
    let tried = NOT_DECIDING.iter().map(|change| change.0).chain(DECIDING.iter().map(|change| change.0));
    assert_eq!(tried.collect::<BTreeSet<&str>>(), known);
}

#[test]
fn several_regions_share_what_is_cast_and_the_memory() {
    let folder = folder();
    let study = Study::load(&folder.path(STUDY), &Overrides::default()).unwrap();
    let (worlds, out) = (World::prepare_all(&study).unwrap(), folder.path("out"));
    fs::create_dir(&out).unwrap();
    let people = WantedCounts::from_scores([Score::HumanSeen].into_iter());
    let asked = [(2, people), (0, WantedCounts::ALL), (1, WantedCounts::ALL)];
    let ways = vec![0; study.sensors.len()];
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let alone = asked.map(|(region, _)| {
        cast_evidence(&study, &worlds, (region, &ways), 1 << 30, &mut cpu, &|| None).unwrap()
    });
    let same = |all: &[CandidateEvidence]| {
        for ((found, expected), (region, wanted)) in all.iter().zip(&alone).zip(&asked) {
            assert_eq!(found.items, alone[0].items);
            for item in 0..expected.count() {
                let set = [item, (item * 7 + 3) % expected.count()];
                let (found, expected) = (found.counts(&set), expected.counts(&set));
                match wanted.labels {
                    true => assert_eq!(found, expected, "region {region}: {set:?}"),
                    false => {
                        assert!(found.iter().map(|c| c.detection).eq(expected.iter().map(|c| c.detection)))
                    }
                }
            }
        }
    };
    let mut casting = begin_of(&study, &asked, &worlds, 1 << 30, Some((&out, false))).unwrap();
    assert_eq!(casting.total(), 19, "each is cast once for all regions");
    casting.run(&mut cpu, &|| None).unwrap();
    let held = casting.evidence();
    same(&held);
    let bytes: u64 = held.iter().map(CandidateEvidence::bytes).sum();
    assert!(held.iter().all(|of| of.bytes() > 0 && of.spare_bytes() == (1 << 30) - bytes));
    drop(held);
    let enough = begin_of(&study, &asked, &worlds, bytes, Some((&out, false))).unwrap();
    assert!(!enough.is_filed() && enough.remaining() == 0);
    same(&enough.evidence());
    let filed = begin_of(&study, &asked, &worlds, bytes - 1, Some((&out, false))).unwrap();
    assert!(filed.is_filed() && filed.remaining() == 0);
    let filed = filed.evidence();
    assert!(filed.iter().all(|of| of.is_filed() && of.spare_bytes() == bytes - 1));
    same(&filed);
    filed.iter().for_each(|of| of.was_read().unwrap());
}

#[test]
fn a_folder_that_cannot_keep_it_is_refused() {
    let folder = folder();
    fs::create_dir_all(folder.path("out").join(EVIDENCE)).unwrap();
    refused(&folder, &[], 2, &["evidence.journal: is not a regular file"]);
    fs::remove_dir(folder.path("out").join(EVIDENCE)).unwrap();
    write_journal(&folder, b"");
    let held = fs::File::open(folder.path("out").join(EVIDENCE)).unwrap();
    held.lock().unwrap();
    refused(&folder, &[], 75, &["evidence.journal: another run uses this folder"]);
    drop(held);
    chosen(&folder, "out", &[]);
    #[cfg(unix)]
    {
        let two = folder.path("two");
        fs::hard_link(folder.path("out").join(EVIDENCE), &two).unwrap();
        refused(&folder, &[], 2, &["evidence.journal: has 2 names"]);
        fs::remove_file(two).unwrap();
        // Whoever owns the machine may write anywhere, but not here.
        let outcome = choose(&folder, "/proc/none", &[]);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("/proc/none: cannot be made a folder for results"),
            "{}",
            outcome.stderr
        );
        assert!(!outcome.stderr.contains("running on"), "{}", outcome.stderr);
    }
}

#[test]
fn a_damaged_proof_is_told_before_anything_is_cast_and_a_sound_one_trusts_no_file() {
    let folder = folder();
    chosen(&folder, "out", &[]);
    let cast = journal(&folder);
    let (study, out) = (folder.path(STUDY), folder.path("out"));
    let verify = || perirobot(&["choose", text(&study), "--verify", text(&out), "--progress", "none"]);
    let outcome = verify();
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("running on") && !outcome.stderr.contains("found in"),
        "{}",
        outcome.stderr
    );
    assert!(journal(&folder) == cast);
    let proof = fs::read_to_string(out.join("choose.json")).unwrap();
    for (damaged, expected) in [
        (proof.replacen('{', "[", 1), "choose.json: is not as it was written"),
        (proof.replacen("\"budget\": null", "\"budget\": 3", 1), "the study's question has changed"),
        (proof.replacen("camera:", "camera:x", 1), "is not a pose of the study"),
    ] {
        assert_ne!(damaged, proof);
        fs::write(out.join("choose.json"), damaged).unwrap();
        let outcome = verify();
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
        assert!(!outcome.stderr.contains("running on"), "{}", outcome.stderr);
    }
}

#[test]
fn a_region_with_too_many_voxels_is_told_before_anything_is_cast() {
    let folder = folder();
    folder.edit(STUDY, "voxel_size_m = 0.1", "voxel_size_m = 0.0125");
    folder.edit(STUDY, "repeats = 2", "repeats = 5000");
    refused(&folder, &[], 2, &["region \"box\": has 2", "at most 2147483648 are exact"]);
    assert!(!folder.names().contains(&"out".to_string()));
}

/// Begins to cast. A child that another test has just started may hold the lock of a file for a moment.
fn begin<'a>(
    study: &'a Study,
    worlds: &'a [World],
    memory_bytes: u64,
    kept: Option<(&Path, bool)>,
) -> perirobot_march::Result<Casting<'a>> {
    let choose = study.choose.as_ref().unwrap().best().unwrap();
    begin_of(study, &[wanted_counts(choose)], worlds, memory_bytes, kept)
}

/// The same of some regions.
fn begin_of<'a>(
    study: &'a Study,
    asked: &[(usize, WantedCounts)],
    worlds: &'a [World],
    memory_bytes: u64,
    kept: Option<(&Path, bool)>,
) -> perirobot_march::Result<Casting<'a>> {
    let representations = &study.choose.as_ref().unwrap().best().unwrap().representations;
    loop {
        match Casting::begin(study, asked, representations, worlds, memory_bytes, kept) {
            Err(Error::Busy(_)) => std::thread::sleep(Duration::from_millis(10)),
            begun => return begun,
        }
    }
}

/// The least memory with which evidence is held.
fn least_memory(study: &Study, worlds: &[World], kept: Option<(&Path, bool)>) -> u64 {
    let (mut refused, mut taken) = (0, 1 << 30);
    while taken - refused > 1 {
        let middle = (refused + taken) / 2;
        match begin(study, worlds, middle, kept) {
            Ok(casting) if casting.is_filed() => refused = middle,
            Ok(_) => taken = middle,
            Err(e) => {
                assert!(
                    kept.is_none() && e.to_string().contains("scenes, snapshots and repeats takes"),
                    "{e}"
                );
                refused = middle;
            }
        }
    }
    taken
}

#[test]
fn what_takes_how_much_memory_is_known_before_it_is_cast() {
    let mut sizes = Vec::new();
    for noisy in [false, true] {
        for objective in ["f1", "human_seen", "people_detected"] {
            let folder = if noisy { folder() } else { Folder::new() };
            if !noisy {
                folder.edit(STUDY, "", CHOOSE);
            }
            folder.edit(STUDY, "objective = \"f1\"", &format!("objective = {objective:?}"));
            let study = Study::load(&folder.path(STUDY), &Overrides::default()).unwrap();
            let worlds = World::prepare_all(&study).unwrap();
            let out = folder.path("out");
            fs::create_dir(&out).unwrap();
            let needed = least_memory(&study, &worlds, Some((&out, false)));
            assert_eq!(least_memory(&study, &worlds, None), needed);
            let mut casting = begin(&study, &worlds, needed, Some((&out, false))).unwrap();
            casting.run(&mut Cpu::new(Some(1)).unwrap(), &|| None).unwrap();
            let evidence = casting.evidence().remove(0);
            let held = evidence.bytes();
            // What is too much is read from the file, and says the same.
            let filed = begin(&study, &worlds, held - 1, Some((&out, false))).unwrap();
            assert!(filed.is_filed() && filed.remaining() == 0);
            let filed = filed.evidence().remove(0);
            assert!(filed.is_filed() && filed.bytes() == 0);
            for item in 0..evidence.count() {
                let set = [item, (item * 7 + 3) % evidence.count()];
                assert_eq!(filed.counts(&set), evidence.counts(&set), "{objective}: {set:?}");
            }
            filed.was_read().unwrap();
            // What was read once may be another when it is read again.
            let whole = journal(&folder);
            let mut altered = whole.clone();
            altered[first_record(&whole)..].iter_mut().for_each(|byte| *byte ^= 1);
            write_journal(&folder, &altered);
            (0..filed.count()).for_each(|item| drop(filed.counts(&[item])));
            let error = filed.was_read().unwrap_err();
            assert!(
                matches!(error, Error::Storage(_)) && error.to_string().contains("the bytes have changed"),
                "{error}"
            );
            write_journal(&folder, &whole);
            drop(filed);
            assert!(held <= needed, "{objective}: {held} bytes, {needed} were announced");
            // What the file has is known exactly.
            assert_eq!(least_memory(&study, &worlds, Some((&out, false))), held, "{objective}");
            sizes.push(held);
        }
    }
    let [plain, seen, detected, noisy, noisy_seen, _] = sizes[..] else { panic!("{sizes:?}") };
    assert!(plain > 2 * seen && noisy > 2 * plain && noisy_seen >= 2 * seen && detected >= seen, "{sizes:?}");
}

#[test]
fn evidence_that_does_not_fit_is_read_from_its_file() {
    let folder = Folder::new();
    folder.edit(STUDY, "voxel_size_m = 0.1", "voxel_size_m = 0.025");
    folder.edit(STUDY, "count = 2", "count = 302");
    folder.edit(STUDY, "", CHOOSE);
    let (said, _) = chosen(&folder, "filed", &["--memory", "1MiB"]);
    assert!(said.contains("--memory and is read from"), "{said}");
    let (said, expected) = chosen(&folder, "out", &["--memory", "3MiB"]);
    assert!(!said.contains("is read from"), "{said}");
    let steps = |out: &str| -> serde_json::Value {
        let proof = fs::read(folder.path(out).join("choose.json")).unwrap();
        serde_json::from_slice::<serde_json::Value>(&proof).unwrap()["steps"].clone()
    };
    // Of single sensors each was tried, of two not.
    let (filed, held) = (steps("filed"), steps("out"));
    assert_eq!(filed[0], held[0]);
    let (filed, held) = (&filed[1], &held[1]);
    assert_eq!([&filed["at_most"], &held["at_most"]], [2, 2]);
    assert_eq!([&filed["proven"], &held["proven"]], [false, true]);
    let above = filed["no_set_is_above"].as_f64().unwrap();
    assert!(
        above >= held["best"]["score"].as_f64().unwrap() && !filed["shown_by"].as_array().unwrap().is_empty()
    );
    // The proof of the bound needs no file, but memory.
    let out = folder.path("filed");
    let verify = |memory: &str| perirobot(&["choose", "--verify", text(&out), "--memory", memory]);
    let refused = verify("1MiB");
    let said =
        "the evidence of 311 poses in 1 scenes, snapshots and repeats takes 3 MiB, but 1 MiB are allowed";
    assert_eq!(refused.code, Some(2));
    assert!(
        refused.stderr.contains(said) && refused.stderr.contains("give --memory 3MiB"),
        "{}",
        refused.stderr
    );
    let checked = verify("3MiB");
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    assert!(checked.stdout.contains("1 bounds added up again"), "{}", checked.stdout);
    // What is there takes no more than was said, and what the question does not need takes nothing.
    assert_eq!(chosen(&folder, "out", &["--memory", "3MiB"]).1, expected);
    folder.edit(STUDY, "objective = \"f1\"", "objective = \"human_seen\"");
    let (said, _) = chosen(&folder, "out", &["--memory", "1MiB"]);
    assert!(said.contains(NOTHING_CAST), "{said}");
}

/// A study of some seconds, ended at any moment.
#[cfg(unix)]
mod ended {
    use std::thread::sleep;
    use std::time::Instant;

    use super::*;
    use crate::common::running::{Running, long, size};
    use crate::common::{Random, say};

    fn long_folder() -> Folder {
        let folder = Folder::new();
        long(&folder);
        folder.edit(STUDY, "count = 302", "count = 100");
        folder.edit(STUDY, "", &CHOOSE.replace("at_most = 2", "at_most = 1"));
        folder
    }

    fn start(folder: &Folder, more: &[&str]) -> Running {
        let (study, out) = (folder.path(STUDY), folder.path("out"));
        let fixed = ["choose", text(&study), "--out", text(&out), "--backend", "cpu", "--threads", "1"];
        Running::start(&[&fixed, more].concat())
    }

    #[test]
    fn casting_that_is_killed_again_and_again_ends_as_a_quiet_one() {
        let folder = long_folder();
        let begin = Instant::now();
        let (_, expected) = chosen(&folder, "quiet", &["--threads", "1"]);
        let whole = begin.elapsed();
        let mut random = Random(whole.as_nanos() as u64);
        let (path, mut with_some) = (folder.path("out").join(EVIDENCE), 0);
        for number in 0..4 {
            let mut run = start(&folder, &[]);
            let before = size(&path);
            let _ = number % 2 == 0 || run.until_rows(&path, before);
            sleep(whole.mul_f64(f64::from(random.below(1000)) / 8000.0));
            run.signal("KILL");
            let outcome = run.end();
            assert!(outcome.code.is_none() || outcome.code == Some(0), "{}", outcome.stderr);
            with_some += u32::from(size(&path) > 0);
        }
        let (said, answer) = chosen(&folder, "out", &[]);
        assert_eq!(answer, expected);
        assert!(!said.contains(DAMAGED) && said.contains(" scene-poses found in "), "{said}");
        say(&format!("4 runs of choose killed, {with_some} with evidence"));
        assert!(with_some > 0);
    }

    #[test]
    fn what_a_device_cast_is_counted_again_by_whoever_goes_on() {
        const CHECKED: &str = "poses counted again on the CPU: no difference";
        let Some(on) = crate::common::on_adapter() else { return };
        // A quick device may be done before the signal comes.
        for poses in ["500", "5000", "50000"] {
            let folder = long_folder();
            folder.edit(STUDY, "count = 100", &format!("count = {poses}"));
            let (study, out) = (folder.path(STUDY), folder.path("out"));
            let mut run = Running::start(&[&["choose", text(&study), "--out", text(&out)][..], &on].concat());
            assert!(run.until_rows(&out.join(EVIDENCE), 0));
            run.signal("KILL");
            let ended = run.end();
            if ended.stderr.contains(CHECKED) || ended.code.is_some() {
                continue;
            }
            let unchecked = out.join("evidence.unchecked");
            assert!(unchecked.exists(), "{:?}", program::names(&out));
            let outcome = choose(&folder, "out", &[]);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            assert!(outcome.stderr.contains(CHECKED), "{}", outcome.stderr);
            let again = choose(&folder, "out", &[]);
            assert!(!again.stderr.contains(CHECKED), "once is enough: {}", again.stderr);
            folder.edit(STUDY, "region = \"box\"", "region = \"robot\"");
            let elsewhere = choose(&folder, "out", &[]);
            assert!(elsewhere.stderr.contains(CHECKED), "not in this region yet: {}", elsewhere.stderr);
            return;
        }
        panic!("the device was never stopped in time");
    }

    #[test]
    fn casting_that_is_stopped_says_what_is_kept() {
        // A quick machine may be done with few poses before the signal comes.
        for poses in ["100", "1000", "10000"] {
            let folder = long_folder();
            folder.edit(STUDY, "count = 100", &format!("count = {poses}"));
            let path = folder.path("out").join(EVIDENCE);
            let mut run = start(&folder, &[]);
            assert!(run.until_rows(&path, 0));
            run.signal("INT");
            let outcome = run.end();
            assert_eq!(outcome.code, Some(75), "{}", outcome.stderr);
            assert_eq!(program::names(&folder.path("out")), [EVIDENCE], "nothing half-written");
            if outcome.stderr.contains("scene-poses are left to cast; the work so far is kept in ") {
                return;
            }
            assert!(outcome.stderr.contains("no set was found yet"), "{}", outcome.stderr);
        }
        panic!("casting was never stopped");
    }
}
