//! Fewer vertices, inward only.

use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;

/// A polytope of at most `most` of the vertices of `polytope`, so inside it:
/// extreme ones first, then for every face the vertex farthest beyond it,
/// until none is farther than `reach`.
pub fn thin_inward(polytope: &Mesh, reach: f64, most: usize) -> Option<Mesh> {
    let points = &polytope.vertices;
    if points.len() <= 8 {
        return Some(polytope.clone());
    }
    let mut kept: Vec<usize> = Vec::new();
    for direction in DIRECTIONS {
        let far = |sign: f64| {
            (0..points.len()).fold(0, |best, k| {
                let ahead = sign * direction.dot(points[k] - points[best]);
                if ahead > 0.0 {
                    k
                } else {
                    best
                }
            })
        };
        kept.extend([far(1.0), far(-1.0)]);
    }
    kept.sort_unstable();
    kept.dedup();
    kept.truncate(most);
    loop {
        let chosen: Vec<DVec3> = kept.iter().map(|&k| points[k]).collect();
        let hull = convex_hull(&chosen).ok()?;
        let mut missing: Vec<(f64, usize)> = hull
            .faces()
            .filter_map(|[a, b, c]| {
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let mut best = (reach, usize::MAX);
                for (k, p) in points.iter().enumerate() {
                    let height = normal.dot(*p - a);
                    if height > best.0 {
                        best = (height, k);
                    }
                }
                (best.1 != usize::MAX).then_some(best)
            })
            .collect();
        missing.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let before = kept.len();
        for (_, k) in missing {
            if kept.len() < most && !kept.contains(&k) {
                kept.push(k);
            }
        }
        if kept.len() == before {
            return Some(hull);
        }
    }
}

const DIRECTIONS: [DVec3; 7] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
];
