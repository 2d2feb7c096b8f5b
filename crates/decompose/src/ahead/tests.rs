use super::*;

type Key = (u32, [u32; 2]);

impl Pair for Key {
    fn pair(&self) -> [u32; 2] {
        self.1
    }
}

/// Sums of pairs of numbers, the least first, replace both: until one is left.
struct Sums {
    numbers: Vec<Option<u32>>,
    order: Order<Key, (), u32>,
    trace: Vec<[u32; 2]>,
}

impl Sums {
    fn of(numbers: &[u32], ahead: Ahead) -> Sums {
        let mut sums = Sums {
            numbers: Vec::new(),
            order: Order::new(ahead),
            trace: Vec::new(),
        };
        for &number in numbers {
            sums.add(number);
        }
        sums
    }

    fn add(&mut self, number: u32) {
        let new = self.numbers.len() as u32;
        for (k, other) in self.numbers.iter().enumerate() {
            if let Some(other) = other {
                self.order.push((other + number, [k as u32, new]), ());
            }
        }
        self.numbers.push(Some(number));
    }
}

impl Turns for Sums {
    type Task = (Key, Dropped);
    type Done = (Key, Option<u32>);

    fn next(&mut self) -> Option<Self::Task> {
        while let Some((key, sum)) = self.order.settle() {
            for k in key.1 {
                self.numbers[k as usize] = None;
            }
            self.trace.push(key.1);
            self.order.retire(&key);
            self.add(sum);
        }
        let (key, (), dropped) = self.order.ask()?;
        Some((key, dropped))
    }

    fn take(&mut self, (key, sum): Self::Done) {
        if let Some(sum) = sum {
            self.order.answer(key, sum);
        }
    }
}

fn trace(threads: usize, ahead: Ahead) -> Vec<[u32; 2]> {
    let mut random = assetpipe_geometry::sample::Random::new(5);
    let numbers: Vec<u32> = (0..40).map(|_| (random.unit() * 50.0) as u32).collect();
    let work = |(key, dropped): (Key, Dropped)| {
        // Some take longer, and stop when nobody waits for them.
        for _ in 0..key.0 % 7 {
            std::thread::sleep(std::time::Duration::from_micros(200));
            if dropped.is_dropped() {
                return (key, None);
            }
        }
        (key, Some(key.0))
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = pool.build().unwrap();
    let done = pool.install(|| in_turn(Sums::of(&numbers, ahead), work));
    assert_eq!(done.numbers.iter().flatten().count(), 1);
    done.trace
}

#[test]
fn turns_are_those_of_one_thread() {
    let alone = trace(1, Ahead::Any);
    assert_eq!(alone.len(), 39);
    for threads in [2, 3, 8] {
        for ahead in [Ahead::Any, Ahead::Apart] {
            assert_eq!(trace(threads, ahead), alone);
        }
    }
}

#[test]
fn one_thread_asks_about_nothing_ahead_and_several_about_pairs_apart_first() {
    let asked = |threads: usize, ahead: Ahead| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let mut order = Order::<Key, (), u32>::new(ahead);
            for pair in [[0, 1], [0, 2], [1, 2], [2, 3], [4, 5]] {
                order.push((pair[0] + pair[1], pair), ());
            }
            let mut pairs = Vec::new();
            while let Some((key, (), _)) = order.ask() {
                pairs.push(key.1);
            }
            pairs
        })
    };
    assert_eq!(asked(1, Ahead::Any), [[0, 1]]);
    assert_eq!(asked(2, Ahead::Apart), [[0, 1], [4, 5]]);
    let any = asked(2, Ahead::Any);
    assert_eq!(any, [[0, 1], [4, 5], [0, 2], [1, 2], [2, 3]]);
}

#[test]
fn what_lost_its_turn_is_dropped() {
    let mut order = Order::<Key, (), u32>::new(Ahead::Any);
    order.push((1, [0, 1]), ());
    order.push((2, [1, 2]), ());
    let (first, (), _) = order.ask().unwrap();
    order.answer(first, 7);
    assert_eq!(order.settle(), Some((first, 7)));
    let (second, (), dropped) = order.ask().unwrap();
    order.retire(&first);
    assert!(dropped.is_dropped());
    order.answer(second, 8);
    assert_eq!(order.settle(), None);
}

#[test]
fn results_are_in_the_order_of_the_things() {
    let things: Vec<u64> = (0..100).rev().collect();
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let done = pool.build().unwrap().install(|| {
            next_first(&things, |&k| {
                std::thread::sleep(std::time::Duration::from_micros(10 * (k % 7)));
                k * k
            })
        });
        let expected: Vec<u64> = things.iter().map(|k| k * k).collect();
        assert_eq!(done, expected);
    }
}
