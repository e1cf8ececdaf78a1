//! Objects that serve one caller at a time.

use std::sync::{Mutex, MutexGuard, TryLockError};

/// What a mutex guards, if nobody is at work with it.
///
/// Nobody waits: the holder may need the interpreter that the caller has, or be interrupted
/// by the very code that asks.
pub fn take_turn<T>(mutex: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    match mutex.try_lock() {
        Ok(guard) => Some(guard),
        // A panic while the lock was held left whole numbers behind, at worst old ones.
        Err(TryLockError::Poisoned(error)) => Some(error.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    }
}
