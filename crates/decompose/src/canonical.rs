//! One order for all meshes of one solid.
//!
//! Sorting, ties and sums depend on the order of vertices and faces; so the engine works on
//! a copy whose order follows from the coordinates alone.

use assetpipe_geometry::Mesh;
use glam::DVec3;

/// The same triangles: vertices by coordinates, each triangle from its smallest vertex on,
/// triangles by their vertices. Meshes that differ in their orders only give the same bits,
/// as long as no two of their vertices coincide.
pub fn ordered(mesh: &Mesh) -> Mesh {
    // One zero, so that equal points are equal.
    let at = |v: u32| mesh.vertices[v as usize] + DVec3::ZERO;
    let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    order.sort_by(|&a, &b| {
        let (p, q) = (at(a), at(b));
        p.x.total_cmp(&q.x)
            .then(p.y.total_cmp(&q.y))
            .then(p.z.total_cmp(&q.z))
    });
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old as usize] = new as u32;
    }
    let mut triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| place[v as usize]);
            if a <= b && a <= c {
                [a, b, c]
            } else if b <= c {
                [b, c, a]
            } else {
                [c, a, b]
            }
        })
        .collect();
    triangles.sort_unstable();
    Mesh {
        vertices: order.iter().map(|&v| at(v)).collect(),
        triangles,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;
    use assetpipe_geometry::sample::Random;

    #[test]
    fn orders_do_not_matter() {
        let mut random = Random::new(4);
        let points: Vec<DVec3> = (0..60).map(|_| random.in_cube()).collect();
        let mesh = convex_hull(&points).unwrap();
        let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
        random.shuffle(&mut order);
        let mut shuffled = Mesh {
            vertices: vec![DVec3::ZERO; order.len()],
            triangles: mesh.triangles.clone(),
        };
        for (old, &new) in order.iter().enumerate() {
            shuffled.vertices[new as usize] = mesh.vertices[old];
        }
        for t in &mut shuffled.triangles {
            *t = t.map(|v| order[v as usize]);
            t.rotate_left(random.below(3) as usize);
        }
        random.shuffle(&mut shuffled.triangles);
        let (a, b) = (ordered(&mesh), ordered(&shuffled));
        assert_eq!(a.vertices, b.vertices);
        assert_eq!(a.triangles, b.triangles);
    }
}
