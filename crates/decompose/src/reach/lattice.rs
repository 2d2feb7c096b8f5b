//! A lattice of points around a solid, and where each of them lies.

use assetpipe_geometry::bvh::Bounds;
use assetpipe_geometry::distance::SolidIndex;
use glam::DVec3;
use rayon::prelude::*;

use crate::control::Control;

/// Side of the blocks whose points are classified together, a power of two.
const BLOCK: usize = 16;
/// How deep the skin is, in spacings: less than ρ, so that where a ball touches the
/// surface no point of the skin counts as unreachable. A gap too narrow to hold lattice
/// points is found between two skins, whose points are half a diagonal from it at most.
const SKIN: f64 = 0.86;
/// Layers beyond the reach of a ball that touches the solid.
const MARGIN: f64 = 3.0;

/// Where a lattice point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Its cube may hold the centre of a ball that does not overlap the solid.
    Passable,
    /// Outside of the solid, too near for that.
    Near,
    /// In the solid, near its surface.
    Skin,
    /// Deeper in the solid.
    Inside,
}

/// Points `low + spacing · (x, y, z)`, numbered with x fastest. The outermost
/// layers are farther from the solid than the ball reaches.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    low: DVec3,
    pub spacing: f64,
    /// Points along x, y and z.
    pub size: [usize; 3],
}

fn counts(bounds: &Bounds, radius: f64, spacing: f64) -> [f64; 3] {
    let pad = radius + MARGIN * spacing;
    (bounds.hi - bounds.lo)
        .to_array()
        .map(|side| ((side + 2.0 * pad) / spacing).ceil() + 1.0)
}

impl Lattice {
    /// How many points it has; at most `usize::MAX`.
    pub(super) fn points(bounds: &Bounds, radius: f64, spacing: f64) -> usize {
        // A cast from float to integer saturates.
        counts(bounds, radius, spacing).iter().product::<f64>() as usize
    }

    pub(super) fn new(bounds: &Bounds, radius: f64, spacing: f64) -> Lattice {
        let pad = radius + MARGIN * spacing;
        Lattice {
            low: bounds.lo - pad,
            spacing,
            size: counts(bounds, radius, spacing).map(|n| n as usize),
        }
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.size.iter().product()
    }

    pub(super) fn index(&self, at: [usize; 3]) -> usize {
        (at[2] * self.size[1] + at[1]) * self.size[0] + at[0]
    }

    pub(super) fn at(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    pub(super) fn position(&self, at: [usize; 3]) -> DVec3 {
        self.low + self.spacing * DVec3::from(at.map(|k| k as f64))
    }

    /// Where every point lies; `passable` from this distance on.
    pub(super) fn classify(
        &self,
        solid: &SolidIndex,
        passable: f64,
        control: &Control,
    ) -> Vec<Place> {
        let layer = self.size[0] * self.size[1];
        let mut places = vec![Place::Near; self.len()];
        places
            .par_chunks_mut(layer * BLOCK)
            .enumerate()
            .for_each(|(slab, places)| {
                let block = Classify {
                    lattice: self,
                    solid,
                    passable,
                    base: slab * BLOCK,
                };
                for y in (0..self.size[1]).step_by(BLOCK) {
                    for x in (0..self.size[0]).step_by(BLOCK) {
                        if control.is_cancelled() {
                            return;
                        }
                        block.cube([x, y, block.base], BLOCK, places);
                    }
                }
            });
        places
    }

    /// `chosen` and all points beside it, over corners too, that `may`.
    pub(super) fn grown(&self, chosen: &[bool], may: impl Fn(usize) -> bool) -> Vec<bool> {
        let mut grown = chosen.to_vec();
        for (index, _) in chosen.iter().enumerate().filter(|(_, &is_in)| is_in) {
            let at = self.at(index);
            let range =
                |axis: usize| at[axis].saturating_sub(1)..=(at[axis] + 1).min(self.size[axis] - 1);
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        let beside = self.index([x, y, z]);
                        grown[beside] = grown[beside] || may(beside);
                    }
                }
            }
        }
        grown
    }
}

/// Classifies the points of one slab of layers.
struct Classify<'a> {
    lattice: &'a Lattice,
    solid: &'a SolidIndex,
    passable: f64,
    /// The first layer.
    base: usize,
}

impl Classify<'_> {
    /// All points of a cube of `side` points, its lowest at `low`: one query where the
    /// distance, which is 1-Lipschitz, decides for all of them.
    fn cube(&self, low: [usize; 3], side: usize, places: &mut [Place]) {
        let size = self.lattice.size;
        if (0..3).any(|axis| low[axis] >= size[axis]) {
            return;
        }
        let half = 0.5 * (side - 1) as f64;
        let middle = self.lattice.position(low) + self.lattice.spacing * half;
        let around = self.lattice.spacing * half * 3.0_f64.sqrt();
        let slack = self.solid.slack();
        let surface = self
            .solid
            .surface(middle)
            .map_or(f64::INFINITY, |n| n.distance2.sqrt());
        // Points of the surface itself may count as either side.
        let uniform = surface > around + slack || side == 1;
        let inside = uniform && self.solid.contains(middle);
        let skin = SKIN * self.lattice.spacing;
        let place = if inside && surface - around > skin {
            Place::Inside
        } else if inside && surface + around <= skin {
            Place::Skin
        } else if inside {
            return self.divide(low, side, places);
        } else if uniform && surface - around >= self.passable {
            Place::Passable
        } else if uniform && surface + around < self.passable {
            Place::Near
        } else {
            return self.divide(low, side, places);
        };
        let end = |axis: usize| (low[axis] + side).min(size[axis]);
        for z in low[2]..end(2) {
            for y in low[1]..end(1) {
                let row = ((z - self.base) * size[1] + y) * size[0];
                places[row + low[0]..row + end(0)].fill(place);
            }
        }
    }
    fn divide(&self, low: [usize; 3], side: usize, places: &mut [Place]) {
        let half = side / 2;
        for corner in 0..8 {
            let next = [0, 1, 2].map(|axis| low[axis] + half * (corner >> axis & 1));
            self.cube(next, half, places);
        }
    }
}
