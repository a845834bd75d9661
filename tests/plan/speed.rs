//! How soon the page follows the pointer, measured in a real browser: printed, never asserted. Not run by default:
//! `cargo test --release --test plan speed -- --ignored --nocapture`.

use crate::browser::{cell, script};
use crate::common::program::text;
use crate::planner::Planner;

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn how_soon_the_page_follows() {
    for template in ["assembly", "palletiser"] {
        let folder = tempfile::tempdir().unwrap();
        let planner = Planner::start(text(&cell(folder.path(), template)), &["--backend", "cpu"]);
        println!("{template}: {}", script("speed", &[&planner.address()]).trim());
        planner.end();
    }
}
