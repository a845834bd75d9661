//! The counts of a finished sweep by row: from one journal or from those of all its shards, with cached pages for a
//! report; or all of them in memory.

use std::cell::RefCell;

use crate::results::journal::Journal;
use perirobot_march::Result;
use perirobot_march::metrics::Confusion;

/// Cached counts, all blocks together: some 50 MB.
const KEPT_ROWS: u64 = 1 << 19;

/// Fewest rows of a block per read.
const LEAST_ROWS: u64 = 64;

/// The index of a page of a block, and its counts.
type CountsPage = (u64, Vec<Confusion>);

/// Journals that together contain all rows of a sweep. A report reads the same row of many blocks, then the next row of
/// them, so one page of each block is cached.
#[derive(Debug)]
pub struct Pages {
    /// In the order of their rows; empty if all counts are in memory.
    journals: Vec<Journal>,
    block_rows: u64,
    pub(super) page_rows: u64,
    /// The cached page of each block.
    pub(super) pages: RefCell<Vec<Option<CountsPage>>>,
}

impl Pages {
    /// From journals of one sweep that together contain every row of each block once, in the order of those rows.
    pub(crate) fn new(journals: Vec<Journal>) -> Pages {
        let (blocks, block_rows) = (journals[0].header().blocks, journals[0].header().block_rows);
        let page_rows = (KEPT_ROWS / blocks.max(1)).max(LEAST_ROWS);
        let pages = RefCell::new((0..blocks).map(|_| None).collect());
        Pages { journals, block_rows, page_rows, pages }
    }

    /// From the counts of all rows of equal blocks, block by block: one page each, which is never reloaded.
    pub(crate) fn in_memory(blocks: Vec<Vec<Confusion>>) -> Pages {
        let block_rows = blocks.first().map_or(0, |block| block.len() as u64);
        let pages = RefCell::new(blocks.into_iter().map(|block| Some((0, block))).collect());
        Pages { journals: Vec::new(), block_rows, page_rows: block_rows.max(1), pages }
    }

    /// The counts of a row.
    ///
    /// # Errors
    /// `Error::Storage` if the disk fails, or the row is no longer in its file.
    pub(crate) fn counts(&self, row: u64) -> Result<Confusion> {
        let (block, within) = (row / self.block_rows, row % self.block_rows);
        let (page, at) = (within / self.page_rows, (within % self.page_rows) as usize);
        let kept = &mut self.pages.borrow_mut()[block as usize];
        if let Some((number, counts)) = kept
            && *number == page
        {
            return Ok(counts[at]);
        }
        let (_, counts) = kept.insert((page, self.read(block, page)?));
        Ok(counts[at])
    }

    /// Makes every later read fail.
    #[cfg(all(any(test, feature = "example"), target_os = "linux"))]
    pub(crate) fn break_disk(&mut self) {
        self.journals.iter_mut().for_each(Journal::break_disk);
    }

    /// A page of a block.
    fn read(&self, block: u64, page: u64) -> Result<Vec<Confusion>> {
        let block_rows = self.block_rows;
        let (first, end) = (page * self.page_rows, block_rows.min((page + 1) * self.page_rows));
        let mut counts = Vec::new();
        for journal in &self.journals {
            let kept = &journal.header().kept;
            let (from, to) = (first.max(kept.start), end.min(kept.end));
            if from < to {
                counts.extend(journal.counts(block * block_rows + from..block * block_rows + to)?);
            }
        }
        Ok(counts)
    }
}
