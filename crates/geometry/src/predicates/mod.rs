//! Signs that are always right.
//!
//! Every predicate answers with the sign of a polynomial in its inputs *as
//! they stand*, for all finite `f64`: a floating-point filter decides nearly
//! always (Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast
//! Robust Geometric Predicates*, 1997, §4); what it cannot decide goes to the
//! adaptive expansions of the `robust` crate, and coordinates so large or so
//! small that expansions would overflow or underflow go to integers of
//! unlimited width.

mod wide;

use std::cmp::Ordering;

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D};

use crate::plane::Plane;

/// Half an ulp of one: the unit roundoff of `f64`.
const ROUNDOFF: f64 = f64::EPSILON / 2.0;
/// Shewchuk's bound of the plain `orient3d` determinant, relative to its permanent.
const ORIENT3D_ERROR: f64 = (7.0 + 56.0 * ROUNDOFF) * ROUNDOFF;
/// Shewchuk's bound of the plain `orient2d` determinant, relative to its permanent.
const ORIENT2D_ERROR: f64 = (3.0 + 16.0 * ROUNDOFF) * ROUNDOFF;
/// Bound of the plain `normal · x - offset`, relative to the sum of magnitudes.
const SIDE_ERROR: f64 = 5.0 * ROUNDOFF;
/// More than what a few underflowing products can lose, each times a factor of at most one.
const UNDERFLOW: f64 = 1e-300;
/// Magnitudes between which no step of an expansion of degree three can
/// overflow or lose bits: a non-zero coordinate is then a multiple of
/// 2^-332, a product of three is a multiple of 2^-996.
const EXPANSION_RANGE: std::ops::Range<f64> = 1e-84..1e84;
/// The same for degree four: a product of four is a multiple of 2^-1012.
const QUARTIC_RANGE: std::ops::Range<f64> = 1e-60..1e60;

/// Which way `a`, `b`, `c` turn in the plane.
///
/// `Greater`: counter-clockwise, `c` is left of the line from `a` to `b`.
#[inline]
pub fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> Ordering {
    let ac = a - c;
    let bc = b - c;
    let (left, right) = (ac.x * bc.y, ac.y * bc.x);
    let determinant = left - right;
    let bound = ORIENT2D_ERROR * (left.abs() + right.abs()) + UNDERFLOW;
    if determinant > bound {
        Ordering::Greater
    } else if -determinant > bound {
        Ordering::Less
    } else {
        orient2d_exact(a, b, c)
    }
}

#[cold]
#[inline(never)]
fn orient2d_exact(a: DVec2, b: DVec2, c: DVec2) -> Ordering {
    if a == b || b == c || a == c {
        return Ordering::Equal;
    }
    if (a.x == b.x && b.x == c.x) || (a.y == b.y && b.y == c.y) {
        return Ordering::Equal;
    }
    if [a, b, c].iter().all(|p| expands(p.x) && expands(p.y)) {
        let coord = |p: DVec2| Coord { x: p.x, y: p.y };
        sign(robust::orient2d(coord(a), coord(b), coord(c)))
    } else {
        wide::orient2d(a, b, c)
    }
}

/// On which side of the plane through `a`, `b`, `c` the point `d` lies.
///
/// The sign of `(b - a) × (c - a) · (d - a)`: `Greater` means strictly on the
/// side from which the triangle looks counter-clockwise, that is strictly
/// outside of an outward facing triangle.
#[inline]
pub fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Ordering {
    let ad = a - d;
    let bd = b - d;
    let cd = c - d;
    let bc = (bd.x * cd.y, cd.x * bd.y);
    let ca = (cd.x * ad.y, ad.x * cd.y);
    let ab = (ad.x * bd.y, bd.x * ad.y);
    // Shewchuk's orientation is positive when `d` is *below* the triangle.
    let below = ad.z * (bc.0 - bc.1) + bd.z * (ca.0 - ca.1) + cd.z * (ab.0 - ab.1);
    let permanent = (bc.0.abs() + bc.1.abs()) * ad.z.abs()
        + (ca.0.abs() + ca.1.abs()) * bd.z.abs()
        + (ab.0.abs() + ab.1.abs()) * cd.z.abs();
    let bound =
        ORIENT3D_ERROR * permanent + UNDERFLOW * (1.0 + ad.z.abs() + bd.z.abs() + cd.z.abs());
    if below > bound {
        Ordering::Less
    } else if -below > bound {
        Ordering::Greater
    } else {
        orient3d_exact(a, b, c, d)
    }
}

#[cold]
#[inline(never)]
fn orient3d_exact(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Ordering {
    // Section points of one cut share a coordinate exactly: the common case here.
    for axis in 0..3 {
        if a[axis] == b[axis] && b[axis] == c[axis] && c[axis] == d[axis] {
            return Ordering::Equal;
        }
    }
    if a == b || a == c || a == d || b == c || b == d || c == d {
        return Ordering::Equal;
    }
    if [a, b, c, d]
        .iter()
        .all(|p| expands(p.x) && expands(p.y) && expands(p.z))
    {
        let coord = |p: DVec3| Coord3D {
            x: p.x,
            y: p.y,
            z: p.z,
        };
        sign(robust::orient3d(coord(a), coord(b), coord(c), coord(d))).reverse()
    } else {
        wide::orient3d(a, b, c, d)
    }
}

/// Whether three points lie on one line (two or three may coincide).
pub fn collinear(a: DVec3, b: DVec3, c: DVec3) -> bool {
    // A direction vanishes exactly when its three projections do.
    let xy = |p: DVec3| DVec2::new(p.x, p.y);
    let yz = |p: DVec3| DVec2::new(p.y, p.z);
    let zx = |p: DVec3| DVec2::new(p.z, p.x);
    orient2d(xy(a), xy(b), xy(c)).is_eq()
        && orient2d(yz(a), yz(b), yz(c)).is_eq()
        && orient2d(zx(a), zx(b), zx(c)).is_eq()
}

/// On which side of `plane` the point `x` lies: the sign of
/// `normal · x - offset` in exact arithmetic. `Less` is below, `Equal` is
/// really on the plane.
#[inline]
pub fn side(plane: &Plane, x: DVec3) -> Ordering {
    if let Some((axis, normal)) = plane.axis() {
        // One product is rounded monotonically; by ±1 it is exact.
        if normal == 1.0 {
            return compare(x[axis], plane.offset);
        } else if normal == -1.0 {
            return compare(-x[axis], plane.offset);
        }
    }
    let terms = plane.normal * x;
    let value = terms.x + terms.y + terms.z - plane.offset;
    let magnitude = terms.x.abs() + terms.y.abs() + terms.z.abs() + plane.offset.abs();
    let bound = SIDE_ERROR * magnitude + UNDERFLOW;
    if value > bound {
        Ordering::Greater
    } else if -value > bound {
        Ordering::Less
    } else {
        side_exact(plane, x)
    }
}

#[cold]
#[inline(never)]
fn side_exact(plane: &Plane, x: DVec3) -> Ordering {
    let (n, d) = (plane.normal, plane.offset);
    if ![n.x, n.y, n.z, x.x, x.y, x.z, d].into_iter().all(expands) {
        return wide::side(plane, x);
    }
    // Shewchuk 1997, figures 6 and 18: exact products, grown into one expansion.
    let mut expansion = [0.0; 7];
    let mut length = 0;
    let mut grow = |term: f64| {
        let mut carry = term;
        for part in &mut expansion[..length] {
            let (sum, rest) = two_sum(carry, *part);
            *part = rest;
            carry = sum;
        }
        expansion[length] = carry;
        length += 1;
    };
    for (p, q) in [(n.x, x.x), (n.y, x.y), (n.z, x.z)] {
        let product = p * q;
        grow(p.mul_add(q, -product));
        grow(product);
    }
    grow(-d);
    // Parts do not overlap and grow in magnitude: the last one that is not zero decides.
    expansion
        .iter()
        .rev()
        .find(|part| **part != 0.0)
        .map_or(Ordering::Equal, |part| sign(*part))
}

/// `a + b` as a rounded sum and its exact error (Knuth; Shewchuk 1997, theorem 7).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_virtual = sum - a;
    let a_virtual = sum - b_virtual;
    (sum, (a - a_virtual) + (b - b_virtual))
}

/// Whether `d` is inside the circle through `a`, `b`, `c`, given counter-clockwise.
///
/// `Greater`: strictly inside, `Equal`: on the circle (or line) through them.
pub fn incircle(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> Ordering {
    let fits = |x: f64| x == 0.0 || QUARTIC_RANGE.contains(&x.abs());
    if [a, b, c, d].iter().all(|p| fits(p.x) && fits(p.y)) {
        let coord = |p: DVec2| Coord { x: p.x, y: p.y };
        sign(robust::incircle(coord(a), coord(b), coord(c), coord(d)))
    } else {
        wide::incircle(a, b, c, d)
    }
}

fn expands(coordinate: f64) -> bool {
    coordinate == 0.0 || EXPANSION_RANGE.contains(&coordinate.abs())
}

fn sign(value: f64) -> Ordering {
    compare(value, 0.0)
}

fn compare(a: f64, b: f64) -> Ordering {
    if a < b {
        Ordering::Less
    } else if a > b {
        Ordering::Greater
    } else {
        Ordering::Equal
    }
}

#[cfg(test)]
mod tests;
