//! The choice of number type at run time, made once per process.

#![allow(unsafe_code)]

use std::sync::OnceLock;

use super::Real;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
use super::scalar::Fused;

/// Environment variable that forces a level: `scalar`, `avx2`, `avx512` or `neon`.
pub const VARIABLE: &str = "AGRIK_SIMD";

/// Which instructions the batch loops use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// One target at a time, baseline instructions.
    Scalar,
    /// Four targets in NEON registers (aarch64).
    Neon,
    /// Four targets in AVX2 registers with fused multiply-add.
    Avx2,
    /// Eight targets in AVX-512 registers.
    Avx512,
}

impl Level {
    /// All levels, lowest first.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Neon, Self::Avx2, Self::Avx512];

    /// Name as in [`VARIABLE`].
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Neon => "neon",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// True where this machine can run the level.
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            Self::Neon => cfg!(target_arch = "aarch64"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// What [`VARIABLE`] holds where that is no level of this machine: such a wish is not
    /// met, and the bindings say so.
    pub fn unmet_wish() -> Option<String> {
        let wanted = std::env::var(VARIABLE).unwrap_or_default();
        let met = |level: &Self| level.name() == wanted.trim() && level.is_available();
        (!wanted.trim().is_empty() && !Self::ALL.iter().any(met)).then_some(wanted)
    }

    /// The level in use: the one that [`VARIABLE`] names if the machine has it, else the
    /// highest that the machine has.
    pub fn in_use() -> Self {
        static LEVEL: OnceLock<Level> = OnceLock::new();
        *LEVEL.get_or_init(|| {
            let wanted = std::env::var(VARIABLE).unwrap_or_default();
            let available = || Self::ALL.into_iter().rev().filter(|l| l.is_available());
            available()
                .find(|l| l.name() == wanted.trim())
                .or_else(|| available().next())
                .unwrap_or(Self::Scalar)
        })
    }
}

/// A computation written once for every number type.
///
/// Implementations of `run` are `#[inline(always)]`, and so is everything hot below them:
/// only what is inlined into the entry function is compiled for its instruction set.
pub trait Kernel {
    /// What the computation returns.
    type Output;
    /// The computation.
    fn run<R: Real>(self) -> Self::Output;
}

/// Runs a kernel with the number type of a level. A level that the machine lacks runs as
/// [`Level::Scalar`].
pub fn dispatch<K: Kernel>(level: Level, kernel: K) -> K::Output {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 if level.is_available() => {
            // SAFETY: the processor has the features of `with_avx512`, just asked.
            unsafe { kernel.with_avx512() }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 if level.is_available() => {
            // SAFETY: the processor has the features of `with_avx2`, just asked.
            unsafe { kernel.with_avx2() }
        }
        #[cfg(target_arch = "aarch64")]
        Level::Neon => kernel.run::<super::neon::F64x4>(),
        _ => kernel.plain(),
    }
}

/// Runs a kernel one number at a time, with the roundings of a level: what a kernel
/// computes for one target is bit for bit what [`dispatch`] computes in a lane.
pub fn dispatch_single<K: Kernel>(level: Level, kernel: K) -> K::Output {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 | Level::Avx512 if level.is_available() => {
            // SAFETY: both levels ask for the features of `with_fma`.
            unsafe { kernel.with_fma() }
        }
        #[cfg(target_arch = "aarch64")]
        Level::Neon => kernel.run::<Fused>(),
        _ => kernel.plain(),
    }
}

/// The functions that a kernel is compiled into, one for each set of instructions.
///
/// They are methods of the kernel, not functions that take one, because the compiler puts
/// methods with their type: kernels of different modules are then compiled side by side.
trait Entries: Kernel + Sized {
    /// One copy for both dispatches.
    #[inline(never)]
    fn plain(self) -> Self::Output {
        self.run::<f64>()
    }

    /// # Safety
    ///
    /// The processor has the features named here.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn with_fma(self) -> Self::Output {
        self.run::<Fused>()
    }

    /// # Safety
    ///
    /// As above.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn with_avx2(self) -> Self::Output {
        self.run::<super::x86::F64x4>()
    }

    /// # Safety
    ///
    /// As above.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn with_avx512(self) -> Self::Output {
        self.run::<super::x86::F64x8>()
    }
}

impl<K: Kernel> Entries for K {}
