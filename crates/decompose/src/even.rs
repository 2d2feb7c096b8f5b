//! Numbers and choices that rounding does not tip.
//!
//! Moving or turning a solid rounds its coordinates. Where a search compares, sorts or counts, a last
//! digit would decide between equals, and another cut leads to other parts. So lengths
//! that only the search sees are put on a lattice, and weights keep their leading digits.

use glam::DVec3;

/// Lengths are multiples of 1/LATTICE in the working copy (size about one): far above rounding, far
/// below what a search tells apart.
const LATTICE: f64 = 1_073_741_824.0;
/// Heights closer than this are one but for rounding.
pub const ROUNDING: f64 = 1e-10;
/// Bits that a weight keeps.
const BITS: u32 = 24;

/// A length as a search sees it.
pub fn length(x: f64) -> f64 {
    // One zero, so that equal lengths have equal bits.
    (x * LATTICE).round() / LATTICE + 0.0
}

/// A point as a search sees it.
pub fn point(p: DVec3) -> DVec3 {
    (p * LATTICE).round() / LATTICE + DVec3::ZERO
}

/// A weight that is compared with others: its leading [`BITS`] bits, rounded half away from zero.
pub fn weight(x: f64) -> f64 {
    /// What is not kept of the 53 bits of a number.
    const DROPPED: u32 = f64::MANTISSA_DIGITS - BITS;
    if !x.is_normal() {
        return 0.0;
    }
    // What carries beyond the highest bit goes into the exponent, as it should.
    let half = 1u64 << (DROPPED - 1);
    f64::from_bits((x.to_bits() + half) >> DROPPED << DROPPED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_changes_no_length_and_no_weight() {
        for x in [0.1, -0.7, 1.0 / 3.0, 0.25, 1e-3] {
            for noise in [-3e-16, 2e-16] {
                assert_eq!(length(x).to_bits(), length(x + noise).to_bits());
                assert_eq!(weight(x).to_bits(), weight(x * (1.0 + noise)).to_bits());
            }
            assert!((length(x) - x).abs() < 1e-9);
            assert!((weight(x) / x - 1.0).abs() < 1e-7);
        }
        assert_eq!(length(-1e-17).to_bits(), 0.0f64.to_bits());
        assert_eq!(weight(0.0), 0.0);
    }

    #[test]
    fn weights_are_rounded() {
        for (exact, rounded) in [
            (1.0, 1.0),
            (1.0 + 2f64.powi(-24), 1.0 + 2f64.powi(-23)),
            (1.0 + 2f64.powi(-25), 1.0),
            (-1.0 - 2f64.powi(-24), -1.0 - 2f64.powi(-23)),
            (2.0 - 2f64.powi(-30), 2.0),
        ] {
            assert_eq!(weight(exact).to_bits(), rounded.to_bits());
        }
    }

    #[test]
    fn what_is_apart_stays_apart() {
        assert!(length(0.1) < length(0.1 + 3e-9));
        assert!(weight(5.0) < weight(5.0 * (1.0 + 3e-7)));
    }
}
