//! A device that fails or lies while every pose is cast for `choose`: others step in, and the evidence is the
//! same; a lie is found before anything is searched.

use crate::common::program::Folder;
use crate::common::watch::Onlooker;
use perirobot_decide::choose::{Casting, MEMORY_BYTES, count_again, wanted_counts};
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::backend::{
    Backend, Evidence, Fusion, GridPose, Planes, Rays, Reading, Shot, Slot, StageTiming, VoxelScene,
};
use perirobot_march::metrics::{Across, Confusion, Score};
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::Failover;

/// A CPU that passes for a device: it fails when it is asked to cast for this time, or says too much.
struct Device {
    inner: Cpu,
    until_it_fails: usize,
    lies: bool,
}

impl Backend for Device {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        "Device".into()
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        self.inner.tables(tables)
    }

    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        self.inner.load(scene)
    }

    fn slots(&self) -> usize {
        // Few, so that there are many batches.
        self.inner.slots().min(4)
    }

    fn first_hit_slots(&self) -> usize {
        self.inner.first_hit_slots()
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        if self.until_it_fails == 0 {
            return Err(Error::device("adapter Device: is lost"));
        }
        self.until_it_fails -= 1;
        self.inner.sense(table, shots)
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        self.inner.upload(evidence)
    }

    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        self.inner.submit(fusion, jobs)
    }

    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>> {
        self.inner.receive()
    }

    fn timings(&self) -> Vec<StageTiming> {
        self.inner.timings()
    }

    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>> {
        let mut planes = self.inner.planes(slots)?;
        if self.lies {
            planes.iter_mut().for_each(|says| says.occupied = says.free.clone());
        }
        Ok(planes)
    }

    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence> {
        self.inner.read(table, placement)
    }
}

/// Devices that fail so soon: in full batches, and in small ones. And the CPU.
pub(super) struct Devices {
    pub(super) full: usize,
    pub(super) small: usize,
    pub(super) lie: bool,
}

impl BackendFactory for Devices {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        let inner = Cpu::new(Some(1))?;
        let until_it_fails = match fallback {
            Fallback::None => self.full,
            Fallback::Small => self.small,
            Fallback::Cpu => return Ok(Box::new(inner)),
        };
        Ok(Box::new(Device { inner, until_it_fails, lies: self.lie }))
    }

    fn needs_check(&self) -> bool {
        true
    }
}

/// The small study with noise, three times, and what is asked of it.
fn study() -> (Folder, Study, Vec<World>, Choose) {
    let folder = Folder::new();
    folder.edit("study.toml", "seed = 7", "seed = 7\nrepeats = 3\nmixed_noise = true");
    folder.edit(
        "study.toml",
        "range_m = [0.2, 3.0]",
        "range_m = [0.2, 3.0]\nnoise = { std_m = 0.05, per_m2 = 0.0 }",
    );
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let choose = Choose {
        objective: Score::F1,
        over: Across::Pooled,
        region: 0,
        at_most: 1,
        budget: None,
        apart_m: 0.0,
        disturb: None,
        always: Vec::new(),
        require: Vec::new(),
        representations: vec![0; study.sensors.len()],
        refine: false,
        fusion: Default::default(),
    };
    (folder, study, worlds, choose)
}

#[test]
fn what_a_device_does_not_cast_others_do() {
    let (_folder, study, worlds, choose) = study();
    let asked = wanted_counts(&choose);
    let begin =
        || Casting::begin(&study, &[asked], &choose.representations, &worlds, MEMORY_BYTES, None).unwrap();
    let (mut cpu, mut casting) = (Cpu::new(Some(1)).unwrap(), begin());
    casting.run(&mut cpu, &|| None).unwrap();
    let expected = casting.evidence().remove(0);
    let often = usize::MAX;
    for (full, small, instead) in [
        (often, often, &[][..]),
        (0, often, &["small"]),
        (3, often, &["small"]),
        (3, 2, &["CPU"]),
        (0, 0, &["CPU"]),
    ] {
        let (watch, mut devices) = (Onlooker::default(), Devices { full, small, lie: false });
        let mut casting = begin();
        casting.run_on(&mut Failover::new(&mut devices, &watch)).unwrap();
        let heard = watch.heard();
        assert_eq!(heard.finished, casting.total(), "each is taken once");
        let found = casting.evidence().remove(0);
        assert_eq!(heard.faults.len(), instead.len(), "{:?}", heard.faults);
        for (fault, instead) in heard.faults.iter().zip(instead) {
            assert!(fault.what.contains("is lost") && fault.instead.contains(instead), "{fault:?}");
        }
        for item in 0..expected.count() {
            assert_eq!(found.counts(&[item]), expected.counts(&[item]), "{full}, {small}: {item}");
        }
        let found_in = [(asked, &found)];
        let checked =
            count_again(&found_in, (&study, &worlds), &choose.representations, &mut cpu, 2).unwrap();
        assert_eq!(checked, 1 + found.count().div_ceil(2) as u64, "the first three, and one in two");
    }
}

#[test]
fn a_lie_is_found_before_anything_is_searched() {
    let (_folder, study, worlds, choose) = study();
    let often = usize::MAX;
    let mut devices = Devices { full: often, small: often, lie: true };
    let (asked, ways) = (wanted_counts(&choose), &choose.representations);
    let mut casting = Casting::begin(&study, &[asked], ways, &worlds, MEMORY_BYTES, None).unwrap();
    casting.run_on(&mut Failover::new(&mut devices, &|| None)).unwrap();
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let found = casting.evidence().remove(0);
    let told = count_again(&[(asked, &found)], (&study, &worlds), ways, &mut cpu, 500).unwrap_err();
    assert!(matches!(&told, Error::Disagreement(_)), "{told}");
    assert!(told.to_string().contains("disagree about camera:wall/0/0"), "{told}");
}
