//! The vector instructions that the floating-point renderers use.

use std::fmt;

use fearless_simd::Level;

/// Vector instructions of a processor. All give the same bits: no operation is fused, and none is
/// reordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Vectors {
    /// 128 bits, on every x86-64.
    Sse2,
    /// 128 bits, with the instructions of SSE4.2.
    Sse42,
    /// 256 bits.
    Avx2,
    /// 512 bits, with the extensions of Ice Lake.
    Avx512,
    /// 128 bits, on every 64-bit ARM.
    Neon,
}

impl Vectors {
    /// All of them, the narrowest of each architecture first.
    pub const ALL: [Self; 5] = [
        Self::Sse2,
        Self::Sse42,
        Self::Avx2,
        Self::Avx512,
        Self::Neon,
    ];

    /// The usual name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sse2 => "SSE2",
            Self::Sse42 => "SSE4.2",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
            Self::Neon => "NEON",
        }
    }

    /// Those of this processor, the narrowest first.
    pub fn here() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|own| own.level().is_some())
    }

    /// The widest of this processor; `None` where it has none of them.
    #[must_use]
    pub fn widest() -> Option<Self> {
        Self::here().last()
    }

    /// The proof that this processor has them, for [`fearless_simd::dispatch`].
    #[must_use]
    pub fn level(self) -> Option<Level> {
        let here = Level::new();
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => here.as_sse2().map(Level::Sse2),
            #[cfg(target_arch = "x86_64")]
            Self::Sse42 => here.as_sse4_2().map(Level::Sse4_2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => here.as_avx2().map(Level::Avx2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => here.as_avx512().map(Level::Avx512),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => here.as_neon().map(Level::Neon),
            #[allow(unreachable_patterns)]
            _ => {
                let _ = here;
                None
            }
        }
    }
}

impl fmt::Display for Vectors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
