//! Points of the plane and the exact signs everything rests on.

use robust::{orient2d, Coord};

/// A point, in the polygon's own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
}

impl Point {
    /// The point `(x, y)`.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Euclidean distance to `other`.
    ///
    /// Written with `sqrt`, which IEEE 754 rounds correctly, and not with
    /// `hypot`, which differs between platforms.
    pub fn distance(self, other: Self) -> f64 {
        let (dx, dy) = (other.x - self.x, other.y - self.y);
        (dx * dx + dy * dy).sqrt()
    }

    /// Lexicographic order, x first: the order of every sweep here.
    pub fn precedes(self, other: Self) -> bool {
        self.x < other.x || (self.x == other.x && self.y < other.y)
    }

    const fn coord(self) -> Coord<f64> {
        Coord {
            x: self.x,
            y: self.y,
        }
    }
}

/// Twice the signed area of `a b c`; its **sign is exact** (Shewchuk 1997):
/// positive when `c` lies left of the line from `a` to `b`.
pub fn orient(a: Point, b: Point, c: Point) -> f64 {
    orient2d(a.coord(), b.coord(), c.coord())
}

/// Distance from `q` to the segment `a b`.
pub fn distance_to_segment(q: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let squared = dx * dx + dy * dy;
    if squared == 0.0 {
        return q.distance(a);
    }
    let along = (q.x - a.x) * dx + (q.y - a.y) * dy;
    if along <= 0.0 {
        q.distance(a)
    } else if along >= squared {
        q.distance(b)
    } else {
        ((q.y - a.y) * dx - (q.x - a.x) * dy).abs() / squared.sqrt()
    }
}

/// Whether `q` lies strictly inside the corner `previous → v → next` of a
/// boundary that has its interior on the left.
pub fn in_corner(previous: Point, v: Point, next: Point, q: Point) -> bool {
    let leaving = orient(v, next, q) > 0.0;
    let entering = orient(previous, v, q) > 0.0;
    if orient(previous, v, next) >= 0.0 {
        leaving && entering
    } else {
        leaving || entering
    }
}

/// Signed area of a ring, positive counter-clockwise; summed about the first
/// point so that distance from the origin costs no digits.
pub fn signed_area(ring: &[Point]) -> f64 {
    let Some(&origin) = ring.first() else {
        return 0.0;
    };
    let cross = |a: Point, b: Point| {
        (a.x - origin.x) * (b.y - origin.y) - (b.x - origin.x) * (a.y - origin.y)
    };
    ring.windows(2)
        .map(|edge| cross(edge[0], edge[1]))
        .sum::<f64>()
        / 2.0
}

/// The convex hull, counter-clockwise, without collinear points
/// (Andrew's monotone chain, exact signs).
pub fn convex_hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull: Vec<Point> = Vec::with_capacity(sorted.len());
    for pass in 0..2 {
        let floor = hull.len() + 1;
        let mut push = |q: Point| {
            while hull.len() > floor && orient(hull[hull.len() - 2], hull[hull.len() - 1], q) <= 0.0
            {
                hull.pop();
            }
            hull.push(q);
        };
        if pass == 0 {
            sorted.iter().copied().for_each(&mut push);
        } else {
            sorted.iter().rev().copied().for_each(&mut push);
        }
        hull.pop();
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hull_drops_collinear_and_inner_points() {
        let square = [
            (0., 0.),
            (1., 0.),
            (2., 0.),
            (2., 2.),
            (1., 1.),
            (0., 2.),
            (0., 1.),
        ]
        .map(|(x, y)| Point::new(x, y));
        let hull = convex_hull(&square);
        assert_eq!(hull.len(), 4);
        assert_eq!(signed_area(&hull), 4.0);
    }

    #[test]
    fn a_reflex_corner_contains_what_a_convex_one_does_not() {
        let [a, v, b] = [(1., 0.), (0., 0.), (0., 1.)].map(|(x, y)| Point::new(x, y));
        let q = Point::new(-1.0, -1.0);
        assert!(in_corner(a, v, b, q) != in_corner(b, v, a, q));
    }
}
