//! Parallel work with ordered results.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Condvar, Mutex};

/// Calls `work` with every number below `count`, each on a new thread, or on the calling thread if no thread can be started.
pub fn run_on_threads(count: usize, work: &(dyn Fn(usize) + Sync)) {
    std::thread::scope(|scope| {
        let is_not_started = |&i: &usize| {
            let thread = std::thread::Builder::new();
            thread.spawn_scoped(scope, move || work(i)).is_err()
        };
        let rest: Vec<usize> = (0..count).filter(is_not_started).collect();
        rest.into_iter().for_each(work);
    });
}

/// Returns the results of `make` for every number below `count`, in order. Runs up to `jobs` calls in parallel.
pub fn map_in_parallel<T: Send>(
    count: usize,
    jobs: usize,
    progress: &(impl Fn(usize, usize) + Sync),
    make: &(impl Fn(usize) -> T + Sync),
) -> Vec<T> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let slots: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    run_on_threads(jobs.clamp(1, count.max(1)), &|_| {
        loop {
            let i = next.fetch_add(1, Relaxed);
            if i >= count {
                break;
            }
            *slots[i].lock().expect("no worker panics") = Some(make(i));
            progress(done.fetch_add(1, Relaxed) + 1, count);
        }
    });
    let results = slots
        .into_iter()
        .map(|slot| slot.into_inner().expect("no worker panics"));
    results.flatten().collect()
}

/// Maximum number of results that wait for an earlier result.
const MAX_WAITING_RESULTS: usize = 256;

/// Index of the next result to emit, and later results that are ready.
struct OrderedResults<R, S> {
    next: usize,
    waiting: BTreeMap<usize, R>,
    emit: S,
}

/// Calls `work` with every item, with up to `jobs` calls in parallel, and calls `emit` with every result in the order of the
/// items. Buffers only a few results: a thread that is too far ahead waits. `work` must not panic.
pub fn process_in_order<T: Send, R: Send>(
    items: impl Iterator<Item = T> + Send,
    jobs: usize,
    work: &(impl Fn(T) -> R + Sync),
    emit: impl FnMut(R) + Send,
) {
    const LOCK_NOT_POISONED: &str = "no worker panics";
    let items = Mutex::new(items.enumerate());
    let queue = Mutex::new(OrderedResults {
        next: 0,
        waiting: BTreeMap::new(),
        emit,
    });
    let turn = Condvar::new();
    run_on_threads(jobs.max(1), &|_| {
        loop {
            let Some((i, item)) = items.lock().expect(LOCK_NOT_POISONED).next() else {
                break;
            };
            let result = work(item);
            let queue = queue.lock().expect(LOCK_NOT_POISONED);
            let is_early = |r: &mut OrderedResults<R, _>| i > r.next + MAX_WAITING_RESULTS;
            let mut queue = turn.wait_while(queue, is_early).expect(LOCK_NOT_POISONED);
            queue.waiting.insert(i, result);
            let queue = &mut *queue;
            while let Some(result) = queue.waiting.remove(&queue.next) {
                (queue.emit)(result);
                queue.next += 1;
            }
            turn.notify_all();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_arrive_in_order() {
        let mut emitted = Vec::new();
        let work = |item: usize| {
            if item == 0 {
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
            item
        };
        process_in_order(0..2000, 4, &work, |result| emitted.push(result));
        assert!(emitted.into_iter().eq(0..2000));
    }
}
