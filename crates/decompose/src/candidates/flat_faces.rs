//! Planes of flat faces: where machined parts want to be cut.
//!
//! A face perpendicular to a direction offers the plane it lies in: cutting
//! there peels a plate from what stands on it. The plane goes through the
//! outermost vertex of the face, so that nothing of the face is left on the
//! side it faces; where all its vertices share one coordinate, as in the
//! frame a part was drawn in, that is the face itself.

use glam::DVec3;

use crate::even;
use crate::search::piece::Piece;

/// Sine of the largest angle between a face's normal and the direction.
const TILT: f64 = 1e-3;

/// Offsets along the unit vector `w` of the flat faces of `piece` with at
/// least `area` of surface, at most `most` of them by area, increasing.
/// Faces closer together than `gap` count as one.
pub fn offsets(piece: &Piece, w: DVec3, area: f64, gap: f64, most: usize) -> Vec<f64> {
    // (height, area): one entry a triangle, heights at the outermost vertex.
    let mut faces: Vec<(f64, f64)> = Vec::new();
    for t in &piece.triangles {
        let [a, b, c] = t.map(|v| piece.points[v as usize]);
        let normal = (b - a).cross(c - a);
        let along = normal.dot(w);
        if normal.length_squared() - along * along > TILT * TILT * normal.length_squared() {
            continue;
        }
        let heights = [a, b, c].map(|p| w.dot(p));
        let height = if along > 0.0 {
            heights.into_iter().fold(f64::NEG_INFINITY, f64::max)
        } else {
            heights.into_iter().fold(f64::INFINITY, f64::min)
        };
        faces.push((height, 0.5 * along));
    }
    faces.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut clusters: Vec<(f64, f64)> = Vec::new();
    for sense in [1.0, -1.0] {
        let mut run: Option<(f64, f64, f64)> = None; // first height, last height, area
        let mut close = |run: Option<(f64, f64, f64)>| {
            if let Some((first, last, sum)) = run {
                clusters.push((if sense > 0.0 { last } else { first }, sum));
            }
        };
        for &(height, signed) in faces.iter().filter(|f| f.1 * sense > 0.0) {
            match &mut run {
                Some((_, last, sum)) if height - *last <= gap => {
                    *last = height;
                    *sum += signed.abs();
                }
                _ => {
                    close(run.take());
                    run = Some((height, height, signed.abs()));
                }
            }
        }
        close(run);
    }
    clusters.retain(|c| even::weight(c.1) >= even::weight(area));
    clusters.sort_by(|x, y| {
        let (a, b) = (even::weight(x.1), even::weight(y.1));
        b.total_cmp(&a).then(x.0.total_cmp(&y.0))
    });
    clusters.truncate(most);
    let mut offsets: Vec<f64> = clusters.into_iter().map(|c| c.0).collect();
    offsets.sort_by(f64::total_cmp);
    offsets.dedup();
    offsets
}
