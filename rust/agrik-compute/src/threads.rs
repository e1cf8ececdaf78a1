//! Work spread over threads, with a way to stop early.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::pool;
pub use crate::pool::{num_threads, set_num_threads};

/// Time between two questions whether to go on, once the caller only waits for others.
const BETWEEN_POLLS: Duration = Duration::from_millis(10);

/// Hands pieces of work to `work` on `threads` threads (0: the number in force); false
/// where `poll`, asked now and then on the calling thread, said to stop.
pub fn share<T: Send>(
    mut runs: Vec<T>,
    threads: usize,
    work: &(dyn Fn(T) + Sync),
    poll: &mut dyn FnMut() -> bool,
) -> bool {
    let threads = if threads == 0 { num_threads() } else { threads };
    let threads = threads.min(runs.len());
    runs.reverse();
    if threads <= 1 {
        while let Some(run) = runs.pop() {
            work(run);
            if !runs.is_empty() && !poll() {
                return false;
            }
        }
        return true;
    }
    let stop = AtomicBool::new(false);
    let queue = Mutex::new(runs);
    let next = || lock(&queue).pop();
    pool::scope(threads, |scope| {
        for _ in 1..threads {
            scope.spawn(|_| {
                while !stop.load(Ordering::Relaxed)
                    && let Some(run) = next()
                {
                    work(run);
                }
            });
        }
        while let Some(run) = next() {
            work(run);
            if !poll() {
                stop.store(true, Ordering::Relaxed);
                break;
            }
        }
    });
    !stop.into_inner()
}

/// Runs `work` on the calling thread and on `threads - 1` others at once; false where `poll`,
/// asked by the calling thread's work and then while it waits, said to stop.
///
/// Each is handed a question whether to go on, and says whether it went on to the end.
pub fn together(
    threads: usize,
    work: &(dyn Fn(&mut dyn FnMut() -> bool) -> bool + Sync),
    poll: &mut dyn FnMut() -> bool,
) -> bool {
    let stop = AtomicBool::new(false);
    let working = Working::new(threads - 1);
    pool::scope(threads, |scope| {
        // The calling thread works too, and is the one that asks whether to go on: while it
        // has work of its own, and after that until the others are done.
        for _ in 1..threads {
            scope.spawn(|_| {
                let _done = Done(&working);
                work(&mut || !stop.load(Ordering::Relaxed));
            });
        }
        let mut go_on = work(&mut *poll);
        while go_on && working.wait() {
            go_on = poll();
        }
        stop.store(!go_on, Ordering::Relaxed);
    });
    !stop.into_inner()
}

/// A lock whose holder panicked guards data that is still whole: counts and whole runs.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How many helpers have not finished yet.
struct Working {
    count: Mutex<usize>,
    changed: Condvar,
}

impl Working {
    fn new(count: usize) -> Self {
        Self { count: Mutex::new(count), changed: Condvar::new() }
    }

    /// Waits until none is working, but not long; true while some are.
    fn wait(&self) -> bool {
        let count = lock(&self.count);
        let (count, _) = self
            .changed
            .wait_timeout_while(count, BETWEEN_POLLS, |count| *count > 0)
            .unwrap_or_else(PoisonError::into_inner);
        *count > 0
    }
}

/// Counts a helper out, whichever way it ends.
struct Done<'w>(&'w Working);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        *lock(&self.0.count) -= 1;
        self.0.changed.notify_all();
    }
}
