//! What the targets share: the entries, and an allocator that ends the process when an input takes more
//! memory than its length can justify, so that libFuzzer keeps it. `-rss_limit_mb` would see only what is far
//! too much.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

pub mod entries;
pub mod folders;

#[global_allocator]
static MEMORY: Counted = Counted;

/// Bytes that are allocated now, and that may be.
static NOW: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);

/// Runs an entry, which may take `floor_mib` and so many bytes for each byte of the input, more than before.
pub fn within(floor_mib: usize, per_byte: usize, entry: fn(&[u8]), bytes: &[u8]) {
    MOST.store(NOW.load(Relaxed) + (floor_mib << 20) + per_byte * bytes.len(), Relaxed);
    entry(bytes);
    MOST.store(usize::MAX, Relaxed);
}

/// A target: its entry, and what it may take.
#[macro_export]
macro_rules! target {
    ($entry:ident, floor_mib = $floor_mib:literal, per_byte = $per_byte:literal) => {
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
            $crate::within($floor_mib, $per_byte, $crate::entries::$entry, bytes);
        });
    };
}

struct Counted;

impl Counted {
    fn take(bytes: usize) {
        if NOW.fetch_add(bytes, Relaxed) + bytes > MOST.load(Relaxed) {
            MOST.store(usize::MAX, Relaxed);
            eprintln!("the input takes more memory than it may: {} bytes asked for now", bytes);
            std::process::abort();
        }
    }
}

// SAFETY: every call goes on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Counted::take(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        Counted::take(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Counted::take(size);
        NOW.fetch_sub(layout.size(), Relaxed);
        unsafe { System.realloc(at, layout, size) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(at, layout) }
    }
}
