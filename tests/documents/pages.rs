//! What the documents tell a reader to do is done here, in a copy of what ships: every block of commands and
//! of Python, every piece of TOML, and the examples of every `--help`. A block that needs what a test has not
//! says so where it begins: "```sh not-run". `render.rs` tests the pictures.

use std::collections::BTreeSet;
use std::fs;

use crate::common::blocks::{Block, blocks, prose};
use crate::common::place::{Place, read, root};
use crate::common::program::{self, perirobot};
use crate::common::python;
use jsonschema::error::ValidationErrorKind;
use perirobot_study::input::schema;

const README: &str = "README.md";
const COMMANDS: &str = "src/guide/commands.md";
const RESULTS: &str = "src/guide/results.md";
const PLAN_A_CELL: &str = "src/guide/plan_a_cell.md";
const INTEGRATOR: &str = "src/guide/integrator.md";
const SAFETY_ENGINEER: &str = "src/guide/safety_engineer.md";
const RESEARCHER: &str = "src/guide/researcher.md";
const REFERENCE: &str = "scenes/README.md";
const TUTORIAL: &str = "scenes/tutorial/README.md";
const PALLETISER: &str = "scenes/palletiser/README.md";
const FIRST_HOUR: &str = "src/guide/first_hour.md";
const PLAN: &str = "src/guide/plan.md";
const CHOOSE: &str = "src/guide/choose.md";
const APPROACH: &str = "src/guide/approach.md";
const REVIEW: &str = "src/guide/review.md";
const RECORDED: &str = "src/guide/recorded.md";
const SENSORS: &str = "src/guide/sensors.md";
const LONG_SWEEPS: &str = "src/guide/long_sweeps.md";
const PYTHON: &str = "src/guide/python.md";
const SAME_INTEGERS: &str = "src/guide/same_integers.md";
const WHY_FAST: &str = "src/guide/why_fast.md";
const WIDE_GPUS: &str = "src/guide/wide_gpus.md";
const CHANGE_IT: &str = "src/guide/change_it.md";
const CONTRIBUTING: &str = "src/guide/contributing.md";
const DOCUMENTS: [&str; 24] = [
    README,
    COMMANDS,
    RESULTS,
    PLAN_A_CELL,
    INTEGRATOR,
    SAFETY_ENGINEER,
    RESEARCHER,
    REFERENCE,
    TUTORIAL,
    PALLETISER,
    FIRST_HOUR,
    PLAN,
    CHOOSE,
    APPROACH,
    REVIEW,
    RECORDED,
    SENSORS,
    LONG_SWEEPS,
    PYTHON,
    SAME_INTEGERS,
    WHY_FAST,
    WIDE_GPUS,
    CHANGE_IT,
    CONTRIBUTING,
];

/// Pages whose blocks of text are the output of the commands before.
const SHOWS_OUTPUT: [&str; 7] =
    [README, PLAN_A_CELL, SAFETY_ENGINEER, TUTORIAL, PALLETISER, CHOOSE, APPROACH];

/// Languages of blocks that are there to be read.
const READ: [&str; 2] = ["text", "csv"];

/// Examples of `--help` that are not run, with the reason.
const TOO_LONG: [(&str, &str); 6] = [
    ("perirobot plan", "serves a page until it is ended; tests/plan has it"),
    ("perirobot plan my-cell/study.toml", "serves a page until it is ended; tests/plan has it"),
    ("perirobot plan my-cell/study.toml --no-open --port 8080", "serves a page until it is ended"),
    ("perirobot bench", "takes minutes, as its help says"),
    ("perirobot bench --voxel-size 0.05 --poses 2", "casts the paper's cameras with the plain oracle"),
    (
        "perirobot bench my.toml --backend cpu >> RESULTS.md",
        "measures each of many rounds for a second; bench.rs runs one",
    ),
];

/// What an example takes for granted: the subcommand, the example, commands.
const BEFORE: [(&str, &str, &str); 3] = [
    (
        "sweep",
        "perirobot merge out/my",
        "rm out/my/*.*; for k in 1 2 3; do perirobot sweep my.toml --out out/my --shard $k/4; done",
    ),
    (
        "merge",
        "perirobot merge whole here/shard-0-of-2 there/shard-1-of-2",
        "mkdir here there; cp -r out/my/shard-0-of-2 here; cp -r out/my/shard-1-of-2 there",
    ),
    (
        "render",
        "perirobot render out/quick --pose camera:right-wall/4/1 --out swept.png",
        "perirobot sweep scenes/quick.toml",
    ),
];

/// Runs the blocks of a document, in order, in one place; at least so many must be there.
#[track_caller]
fn follow(document: &str, least: usize) {
    let place = Place::new();
    let (mut run, mut skipped, mut printed) = (0, 0, String::new());
    for block in blocks(document, &read(document)) {
        let Block { language, is_run, text, place: at } = block;
        match (language.as_str(), is_run) {
            (_, false) => continue,
            ("sh", _) => printed = place.shell(&text.replace("cargo run --release --", "perirobot"), &at),
            ("python", _) => {
                let Some(interpreter) = python::python() else {
                    skipped += 1;
                    continue;
                };
                place.run(&interpreter, &["-W", "error", "-c", &text], &at);
                place.has_files(&text, &at);
            }
            ("toml", _) => check_toml(document, &text, &at),
            ("text", _) if SHOWS_OUTPUT.contains(&document) => {
                let missing = text.split("\n\n").find(|paragraph| !is_printed(paragraph, &printed));
                assert_eq!(missing, None, "{at}: is not what the commands before print:\n{printed}");
            }
            (language, _) => {
                assert!(READ.contains(&language), "{at}: ```{language} is neither run nor known to be read");
                continue;
            }
        }
        run += 1;
    }
    assert!(run + skipped >= least, "{document}: only {run} blocks were run");
}

/// Whether text is printed, apart from the number of spaces. A page may break a long line and indent the rest deeper.
fn is_printed(shown: &str, printed: &str) -> bool {
    let joined = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let (printed, mut lines) = (joined(printed), Vec::<String>::new());
    let mut indent = 0;
    for line in shown.lines() {
        let deeper = line.len() - line.trim_start().len();
        match lines.last_mut() {
            Some(last) if deeper > indent && !printed.contains(&joined(line)) => *last += &format!(" {line}"),
            _ => {
                indent = deeper;
                lines.push(line.into());
            }
        }
    }
    lines.iter().all(|line| printed.contains(&joined(line))) || printed.contains(&joined(shown))
}

/// Panics unless a block is spelled as files of its kind are; in the tutorial it is a piece of a file beside
/// it.
#[track_caller]
fn check_toml(document: &str, text: &str, at: &str) {
    let mut json: serde_json::Value = toml::from_str(text).unwrap_or_else(|e| panic!("{at}: {e}"));
    if let Some(models) = json.get_mut("model").and_then(|models| models.as_array_mut()) {
        // A catalogue: the keys of its devices are those of sensors.
        let named = |model: &mut serde_json::Value| {
            model["keys"]["name"] = model["name"].take();
            model["keys"].take()
        };
        let keys: Vec<_> = models.iter_mut().map(named).collect();
        json = serde_json::json!({ "sensor": keys });
    }
    let schema = if json.get("object").is_some() { schema::scene() } else { schema::study() };
    let validator = jsonschema::validator_for(&serde_json::from_str(schema).unwrap()).unwrap();
    // A piece of a file lacks what the rest of the file says.
    let wrong =
        validator.iter_errors(&json).filter(|e| !matches!(e.kind(), ValidationErrorKind::Required { .. }));
    let wrong: Vec<String> = wrong.map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(wrong.is_empty(), "{at}: {wrong:#?}");
    if document == TUTORIAL {
        let files = ["scenes/tutorial/cell.toml", "scenes/tutorial/study.toml"];
        assert!(files.iter().any(|file| read(file).contains(text)), "{at}: is in neither of {files:?}");
    }
}

#[test]
fn readme() {
    follow(README, 2);
}

#[test]
fn commands() {
    follow(COMMANDS, 1);
}

#[test]
fn results() {
    follow(RESULTS, 1);
}

#[test]
fn plan_a_cell() {
    follow(PLAN_A_CELL, 6);
}

#[test]
fn pages_for_three_readers() {
    follow(INTEGRATOR, 1);
    follow(SAFETY_ENGINEER, 1);
    follow(RESEARCHER, 1);
}

#[test]
fn reference() {
    follow(REFERENCE, 7);
}

#[test]
fn tutorial() {
    follow(TUTORIAL, 10);
}

/// A cell of real size, by the program that is not optimised.
#[test]
#[ignore = "takes two minutes; the nightly runs it"]
fn palletiser() {
    follow(PALLETISER, 5);
}

#[test]
fn first_hour() {
    follow(FIRST_HOUR, 5);
}

#[test]
fn choose() {
    follow(CHOOSE, 4);
}

#[test]
fn approach() {
    follow(APPROACH, 3);
}

#[test]
fn review() {
    follow(REVIEW, 3);
}

#[test]
fn sensors() {
    follow(SENSORS, 2);
}

#[test]
fn recorded_maps() {
    follow(RECORDED, 3);
}

#[test]
fn long_sweeps() {
    follow(LONG_SWEEPS, 2);
}

#[test]
fn same_integers() {
    follow(SAME_INTEGERS, 1);
}

#[test]
fn python_page() {
    follow(PYTHON, 7);
}

#[test]
fn every_page_of_the_guide_is_tested() {
    let folder = program::names(&root("src/guide"));
    for name in folder.iter().filter(|name| name.ends_with(".md")) {
        assert!(DOCUMENTS.contains(&format!("src/guide/{name}").as_str()), "src/guide/{name} is not tested");
    }
    assert!(folder.len() > 5, "{folder:?}");
}

/// Paths of the project in backquotes: those with a folder and without a placeholder.
fn paths(text: &str) -> Vec<String> {
    let folders = ["src/", "shaders/", "tests/", "scenes/", "benches/", ".ci/"];
    let is_path =
        |code: &String| folders.iter().any(|folder| code.starts_with(folder)) && !code.contains('*');
    inline_code(text).into_iter().filter(is_path).collect()
}

#[test]
fn files_that_the_guide_names_are_there() {
    let mut named = 0;
    for document in [
        FIRST_HOUR,
        RESEARCHER,
        CHOOSE,
        APPROACH,
        REVIEW,
        SENSORS,
        LONG_SWEEPS,
        SAME_INTEGERS,
        WHY_FAST,
        WIDE_GPUS,
        CHANGE_IT,
        CONTRIBUTING,
    ] {
        for path in paths(&read(document)) {
            assert!(root(&path).exists(), "{document}: no {path}");
            named += 1;
        }
    }
    assert!(named > 50, "only {named} files were found");
}

/// The subcommands that `--help` lists.
pub(super) fn subcommands() -> Vec<String> {
    let help = perirobot(&["--help"]).stdout;
    let (_, list) = help.split_once("Usage: ").unwrap();
    let rows = list.lines().skip(1).take_while(|line| *line != "Options:");
    let names =
        rows.filter_map(|row| row.strip_prefix("  ")?.split(' ').next().filter(|name| !name.is_empty()));
    names.map(str::to_string).collect()
}

/// The commands below "Examples:" or "First steps:" of a help, put together where lines were broken.
fn examples(help: &str) -> Vec<String> {
    let Some((_, rest)) = help.split_once("Examples:\n").or_else(|| help.split_once("First steps:\n")) else {
        return vec![];
    };
    let mut examples: Vec<String> = Vec::new();
    for line in rest.lines().take_while(|line| !line.is_empty()) {
        let bare = line.trim_start();
        let is_new = ["perirobot ", "octovis "].iter().any(|name| bare.starts_with(name));
        match examples.last_mut() {
            // Deeper lines say what to do next, elsewhere.
            _ if line.starts_with("      ") => {}
            Some(last) if !is_new => *last = format!("{} {bare}", last.trim_end_matches(" \\")),
            _ => examples.push(bare.into()),
        }
    }
    examples
}

#[test]
fn help_is_not_broken_at_80_columns() {
    let help = |words: &[String], columns: u32| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_perirobot"));
        let output = command.args(words).env("COLUMNS", columns.to_string()).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    // What is laid out by hand begins behind the options.
    let by_hand = |help: &str| -> Vec<String> {
        let begins = ["Examples:", "First steps:", "How to read it:", "Reasons;"];
        let lines = help.lines().skip_while(|line| !begins.iter().any(|begin| line.starts_with(begin)));
        lines.map(String::from).collect()
    };
    let engines = ["slurm", "hyperqueue", "kubernetes"].map(|engine| format!("cluster {engine}"));
    let all = subcommands().into_iter().chain(engines).chain([String::new()]);
    for subcommand in all {
        let words: Vec<String> = subcommand.split_whitespace().chain(["--help"]).map(String::from).collect();
        let [narrow, wide] = [80, 100].map(|columns| help(&words, columns));
        // clap does not break the line of the usage.
        let mut lines = narrow.lines().filter(|line| !line.starts_with("Usage:"));
        let long = lines.find(|line| line.chars().count() > 80);
        assert_eq!(long, None, "perirobot {subcommand} --help");
        assert_eq!(by_hand(&narrow), by_hand(&wide), "perirobot {subcommand} --help");
    }
}

#[test]
fn examples_of_help() {
    let (mut run, mut skipped) = (0, 0);
    for subcommand in [vec![String::new()], subcommands()].concat() {
        let words = if subcommand.is_empty() { vec!["--help"] } else { vec![subcommand.as_str(), "--help"] };
        let (place, examples) = (Place::new(), examples(&perirobot(&words).stdout));
        let has_none = ["devices", "verify-backends", "voxelize", "schema"].contains(&subcommand.as_str());
        assert_eq!(examples.is_empty(), has_none, "perirobot {subcommand} --help");
        for example in examples {
            let command = example.split("  ").next().unwrap().to_string();
            let what = format!("`perirobot {subcommand} --help`: {command}");
            if TOO_LONG.iter().any(|(long, _)| *long == command) {
                skipped += 1;
                continue;
            }
            if let Some((.., before)) = BEFORE.iter().find(|(of, it, _)| *of == subcommand && *it == command)
            {
                place.shell(before, &what);
            }
            // Of other programs, the files that they are given.
            if command.starts_with("perirobot") {
                place.shell(&command, &what);
            }
            place.has_files(&example, &what);
            run += 1;
        }
    }
    assert!(run > 30 && skipped == TOO_LONG.len(), "{run} run, {skipped} not");
}

/// Text in backquotes, outside of blocks.
fn inline_code(text: &str) -> Vec<String> {
    let of_line =
        |line: &str| -> Vec<String> { line.split('`').skip(1).step_by(2).map(str::to_string).collect() };
    prose(text).into_iter().flat_map(of_line).collect()
}

#[test]
fn subcommands_and_options_are_those_of_the_program() {
    let subcommands = subcommands();
    let helps: Vec<String> = subcommands.iter().map(|name| perirobot(&[name, "--help"]).stdout).collect();
    let engines = ["slurm", "hyperqueue", "kubernetes"].map(|e| perirobot(&["cluster", e, "--help"]).stdout);
    let known: BTreeSet<&str> = (helps.iter().chain(&engines))
        .flat_map(|help| help.split(|c: char| !c.is_ascii_alphanumeric() && c != '-'))
        .filter(|word| word.starts_with("--"))
        .collect();
    let named: Vec<String> = inline_code(&read(COMMANDS));
    for name in &subcommands {
        let is_named = |code: &String| code.split_whitespace().take(2).eq(["perirobot", name]);
        assert!(named.iter().any(is_named), "{COMMANDS} lacks `perirobot {name}`");
    }
    for document in DOCUMENTS {
        for code in inline_code(&read(document)) {
            let words: Vec<&str> = code.split_whitespace().collect();
            if let ["perirobot", name, ..] = words[..] {
                assert!(subcommands.iter().any(|known| known == name), "{document}: `{code}`");
            }
            // Of other programs nothing is known.
            let first = words.first().copied().unwrap_or_default();
            if first != "perirobot"
                && !first.starts_with("--")
                && !subcommands.iter().any(|name| name == first)
            {
                continue;
            }
            for option in words.iter().filter(|word| word.starts_with("--")) {
                let option = option.split(['=', ',']).next().unwrap();
                assert!(known.contains(option), "{document}: no {option}, in `{code}`");
            }
        }
    }
}

/// What GitHub makes of a heading to link to it.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

#[test]
fn links_lead_somewhere() {
    for document in DOCUMENTS {
        let text = prose(&read(document)).join("\n");
        // `[text](file)`, and `[text][page]` with `[page]: file` at the end, which the guide's modules must
        // know, too.
        let inline = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        let is_page = |line: &&str| line.starts_with('[') && line.contains("]: ");
        let pages: Vec<(&str, &str)> =
            text.lines().filter(is_page).filter_map(|line| line[1..].split_once("]: ")).collect();
        for used in text.split("][").skip(1).filter_map(|rest| rest.split(']').next()) {
            assert!(pages.iter().any(|(page, _)| *page == used), "{document}: no page [{used}]");
        }
        for (page, _) in &pages {
            let (file, known) = match document.starts_with("scenes/") {
                true => ("scenes/lib.rs", format!("[{page}]: ../")),
                false => ("src/guide/mod.rs", format!("[{page}]: crate::")),
            };
            assert!(read(file).contains(&known), "{document}: {file} has no page [{page}]");
        }
        for link in inline.chain(pages.iter().map(|(_, file)| *file)) {
            if link.starts_with("https://") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = root(document);
            let target = if file.is_empty() { target } else { target.with_file_name("").join(file) };
            assert!(target.exists(), "{document}: no {file}");
            if !heading.is_empty() {
                let text = fs::read_to_string(&target).unwrap();
                let mut headings = text.lines().filter(|line| line.starts_with('#'));
                let found = headings.any(|line| anchor(line.trim_start_matches('#').trim()) == heading);
                assert!(found, "{document}: {} has no heading {heading}", target.display());
            }
        }
    }
}

#[test]
fn the_index_names_every_study_and_scene() {
    let index = read(REFERENCE);
    for folder in ["scenes", "scenes/paper", "scenes/palletiser", "scenes/tutorial"] {
        // The folder is also a crate.
        let is_ours = |name: &&String| name.ends_with(".toml") && *name != "Cargo.toml";
        for name in program::names(&root(folder)).iter().filter(is_ours) {
            let path = root(folder).join(name);
            let below = path.strip_prefix(root("scenes")).unwrap().display().to_string();
            assert!(index.contains(&format!("`{below}`")), "{REFERENCE} lacks `{below}`");
        }
    }
}
