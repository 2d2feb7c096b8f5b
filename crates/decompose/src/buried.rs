//! Samples of a part's surface that lie deeper than ε in its hull: what part → hull of Eq. 2 refuses
//! (Wei et al. 2022), as a deep hole that is narrower than ε, where no space is forbidden. Like
//! [`forbidden`](crate::forbidden) samples they only make the search foresee the proof.

use assetpipe_geometry::distance::ConvexBody;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::search::piece::Piece;
use crate::search::sweep::Forbidden;

/// Most rows of samples in one triangle.
const ROWS: f64 = 100.0;

/// About `count` samples of the whole surface of `piece`, those deeper than `epsilon` in `hull`.
/// Each weighs its area times `height`.
pub fn sample(
    piece: &Piece,
    hull: &Mesh,
    epsilon: f64,
    count: usize,
    height: f64,
) -> Vec<Forbidden> {
    let body = ConvexBody::new(hull);
    let planes = body.half_spaces();
    let is_deep = |p: DVec3| planes.iter().all(|s| s.normal.dot(p) < s.offset - epsilon);
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let corners = || (piece.triangles.iter()).map(|t| t.map(|v| piece.points[v as usize]));
    let cell = corners().map(area).sum::<f64>() / count as f64;
    let mut samples = Vec::new();
    for corners in corners() {
        let whole = area(corners);
        let rows = (whole / cell).sqrt().ceil().clamp(1.0, ROWS);
        let weight = height * whole / (rows * rows);
        let deep = middles(corners, rows as u32).filter(|&p| is_deep(p));
        samples.extend(deep.map(|point| Forbidden {
            point,
            weight,
            depth: epsilon,
        }));
    }
    samples
}

/// The middles of the n² congruent triangles that `rows` rows divide a triangle into.
fn middles([a, b, c]: [DVec3; 3], rows: u32) -> impl Iterator<Item = DVec3> {
    let at = move |i: f64, j: f64| a + ((b - a) * i + (c - a) * j) / f64::from(rows);
    (0..rows).flat_map(move |i| {
        (0..rows - i).flat_map(move |j| {
            let (x, y) = (f64::from(i), f64::from(j));
            let upright = at(x + 1.0 / 3.0, y + 1.0 / 3.0);
            let turned = (i + j + 1 < rows).then(|| at(x + 2.0 / 3.0, y + 2.0 / 3.0));
            std::iter::once(upright).chain(turned)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cuboid;

    #[test]
    fn triangles_are_divided_evenly() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for rows in 1..6 {
            let points: Vec<DVec3> = middles(corners, rows).collect();
            assert_eq!(points.len(), (rows * rows) as usize);
            let mean = points.iter().sum::<DVec3>() / points.len() as f64;
            assert!(mean.distance(DVec3::new(1.0 / 3.0, 1.0 / 3.0, 0.0)) < 1e-12);
        }
    }

    #[test]
    fn only_what_is_deep_counts_and_by_its_area() {
        let hull = cuboid(DVec3::ZERO, DVec3::ONE);
        // A square in the middle plane: the inner 0.6 × 0.6 of it is deeper than 0.2.
        let square = Piece {
            points: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                .map(|(x, y)| DVec3::new(x, y, 0.5))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            caps: Vec::new(),
        };
        let samples = sample(&square, &hull, 0.2, 4000, 2.0);
        let weight: f64 = samples.iter().map(|s| s.weight).sum();
        assert!((weight - 2.0 * 0.36).abs() < 0.03, "{weight}");
        assert!(samples
            .iter()
            .all(|s| (s.point - 0.5).abs().max_element() < 0.3));
    }
}
