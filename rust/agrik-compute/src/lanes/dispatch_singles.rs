//! The choice of the lanes of singles at run time.

#![allow(unsafe_code)]

use super::plain_singles::Plain8;
use super::{Level, Real32};

/// A computation on singles, written once for every lane type.
///
/// As with [`super::Kernel`], `run` and everything hot below it are `#[inline(always)]`.
pub trait Kernel32 {
    /// What the computation returns.
    type Output;
    /// The computation.
    fn run<R: Real32>(self) -> Self::Output;
}

/// Runs a kernel with the widest lanes of a level: 16 with AVX-512, else 8. A level that the
/// machine lacks runs as [`Level::Scalar`].
pub fn dispatch_singles<K: Kernel32>(level: Level, kernel: K) -> K::Output {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 if level.is_available() => {
            // SAFETY: the processor has the features of `with_avx512`, just asked.
            unsafe { kernel.with_avx512() }
        }
        _ => dispatch_eights(level, kernel),
    }
}

/// Runs a kernel with 8 lanes, whatever the level: for what is stored in groups of eight.
pub fn dispatch_eights<K: Kernel32>(level: Level, kernel: K) -> K::Output {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 | Level::Avx512 if level.is_available() => {
            // SAFETY: both levels ask for the features of `with_avx2`.
            unsafe { kernel.with_avx2() }
        }
        #[cfg(target_arch = "aarch64")]
        Level::Neon => kernel.run::<super::neon_singles::F32x8>(),
        _ => kernel.run::<Plain8>(),
    }
}

/// The functions that a kernel is compiled into, one for each set of instructions that is not
/// the baseline.
#[cfg(target_arch = "x86_64")]
trait Entries: Kernel32 + Sized {
    /// # Safety
    ///
    /// The processor has the features named here.
    #[target_feature(enable = "avx2,fma")]
    unsafe fn with_avx2(self) -> Self::Output {
        self.run::<super::x86_singles::F32x8>()
    }

    /// # Safety
    ///
    /// As above.
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn with_avx512(self) -> Self::Output {
        self.run::<super::x86_singles::F32x16>()
    }
}

#[cfg(target_arch = "x86_64")]
impl<K: Kernel32> Entries for K {}
