//! The section on the run: study, cell, sensors, devices and faults; and the assumptions.

use maud::{Markup, html};

use crate::report::page::device::keys_of;
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::{ReportedSweep, now};
use crate::report::table::{NONE, Table};
use perirobot_march::SEMANTICS_VERSION;
use perirobot_march::backend::Fusion;
use perirobot_march::progress::Fault;
use perirobot_scene::shell;
use perirobot_study::sensor::SaidOfNoise;

/// The run and its assumptions.
pub(super) struct Run {
    /// Name and value.
    lines: Vec<(&'static str, String)>,
    tables: Vec<Titled>,
    /// A sentence each.
    assumed: Vec<String>,
}

impl Run {
    pub(super) fn new(sweep: &ReportedSweep) -> Run {
        let (study, manifest) = (sweep.study, sweep.manifest);
        let about = &manifest.provenance.about;
        let lines = vec![
            ("study", study.path.display().to_string()),
            ("command", shell::command(&about.command)),
            ("voxel size", format!("{} m", study.voxel_size_m)),
            ("seed", study.seed.to_string()),
            ("repeats", study.repeats.to_string()),
            ("swept by", format!("perirobot {}", about.perirobot)),
            ("rules of counting", format!("version {}", manifest.identity.semantics_version)),
            ("report by", format!("perirobot {} (rules {SEMANTICS_VERSION})", env!("CARGO_PKG_VERSION"))),
            ("fingerprint", manifest.provenance.fingerprint.clone()),
            ("written", now("%Y-%m-%d, %H:%M UTC")),
        ];
        let tables = vec![scenes(sweep), sensors(sweep), combinations(sweep), runs(sweep)];
        Run { lines, tables, assumed: assumptions(sweep) }
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #run {
                h2 { "What was run, and what was assumed?" }
                div #assumed {
                    h3 { "What was assumed" }
                    p {
                        "Scores come from a model of the cell, voxel by voxel. They show which placements are worth trying, \
                         not that a cell is safe. The model knows rays with Gaussian noise, returns lost by chance, mounts \
                         that are as far off as the study says, still snapshots, and the geometry it was given: no \
                         reflections, no motion blur, no other error of a calibration, and no failing sensor but where a verdict says so, which is known and silent then. Check the chosen \
                         placement on the real cell, by the standards that apply there."
                    }
                    ul { @for sentence in &self.assumed { li { (sentence) } } }
                }
                h3 { "What was run" }
                table.lines {
                    @for (name, value) in &self.lines { tr { th scope="row" { (name) } td { (value) } } }
                }
                @for table in &self.tables { (plain(table)) }
            }
        }
    }
}

fn titled(title: &str, columns: &[&str], rows: impl Iterator<Item = Vec<String>>) -> Titled {
    let mut table = Table::new(columns);
    rows.for_each(|row| table.row(row));
    (title.into(), table)
}

fn scenes(sweep: &ReportedSweep) -> Titled {
    let rows = sweep.results.scenes.iter().zip(&sweep.study.scenes).map(|(scene, spec)| {
        let world = &sweep.worlds[scene.moments.start];
        let truth = &world.truth();
        let [x, y, z] = truth.grid.size;
        let objects = truth.objects.iter().map(|object| object.name.as_str());
        vec![
            scene.name.clone(),
            spec.path.display().to_string(),
            scene.moments.len().to_string(),
            format!("{x} × {y} × {z}"),
            truth.occupied.count().to_string(),
            objects.collect::<Vec<_>>().join(", "),
        ]
    });
    let columns = ["scene", "file", "snapshots", "voxels", "occupied", "objects"];
    titled("Cell", &columns, rows)
}

fn sensors(sweep: &ReportedSweep) -> Titled {
    let rows = sweep.manifest.identity.sensors.iter().map(|sensor| {
        vec![
            sensor.name.clone(),
            sensor.kind.clone(),
            sensor.poses.to_string(),
            sensor.rays_per_pose.to_string(),
            sensor.representations.join(", "),
            keys_of(sweep.study, &sensor.name),
        ]
    });
    let columns = ["sensor", "kind", "poses", "rays a pose", "representations", "as the study says"];
    titled("Sensors", &columns, rows)
}

fn combinations(sweep: &ReportedSweep) -> Titled {
    let pairs = sweep.results.combinations.iter().zip(&sweep.study.combinations);
    let rows = pairs.map(|(found, asked)| {
        let sensors = found.members.iter().map(|member| member.sensor.as_str());
        let fusion = serde_json::to_value(asked.fusion).unwrap_or_default();
        vec![
            found.name.clone(),
            sensors.collect::<Vec<_>>().join(", "),
            fusion.as_str().unwrap_or_default().to_string(),
            found.choices().to_string(),
        ]
    });
    titled("Combinations", &["combination", "sensors", "fusion", "choices of poses"], rows)
}

fn runs(sweep: &ReportedSweep) -> Titled {
    let rows = sweep.manifest.provenance.runs.iter().map(|run| {
        let count = |count: Option<u64>| count.map_or(NONE.into(), |count| count.to_string());
        let faults = run
            .faults
            .iter()
            .flatten()
            .map(|Fault { what, scene, instead }| format!("{what} (scene {scene}; instead: {instead})"));
        let faults = faults.collect::<Vec<_>>().join("; ");
        vec![
            format!("{}, {}", run.backend, run.device),
            count(run.poses),
            run.sweep_s.map_or(NONE.into(), |seconds| format!("{seconds:.1}")),
            count(run.verified),
            run.ended.clone(),
            if faults.is_empty() { "none".into() } else { faults },
        ]
    });
    let columns = ["adapter", "poses scored", "seconds", "poses checked on the CPU", "ended", "faults"];
    titled("Runs", &columns, rows)
}

/// Assumptions that may surprise a reader, a sentence each.
fn assumptions(sweep: &ReportedSweep) -> Vec<String> {
    let (study, results) = (sweep.study, sweep.results);
    let mut assumed = vec![format!(
        "Space is cut into voxels of {} m: nothing smaller is told apart, and scores at other sizes are not comparable.",
        study.voxel_size_m
    )];
    assumed.push(match (study.noiseless, study.repeats) {
        (true, _) => "Sensors measure without noise, lose no returns and have no mounting error, overriding the study.".into(),
        (false, 1) => {
            "Every pose was scored once; for a sensor with noise, another draw gives a slightly different score."
                .into()
        }
        (false, n) => format!("Every pose was scored {n} times with other noise; scores are means."),
    });
    let unknown = study.sensors.iter().filter(|sensor| sensor.noise == SaidOfNoise::Unknown);
    assumed.extend(
        unknown.map(|sensor| {
            format!("The noise of {:?} is unknown: it measures as if it had none.", sensor.name)
        }),
    );
    if study.backdrop {
        assumed.push(
            "A ray that leaves the grid returns from just outside: the voxels before count as free.".into(),
        );
    }
    let (scenes, moments) = (results.scenes.len(), results.moments().len());
    let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    assumed.push(format!(
        "The cell was sampled in {}, {}, and is static in each: nothing moves while sensors measure, and other moments \
         are not covered.",
        counted(scenes, "scene"),
        counted(moments, "snapshot")
    ));
    assumed.extend(see_through(sweep));
    assumed.extend(fusion(sweep));
    assumed.push(format!(
        "A body part is detected where at least {} of its voxels are hit (min_hits).",
        study.min_hits
    ));
    assumed.extend(study.stopping.iter().flat_map(|stopping| stopping.assumptions(study.voxel_size_m)));
    assumed
        .extend(warnings(sweep).into_iter().map(|(what, scenes)| format!("{}: {what}", scenes.join(", "))));
    assumed
}

/// The objects that rays pass.
fn see_through(sweep: &ReportedSweep) -> Option<String> {
    let mut names: Vec<String> = Vec::new();
    for world in sweep.worlds {
        for object in world.truth().objects.iter().filter(|object| !object.stops_rays) {
            if !names.contains(&object.name) {
                names.push(object.name.clone());
            }
        }
    }
    match names.is_empty() {
        true => Some("Nothing is see-through: rays end on every object.".into()),
        false => Some(format!("Rays pass, and end behind them: {}.", names.join(", "))),
    }
}

/// How the evidence of several sensors is fused into one label.
fn fusion(sweep: &ReportedSweep) -> Vec<String> {
    let several = sweep.study.combinations.iter().filter(|one| one.members.len() > 1);
    let mut rules: Vec<Fusion> = Vec::new();
    several.for_each(|one| {
        if !rules.contains(&one.fusion) {
            rules.push(one.fusion);
        }
    });
    let words = |fusion: &Fusion| match fusion {
        Fusion::OccupiedWins => "If several sensors label a voxel, occupied wins.",
        Fusion::Octomap => {
            "If several sensors label a voxel, their log-odds are added: contradictions may cancel."
        }
    };
    rules.iter().map(|rule| words(rule).to_string()).collect()
}

/// Warnings of the scenes, each once, with its scenes.
fn warnings<'a>(sweep: &ReportedSweep<'a>) -> Vec<(&'a str, Vec<&'a str>)> {
    let mut all: Vec<(&str, Vec<&str>)> = Vec::new();
    for world in sweep.worlds {
        for warning in &world.warnings {
            match all.iter_mut().find(|(known, _)| known == warning) {
                Some((_, scenes)) => scenes.push(&world.name),
                None => all.push((warning, vec![&world.name])),
            }
        }
    }
    all
}
