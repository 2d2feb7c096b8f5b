//! Points moved a little, so that no four are on a plane.

use glam::DVec3;

/// Size of the jitter of search-only points; working copies have extent ~1.
const JITTER: f64 = 4e-7;

/// Points closer than its inverse are moved alike.
const GRAIN: f64 = 67_108_864.0;

/// A point moved by noise that depends on nothing but where it is.
pub fn jittered(p: DVec3) -> DVec3 {
    let mut x = 0u64;
    for q in (p * GRAIN).round().to_array() {
        // The finaliser of SplitMix64.
        x = x
            .wrapping_add(q as i64 as u64)
            .wrapping_add(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^= x >> 31;
    }
    let part = |shift: u32| ((x >> shift) & 0x1f_ffff) as f64 / 2_097_152.0 - 0.5;
    p + JITTER * DVec3::new(part(0), part(21), part(42))
}
