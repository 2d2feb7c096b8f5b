//! How far threads look ahead where one thing comes after another.

/// How many things are looked at together with the one whose turn it is: none on one thread, two a
/// thread more. They take unequal time, so one each would leave threads waiting; hardly any
/// of them is looked at in vain.
pub fn ahead() -> usize {
    2 * (rayon::current_num_threads() - 1)
}
