//! Pairs that wait for their turn, and those that were asked about ahead of it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

/// Whether nobody waits for a task any more.
#[derive(Clone, Debug, Default)]
pub struct Dropped(Arc<AtomicBool>);

impl Dropped {
    /// Whether it is so.
    pub fn is_dropped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Pairs that wait which are looked at for one to ask about ahead of its turn.
const LOOKED_AT: usize = 16;

/// What has a place among turns and is about two of some numbered things.
pub trait Pair: Ord + Copy {
    /// The numbers of both.
    fn pair(&self) -> [u32; 2];

    /// Whether both are about the same thing.
    fn touches(&self, other: &impl Pair) -> bool {
        let other = other.pair();
        self.pair().iter().any(|k| other.contains(k))
    }
}

/// Which pairs are worth asking about before it is known what comes of those before them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ahead {
    /// Those about nothing that others before them are about: where every pair that has its turn
    /// leaves others without one.
    Apart,
    /// These first, then the next ones: where most come to nothing.
    Any,
}

/// Pairs in the order of their turns, the least first, with what is known of them (`W`) and, of
/// those that were asked about, with what came of it (`A`). Pairs that are about something that is
/// gone have no turn.
#[derive(Debug)]
pub struct Order<K, W, A> {
    waiting: BTreeMap<K, W>,
    asked: BTreeMap<K, Asked<A>>,
    gone: BTreeSet<u32>,
    ahead: Ahead,
}

#[derive(Debug)]
enum Asked<A> {
    Open(Dropped),
    Known(A),
}

impl<K: Pair, W, A> Order<K, W, A> {
    /// Nothing.
    pub fn new(ahead: Ahead) -> Self {
        Order {
            waiting: BTreeMap::new(),
            asked: BTreeMap::new(),
            gone: BTreeSet::new(),
            ahead,
        }
    }

    /// How many wait.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Let a pair wait for its turn.
    pub fn push(&mut self, key: K, what: W) {
        self.waiting.insert(key, what);
    }

    /// What to ask about next: the pair whose turn it is, or one that will most likely have its
    /// turn, whatever comes of those before it. Nothing if enough is being asked.
    pub fn ask(&mut self) -> Option<(K, W, Dropped)> {
        let key = if self.is_unasked() {
            *self.waiting.first_key_value()?.0
        } else if self.asked.len() < most() {
            self.promising()?
        } else {
            return None;
        };
        let what = self.waiting.remove(&key)?;
        let dropped = Dropped::default();
        self.asked.insert(key, Asked::Open(dropped.clone()));
        Some((key, what, dropped))
    }

    /// What to ask about ahead of its turn.
    fn promising(&self) -> Option<K> {
        let waiting = || self.waiting.keys().filter(|key| self.stands(key));
        let mut before: Vec<K> = self.asked.keys().copied().collect();
        for key in waiting().take(LOOKED_AT) {
            if !before.iter().any(|other| key.touches(other)) {
                return Some(*key);
            }
            before.push(*key);
        }
        match self.ahead {
            Ahead::Apart => None,
            Ahead::Any => waiting().next().copied(),
        }
    }

    /// What came of asking about a pair.
    pub fn answer(&mut self, key: K, answer: A) {
        // Not there if it has no turn any more.
        if let Some(asked) = self.asked.get_mut(&key) {
            *asked = Asked::Known(answer);
        }
    }

    /// A pair that was asked about has another turn.
    pub fn again(&mut self, before: K, after: K, what: W) {
        if self.asked.remove(&before).is_some() {
            self.push(after, what);
        }
    }

    /// Take out the pair whose turn it is, if it is known what came of it.
    pub fn settle(&mut self) -> Option<(K, A)> {
        if self.is_unasked() {
            return None;
        }
        match self.asked.pop_first()? {
            (key, Asked::Known(answer)) => Some((key, answer)),
            (key, open) => {
                self.asked.insert(key, open);
                None
            }
        }
    }

    /// What a pair was about is gone.
    pub fn retire(&mut self, pair: &K) {
        self.gone.extend(pair.pair());
        self.asked.retain(|key, asked| {
            let over = key.touches(pair);
            if let (true, Asked::Open(dropped)) = (over, asked) {
                dropped.0.store(true, Ordering::Relaxed);
            }
            !over
        });
    }

    /// Whether a thing is gone.
    pub fn is_gone(&self, k: u32) -> bool {
        self.gone.contains(&k)
    }

    /// Whether both things of a pair stand.
    fn stands(&self, key: &K) -> bool {
        !key.pair().into_iter().any(|k| self.is_gone(k))
    }

    /// Whether the pair whose turn it is was not asked about.
    fn is_unasked(&mut self) -> bool {
        while let Some((key, _)) = self.waiting.first_key_value() {
            if self.stands(key) {
                let first = self.asked.first_key_value();
                return first.is_none_or(|(first, _)| key < first);
            }
            self.waiting.pop_first();
        }
        false
    }
}

/// How many pairs may be asked about before the first of them has had its turn. On one thread
/// nothing is worked on in vain; on more, hardly anything.
fn most() -> usize {
    match rayon::current_num_threads() {
        0 | 1 => 1,
        threads => 3 * threads,
    }
}
