//! Rows of results a second into the journal, as a sweep writes them, and then into each kind of table,
//! beside the rate at which the fastest sweep would make them, and the memory that it takes. The machine's
//! disk is part of what is measured: tables are synced before the clock stops.
//!
//! `cargo bench --bench rows` prints a table in Markdown, with a million rows and with four million, so that
//! memory that grows would be seen. Under `cargo test` it writes a few rows only.

use std::path::Path;
use std::time::Instant;

use perirobot_march::metrics::{BODY_PARTS, COUNTERS, Confusion, Detection};
use perirobot_sweep::results::journal::{JournalHeader, Locked, Shard};
use perirobot_sweep::results::rows::RowsFile;
use perirobot_sweep::results::table::TableFormat;

/// 20,000 poses a second, five representations, two regions.
const AIM_PER_S: f64 = 20_000.0 * 5.0 * 2.0;

const REPRESENTATIONS: [&str; 5] =
    ["points;volume", "rays;volume", "occupied;volume", "free;volume", "all;volume"];
const REGIONS: [&str; 2] = ["robot", "human"];

/// Counts below 2^17, as of a region of some hundred thousand voxels, without anything that repeats.
fn counts(row: u64) -> Confusion {
    // SplitMix64, so that no encoding finds the counts easier than those of poses.
    let counts: [u64; COUNTERS] = std::array::from_fn(|i| {
        let mut z = (row * 12 + i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) >> 47
    });
    // Two of eleven body parts are missed.
    let mut missed = [0; BODY_PARTS];
    missed[..2].fill(1);
    let detection = Detection {
        hit_human: counts[0],
        people: 1,
        people_detected: 1,
        parts: 11,
        parts_detected: 9,
        missed,
    };
    Confusion { detection, ..Confusion::from_counts(counts) }
}

/// Writes rows of results, and says how many seconds it took and how many bytes it made.
fn write(path: &Path, format: TableFormat, rows: u64) -> perirobot_march::Result<(f64, u64)> {
    let begin = Instant::now();
    let mut table = RowsFile::create(path, format)?;
    let mut poses = String::new();
    for row in 0..rows {
        let choice = row / 10;
        if row % 10 == 0 {
            poses = format!("camera:right-wall/{}/{};pads:floor/{}/0", choice / 16, choice % 16, choice % 7);
        }
        let representation = REPRESENTATIONS[(row % 10 / 2) as usize];
        let names = ["both", &poses, representation, REGIONS[(row % 2) as usize]];
        table.row("cell", [0, row as usize % 3], names, &counts(row))?;
    }
    table.finish()?;
    let bytes = std::fs::metadata(path).map(|file| file.len()).unwrap_or_default();
    Ok((begin.elapsed().as_secs_f64(), bytes))
}

/// Rows that a sweep hands to the journal at once: a batch of choices that follow each other.
const BATCH_ROWS: u64 = 4096;

/// Writes rows of one block into a journal, checksums and syncs included.
fn keep(folder: &Path, rows: u64) -> perirobot_march::Result<(f64, u64)> {
    let header = JournalHeader {
        fingerprint: [7; 32],
        shard: Shard::WHOLE,
        blocks: 1,
        block_rows: rows,
        kept: 0..rows,
    };
    let begin = Instant::now();
    let mut journal = Locked::open(folder)?.begin(header)?;
    for first in (0..rows).step_by(BATCH_ROWS as usize) {
        let batch: Vec<Confusion> = (first..rows.min(first + BATCH_ROWS)).map(counts).collect();
        journal.put(first, &batch)?;
    }
    journal.sync()?;
    let seconds = begin.elapsed().as_secs_f64();
    let bytes = std::fs::metadata(journal.path()).map(|file| file.len()).unwrap_or_default();
    Ok((seconds, bytes))
}

/// The most memory that the process has held so far, in MiB, where the system tells.
fn peak_mib() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = peak.and_then(|peak| peak.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    kib.map_or("?".into(), |kib| (kib >> 10).to_string())
}

fn main() -> perirobot_march::Result<()> {
    let measured = std::env::args().any(|argument| argument == "--bench");
    let sizes = if measured { [1_000_000, 4_000_000] } else { [1_000, 4_000] };
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("the target folder takes folders");
    let line = |what: &str, rows: u64, (seconds, bytes): (f64, u64)| {
        let per_s = rows as f64 / seconds;
        println!(
            "| {what} | {rows} | {per_s:.0} | {:.1} | {:.0} | {} |",
            per_s / AIM_PER_S,
            bytes as f64 / rows as f64,
            peak_mib()
        );
    };
    println!("| file | rows | rows/s | × {AIM_PER_S:.0} rows/s | bytes/row | peak memory so far, MiB |");
    println!("|---|---:|---:|---:|---:|---:|");
    for rows in sizes {
        line("journal", rows, keep(folder.path(), rows)?);
    }
    for format in [TableFormat::Csv, TableFormat::Parquet] {
        for rows in sizes {
            let path = folder.path().join("results").with_extension(format.extension());
            line(format.extension(), rows, write(&path, format, rows)?);
        }
    }
    Ok(())
}
