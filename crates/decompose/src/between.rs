//! Points between two hulls: what their joined hull reaches over, seen at the price of a few
//! distances instead of a hull and a proof.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::Mesh;
use glam::DVec3;

/// Where on the way from one hull to the other.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];

/// A hull's middle and its extreme vertices along the axes: the ends of the ways to others.
#[derive(Clone, Copy, Debug)]
pub struct Tips([DVec3; 7]);

impl Tips {
    /// Those of a hull.
    pub fn of(hull: &Mesh) -> Tips {
        let vertices = || hull.vertices.iter().copied();
        let farthest = |d: DVec3| {
            vertices()
                .max_by(|x, y| d.dot(*x).total_cmp(&d.dot(*y)))
                .unwrap_or(DVec3::ZERO)
        };
        let [x, y, z] = DVec3::AXES;
        let middle = vertices().sum::<DVec3>() / hull.vertices.len().max(1) as f64;
        let ends = [x, y, z, -x, -y, -z].map(farthest);
        let [a, b, c, d, e, f] = ends;
        Tips([middle, a, b, c, d, e, f])
    }

    /// Points of the hull of both, between like ends; those between the middles first.
    fn between<'a>(&'a self, other: &'a Tips) -> impl Iterator<Item = DVec3> + 'a {
        let ways = self.0.iter().zip(&other.0);
        ways.flat_map(|(p, q)| SHARES.map(|share| p.lerp(*q, share)))
    }

    /// A lower bound of the thickening of the hull of both, up to the solid's slack; found at one
    /// point.
    pub fn glance(&self, other: &Tips, solid: &SolidIndex) -> f64 {
        solid.distance(self.0[0].lerp(other.0[0], SHARES[1]))
    }

    /// The largest of `known` and of the distances at all points between both: a lower bound of
    /// the thickening of the hull of both, up to the solid's slack, if `known` is one.
    pub fn thickening(&self, other: &Tips, solid: &SolidIndex, known: f64) -> f64 {
        // What is seen to be no farther need not be measured; the last digits are left to that.
        let below = |most: f64| most * (1.0 - 1e-12);
        self.between(other).fold(known, |most, p| {
            if most > 0.0 && solid.bvh().any_within(p, below(most)) {
                return most;
            }
            solid.distance(p).max(most)
        })
    }

    /// Whether the hull of both is known to hold a point farther than `epsilon` from the solid:
    /// no proof could accept it.
    pub fn reach_beyond(&self, other: &Tips, solid: &SolidIndex, epsilon: f64) -> bool {
        let beyond = epsilon + 2.0 * solid.slack();
        self.between(other)
            .any(|p| !solid.bvh().any_within(p, beyond) && !solid.contains(p))
    }
}
