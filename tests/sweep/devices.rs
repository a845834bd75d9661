//! Several devices that share a sweep: the same bytes as one, also where one of them fails, or counts wrongly.

use std::fs;

use crate::common;
use crate::common::program::{Folder, perirobot, text};
use crate::common::watch::Onlooker;
use crate::faults::{Call, Theatre, Trouble, Troupe, manifest};
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::{Error, Result};
use perirobot_sweep::results::files::{DISAGREED, JOURNAL};
use perirobot_sweep::scoring::run_on;
use perirobot_sweep::scoring::session::Ending;

/// Devices that share a job.
struct Several(Vec<Troupe>);

impl BackendFactory for Several {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        self.0[0].open(fallback)
    }

    fn needs_check(&self) -> bool {
        true
    }

    fn each_device(&mut self) -> Vec<&mut dyn BackendFactory> {
        self.0.iter_mut().map(|device| device as &mut dyn BackendFactory).collect()
    }
}

fn honest() -> Troupe {
    Troupe::new(|_, _, _| None)
}

/// Whether a call of a device that was opened so fails, after so many like it.
type Cue = fn(Call, Fallback, usize) -> bool;

/// What goes wrong on the second device, when, and who does the work instead, each time that it is told.
const CASES: [(&str, Cue, &[&str]); 3] = [
    ("nothing", |_, _, _| false, &[]),
    (
        "it is lost once",
        |call, fallback, before| (call, fallback, before) == (Call::Sense, Fallback::None, 0),
        &["the same device in small batches"],
    ),
    (
        "it never works",
        |call, _, _| call == Call::Sense,
        &["the CPU", "the CPU", "the CPU, and from then on the CPU"],
    ),
];

#[test]
fn devices_share_a_sweep_and_one_that_fails_is_replaced() {
    let theatre = Theatre::new();
    theatre.sweep("alone", &mut honest(), 500, &Onlooker::default()).unwrap();
    for (number, (name, cue, instead)) in CASES.into_iter().enumerate() {
        let failing = Troupe::new(move |call, fallback, before| {
            cue(call, fallback, before).then_some(Trouble::Fails("device lost"))
        });
        // The first one is slow, so that the second has work to fail at.
        let slow = Troupe::new(|call, _, _| {
            let wait = if call == Call::Load { 200 } else { 0 };
            std::thread::sleep(std::time::Duration::from_millis(wait));
            None
        });
        let (out, watch) = (format!("out-{number}"), Onlooker::default());
        let report = theatre.sweep(&out, &mut Several(vec![slow, failing]), 500, &watch).unwrap();
        let heard = watch.heard();
        assert_eq!(report.ending, Ending::Finished, "{name}");
        assert!(theatre.journal(&out) == theatre.journal("alone"), "{name}: other counts");
        assert_eq!((heard.finished, report.run.poses), (151 * 2 * 2, Some(151 * 2 * 2)), "{name}");
        let told: Vec<&str> = heard.faults.iter().map(|fault| fault.instead.as_str()).collect();
        assert_eq!(told, instead, "{name}");
        let run = &manifest(&theatre.out(&out))["runs"][0];
        assert_eq!((&run["device"], &run["ended"]), (&"Actor; Actor".into(), &"finished".into()), "{name}");
        // The first poses of each device are counted again, but not what the CPU did.
        let least = if name == "it never works" { 3 } else { 6 };
        assert!(run["verified"].as_u64() >= Some(least), "{name}: {run}");
    }
}

#[test]
fn a_device_that_counts_wrongly_ends_the_sweep_of_all_and_is_named() {
    let theatre = Theatre::new();
    let liar = Troupe::new(|call, fallback, _| {
        ((call, fallback) == (Call::Receive, Fallback::None)).then_some(Trouble::Lies)
    });
    let watch = Onlooker::default();
    let error = theatre.sweep("out", &mut Several(vec![honest(), liar]), 500, &watch).unwrap_err();
    assert!(matches!(error, Error::Disagreement(_)), "{error}");
    assert!(error.to_string().starts_with("Actor and the CPU disagree: scene"), "{error}");
    let out = theatre.out("out");
    assert!(out.join(DISAGREED).exists());
    // What the other device counted afterwards is not written down either.
    let header = fs::read(out.join(DISAGREED)).unwrap();
    let after = fs::read(out.join(JOURNAL)).unwrap();
    assert!(after.len() < header.len() && after.iter().zip(&header).all(|(a, b)| a == b), "rows were added");
    assert!(manifest(&out)["runs"][0]["ended"].as_str().is_some_and(|ended| ended.contains("disagree")));
}

/// The first difference decides what is kept: a second liar must not put the new, empty journal over it.
#[test]
fn two_devices_that_count_wrongly_leave_all_rows_set_aside() {
    let theatre = Theatre::new();
    let liar = || {
        Troupe::new(|call, fallback, _| {
            ((call, fallback) == (Call::Receive, Fallback::None)).then_some(Trouble::Lies)
        })
    };
    let error =
        theatre.sweep("out", &mut Several(vec![liar(), liar()]), 500, &Onlooker::default()).unwrap_err();
    assert!(matches!(error, Error::Disagreement(_)), "{error}");
    let out = theatre.out("out");
    let [aside, after] = [DISAGREED, JOURNAL].map(|name| fs::read(out.join(name)).unwrap().len());
    assert!(aside > after, "{aside} bytes are set aside, {after} are left");
}

#[test]
fn rows_in_memory_are_those_of_one_device() {
    let theatre = Theatre::new();
    let count = |mut backends: Several| {
        run_on(&theatre.study, &theatre.worlds, &mut backends, &Onlooker::default()).unwrap()
    };
    assert!(count(Several(vec![honest()])) == count(Several(vec![honest(), honest(), honest()])));
}

/// The same adapter twice stands for two.
#[test]
fn a_list_of_adapters_sweeps_to_the_same_bytes() {
    let Some([.., adapter]) = common::on_adapter() else { return };
    let folder = Folder::new();
    folder.edit("study.toml", "count = 2", "count = 200");
    let both = format!("{adapter},{adapter}");
    let sweep = |out: &str, more: &[&str]| {
        let (study, out) = (folder.path("study.toml"), folder.path(out));
        let outcome = perirobot(&[&["sweep", text(&study), "--out", text(&out)], more].concat());
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome
    };
    sweep("one", &["--adapter", adapter]);
    let told = [
        sweep("listed", &["--adapter", &both]),
        sweep("repeated", &["--adapter", adapter, "--adapter", adapter]),
    ];
    for (out, told) in ["listed", "repeated"].into_iter().zip(told) {
        for name in [JOURNAL, "poses.csv", "results.csv", "scores.csv"] {
            let read = |out: &str| fs::read(folder.path(out).join(name)).unwrap();
            assert!(read("one") == read(out), "{out}/{name}");
        }
        let [one, all] = ["one", out].map(|out| manifest(&folder.path(out)));
        let device = one["runs"][0]["device"].as_str().unwrap();
        assert_eq!(all["runs"][0]["device"], format!("{device}; {device}"));
        assert_eq!(all["fingerprint"], one["fingerprint"]);
        assert!(told.stdout.contains(&format!("on gpu: {device}; {device}")), "{}", told.stdout);
    }
}

#[test]
fn what_is_wrong_with_a_list_is_named() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    for (command, adapters, expected) in [
        ("sweep", "0,", "--adapter \"0,\": has an empty name: write numbers or parts of names"),
        ("sweep", "no such GPU,0", "no such GPU"),
        ("bench", "0,1", "--adapter: names 2 devices, and only a sweep shares its work among them: name one"),
        ("verify-backends", "0,1,2", "names 3 devices"),
    ] {
        let outcome = perirobot(&[command, text(&study), "--backend", "gpu", "--adapter", adapters]);
        assert_eq!(outcome.code, Some(2), "{command}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    }
}
