//! How long it takes to find the best sets and to prove that none is better: Experiment 1's 860 camera poses
//! at 5 cm, after their evidence was cast.
//!
//! `cargo bench --bench choose` prints a table in Markdown: for each size of a set its score, what no set is
//! above, and the seconds of search for it so far. A size that is not proven at first has two rows: one with the
//! bound that it then gets, one when no set is more than .002 above it, one at its end. A question is given up when the search of a size to its end takes
//! [`LONGEST`] seconds. Under `cargo test` a small study is searched once.

use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use perirobot_decide::choose::{MEMORY_BYTES, answer, cast_evidence, problem_of};
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::metrics::{Across, Score};
use perirobot_march::progress::{Progress, SearchState};
use perirobot_study::input::{Choose, Overrides, Study};
use perirobot_study::world::World;

/// Seconds after which a size is given up.
const LONGEST: f64 = 150.0;

/// What is asked of one evidence: scores, of which counts, and sets of how many sensors.
type Questions = &'static [(Score, Across, usize)];

/// Each evidence by its name, with how many scenes, the region, and whether sensors measure with noise.
const MEASURED: &[(&str, usize, usize, bool, Questions)] = &[
    (
        "scene 1, robot",
        1,
        0,
        false,
        &[
            (Score::F1, Across::Pooled, 6),
            (Score::Kappa, Across::Pooled, 5),
            (Score::HumanSeen, Across::Pooled, 6),
        ],
    ),
    ("scene 1, human", 1, 1, false, &[(Score::F1, Across::Pooled, 5)]),
    (
        "three scenes, robot",
        3,
        0,
        false,
        &[(Score::F1, Across::Pooled, 5), (Score::F1, Across::Worst, 4), (Score::F1, Across::Mean, 4)],
    ),
    ("scene 1, robot, with noise", 1, 0, true, &[(Score::F1, Across::Pooled, 4)]),
];

/// Prints what is known of each size, and when the last of them was begun.
struct Clock {
    question: String,
    begun: Mutex<Instant>,
}

impl Progress for Clock {
    fn stop_reason(&self) -> Option<String> {
        let seconds = self.begun.lock().expect("no thread panics here").elapsed().as_secs_f64();
        (seconds > LONGEST).then(|| "too long".into())
    }

    fn show_search(&self, state: &SearchState) {
        let SearchState { at_most: size, best, bound, seconds: Some(seconds), .. } = *state else { return };
        let bound = match bound {
            Some(_) if bound == best => "proven".into(),
            bound => bound.map_or("no bound".into(), |bound| format!("{bound:.4}")),
        };
        let (question, best) = (&self.question, best.unwrap_or(f64::NAN));
        println!("| {question} | {size} | {best:.4} | {bound} | {seconds:.2} |");
        *self.begun.lock().expect("no thread panics here") = Instant::now();
    }
}

fn measure(
    (study, worlds): (&Study, &[World]),
    name: &str,
    region: usize,
    questions: &[(Score, Across, usize)],
) -> perirobot_march::Result<()> {
    let representations = vec![0; study.sensors.len()];
    let (begin, mut cpu) = (Instant::now(), Cpu::new(Some(2))?);
    let evidence =
        cast_evidence(study, worlds, (region, &representations), MEMORY_BYTES, &mut cpu, &|| None)?;
    println!("\n{name}: {} poses cast in {:.1} s", evidence.count(), begin.elapsed().as_secs_f64());
    println!("\n| score | sensors | best | no set is above | s |\n|---|---:|---:|---:|---:|");
    for &(objective, over, at_most) in questions {
        let choose = Choose {
            objective,
            over,
            region,
            at_most,
            budget: None,
            apart_m: 0.0,
            disturb: None,
            always: Vec::new(),
            require: Vec::new(),
            representations: representations.clone(),
            refine: false,
            fusion: Default::default(),
        };
        let problem = problem_of(study, &choose, worlds, &evidence);
        let question = format!("{objective:?} {over:?}");
        answer(&problem, &Clock { question, begun: Mutex::new(Instant::now()) })?;
    }
    Ok(())
}

fn main() -> perirobot_march::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if !std::env::args().any(|argument| argument == "--bench") {
        let study = Study::load(&root.join("scenes/tiny.toml"), &Overrides::default())?;
        let worlds = World::prepare_all(&study)?;
        return measure((&study, &worlds), "tiny", 0, &[(Score::F1, Across::Pooled, 3)]);
    }
    for &(name, scenes, region, noisy, questions) in MEASURED {
        let overrides = Overrides { voxel_size_m: None, noiseless: !noisy };
        let mut study = Study::load(&root.join("scenes/paper/exp1.toml"), &overrides)?;
        study.sensors.truncate(1);
        study.combinations.clear();
        let mut worlds = World::prepare_all(&study)?;
        worlds.truncate(scenes);
        measure((&study, &worlds), name, region, questions)?;
    }
    Ok(())
}
