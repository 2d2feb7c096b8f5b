//! Slicing without progress, noticed.
//!
//! A cut makes progress if one side is less hollow than the part was (a share of its hull is
//! forbidden or empty), or less forbidden space is left in all. Slicing a hole across its axis
//! does neither, however often: every slice is as hollow as the part. A single cut like that may
//! be right (a ring cut in halves is two hollow halves), but not one after another in the same
//! direction: after `patience` of them that direction is closed, until a cut in another one makes
//! progress. And whatever a search likes, after [`MOST_CUTS`] cuts a part is halved until it fits.

use glam::DVec3;

use crate::search::policy::Choice;
use crate::search::sweep::Side;

/// Cuts between a solid and its parts: enough for a comb of as many teeth, and halving ends soon
/// after it.
pub const MOST_CUTS: u32 = 200;
/// Less hollow, or less forbidden space, by this much is progress.
const GAIN: f64 = 0.9;
/// Cosine from which two cuts count as parallel.
const PARALLEL: f64 = 0.999;

/// Three axes and all other directions.
const NONE: [(DVec3, u32); 4] = [(DVec3::ZERO, 0); 4];

/// How a part came to be.
#[derive(Clone, Copy, Debug)]
pub struct Lineage {
    /// Names the part by the cuts that led to it: the same in every run.
    pub key: u64,
    /// How many cuts led to it.
    pub cuts: u32,
    /// Directions of cuts since the last progress, and how many there were.
    idle: [(DVec3, u32); 4],
}

impl Lineage {
    /// Of a component of the solid.
    pub fn root(index: usize) -> Self {
        Lineage {
            key: mix(index as u64),
            cuts: 0,
            idle: NONE,
        }
    }

    /// Whether a direction is closed after `patience` idle cuts (0: never).
    pub fn closed(&self, direction: DVec3, patience: u32) -> bool {
        let tired = |(d, count): &(DVec3, u32)| *count >= patience && alike(*d, direction);
        patience > 0 && self.idle.iter().any(tired)
    }

    /// After a cut along a unit vector.
    #[must_use]
    pub fn after(&self, direction: DVec3, progress: bool) -> Lineage {
        let mut idle = if progress { NONE } else { self.idle };
        if !progress {
            let slot = idle
                .iter()
                .position(|(d, count)| *count == 0 || alike(*d, direction));
            match slot {
                Some(slot) => idle[slot] = (direction, idle[slot].1 + 1),
                // More directions than an idle part can have: start again.
                None => idle = NONE,
            }
        }
        Lineage {
            key: self.key,
            cuts: self.cuts + 1,
            idle,
        }
    }

    /// Of the child with an index.
    #[must_use]
    pub fn child(&self, index: usize) -> Lineage {
        Lineage {
            key: mix(self.key ^ (index as u64 + 1)),
            ..*self
        }
    }
}

/// Whether two cuts go the same way. Those along no axis all do: there are more of them than a
/// part has axes, and each would be tried in turn.
fn alike(a: DVec3, b: DVec3) -> bool {
    let oblique = |d: DVec3| d.abs().max_element() < PARALLEL;
    a.dot(b).abs() > PARALLEL || oblique(a) && oblique(b)
}

/// Whether a cut leaves less to do than the `whole` part had. `excess` weighs empty space
/// against forbidden space.
pub fn progress(whole: &Side, choice: &Choice, excess: f64) -> bool {
    let hollow = |s: &Side| (s.forbidden + excess * (s.hull - s.part).max(0.0)) / s.hull;
    let sides = [&choice.below, &choice.above];
    let least = sides.map(hollow).into_iter().fold(f64::INFINITY, f64::min);
    let left = choice.below.forbidden + choice.above.forbidden;
    least < GAIN * hollow(whole) || left < GAIN * whole.forbidden
}

/// A well-mixed number for a name (the finaliser of `SplitMix64`).
fn mix(name: u64) -> u64 {
    let mut x = name.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(part: f64, hull: f64, forbidden: f64) -> Side {
        Side {
            part,
            hull,
            forbidden,
        }
    }

    #[test]
    fn slices_of_a_hole_are_idle_and_walls_are_not() {
        let whole = side(3.0, 4.0, 0.8);
        let cut = |below, above| Choice {
            direction: 0,
            offset: 0.0,
            value: 0.0,
            below,
            above,
        };
        let slice = cut(side(0.75, 1.0, 0.2), side(2.25, 3.0, 0.6));
        assert!(!progress(&whole, &slice, 0.1));
        let wall = cut(side(1.0, 1.0, 0.0), side(2.0, 3.0, 0.8));
        assert!(progress(&whole, &wall, 0.1));

        let mut part = Lineage::root(0);
        part = part.after(DVec3::Z, false).child(1);
        assert!(!part.closed(DVec3::Z, 2) && part.closed(DVec3::Z, 1));
        part = part.after(-DVec3::Z, false).child(0);
        assert!(part.closed(DVec3::Z, 2) && !part.closed(DVec3::X, 2));
        assert!(!part.closed(DVec3::Z, 0));
        // An idle cut along no axis closes all such directions, and no axis.
        let turned = part.after(DVec3::new(0.6, 0.8, 0.0), false);
        assert!(turned.closed(DVec3::new(0.0, 0.6, 0.8), 1) && !turned.closed(DVec3::X, 1));
        // Still closed after an idle cut in another direction, open after progress.
        part = part.after(DVec3::X, false);
        assert!(part.closed(DVec3::Z, 2));
        assert!(!part.after(DVec3::X, true).closed(DVec3::Z, 1));
    }

    #[test]
    fn every_part_has_its_own_name() {
        let root = Lineage::root(0);
        let mut keys = vec![root.key, Lineage::root(1).key];
        for i in 0..2 {
            let child = root.after(DVec3::X, true).child(i);
            keys.push(child.key);
            keys.extend((0..2).map(|j| child.after(DVec3::Y, true).child(j).key));
        }
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), 8);
    }
}
