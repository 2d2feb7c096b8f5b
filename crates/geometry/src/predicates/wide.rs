//! The predicates over integers of unlimited width.
//!
//! A finite `f64` is a whole multiple of 2^-1074, so after scaling every
//! predicate is a polynomial over the integers. Slow (microseconds) and
//! reached only by coordinates that no expansion can hold.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use crate::plane::Plane;

/// Sign and magnitude; limbs from the least significant, none of the highest zero.
#[derive(Clone, Debug, PartialEq)]
struct Integer {
    negative: bool,
    limbs: Vec<u64>,
}

impl Integer {
    /// `value · 2^1074`.
    fn scaled(value: f64) -> Self {
        const FRACTION_BITS: u32 = 52;
        let bits = value.to_bits();
        let exponent = (bits >> FRACTION_BITS & 0x7ff) as usize;
        let fraction = bits & ((1 << FRACTION_BITS) - 1);
        let (mantissa, shift) = match exponent {
            0 => (fraction, 0),
            _ => (fraction | 1 << FRACTION_BITS, exponent - 1),
        };
        let spread = u128::from(mantissa) << (shift % 64);
        let mut limbs = vec![0; shift / 64];
        limbs.extend([spread as u64, (spread >> 64) as u64]);
        Self {
            negative: value.is_sign_negative(),
            limbs,
        }
        .trimmed()
    }

    fn trimmed(mut self) -> Self {
        while self.limbs.last() == Some(&0) {
            self.limbs.pop();
        }
        self.negative &= !self.limbs.is_empty();
        self
    }

    fn negated(mut self) -> Self {
        self.negative = !self.negative;
        self.trimmed()
    }

    fn sign(&self) -> Ordering {
        match (self.limbs.is_empty(), self.negative) {
            (true, _) => Ordering::Equal,
            (false, true) => Ordering::Less,
            (false, false) => Ordering::Greater,
        }
    }

    fn plus(&self, other: &Self) -> Self {
        if self.negative == other.negative {
            let limbs = add_magnitudes(&self.limbs, &other.limbs);
            return Self {
                negative: self.negative,
                limbs,
            }
            .trimmed();
        }
        let (large, small) = match compare_magnitudes(&self.limbs, &other.limbs) {
            Ordering::Less => (other, self),
            _ => (self, other),
        };
        let limbs = subtract_magnitudes(&large.limbs, &small.limbs);
        Self {
            negative: large.negative,
            limbs,
        }
        .trimmed()
    }

    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.clone().negated())
    }

    fn times(&self, other: &Self) -> Self {
        let mut limbs = vec![0; self.limbs.len() + other.limbs.len()];
        for (i, &a) in self.limbs.iter().enumerate() {
            let mut carry = 0;
            for (j, &b) in other.limbs.iter().enumerate() {
                let sum = u128::from(a) * u128::from(b) + u128::from(limbs[i + j]) + carry;
                limbs[i + j] = sum as u64;
                carry = sum >> 64;
            }
            limbs[i + other.limbs.len()] = carry as u64;
        }
        Self {
            negative: self.negative != other.negative,
            limbs,
        }
        .trimmed()
    }
}

fn compare_magnitudes(a: &[u64], b: &[u64]) -> Ordering {
    a.len()
        .cmp(&b.len())
        .then_with(|| a.iter().rev().cmp(b.iter().rev()))
}

fn add_magnitudes(a: &[u64], b: &[u64]) -> Vec<u64> {
    let mut carry = false;
    let mut limbs: Vec<u64> = (0..a.len().max(b.len()))
        .map(|i| {
            let (x, y) = (
                a.get(i).copied().unwrap_or(0),
                b.get(i).copied().unwrap_or(0),
            );
            let (sum, over) = x.overflowing_add(y);
            let (sum, again) = sum.overflowing_add(u64::from(carry));
            carry = over || again;
            sum
        })
        .collect();
    limbs.push(u64::from(carry));
    limbs
}

/// `a - b`, where `a` is not smaller.
fn subtract_magnitudes(a: &[u64], b: &[u64]) -> Vec<u64> {
    let mut borrow = false;
    a.iter()
        .enumerate()
        .map(|(i, &x)| {
            let (difference, under) = x.overflowing_sub(b.get(i).copied().unwrap_or(0));
            let (difference, again) = difference.overflowing_sub(u64::from(borrow));
            borrow = under || again;
            difference
        })
        .collect()
}

fn difference(a: DVec3, b: DVec3) -> [Integer; 3] {
    [0, 1, 2].map(|i| Integer::scaled(a[i]).minus(&Integer::scaled(b[i])))
}

fn minor(a: &Integer, b: &Integer, c: &Integer, d: &Integer) -> Integer {
    a.times(d).minus(&b.times(c))
}

pub(super) fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> Ordering {
    let [ux, uy, _] = difference(b.extend(0.0), a.extend(0.0));
    let [vx, vy, _] = difference(c.extend(0.0), a.extend(0.0));
    minor(&ux, &uy, &vx, &vy).sign()
}

pub(super) fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Ordering {
    let u = difference(b, a);
    let v = difference(c, a);
    let w = difference(d, a);
    let x = minor(&u[1], &u[2], &v[1], &v[2]).times(&w[0]);
    let y = minor(&u[2], &u[0], &v[2], &v[0]).times(&w[1]);
    let z = minor(&u[0], &u[1], &v[0], &v[1]).times(&w[2]);
    x.plus(&y).plus(&z).sign()
}

pub(super) fn incircle(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> Ordering {
    let [a, b, c] = [a, b, c].map(|p| difference(p.extend(0.0), d.extend(0.0)));
    let lift = |[x, y, _]: &[Integer; 3]| x.times(x).plus(&y.times(y));
    let cross = |p: &[Integer; 3], q: &[Integer; 3]| minor(&p[0], &p[1], &q[0], &q[1]);
    let bc = lift(&a).times(&cross(&b, &c));
    let ca = lift(&b).times(&cross(&c, &a));
    let ab = lift(&c).times(&cross(&a, &b));
    bc.plus(&ca).plus(&ab).sign()
}

pub(super) fn side(plane: &Plane, x: DVec3) -> Ordering {
    let offset = Integer::scaled(plane.offset).times(&Integer::scaled(1.0));
    let product = |i: usize| Integer::scaled(plane.normal[i]).times(&Integer::scaled(x[i]));
    product(0)
        .plus(&product(1))
        .plus(&product(2))
        .minus(&offset)
        .sign()
}
