//! Scripts are read by the shells and parsers that will read them.

use std::process::Command;

use super::slurm::{LEAST_TIME_LIMIT_MIN, SlurmLimits};
use super::*;

/// Words that are hard to quote.
const NASTY: [&str; 12] = [
    "plain/path-1_2.toml",
    "two words",
    "it's",
    "\"double\"",
    "$HOME `id` $(id) ${x}",
    "back\\slash\\",
    "*?[a]~",
    "a;b&c|d>e<f#g!h",
    "-x",
    "50%a %% %{TASK_ID}",
    "größe 机",
    "$$ $$(A) '\\''",
];

const LIMITS: SlurmLimits = SlurmLimits { time_limit_min: Some(60), max_array_size: slurm::MAX_ARRAY_SIZE };

fn word(text: &str) -> VisibleWord {
    text.parse().unwrap()
}

fn job() -> Job {
    Job {
        name: word("perirobot-quick"),
        program: word("/opt/perirobot"),
        study: word("scenes/quick.toml"),
        out: word("out/quick"),
        shards: 4,
        sweep_arguments: vec![word("--noiseless")],
        merge_arguments: vec![word("--table"), word("both")],
        cpus: 2,
        memory_mib: Some(1024),
        tries: 5,
    }
}

fn pods() -> kubernetes::Pods {
    kubernetes::Pods { image: word("i:1"), claim: word("cells"), mount: word("/data"), parallelism: Some(3) }
}

/// A job whose every text is hard to quote.
fn nasty_job(text: &str) -> Job {
    let path = word(&format!("./{text}"));
    let sweep_arguments = vec![word(text)];
    Job { program: path.clone(), study: path.clone(), out: path, sweep_arguments, ..job() }
}

#[test]
fn what_ends_a_line_or_is_not_seen_is_no_word() {
    for text in [
        "",
        "a\nb",
        "a\u{7}",
        "a\u{85}b",
        "out/a\u{2028}b",
        "out/a\u{2029}b",
        "\u{feff}sh",
        "a\u{202e}b",
        "a\u{200b}",
    ] {
        assert!(text.parse::<VisibleWord>().is_err(), "{text:?}");
    }
}

#[test]
fn shells_read_words_as_they_were() {
    for text in NASTY {
        for shell in ["sh", "bash"] {
            let command = format!("printf %s {}", word(text).shell());
            let said = Command::new(shell).args(["-c", &command]).output().unwrap();
            assert_eq!(String::from_utf8(said.stdout).unwrap(), text, "{shell}: {command}");
        }
    }
    assert_eq!(word("plain/path-1_2.toml").shell(), "plain/path-1_2.toml");
    assert_eq!(word("it's").shell(), r"'it'\''s'");
}

/// What Kubernetes makes of an argument of a container without variables: `$$` is `$`, and `$(NAME)` would be
/// looked up.
fn expand(text: &str) -> String {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once('$') {
        out += before;
        out.push('$');
        assert!(!after.starts_with('('), "{text} would be looked up");
        rest = after.strip_prefix('$').unwrap_or(after);
    }
    out + rest
}

#[test]
fn containers_read_words_as_they_were() {
    for text in NASTY {
        let yaml = word(text).container_argument();
        let read: String = serde_json::from_str(&yaml).unwrap();
        assert_eq!(expand(&read), text, "{yaml}");
    }
    assert_eq!(word("$(A) \"b\"").container_argument(), r#""$$(A) \"b\"""#);
}

#[test]
fn what_is_no_line_of_text_is_no_word() {
    for text in ["", "a\nb", "a\rb", "a\0b", "tab\t", "\u{1b}[1m", "\u{85}"] {
        assert!(text.parse::<VisibleWord>().is_err(), "{text:?}");
    }
}

#[test]
fn shells_take_the_scripts() {
    for text in NASTY {
        let job = nasty_job(&text.replace('\\', "")).check().unwrap();
        for script in [slurm::script(&job, &LIMITS).unwrap(), hyperqueue::script(&job)] {
            for shell in ["sh", "bash"] {
                let said = Command::new(shell).args(["-n", "-c", &script]).output().unwrap();
                assert!(
                    said.status.success(),
                    "{shell}: {}\n{script}",
                    String::from_utf8_lossy(&said.stderr)
                );
            }
        }
    }
}

#[test]
fn the_number_of_shards_is_written_out() {
    let slurm = slurm::script(&job(), &LIMITS).unwrap();
    let kubernetes = kubernetes::manifest(&job(), &pods());
    for (script, expected) in [
        (&slurm, "sweep scenes/quick.toml --out out/quick --shard auto/4 --threads 2 --noiseless\n"),
        (&slurm, "merge out/quick --table both\n"),
        (&slurm, " --array=0-3 --cpus-per-task=2 --requeue --open-mode=append --signal=B:USR1@120 "),
        (&slurm, " --mem=1024M --time=60 \\\n"),
        (&slurm, "--dependency=\"afterany:$1\""),
        (&hyperqueue::script(&job()), "--shard auto/4"),
        (&hyperqueue::script(&job()), " --cpus=2 --resource=mem=1024 --crash-limit=5 "),
        (&kubernetes, r#"command: ["/opt/perirobot", "sweep", "scenes/quick.toml", "--out", "out/quick", "#),
        (&kubernetes, r#""--shard", "auto/4", "--threads", "2", "--noiseless"]"#),
        (&kubernetes, r#""merge", "out/quick", "--table", "both"]"#),
        (&kubernetes, "completions: 4\n  parallelism: 3\n  backoffLimitPerIndex: 5\n"),
    ] {
        assert!(script.contains(expected), "no {expected:?} in\n{script}");
    }
}

#[test]
fn no_more_tries_are_not_endless_ones() {
    assert!(hyperqueue::script(&Job { tries: 0, ..job() }).contains(" --crash-limit=1 "));
}

#[test]
fn threads_are_those_asked_for() {
    let asked = Job { sweep_arguments: vec![word("--threads=7")], ..job() };
    let texts = asked.sweep().iter().map(|word| word.text().to_string()).collect::<Vec<_>>();
    assert_eq!(texts[texts.len() - 3..], ["--shard", "auto/4", "--threads=7"]);
}

#[test]
fn a_percent_sign_in_the_path_of_logs_is_itself() {
    let script = slurm::script(&Job { out: word("out/50%a"), ..job() }, &LIMITS).unwrap();
    assert!(script.contains(" '--output=out/50%%a/logs/shard-%a.out' "), "{script}");
    assert!(script.contains("\nout=out/50%a\n"), "{script}");
}

#[track_caller]
fn assert_refused(outcome: Result<impl std::fmt::Debug>, expected: &[&str]) {
    let message = outcome.expect_err("must be refused").to_string();
    for part in expected {
        assert!(message.contains(part), "no {part:?} in {message}");
    }
}

#[test]
fn what_no_engine_could_carry_out_is_refused() {
    assert_refused(Job { shards: 0, ..job() }.check(), &["--shards 0", "at least 2"]);
    assert_refused(Job { shards: 1, ..job() }.check(), &["--shards 1", "perirobot sweep"]);
    assert_refused(Job { out: word("-o"), ..job() }.check(), &["--out -o", "./-o"]);
    for name in ["Quick", "a--b", "-a", "a_b", "a-name-that-is-longer-than-forty-letters-is"] {
        assert_refused(Job { name: word(name), ..job() }.check(), &["--name", name, "lower-case"]);
    }
    for argument in ["--shard", "--shard=1/2", "--out", "--out=x", "--table=csv", "--restart"] {
        let sweep_arguments = vec![word(argument)];
        assert_refused(
            Job { sweep_arguments, ..job() }.check(),
            &["after `--`", argument.split('=').next().unwrap()],
        );
    }
    assert!(Job { sweep_arguments: vec![word("--shardless")], ..job() }.check().is_ok());
}

#[test]
fn what_slurm_could_not_carry_out_is_refused() {
    let many = Job { shards: 1002, ..job() };
    assert_refused(slurm::script(&many, &LIMITS), &["--shards 1002", "at most 1001", "--max-array-size"]);
    assert!(slurm::script(&Job { shards: 1001, ..job() }, &LIMITS).unwrap().contains("--array=0-1000 "));
    assert!(slurm::script(&many, &SlurmLimits { max_array_size: 1002, ..LIMITS }).is_ok());
    assert_refused(slurm::script(&Job { out: word("a\\b"), ..job() }, &LIMITS), &["--out a\\b", "backslash"]);
    let short = SlurmLimits { time_limit_min: Some(LEAST_TIME_LIMIT_MIN - 1), ..LIMITS };
    assert_refused(slurm::script(&job(), &short), &["--time-limit 4", "at least 5 minutes"]);
}

#[test]
fn names_are_made_that_every_engine_takes() {
    for (text, expected) in [
        ("perirobot-quick", "perirobot-quick"),
        ("Exp 3.v2", "exp-3-v2"),
        ("--größe_", "gr-e"),
        ("机", "sweep"),
        ("thirty-nine-letters-and-then-a-hyphen-aa-b", "thirty-nine-letters-and-then-a-hyphen-aa"),
    ] {
        assert_eq!(label(text), expected, "{text}");
        assert_eq!(label(expected), expected);
    }
}
