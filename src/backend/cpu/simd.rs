//! Which vector instructions the kernels use: the most that the processor has, or fewer of them, so that one machine can
//! test and measure what others run.

use fearless_simd::Level;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Simd;

/// A set of vector instructions that this processor has.
#[derive(Clone, Copy, Debug)]
pub struct SimdLevel {
    pub(super) level: Level,
    /// Whether vectors have 256 bits or more, so that work for many lanes at once pays.
    pub(super) wide: bool,
    name: &'static str,
}

impl SimdLevel {
    /// The instructions that every processor of this architecture has.
    pub fn none() -> Self {
        SimdLevel { level: Level::baseline(), wide: false, name: "no SIMD" }
    }

    /// All that this processor has.
    pub fn most() -> Self {
        *SimdLevel::all().last().expect("none is among them")
    }

    /// Each set that this processor has, from none to the most.
    pub fn all() -> Vec<Self> {
        let mut all = vec![SimdLevel::none()];
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            let most = Level::new();
            let more = [
                ("SSE4.2", false, most.as_sse4_2().map(Simd::level)),
                ("AVX2", true, most.as_avx2().map(Simd::level)),
                ("AVX-512", true, most.as_avx512().map(Simd::level)),
            ];
            let level =
                |(name, wide, level): (_, _, Option<_>)| Some(SimdLevel { level: level?, wide, name });
            all.extend(more.into_iter().filter_map(level));
        }
        all
    }

    /// As tables name it: "no SIMD", "SSE4.2", "AVX2" or "AVX-512".
    pub fn name(self) -> &'static str {
        self.name
    }
}
