use assetpipe_geometry::Plane;
use glam::DVec3;

use super::{sweep, Basis, Forbidden, Scratch, Sweep};
use crate::search::piece::Piece;
use crate::shapes::{both, cuboid};

/// An L: [0,2]×[0,1]×[0,1] and [0,1]×[0,1]×[1,2] as one chain of two boxes.
fn two_boxes() -> Piece {
    let foot = cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
    let tower = cuboid(DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, 1.0, 2.0));
    Piece::from(&both(&foot, &tower))
}

/// Cuts along `basis`, with outlines as they are.
fn priced(piece: &Piece, basis: &Basis, offsets: &[f64], forbidden: &[Forbidden]) -> Sweep {
    let edges: Vec<_> = piece.edges().collect();
    let mut scratch = Scratch::default();
    sweep(piece, &edges, basis, offsets, forbidden, 0.0, &mut scratch)
}

#[test]
fn volumes_and_hulls_of_a_cuboid() {
    let piece = Piece::from(&cuboid(
        DVec3::new(-1.0, -0.5, -0.25),
        DVec3::new(1.0, 0.5, 0.25),
    ));
    for axis in 0..3 {
        let basis = Basis::axis(axis);
        let half = [1.0, 0.5, 0.25][axis];
        let offsets: Vec<f64> = (1..8).map(|i| half * (f64::from(i) / 4.0 - 1.0)).collect();
        let result = priced(&piece, &basis, &offsets, &[]);
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
    let w = DVec3::new(1.0, 2.0, 3.0).normalize();
    let basis = Basis::along(w);
    let offsets = [0.8, 1.2, 1.7];
    let result = priced(&piece, &basis, &offsets, &[]);
    for trial in &result.trials {
        let cut = Plane {
            normal: w,
            offset: trial.offset,
        };
        let (below, above) = piece.split(cut);
        assert!((below.volume() - trial.below.part).abs() < 1e-9);
        assert!((above.volume() - trial.above.part).abs() < 1e-9);
        // Cutting above everything prices the hull of a half alone.
        for (half, side) in [(below, trial.below), (above, trial.above)] {
            let all = priced(&half, &basis, &[100.0], &[]);
            assert!((all.trials[0].below.hull - side.hull).abs() < 1e-5);
        }
    }
}

#[test]
fn forbidden_samples_enter_where_the_hull_reaches_them() {
    let piece = two_boxes();
    let corner = Forbidden {
        point: DVec3::new(1.2, 0.5, 1.2),
        weight: 1.0,
        depth: 0.0,
    };
    let basis = Basis::axis(2);
    let offsets = [0.5, 1.0, 1.1, 1.5];
    let result = priced(&piece, &basis, &offsets, &[corner]);
    let below: Vec<f64> = result.trials.iter().map(|t| t.below.forbidden).collect();
    let above: Vec<f64> = result.trials.iter().map(|t| t.above.forbidden).collect();
    assert_eq!(below, [0.0, 0.0, 0.0, 1.0]);
    // At z = 1 the flat face of the foot is no part of the tower.
    assert_eq!(above, [1.0, 0.0, 0.0, 0.0]);
    assert_eq!((result.enters_below[0], result.leaves_above[0]), (3, 1));
}
