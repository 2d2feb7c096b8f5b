//! Work whose results count one after another, done by several threads.
//!
//! What comes next often depends on what comes of the thing before it, so a thread that waited for
//! that would have nothing to do. It works on what will probably come after instead; what it finds
//! is kept until its turn, and dropped if its turn never comes.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

pub use order::{Ahead, Dropped, Order, Pair};

mod order;

/// Things that have their turn one after another.
pub trait Turns: Send {
    /// Something to work on, by itself.
    type Task: Send;
    /// What came of it.
    type Done: Send;

    /// What to work on next; nothing if that depends on what is being worked on, or at the end.
    fn next(&mut self) -> Option<Self::Task>;

    /// What came of a task.
    fn take(&mut self, done: Self::Done);
}

/// Work on all that has its turn, as many things at a time as there are threads.
pub fn in_turn<T: Turns>(turns: T, work: impl Fn(T::Task) -> T::Done + Sync) -> T {
    let crew = Crew {
        state: Mutex::new((turns, 0)),
        work,
    };
    rayon::scope(|scope| crew.begin(scope));
    let state = crew.state.into_inner();
    state.unwrap_or_else(PoisonError::into_inner).0
}

/// Threads that work together.
struct Crew<T, W> {
    /// With the number of tasks that are being worked on.
    state: Mutex<(T, usize)>,
    work: W,
}

impl<T: Turns, W: Fn(T::Task) -> T::Done + Sync> Crew<T, W> {
    /// Begin with what there is to do, for every thread that has nothing.
    fn begin<'s>(&'s self, scope: &rayon::Scope<'s>) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        while state.1 < rayon::current_num_threads() {
            let Some(task) = state.0.next() else { break };
            state.1 += 1;
            scope.spawn(move |scope| {
                let done = (self.work)(task);
                let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
                state.0.take(done);
                state.1 -= 1;
                drop(state);
                self.begin(scope);
            });
        }
    }
}

/// Work on all of these, each thread on the next that nobody works on: what takes long and comes
/// first is not left for the end. The results are in the order of the things.
pub fn next_first<T: Sync, R: Send>(things: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let done: Vec<Vec<(usize, R)>> = (0..rayon::current_num_threads())
        .into_par_iter()
        .with_max_len(1)
        .map(|_| {
            let taken = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
            let taken = taken.map_while(|k| Some((k, things.get(k)?)));
            taken.map(|(k, thing)| (k, work(thing))).collect()
        })
        .collect();
    let mut done: Vec<(usize, R)> = done.into_iter().flatten().collect();
    done.sort_unstable_by_key(|d| d.0);
    done.into_iter().map(|d| d.1).collect()
}

/// Things to look at together with the first, shared out among threads.
pub fn shared_out<T: Clone>(first: &T, others: &[T]) -> Vec<Vec<T>> {
    let share = others.len().div_ceil(rayon::current_num_threads()).max(1);
    let shares = others.chunks(share);
    shares
        .map(|share| [std::slice::from_ref(first), share].concat())
        .collect()
}

#[cfg(test)]
mod tests;
