//! The stages of the job, by the same names on every backend: `load` a scene, `sense` (cast and carve) two
//! poses, `score` (fuse and count) them. `perirobot bench` measures whole jobs, as ratios to the oracle.
//!
//! `cargo bench` takes some minutes on the paper's first scene; `cargo bench -- sense/cpu` measures a part.
//! Under `cargo test` each runs once, on a small study.

use std::path::Path;
use std::time::Duration;

use criterion::Criterion;
use perirobot_march::backend::adapter::AdapterChoice;
use perirobot_march::backend::cpu::{Cpu, SimdLevel};
use perirobot_march::backend::factory::adapters;
use perirobot_march::backend::gpu::Gpu;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Fusion, Rays, Reading, Shot, VoxelScene};
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::{World, ray_tables};

/// One sensor of a study at two of its poses, in the first scene.
struct Job {
    name: String,
    rays: Rays,
    scene: VoxelScene,
    shots: Vec<Shot>,
}

fn job(study: &str, sensor: usize, voxel_size_m: f64) -> perirobot_march::Result<Job> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(study);
    let study = Study::load(&path, &Overrides { voxel_size_m: Some(voxel_size_m), noiseless: false })?;
    let world = World::prepare(&study, 0)?.remove(0);
    let rays = ray_tables(&study).swap_remove(sensor).expect("the benches' sensors cast rays");
    let poses = world.settings[sensor].len();
    let shots = (0..).zip([poses / 3, 2 * poses / 3]);
    let shots = shots.map(|(slot, pose)| Shot::once(slot, world.placement(&study, sensor, pose, 0)));
    Ok(Job {
        name: format!("{} {} cm", study.sensors[sensor].kind.name(), 100.0 * voxel_size_m),
        rays,
        shots: shots.collect(),
        scene: world.scene(window_of(&world.regions)),
    })
}

/// The oracle, the CPU on one thread as the oracle is, and the GPU if there is any.
fn backends() -> perirobot_march::Result<Vec<(&'static str, Box<dyn Backend>)>> {
    let mut all: Vec<(&str, Box<dyn Backend>)> = vec![
        ("oracle", Box::new(Oracle::default())),
        ("cpu without SIMD", Box::new(Cpu::new(Some(1))?.simd(SimdLevel::none()))),
        ("cpu", Box::new(Cpu::new(Some(1))?)),
    ];
    let found = adapters();
    let hardware = found.iter().any(|adapter| !adapter.software);
    if !found.is_empty() {
        let gpu = Gpu::new(if hardware { &AdapterChoice::Hardware } else { &AdapterChoice::Software })?;
        eprintln!("gpu: {}", gpu.device());
        all.push(("gpu", Box::new(gpu)));
    }
    Ok(all)
}

/// The three stages of a job on a backend.
fn stages(
    criterion: &mut Criterion,
    name: &str,
    backend: &mut dyn Backend,
    job: &Job,
) -> perirobot_march::Result<()> {
    let alone =
        |shot: &Shot| vec![Reading { slot: shot.slot, volume: None, hit: 847, miss: -405, presence: false }];
    let readings: Vec<_> = job.shots.iter().map(alone).collect();
    backend.tables(std::slice::from_ref(&job.rays))?;
    let id = |stage: &str| format!("{stage}/{name}/{}", job.name);
    let fine = "ran before, on the same scene";
    backend.load(&job.scene)?;
    criterion.bench_function(&id("load"), |b| b.iter(|| backend.load(&job.scene).expect(fine)));
    // What is sensed is scored, too, but once only, so that a device's work is over when the clock stops.
    let last = &readings[job.shots.len() - 1..];
    backend.sense(0, &job.shots)?;
    criterion.bench_function(&id("sense"), |b| {
        b.iter(|| {
            backend.sense(0, &job.shots).expect(fine);
            backend.score(Fusion::OccupiedWins, last).expect(fine)
        })
    });
    backend.score(Fusion::OccupiedWins, &readings)?;
    criterion.bench_function(&id("score"), |b| {
        b.iter(|| backend.score(Fusion::OccupiedWins, &readings).expect(fine))
    });
    Ok(())
}

fn main() -> perirobot_march::Result<()> {
    let measured = std::env::args().any(|argument| argument == "--bench");
    let jobs = if measured {
        let paper = ["paper/exp1.toml", "paper/lidar.toml"];
        let sizes_m = [0.05, 0.02];
        paper.iter().flat_map(|study| sizes_m.map(|size_m| job(study, 0, size_m))).collect()
    } else {
        [0, 1]
            .map(|sensor| job("tiny.toml", sensor, 0.1))
            .into_iter()
            .collect::<perirobot_march::Result<Vec<_>>>()
    }?;
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    for (name, mut backend) in backends()? {
        for job in &jobs {
            stages(&mut criterion, name, backend.as_mut(), job)?;
        }
    }
    criterion.final_summary();
    Ok(())
}
