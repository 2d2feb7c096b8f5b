//! Pricing all parallel cuts of one direction in one forward and one backward
//! pass, without making any of them.
//!
//! For a plane at height t the volume below follows from the divergence
//! theorem with the field (0, 0, z − t): it vanishes on the cut itself, so no
//! cap is needed, and over a triangle the integral is a cubic in t. The hulls
//! grow point by point along the direction (`sweep_hull`); what crosses a
//! plane enters as the convex hull of the section. Points of the section lie
//! inside the hull of every later plane, so they are inserted for good.

use glam::{DVec2, DVec3};

use super::piece::Piece;
use super::sweep_hull::SweepHull;

/// A right-handed orthonormal basis; planes are swept along `w`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// First direction in the plane.
    pub u: DVec3,
    /// Second direction in the plane.
    pub v: DVec3,
    /// The plane's normal.
    pub w: DVec3,
}

impl Basis {
    /// The coordinate axis 0, 1 or 2 as sweep direction.
    pub fn axis(axis: usize) -> Self {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        Basis {
            u: axes[(axis + 1) % 3],
            v: axes[(axis + 2) % 3],
            w: axes[axis % 3],
        }
    }

    /// A basis whose sweep direction is the unit vector `w`.
    pub fn along(w: DVec3) -> Self {
        for axis in 0..3 {
            if w == Basis::axis(axis).w {
                return Basis::axis(axis);
            }
        }
        let (u, v) = w.any_orthonormal_pair();
        let (u, v) = if u.cross(v).dot(w) > 0.0 {
            (u, v)
        } else {
            (v, u)
        };
        Basis { u, v, w }
    }

    fn local(&self, p: DVec3) -> DVec3 {
        DVec3::new(self.u.dot(p), self.v.dot(p), self.w.dot(p))
    }
}

/// A sample of the space that no hull may contain.
#[derive(Clone, Copy, Debug)]
pub struct Forbidden {
    /// Where.
    pub point: DVec3,
    /// The volume it stands for.
    pub weight: f64,
}

/// What one side of a trial cut would be.
#[derive(Clone, Copy, Debug, Default)]
pub struct Side {
    /// Volume of the part.
    pub part: f64,
    /// Volume of its hull.
    pub hull: f64,
    /// Forbidden volume in its hull.
    pub forbidden: f64,
}

/// One trial cut.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Height of the plane along the basis' `w`.
    pub offset: f64,
    /// The part with smaller heights.
    pub below: Side,
    /// The part with larger heights.
    pub above: Side,
}

/// All trial cuts of one direction.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    /// By increasing offset.
    pub trials: Vec<Trial>,
    /// For each forbidden sample the first trial whose hull below holds it.
    pub enters_below: Vec<u32>,
    /// For each forbidden sample, one past the last trial whose hull above
    /// holds it.
    pub leaves_above: Vec<u32>,
}

/// Memory reused between sweeps.
#[derive(Default)]
pub struct Scratch {
    hull: SweepHull,
    local: Vec<DVec3>,
    low: Vec<f64>,
    high: Vec<f64>,
    order: Vec<u32>,
    sections: Vec<Vec<DVec2>>,
    outline: Vec<DVec2>,
    inserted: Vec<bool>,
    witness: Vec<u32>,
}

/// Deterministic noise in [−1/2, 1/2)³ for a key.
fn noise(key: u64) -> DVec3 {
    let mut x = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    let part = |shift: u32| ((x >> shift) & 0x1f_ffff) as f64 / 2_097_152.0 - 0.5;
    DVec3::new(part(0), part(21), part(42))
}

/// Size of the jitter of search-only points; working copies have extent ~1.
const JITTER: f64 = 4e-7;

/// Vertices this close to a plane count as on it: stand-ins of a flat face are
/// flat to rounding only.
const ON: f64 = 1e-6;

/// Price cuts at `offsets` (increasing) along `basis.w`.
///
/// `slack` is the distance by which section outlines may be simplified.
pub fn sweep(
    piece: &Piece,
    edges: &[(u32, u32)],
    basis: &Basis,
    offsets: &[f64],
    forbidden: &[Forbidden],
    slack: f64,
    scratch: &mut Scratch,
) -> Sweep {
    let count = offsets.len();
    scratch.local.clear();
    scratch
        .local
        .extend(piece.points.iter().map(|&p| basis.local(p)));
    let volumes = volumes(piece, &scratch.local, offsets);
    let total = volumes[count];
    sections(edges, offsets, slack, scratch);

    let mut result = Sweep {
        trials: offsets
            .iter()
            .zip(&volumes)
            .map(|(&offset, &part)| Trial {
                offset,
                below: Side {
                    part,
                    ..Side::default()
                },
                above: Side {
                    part: total - part,
                    ..Side::default()
                },
            })
            .collect(),
        enters_below: vec![count as u32; forbidden.len()],
        leaves_above: vec![0; forbidden.len()],
    };
    pass(basis, offsets, forbidden, scratch, &mut result, false);
    pass(basis, offsets, forbidden, scratch, &mut result, true);
    result
}

/// One pass over all planes: from below, or mirrored from above.
fn pass(
    basis: &Basis,
    offsets: &[f64],
    forbidden: &[Forbidden],
    scratch: &mut Scratch,
    result: &mut Sweep,
    mirrored: bool,
) {
    let Scratch {
        hull,
        local,
        low,
        high,
        order,
        sections,
        inserted,
        witness,
        ..
    } = scratch;
    let sign = if mirrored { -1.0 } else { 1.0 };
    // The mirror image of the hull has the same volume: both passes go upwards.
    let flip = |p: DVec3| DVec3::new(p.x, p.y, sign * p.z);
    hull.clear();
    inserted.clear();
    inserted.resize(local.len(), false);
    witness.clear();
    witness.resize(forbidden.len(), u32::MAX);
    let reach = |v: u32| {
        if mirrored {
            -high[v as usize]
        } else {
            low[v as usize]
        }
    };
    let position = |rank: usize| {
        if mirrored {
            order.len() - 1 - rank
        } else {
            rank
        }
    };

    let mut next = 0;
    let mut held = 0.0;
    for step in 0..offsets.len() {
        let k = if mirrored {
            offsets.len() - 1 - step
        } else {
            step
        };
        let t = sign * offsets[k];
        let mut ahead = next;
        while ahead < order.len() {
            let v = order[position(ahead)];
            let z = sign * local[v as usize].z;
            if z > t + ON {
                break;
            }
            // A vertex on the plane belongs to this side only if something of
            // this side hangs on it; a flat face seen from outside does not.
            let belongs = z < t - ON || reach(v) < t - ON;
            if belongs && !inserted[v as usize] {
                inserted[v as usize] = true;
                hull.insert(flip(local[v as usize] + JITTER * noise(u64::from(v))));
            }
            ahead += 1;
            if z < t - ON {
                next = ahead;
            }
        }
        for (i, p) in sections[k].iter().enumerate() {
            let key = ((k as u64 + 1) << 32) + i as u64;
            hull.insert(flip(p.extend(offsets[k]) + JITTER * noise(key)));
        }
        for (i, sample) in forbidden.iter().enumerate() {
            let known = if mirrored {
                result.leaves_above[i] != 0
            } else {
                (result.enters_below[i] as usize) < offsets.len()
            };
            if known || sign * basis.w.dot(sample.point) > t {
                continue;
            }
            if hull.contains(flip(basis.local(sample.point)), &mut witness[i]) {
                held += sample.weight;
                if mirrored {
                    result.leaves_above[i] = k as u32 + 1;
                } else {
                    result.enters_below[i] = k as u32;
                }
            }
        }
        let trial = &mut result.trials[k];
        let side = if mirrored {
            &mut trial.above
        } else {
            &mut trial.below
        };
        side.hull = hull.volume();
        side.forbidden = held;
    }
}

/// Volume below each plane, and at the end the whole volume.
fn volumes(piece: &Piece, local: &[DVec3], offsets: &[f64]) -> Vec<f64> {
    // Whole triangles enter as t·Σa − Σa·z̄ from the first plane above them.
    let count = offsets.len();
    let mut area = vec![0.0; count + 1];
    let mut moment = vec![0.0; count + 1];
    let mut partial = vec![0.0; count + 1];
    let mut add = |a: DVec3, b: DVec3, c: DVec3| {
        let twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if twice == 0.0 {
            return;
        }
        let area_here = -0.5 * twice;
        let (mut z0, mut z1, mut z2) = (a.z, b.z, c.z);
        if z0 > z1 {
            std::mem::swap(&mut z0, &mut z1);
        }
        if z1 > z2 {
            std::mem::swap(&mut z1, &mut z2);
        }
        if z0 > z1 {
            std::mem::swap(&mut z0, &mut z1);
        }
        let mean = (z0 + z1 + z2) / 3.0;
        let first = offsets.partition_point(|&t| t <= z0);
        let mut k = first;
        while k < count && offsets[k] < z2 {
            let t = offsets[k];
            let g = if t <= z1 {
                (t - z0).powi(3) / (3.0 * (z1 - z0) * (z2 - z0))
            } else {
                (t - mean) + (z2 - t).powi(3) / (3.0 * (z2 - z0) * (z2 - z1))
            };
            partial[k] += area_here * g;
            k += 1;
        }
        area[k] += area_here;
        moment[k] += area_here * mean;
    };
    for t in &piece.triangles {
        add(
            local[t[0] as usize],
            local[t[1] as usize],
            local[t[2] as usize],
        );
    }
    for cap in &piece.caps {
        let Some(first) = cap.border.first() else {
            continue;
        };
        let apex = local[first[0] as usize];
        for s in &cap.border {
            add(apex, local[s[0] as usize], local[s[1] as usize]);
        }
    }
    let (mut sum_area, mut sum_moment) = (0.0, 0.0);
    let mut result = Vec::with_capacity(count + 1);
    for k in 0..count {
        sum_area += area[k];
        sum_moment += moment[k];
        result.push(offsets[k] * sum_area - sum_moment + partial[k]);
    }
    // A closed chain has Σa = 0.
    result.push(-(sum_moment + moment[count]));
    result
}

/// Outlines of all sections, and what `pass` needs to know of each vertex.
fn sections(edges: &[(u32, u32)], offsets: &[f64], slack: f64, scratch: &mut Scratch) {
    let Scratch {
        local,
        low,
        high,
        order,
        sections,
        outline,
        ..
    } = scratch;
    low.clear();
    low.extend(local.iter().map(|p| p.z));
    high.clear();
    high.extend(local.iter().map(|p| p.z));
    sections.resize_with(offsets.len().max(sections.len()), Vec::new);
    for section in sections.iter_mut() {
        section.clear();
    }
    for &(u, v) in edges {
        let (a, b) = (local[u as usize], local[v as usize]);
        low[u as usize] = low[u as usize].min(b.z);
        low[v as usize] = low[v as usize].min(a.z);
        high[u as usize] = high[u as usize].max(b.z);
        high[v as usize] = high[v as usize].max(a.z);
        let (z0, z1) = (a.z.min(b.z), a.z.max(b.z));
        let mut k = offsets.partition_point(|&t| t <= z0 + ON);
        while k < offsets.len() && offsets[k] < z1 - ON {
            let p = a.lerp(b, (offsets[k] - a.z) / (b.z - a.z));
            sections[k].push(p.truncate());
            k += 1;
        }
    }
    order.clear();
    order.extend(0..local.len() as u32);
    order.sort_unstable_by(|&a, &b| {
        local[a as usize]
            .z
            .total_cmp(&local[b as usize].z)
            .then(a.cmp(&b))
    });
    for section in &mut sections[..offsets.len()] {
        convex_outline(section, slack, outline);
    }
}

/// Replace points by their convex hull, counter-clockwise, leaving out corners
/// that stand out by less than `slack`.
fn convex_outline(points: &mut Vec<DVec2>, slack: f64, outline: &mut Vec<DVec2>) {
    if points.len() < 4 {
        return;
    }
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    outline.clear();
    for upper in [false, true] {
        let start = outline.len();
        for i in 0..points.len() {
            let p = if upper {
                points[points.len() - 1 - i]
            } else {
                points[i]
            };
            while outline.len() >= start + 2 {
                let (a, b) = (outline[outline.len() - 2], outline[outline.len() - 1]);
                if (b - a).perp_dot(p - b) > 0.0 {
                    break;
                }
                outline.pop();
            }
            outline.push(p);
        }
        outline.pop();
    }
    points.clear();
    if outline.is_empty() {
        return;
    }
    // Each corner against the line from the last kept one to the next.
    let n = outline.len();
    for i in 0..n {
        let (b, c) = (outline[i], outline[(i + 1) % n]);
        if let Some(&a) = points.last() {
            let chord = c - a;
            if chord.perp_dot(b - a).abs() < slack * chord.length() {
                continue;
            }
        }
        points.push(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuboid(lo: DVec3, hi: DVec3) -> Piece {
        let points = (0..8)
            .map(|i| {
                DVec3::new(
                    if i & 1 == 0 { lo.x } else { hi.x },
                    if i & 2 == 0 { lo.y } else { hi.y },
                    if i & 4 == 0 { lo.z } else { hi.z },
                )
            })
            .collect();
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
            .collect();
        Piece {
            points,
            triangles,
            caps: Vec::new(),
        }
    }

    /// An L: [0,2]×[0,1]×[0,1] and [0,1]×[0,1]×[1,2] as one chain of two boxes.
    fn two_boxes() -> Piece {
        let mut a = cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
        let b = cuboid(DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, 1.0, 2.0));
        let shift = a.points.len() as u32;
        a.points.extend(b.points);
        a.triangles
            .extend(b.triangles.iter().map(|t| t.map(|v| v + shift)));
        a
    }

    #[test]
    fn volumes_and_hulls_of_a_cuboid() {
        let piece = cuboid(DVec3::new(-1.0, -0.5, -0.25), DVec3::new(1.0, 0.5, 0.25));
        let edges: Vec<_> = piece.edges().collect();
        for axis in 0..3 {
            let basis = Basis::axis(axis);
            let half = [1.0, 0.5, 0.25][axis];
            let offsets: Vec<f64> = (1..8).map(|i| half * (f64::from(i) / 4.0 - 1.0)).collect();
            let result = sweep(
                &piece,
                &edges,
                &basis,
                &offsets,
                &[],
                0.0,
                &mut Scratch::default(),
            );
            for (i, trial) in result.trials.iter().enumerate() {
                let share = (i + 1) as f64 / 8.0;
                assert!((trial.below.part - share).abs() < 1e-12);
                assert!((trial.above.part - (1.0 - share)).abs() < 1e-12);
                assert!((trial.below.hull - share).abs() < 1e-5, "{trial:?}");
                assert!((trial.above.hull - 1.0 + share).abs() < 1e-5, "{trial:?}");
            }
        }
    }

    #[test]
    fn oblique_sweeps_agree_with_real_cuts() {
        let piece = two_boxes();
        let edges: Vec<_> = piece.edges().collect();
        let w = DVec3::new(1.0, 2.0, 3.0).normalize();
        let basis = Basis::along(w);
        let offsets = [0.8, 1.2, 1.7];
        let result = sweep(
            &piece,
            &edges,
            &basis,
            &offsets,
            &[],
            0.0,
            &mut Scratch::default(),
        );
        for trial in &result.trials {
            let cut = assetpipe_geometry::Plane {
                normal: w,
                offset: trial.offset,
            };
            let (below, above) = piece.split(cut);
            assert!((below.volume() - trial.below.part).abs() < 1e-9);
            assert!((above.volume() - trial.above.part).abs() < 1e-9);
            // Cutting above everything prices the hull of a half alone.
            for (half, side) in [(below, trial.below), (above, trial.above)] {
                let edges: Vec<_> = half.edges().collect();
                let all = sweep(
                    &half,
                    &edges,
                    &basis,
                    &[100.0],
                    &[],
                    0.0,
                    &mut Scratch::default(),
                );
                assert!((all.trials[0].below.hull - side.hull).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn forbidden_samples_enter_where_the_hull_reaches_them() {
        let piece = two_boxes();
        let edges: Vec<_> = piece.edges().collect();
        let corner = Forbidden {
            point: DVec3::new(1.2, 0.5, 1.2),
            weight: 1.0,
        };
        let basis = Basis::axis(2);
        let offsets = [0.5, 1.0, 1.1, 1.5];
        let result = sweep(
            &piece,
            &edges,
            &basis,
            &offsets,
            &[corner],
            0.0,
            &mut Scratch::default(),
        );
        let below: Vec<f64> = result.trials.iter().map(|t| t.below.forbidden).collect();
        let above: Vec<f64> = result.trials.iter().map(|t| t.above.forbidden).collect();
        assert_eq!(below, [0.0, 0.0, 0.0, 1.0]);
        // At z = 1 the flat face of the foot is no part of the tower.
        assert_eq!(above, [1.0, 0.0, 0.0, 0.0]);
        assert_eq!((result.enters_below[0], result.leaves_above[0]), (3, 1));
    }
}
