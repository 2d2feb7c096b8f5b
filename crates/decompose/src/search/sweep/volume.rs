//! Volumes below parallel planes.

use glam::DVec3;

use crate::search::piece::Piece;

/// Volume below each plane, and at the end the whole volume.
pub fn volumes_below(piece: &Piece, local: &[DVec3], offsets: &[f64]) -> Vec<f64> {
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
