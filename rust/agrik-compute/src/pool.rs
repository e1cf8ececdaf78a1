//! The private thread pool: made on first use, kept, and made anew in a forked child.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use arc_swap::ArcSwapOption;
use rayon::{Scope, ThreadPool, ThreadPoolBuilder};

struct Pool {
    /// The process that made the threads; a forked child has none of them.
    process: u32,
    threads: ThreadPool,
}

static POOL: ArcSwapOption<Pool> = ArcSwapOption::const_empty();
static CHOSEN: AtomicUsize = AtomicUsize::new(0);

/// The number of threads that a call uses when it does not say: the last
/// [`set_num_threads`], else the environment's `AGRIK_NUM_THREADS`, else all cores.
pub fn num_threads() -> usize {
    let chosen = CHOSEN.load(Ordering::Relaxed);
    if chosen != 0 {
        return chosen;
    }
    std::env::var("AGRIK_NUM_THREADS")
        .ok()
        .and_then(|text| text.trim().parse().ok())
        .filter(|n| *n > 0)
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
}

/// Sets the number of threads; 0 goes back to the environment's choice.
pub fn set_num_threads(threads: usize) {
    CHOSEN.store(threads, Ordering::Relaxed);
}

/// Runs `work` on the calling thread, with a scope whose tasks run on the pool.
pub(super) fn scope<'s>(threads: usize, work: impl FnOnce(&Scope<'s>)) {
    match pool(threads - 1) {
        Some(pool) => pool.threads.in_place_scope(work),
        // Without threads of our own the machine's are still there.
        None => rayon::in_place_scope(work),
    }
}

/// A pool of at least `size` threads that belong to this process.
fn pool(size: usize) -> Option<Arc<Pool>> {
    let process = std::process::id();
    let present = POOL.load_full();
    if let Some(pool) = &present
        && pool.process == process
        && pool.threads.current_num_threads() >= size
    {
        return present;
    }
    // The threads of a parent process do not exist here: waiting for them to end would
    // never end, so their pool is left alone.
    if present.is_some_and(|pool| {
        let foreign = pool.process != process;
        if foreign {
            std::mem::forget(pool);
        }
        foreign
    }) && let Some(old) = POOL.swap(None)
    {
        std::mem::forget(old);
    }
    let threads = ThreadPoolBuilder::new()
        .num_threads(size)
        .thread_name(|i| format!("agrik-{i}"))
        .build()
        .ok()?;
    let pool = Arc::new(Pool { process, threads });
    POOL.store(Some(Arc::clone(&pool)));
    Some(pool)
}
