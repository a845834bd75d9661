//! Shared by all test crates: the adapter to test on, random numbers and cells, and how the program is run.

#![allow(dead_code)] // Each crate uses a part of it.

pub(crate) mod blocks;
pub(crate) mod cases;
pub(crate) mod glb;
pub(crate) mod palletiser;
pub(crate) mod place;
pub(crate) mod program;
pub(crate) mod purchase;
pub(crate) mod python;
#[cfg(unix)]
pub(crate) mod running;
pub(crate) mod stl;
#[path = "../../src/thorough.rs"]
pub(crate) mod thorough;
pub(crate) mod tutorial;
pub(crate) mod watch;

use std::io::Write;

use perirobot_march::backend::adapter::AdapterChoice;
use perirobot_march::backend::factory::adapters;

/// Says something on stderr, also from a test that passes (`eprintln!` would be captured).
pub(crate) fn say(message: &str) {
    // A closed stderr is no reason to fail.
    let _ = writeln!(std::io::stderr(), "{message}");
}

/// The adapter to test on: `PERIROBOT_ADAPTER` (hardware, software, a number, a part of a name), else
/// hardware, else software. Without any, `None` and a note; a failure where `PERIROBOT_REQUIRE_GPU=1`
/// promises one.
pub(crate) fn adapter() -> Option<AdapterChoice> {
    Some(AdapterChoice::Named(adapter_number()?.to_string()))
}

/// What has the program compute on the adapter to test on.
pub(crate) fn on_adapter() -> Option<[&'static str; 4]> {
    Some(["--backend", "gpu", "--adapter", adapter_number()?.to_string().leak()])
}

fn adapter_number() -> Option<usize> {
    let found = adapters();
    if found.is_empty() {
        let promised = std::env::var("PERIROBOT_REQUIRE_GPU").is_ok_and(|v| v == "1");
        assert!(!promised, "PERIROBOT_REQUIRE_GPU=1, but there is no Vulkan adapter");
        say("SKIPPED: no Vulkan adapter");
        return None;
    }
    let choice = match std::env::var("PERIROBOT_ADAPTER") {
        Ok(name) => name.parse().expect("any name is a choice"),
        Err(_) if found.iter().any(|a| !a.software) => AdapterChoice::Hardware,
        Err(_) => AdapterChoice::Software,
    };
    let index = perirobot_march::backend::adapter::select(&found, &choice).unwrap_or_else(|e| panic!("{e}"));
    say(&format!("adapter: {}", found[index].label()));
    Some(index)
}

/// SplitMix64: the same numbers on every machine.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// 64 random bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from 0 to `n` − 1.
    pub(crate) fn below(&mut self, n: u32) -> u32 {
        (self.bits() % n.max(1) as u64) as u32
    }

    /// A number from `from` to `to`, both included.
    pub(crate) fn between(&mut self, from: i32, to: i32) -> i32 {
        from + self.below((to - from + 1) as u32) as i32
    }

    /// True once in `n` times.
    pub(crate) fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    /// From 0 to 1.
    pub(crate) fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// One of several.
    pub(crate) fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u32) as usize]
    }
}
