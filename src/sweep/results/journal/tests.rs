//! A journal keeps its rows, refuses damaged ones, and does not depend on their order.

use std::fs;
use std::path::Path;

use super::*;
use perirobot_march::metrics::{BODY_PARTS, Detection, Overlap};

/// Three blocks of ten rows, with rows 2 to 7 in this file.
fn header() -> JournalHeader {
    JournalHeader {
        fingerprint: std::array::from_fn(|i| i as u8),
        shard: Shard { number: 1, of: 3 },
        blocks: 3,
        block_rows: 10,
        kept: 2..8,
    }
}

/// Counts that encode their row.
fn counts(row: u64) -> Confusion {
    let labels = Confusion::from_counts(std::array::from_fn(|i| 100 * row + i as u64));
    let found = std::array::from_fn(|i| 100 * row + 50 + i as u64);
    let overlap = Overlap { twice: 100 * row + 60, hit_human_twice: 100 * row + 61 };
    labels.with_detection(Detection::from_counts(found, row as u32 % (1 << BODY_PARTS))).with_overlap(overlap)
}

#[cfg(target_os = "linux")]
#[test]
fn a_lock_that_fails_for_a_moment_is_no_bad_input() {
    let [enospc, enolck, eopnotsupp, enosys, erofs] = [28, 37, 95, 38, 30];
    for (number, passes) in
        [(enospc, true), (enolck, true), (eopnotsupp, false), (enosys, false), (erofs, false)]
    {
        let source = std::io::Error::from_raw_os_error(number);
        let error = cannot_lock(Path::new("counts.journal"), &source);
        let is_right = match error {
            Error::Input(_) => !passes,
            Error::Storage(_) => passes,
            _ => false,
        };
        let message = error.to_string();
        let begins = message.starts_with("counts.journal: cannot be locked: ");
        assert!(is_right && begins && message.contains("folder on another file system"), "{message}");
    }
}

fn begin(folder: &Path) -> Journal {
    Locked::open(folder).unwrap().begin(header()).unwrap()
}

/// All rows of a journal, and the number of damaged places.
fn all(journal: &Journal) -> (Vec<u64>, u64) {
    let mut rows = Vec::new();
    let damaged = journal.scan(|row, found| {
        assert_eq!(found, counts(row), "row {row}");
        rows.push(row);
        Ok(())
    });
    (rows, damaged.unwrap())
}

fn flip(folder: &Path, at: usize) {
    let path = folder.join(JOURNAL);
    let mut bytes = fs::read(&path).unwrap();
    bytes[at] ^= 4;
    fs::write(&path, bytes).unwrap();
}

/// The checksums equal those of `hashlib.sha256` over the documented bytes, independent of the crate that computes
/// them.
#[test]
fn the_bytes_of_a_journal_are_those_of_every_version() {
    let bytes = header().bytes();
    assert_eq!(perirobot_scene::source::hex(&bytes[..20]), "506552536a726e6c030000000100000003000000");
    assert_eq!(perirobot_scene::source::hex(&bytes[HEADER_BYTES - 8..]), "eb7acc896b8771da");
    let record = header().record(13, &counts(13));
    let words: Vec<u32> =
        record[8..88].chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(
        words,
        [&(1300..1312).collect::<Vec<u32>>()[..], &[1350, 1351, 1352, 1353, 1354, 13, 1360, 1361]].concat()
    );
    assert_eq!(perirobot_scene::source::hex(&record[RECORD_BYTES - 8..]), "83818789daf3aca5");
}

#[test]
fn order_leaves_no_trace() {
    let [one, other] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let mut journal = begin(one.path());
    for block in 0..3 {
        let rows = header().rows_of_block(block);
        journal.put(rows.start, &rows.map(counts).collect::<Vec<_>>()).unwrap();
    }
    assert_eq!(all(&journal).0, [2, 3, 4, 5, 6, 7, 12, 13, 14, 15, 16, 17, 22, 23, 24, 25, 26, 27]);
    drop(journal);
    let mut journal = begin(other.path());
    for row in [27, 12, 4, 5, 26, 25, 2, 3, 16, 17, 15, 6, 7, 22, 23, 24, 13, 14, 14] {
        journal.put(row, &[counts(row)]).unwrap();
    }
    drop(journal);
    let [a, b] = [&one, &other].map(|folder| fs::read(folder.path().join(JOURNAL)).unwrap());
    assert!(a == b);
    assert_eq!(a.len(), HEADER_BYTES + 18 * RECORD_BYTES);
}

#[test]
fn what_was_finished_is_there_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = begin(folder.path());
    journal.put(13, &[counts(13), counts(14)]).unwrap();
    journal.put(3, &[counts(3)]).unwrap();
    drop(journal);
    let locked = Locked::open(folder.path()).unwrap();
    assert_eq!(*locked.header.as_ref().unwrap(), Some(header()));
    let journal = locked.go_on(header());
    assert_eq!(all(&journal), (vec![3, 13, 14], 0));
    assert!(journal.counts(12..14).unwrap_err().to_string().contains("row 12 is missing now"));
    assert_eq!(journal.counts(13..15).unwrap(), [counts(13), counts(14)]);
    // After a restart it is empty.
    drop(journal);
    assert_eq!(all(&begin(folder.path())), (vec![], 0));
}

#[test]
fn torn_and_foreign_rows_are_not_finished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(JOURNAL);
    let mut journal = begin(folder.path());
    journal.put(2, &[counts(2), counts(3), counts(4)]).unwrap();
    drop(journal);
    let whole = fs::read(&path).unwrap();
    // Torn within the last record.
    for cut in [1, 8, 40, 63] {
        fs::write(&path, &whole[..whole.len() - cut]).unwrap();
        assert_eq!(all(&Locked::open(folder.path()).unwrap().go_on(header())), (vec![2, 3], 1), "{cut}");
    }
    fs::write(&path, &whole[..whole.len() - RECORD_BYTES]).unwrap();
    assert_eq!(all(&Locked::open(folder.path()).unwrap().go_on(header())), (vec![2, 3], 0));
    // Every bit of a record matters.
    for at in 0..RECORD_BYTES {
        fs::write(&path, &whole).unwrap();
        flip(folder.path(), HEADER_BYTES + RECORD_BYTES + at);
        let journal = Locked::open(folder.path()).unwrap().go_on(header());
        assert_eq!(all(&journal), (vec![2, 4], 1), "byte {at}");
    }
    // A good record at another row's place, and the rows of another sweep.
    let mut moved = whole.clone();
    moved.copy_within(HEADER_BYTES..HEADER_BYTES + RECORD_BYTES, HEADER_BYTES + RECORD_BYTES);
    fs::write(&path, &moved).unwrap();
    assert_eq!(all(&Locked::open(folder.path()).unwrap().go_on(header())), (vec![2, 4], 1));
    fs::write(&path, &whole).unwrap();
    let other = JournalHeader { fingerprint: [9; 32], ..header() };
    assert_eq!(all(&Locked::open(folder.path()).unwrap().go_on(other)), (vec![], 3));
}

#[test]
fn a_damaged_beginning_is_refused_and_a_missing_one_is_new() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(JOURNAL);
    drop(begin(folder.path()));
    let whole = fs::read(&path).unwrap();
    for at in 0..HEADER_BYTES {
        fs::write(&path, &whole).unwrap();
        flip(folder.path(), at);
        let error = Locked::open(folder.path()).unwrap().header.unwrap_err().to_string();
        let expected = match at {
            0..8 => "is not a journal",
            8..12 => "is a journal of format",
            _ => "has a damaged beginning",
        };
        assert!(error.contains(expected), "byte {at}: {error}");
    }
    for length in [0, 1, HEADER_BYTES - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(matches!(Locked::open(folder.path()).unwrap().header, Ok(None)), "{length}");
    }
}

#[test]
fn a_short_file_takes_a_short_time_whatever_it_promises() {
    let folder = tempfile::tempdir().unwrap();
    let header = JournalHeader { blocks: 1 << 50, ..header() };
    let mut journal = Locked::open(folder.path()).unwrap().begin(header.clone()).unwrap();
    journal.put(22, &[counts(22), counts(23)]).unwrap();
    assert_eq!(all(&journal), (vec![22, 23], 0));
    // A torn record is damage, wherever the file ends.
    let path = folder.path().join(JOURNAL);
    let length = fs::metadata(&path).unwrap().len();
    fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(length - 1).unwrap();
    assert_eq!(all(&journal), (vec![22], 1));
}

#[cfg(unix)]
#[test]
fn what_a_link_leads_to_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let precious = folder.path().join("precious");
    fs::write(&precious, "short").unwrap();
    std::os::unix::fs::symlink(&precious, folder.path().join(JOURNAL)).unwrap();
    let error = Locked::open(folder.path()).map(drop).unwrap_err().to_string();
    assert!(error.contains("counts.journal: is not a regular file"), "{error}");
    assert_eq!(fs::read(&precious).unwrap(), b"short");
}

/// A second name represents a copy made of links: a snapshot of the folder.
#[test]
fn a_journal_with_two_names_is_not_written_to() {
    let folder = tempfile::tempdir().unwrap();
    drop(begin(folder.path()));
    let (path, copy) = (folder.path().join(JOURNAL), folder.path().join("copy"));
    fs::hard_link(&path, &copy).unwrap();
    let error = Locked::open(folder.path()).map(drop).unwrap_err().to_string();
    assert!(error.contains("counts.journal: has 2 names (hard links)"), "{error}");
    Journal::read(folder.path()).unwrap();
    fs::remove_file(&copy).unwrap();
    Locked::open(folder.path()).unwrap();
}

/// Reading the start of a process's memory is an input/output error.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fails_is_no_damage() {
    let path = Path::new("/proc/self/mem");
    let error = read_header(path, &File::open(path).unwrap()).unwrap_err();
    assert!(
        matches!(&error, Error::Storage(what) if what.to_string().starts_with("/proc/self/mem: cannot be read")),
        "{error}"
    );
}

/// For a file that is long enough, so that the read itself fails.
#[cfg(target_os = "linux")]
#[test]
fn rows_that_cannot_be_read_are_neither_missing_nor_zero() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = begin(folder.path());
    journal.put(2, &[counts(2), counts(3)]).unwrap();
    journal.break_disk();
    let mut pages = Pages::new(vec![begin(tempfile::tempdir().unwrap().path())]);
    pages.break_disk();
    for error in [journal.states(2..4).map(drop), journal.counts(2..4).map(drop), pages.counts(2).map(drop)] {
        let error = error.unwrap_err();
        assert!(
            matches!(&error, Error::Storage(what) if what.to_string().contains("counts.journal: cannot be read")),
            "{error}"
        );
    }
}

#[test]
fn headers_that_cannot_be_are_damaged() {
    let good = header();
    assert_eq!(JournalHeader::parse(&good.bytes()), Ok(good.clone()));
    let shard = |number, of| JournalHeader { shard: Shard { number, of }, ..good.clone() };
    let kept = |kept| JournalHeader { kept, ..good.clone() };
    let size = |blocks, block_rows| JournalHeader { blocks, block_rows, ..good.clone() };
    for bad in [shard(3, 3), shard(5, 3), shard(0, 0), kept(2..2), kept(2..11), size(1 << 60, 10)] {
        let what = JournalHeader::parse(&bad.bytes()).unwrap_err();
        assert_eq!(what, Unfit::Damaged, "{bad:?}");
    }
}

#[test]
fn one_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let journal = begin(folder.path());
    let error = Locked::open(folder.path()).map(drop).unwrap_err().to_string();
    assert!(error.contains("another run uses this folder"), "{error}");
    let error = Journal::read(folder.path()).map(drop).unwrap_err().to_string();
    assert!(error.contains("a run still uses this folder"), "{error}");
    drop(journal);
    let [_a, _b] = [(); 2].map(|()| Journal::read(folder.path()).unwrap());
    assert!(Locked::open(folder.path()).is_err(), "somebody reads it");
}

#[test]
fn pages_find_rows_across_shards() {
    let folders: Vec<_> = (0..3).map(|_| tempfile::tempdir().unwrap()).collect();
    let journals = folders.iter().zip([0..3, 3..4, 4..1000]).map(|(folder, kept)| {
        let header = JournalHeader { block_rows: 1000, kept, ..header() };
        let mut journal = Locked::open(folder.path()).unwrap().begin(header.clone()).unwrap();
        for block in 0..3 {
            let rows = header.rows_of_block(block);
            journal.put(rows.start, &rows.map(counts).collect::<Vec<_>>()).unwrap();
        }
        journal
    });
    let mut pages = Pages::new(journals.collect());
    for page_rows in [64, 1, 2, 999, 1000] {
        pages.page_rows = page_rows;
        pages.pages.borrow_mut().fill(None);
        for row in [0, 1, 2, 3, 4, 63, 64, 999, 1000, 1003, 2999, 0, 2003] {
            assert_eq!(pages.counts(row).unwrap(), counts(row), "row {row}, pages of {page_rows}");
        }
    }
    // The file is truncated during a report.
    fs::write(folders[2].path().join(JOURNAL), b"").unwrap();
    pages.pages.borrow_mut().fill(None);
    assert!(pages.counts(2).unwrap_err().to_string().contains("row 4 is missing now"));
    assert!(pages.counts(500).unwrap_err().to_string().contains("row 4 is missing now"));
}
