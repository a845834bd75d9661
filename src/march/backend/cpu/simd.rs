//! Which vector instructions the kernels use: the most that the processor has, or fewer of them, so that one machine can
//! test and measure what others run.

use fearless_simd::Level;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Simd;

/// A set of vector instructions that this processor has.
#[derive(Clone, Copy, Debug)]
pub struct SimdLevel {
    pub(crate) level: Level,
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
        SimdLevel::all().pop().unwrap_or_else(SimdLevel::none)
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
            for (name, wide, level) in more {
                all.extend(level.map(|level| SimdLevel { level, wide, name }));
            }
        }
        all
    }

    /// As tables name it: "no SIMD", "SSE4.2", "AVX2" or "AVX-512".
    pub fn name(self) -> &'static str {
        self.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_go_from_what_all_processors_have_to_what_this_one_has() {
        let all = SimdLevel::all();
        let [first, last] = [all[0], SimdLevel::most()].map(|simd| std::mem::discriminant(&simd.level));
        assert_eq!(first, std::mem::discriminant(&Level::baseline()));
        assert_eq!(last, std::mem::discriminant(&Level::new()), "{all:?}");
        #[cfg(target_arch = "x86_64")]
        {
            let has_avx2 =
                std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
            assert_eq!(all.iter().any(|simd| simd.name() == "AVX2"), has_avx2, "{all:?}");
        }
    }
}
