//! What a policy is asked and what it answers.

use super::greedy::Greedy;
use super::lookahead::Lookahead;
use super::mcts::TreeSearch;
use super::piece::Piece;
use super::sweep::{Basis, Forbidden, Side};
use crate::settings::{PolicyChoice, SearchSettings};

/// A part to cut, and where it may be cut.
pub struct Question<'a> {
    /// The part, as coarse as the search wants it.
    pub piece: &'a Piece,
    /// Samples of forbidden space in its hull.
    pub forbidden: &'a [Forbidden],
    /// Directions of candidate cuts.
    pub directions: &'a [Basis],
    /// How many of the directions, from the first, have a grid of planes; the others have
    /// only offsets of their own.
    pub gridded: usize,
    /// Offsets beside the grid, for each direction, increasing.
    pub extra: &'a [Vec<f64>],
    /// The same for every later cut.
    pub extra_second: &'a [Vec<f64>],
    /// The tolerance.
    pub epsilon: f64,
    /// Names the part, the same in every run: what random numbers are drawn from,
    /// together with the seed of the settings.
    pub key: u64,
    /// Parameters.
    pub settings: &'a SearchSettings,
}

/// A chosen cut.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Index into the directions.
    pub direction: usize,
    /// Height of the plane.
    pub offset: f64,
    /// Its value, in the policy's own unit; smaller is better.
    pub value: f64,
    /// What is below it.
    pub below: Side,
    /// What is above it.
    pub above: Side,
}

/// Chooses where to cut a part. The same question has the same answer, whatever the threads.
pub trait Policy: Sync {
    /// The best cut, or `None` if there is no candidate.
    fn choose(&self, question: &Question<'_>) -> Option<Choice>;
}

/// The policy of a name.
pub fn policy(choice: PolicyChoice) -> &'static dyn Policy {
    match choice {
        PolicyChoice::Greedy => &Greedy,
        PolicyChoice::Lookahead => &Lookahead,
        PolicyChoice::Mcts => &TreeSearch,
    }
}
