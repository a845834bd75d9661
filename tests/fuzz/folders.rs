//! What a stranger, a copy that was cut short or a broken disk may leave in the folder of a sweep:
//! `counts.journal` and `manifest.json`. The folder is then summarised, merged and gone on with, through the
//! same doors as the program's.

use std::fs;
use std::path::PathBuf;

use perirobot_march::metrics::{Confusion, Score};
use perirobot_page::report::ReportSelection;
use perirobot_page::report::terminal::{best, distribution, groups, maxima, moving_scenes};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::files::{JOURNAL, MANIFEST};
use perirobot_sweep::results::journal::{Journal, JournalHeader, Locked, Shard};
use perirobot_sweep::results::manifest::{Identity, Manifest};
use perirobot_sweep::results::merge::merge;
use perirobot_sweep::results::table::TableFormat;
use perirobot_sweep::results::{Folder, Results, rows, scores};
use perirobot_sweep::scoring::session::Session;
use serde_json::Value;
use sha2::{Digest, Sha256};
use tempfile::TempDir;

/// A sweep of twelve rows: two repeats, three poses, two regions.
const STUDY: &str = r#"
seed = 1
repeats = 2
[grid]
voxel_size_m = 0.1
[[scene]]
file = "cell.toml"
[[region]]
name = "low"
box = { min_m = [-0.5, -0.5, 0], max_m = [0.5, 0.5, 0.5] }
[[region]]
name = "high"
box = { min_m = [-0.5, -0.5, 0.5], max_m = [0.5, 0.5, 1] }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [40, 30]
resolution_px = [2, 2]
range_m = [0.1, 2]
noise = { std_m = 0.01 }
[[sensor.poses]]
name = "wall"
x_m = [-0.2, 0, 0.2]
y_m = 0
z_m = 0.9
facing = [0, 0, -1]
"#;
const CELL: &str = r#"
interior = "free"
[[object]]
name = "room"
room = { size_m = [1, 1, 1] }
position_m = [0, 0, 0.5]
[[object]]
name = "somebody"
role = "human"
sphere = { radius_m = 0.2 }
position_m = [0, 0, 0.3]
"#;
/// Sizes in the journal's bytes.
const HEADER_BYTES: usize = 128;
const RECORD_BYTES: usize = 88;
const CHECK_BYTES: usize = 8;
/// How a journal is mended before it is written, by the bits of its input's first byte: chance does not find
/// checksums.
const OF_THIS_SWEEP: u8 = 1;
const HEADER_IS_CHECKED: u8 = 2;
const RECORDS_ARE_CHECKED: u8 = 4;
const COUNTS_ADD_UP: u8 = 8;
/// Most rows that are written for a manifest.
const MOST_ROWS: u64 = 64;

/// The sweep that a journal is taken for, and its folders: `out` for hostile files, `second` for a shard as
/// it should be, `whole` for what is merged.
struct Sweep {
    root: TempDir,
    study: Study,
    worlds: Vec<World>,
    fingerprint: [u8; 32],
    /// Voxels of each region.
    voxels: Vec<u64>,
}

thread_local! {
    static SWEEP: Sweep = Sweep::new();
}

/// A journal, beside the manifest and the poses of the sweep that it may be of. The first byte says how it is
/// mended.
pub fn journal(bytes: &[u8]) {
    let Some((mend, file)) = bytes.split_first() else { return };
    SWEEP.with(|sweep| {
        let path = sweep.path("out").join(JOURNAL);
        fs::write(path, sweep.mended(*mend, file.to_vec())).expect("a folder that can be written to");
        sweep.read_all();
    });
}

/// A manifest, with the table of poses below it. The hash of the table is put in, and a journal of such a
/// sweep is put beside it, with rows if they are few.
pub fn manifest(bytes: &[u8]) {
    let [manifest, poses] = super::entries::parted(bytes);
    SWEEP.with(|sweep| {
        let out = sweep.path("out");
        let write = |name, bytes: &[u8]| fs::write(out.join(name), bytes).expect("a folder to write to");
        write("poses.csv", poses);
        write(MANIFEST, &with_hash(manifest, poses).unwrap_or_else(|| manifest.to_vec()));
        if let Some(header) = Manifest::read(&out).ok().as_ref().and_then(header_of) {
            let locked = Locked::open(&out).expect("a folder that nobody else uses");
            drop(locked.begin(header).expect("a folder that can be written to"));
            if let Ok(folder) = Folder::open(&out) {
                fill(folder);
            }
        }
        sweep.read_all();
    });
}

impl Sweep {
    fn new() -> Sweep {
        let root = tempfile::tempdir().expect("a folder for temporary files");
        fs::write(root.path().join("study.toml"), STUDY).expect("a folder that can be written to");
        fs::write(root.path().join("cell.toml"), CELL).expect("a folder that can be written to");
        let study = Study::load(&root.path().join("study.toml"), &Overrides::default());
        let study = study.expect("a study without mistakes");
        let worlds = World::prepare_all(&study).expect("scenes without mistakes");
        let fingerprint = Manifest::new(&study, &worlds, Shard::WHOLE, &[]).fingerprint();
        let voxels = worlds[0].regions.iter().map(|region| region.voxels.count()).collect();
        let sweep = Sweep { root, study, worlds, fingerprint, voxels };
        sweep.open("out", Shard::WHOLE);
        sweep.open("second", Shard { number: 1, of: 2 });
        fill(Folder::open(&sweep.path("second")).expect("a folder that was just made"));
        sweep
    }

    fn path(&self, folder: &str) -> PathBuf {
        self.root.path().join(folder)
    }

    /// Takes up what is in a folder, and lets it be.
    fn open(&self, folder: &str, shard: Shard) {
        drop(Session::open(
            &self.study,
            &self.worlds,
            &self.path(folder),
            shard,
            false,
            &["perirobot".into()],
        ));
    }

    /// Everything that reads the folder `out`, what changes it last.
    fn read_all(&self) {
        let [out, second, whole] = ["out", "second", "whole"].map(|folder| self.path(folder));
        if let Ok((results, _)) = Results::read(&out) {
            report(&results, &out);
        }
        let of_two = Journal::read(&out).is_ok_and(|journal| journal.header().shard.of == 2);
        let (shards, shard) = match of_two {
            true => (vec![second, out], Shard { number: 0, of: 2 }),
            false => (vec![out], Shard::WHOLE),
        };
        // What it holds of another sweep would be refused.
        let _ = fs::remove_dir_all(&whole);
        let _ = merge(&whole, &shards);
        self.open("out", shard);
    }

    /// A journal after what the bits say is done to it.
    fn mended(&self, mend: u8, mut file: Vec<u8>) -> Vec<u8> {
        let Some((header, records)) = file.split_at_mut_checked(HEADER_BYTES) else { return file };
        if mend & OF_THIS_SWEEP != 0 {
            header[52..84].copy_from_slice(&self.fingerprint);
        }
        if mend & HEADER_IS_CHECKED != 0 {
            check(&[], header);
        }
        for record in records.chunks_exact_mut(RECORD_BYTES) {
            if mend & COUNTS_ADD_UP != 0 {
                self.add_up(record);
            }
            if mend & RECORDS_ARE_CHECKED != 0 {
                check(&header[52..84], record);
            }
        }
        file
    }

    /// Changes the last of the six counts of all voxels, so that they are as many as their region has.
    fn add_up(&self, record: &mut [u8]) {
        let (row, counts) = record.split_at_mut(8);
        let region = u64::from_le_bytes(row.try_into().expect("eight bytes")) % self.voxels.len() as u64;
        let count = |bytes: &[u8]| u64::from(u32::from_le_bytes(bytes.try_into().expect("four bytes")));
        let others: u64 = counts[..20].chunks_exact(4).map(count).sum();
        if let Some(last) = self.voxels[region as usize].checked_sub(others) {
            counts[20..24].copy_from_slice(&(last as u32).to_le_bytes());
        }
    }
}

/// Sets the checksum at the end of some bytes.
fn check(before: &[u8], bytes: &mut [u8]) {
    let (body, sum) = bytes.split_at_mut(bytes.len() - CHECK_BYTES);
    sum.copy_from_slice(&Sha256::digest([before, body].concat())[..CHECK_BYTES]);
}

/// All that is made of results.
fn report(results: &Results, folder: &std::path::Path) {
    let selection = ReportSelection::resolve(results, None, None, &Score::ALL).expect("nothing is named");
    for render in [distribution::render, maxima::render, groups::render, moving_scenes::render] {
        render(results, &selection).expect("what was scanned can be read again");
    }
    best::render(results).expect("what was scanned can be read again");
    let _ = rows::write(results, folder, TableFormat::Csv);
    let _ = scores::write(results, folder, TableFormat::Csv);
    let _ = scores::write(results, folder, TableFormat::Parquet);
}

/// A manifest that has the hash of its poses, if it is JSON that wants one.
fn with_hash(manifest: &[u8], poses: &[u8]) -> Option<Vec<u8>> {
    let mut value: Value = serde_json::from_slice(manifest).ok()?;
    let hash: String = Sha256::digest(poses).iter().map(|byte| format!("{byte:02x}")).collect();
    *value.get_mut("poses_sha256")? = hash.into();
    serde_json::to_vec(&value).ok()
}

/// The header of the journal of a whole sweep with this manifest.
fn header_of(manifest: &Manifest) -> Option<JournalHeader> {
    let Identity { sensors, scenes, combinations, repeats, .. } = &manifest.identity;
    let ways = |name: &String| {
        let sensor = sensors.iter().find(|sensor| sensor.name == *name)?;
        Some(sensor.representations.len() as u64)
    };
    let length = |[first, end]: &[usize; 2]| end.checked_sub(*first).map(|length| length as u64);
    let regions = scenes.first()?.regions.len() as u64;
    let mut block_rows = 0u64;
    for combination in combinations {
        let mut rows = regions;
        for (name, ranges) in combination.sensors.iter().zip(&combination.poses) {
            let poses = ranges.iter().try_fold(0u64, |sum, range| sum.checked_add(length(range)?))?;
            rows = rows.checked_mul(poses)?.checked_mul(ways(name)?)?;
        }
        block_rows = block_rows.checked_add(rows)?;
    }
    let blocks = (*repeats as u64).checked_mul(scenes.len() as u64)?;
    let (fingerprint, kept) = (manifest.fingerprint(), 0..block_rows);
    Some(JournalHeader { fingerprint, shard: Shard::WHOLE, blocks, block_rows, kept })
}

/// Gives a folder all rows that its journal keeps, if they are few: nothing is seen.
fn fill(folder: Folder) {
    let Folder { subject, journal, .. } = folder;
    let header = journal.header().clone();
    let path = journal.path().parent().expect("a file in a folder").to_path_buf();
    drop(journal);
    if header.rows() > MOST_ROWS {
        return;
    }
    let mut journal = Locked::open(&path).expect("a folder that nobody else uses").go_on(header.clone());
    for block in 0..header.blocks {
        let baselines = &subject.baselines[block as usize / subject.repeats];
        let counts = |row: u64| -> Confusion {
            baselines[(row % header.block_rows) as usize % baselines.len()].nothing_seen
        };
        let rows = header.rows_of_block(block);
        journal.put(rows.start, &rows.map(counts).collect::<Vec<_>>()).expect("a file to write to");
    }
}
