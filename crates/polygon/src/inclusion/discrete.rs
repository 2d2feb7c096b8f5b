//! The discrete method (§2): shrink, hull, cut, restart, on sets of pixels.

use crate::point::convex_hull;
use crate::Point;

/// A binary image, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Pixels in a row.
    pub width: usize,
    /// Whether each pixel belongs to the shape.
    pub inside: Vec<bool>,
}

/// Which pixels are neighbours, and so the digital distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connectivity {
    /// Sides: city-block distance.
    Four,
    /// Sides and corners: chessboard distance.
    Eight,
}

impl Pixels {
    /// Number of rows.
    pub fn height(&self) -> usize {
        self.inside.len().checked_div(self.width).unwrap_or(0)
    }

    /// Number of pixels in the shape.
    pub fn area(&self) -> usize {
        self.inside.iter().filter(|&&p| p).count()
    }

    fn has(&self, x: i64, y: i64) -> bool {
        x >= 0
            && y >= 0
            && (x as usize) < self.width
            && (y as usize) < self.height()
            && self.inside[y as usize * self.width + x as usize]
    }

    fn place(&self, k: usize) -> (i64, i64) {
        ((k % self.width) as i64, (k / self.width) as i64)
    }

    fn keep(&mut self, wanted: impl Fn((i64, i64)) -> bool) {
        for k in 0..self.inside.len() {
            self.inside[k] = self.inside[k] && wanted(self.place(k));
        }
    }

    /// The connected component with pixel `seed`.
    fn component(&self, seed: usize, connectivity: Connectivity) -> Self {
        let mut found = Self {
            width: self.width,
            inside: vec![false; self.inside.len()],
        };
        let mut stack = vec![seed];
        found.inside[seed] = true;
        while let Some(k) = stack.pop() {
            let (x, y) = ((k % self.width) as i64, (k / self.width) as i64);
            for (dx, dy) in neighbours(connectivity) {
                if self.has(x + dx, y + dy) {
                    let next = (y + dy) as usize * self.width + (x + dx) as usize;
                    if !found.inside[next] {
                        found.inside[next] = true;
                        stack.push(next);
                    }
                }
            }
        }
        found
    }
}

fn neighbours(connectivity: Connectivity) -> impl Iterator<Item = (i64, i64)> {
    let all = [
        (1, 0),
        (-1, 0),
        (0, 1),
        (0, -1),
        (1, 1),
        (1, -1),
        (-1, 1),
        (-1, -1),
    ];
    let count = if connectivity == Connectivity::Four {
        4
    } else {
        8
    };
    all.into_iter().take(count)
}

/// Digital distance of every pixel to the nearest pixel with `inside == target`;
/// beyond the image counts as outside the shape.
fn distances(pixels: &Pixels, target: bool, connectivity: Connectivity) -> Vec<u32> {
    let (w, h) = (pixels.width, pixels.height());
    let border = if target { u32::MAX / 2 } else { 0 };
    let mut d: Vec<u32> = pixels
        .inside
        .iter()
        .map(|&p| if p == target { 0 } else { u32::MAX / 2 })
        .collect();
    let at = |d: &[u32], x: i64, y: i64| {
        if x < 0 || y < 0 || x as usize >= w || y as usize >= h {
            border
        } else {
            d[y as usize * w + x as usize]
        }
    };
    let diagonal = connectivity == Connectivity::Eight;
    for backward in [false, true] {
        for k in 0..w * h {
            let k = if backward { w * h - 1 - k } else { k };
            let (x, y) = ((k % w) as i64, (k / w) as i64);
            let s = if backward { 1 } else { -1 };
            let mut best = d[k].min(at(&d, x + s, y) + 1).min(at(&d, x, y + s) + 1);
            if diagonal {
                best = best
                    .min(at(&d, x - 1, y + s) + 1)
                    .min(at(&d, x + 1, y + s) + 1);
            }
            d[k] = best;
        }
    }
    d
}

/// μ(P, Q) of §2: minus the Hausdorff distance of two shapes of one image.
/// `None` when one of them is empty.
pub fn hausdorff(p: &Pixels, q: &Pixels, connectivity: Connectivity) -> Option<i64> {
    if p.area() == 0 || q.area() == 0 {
        return None;
    }
    let one_sided = |a: &Pixels, b: &Pixels| {
        let d = distances(b, true, connectivity);
        a.inside
            .iter()
            .zip(d)
            .filter(|(&inside, _)| inside)
            .map(|(_, d)| d)
            .max()
            .unwrap_or(0)
    };
    Some(-i64::from(one_sided(p, q).max(one_sided(q, p))))
}

/// A digitally convex set of pixels in the component of `shape` that holds
/// its deepest pixel: every pixel whose centre is in its hull belongs to it.
/// Empty for an empty shape.
pub fn convex_pixels(shape: &Pixels, connectivity: Connectivity) -> Pixels {
    let mut shape = shape.clone();
    loop {
        let depth = distances(&shape, false, connectivity);
        let deepest = (0..depth.len()).max_by_key(|&k| (depth[k], std::cmp::Reverse(k)));
        let Some(seed) = deepest.filter(|&k| shape.inside[k]) else {
            return shape;
        };
        shape = shape.component(seed, connectivity);
        // shrink until the hull fits; one pixel always does
        let mut level = 0;
        let mut violations: Vec<(i64, i64)> = Vec::new();
        let sides = loop {
            let kept = |k: usize| shape.inside[k] && depth[k] > level;
            let hull = hull_of(
                &shape,
                if level >= depth[seed] {
                    None
                } else {
                    Some(&kept)
                },
                seed,
            );
            let outside: Vec<_> = pixels_of(&hull)
                .filter(|&(x, y)| !shape.has(x, y))
                .collect();
            if outside.is_empty() {
                break hull;
            }
            violations = outside;
            level += 1;
        };
        if violations.is_empty() {
            return shape;
        }
        cut(&mut shape, &sides, &violations);
    }
}

/// Cuts the shape along the hull side that looks at the nearest concavity:
/// everything as far beyond that side as the concavity goes. A hull of one
/// pixel or one line has no sides; then, of sixteen directions, the one that
/// keeps most pixels.
fn cut(shape: &mut Pixels, hull: &[(i64, i64)], violations: &[(i64, i64)]) {
    if hull.len() < 3 {
        let (x, y) = hull[0];
        let Some(&near) = violations
            .iter()
            .min_by_key(|v| (v.0 - x).pow(2) + (v.1 - y).pow(2))
        else {
            return;
        };
        let steps = [-2, -1, 0, 1, 2];
        let best = steps
            .iter()
            .flat_map(|&a| steps.iter().map(move |&b| (a, b)))
            .filter(|&u| hull.iter().all(|&p| along(u, p) < along(u, near)))
            .max_by_key(|&u| {
                let kept = |k: usize| shape.inside[k] && along(u, shape.place(k)) < along(u, near);
                (0..shape.inside.len()).filter(|&k| kept(k)).count()
            });
        if let Some(u) = best {
            shape.keep(|p| along(u, p) < along(u, near));
        }
        return;
    }
    // how far beyond a side, in units of the side's length
    let normal = |k: usize| {
        let ((ax, ay), (bx, by)) = (hull[k], hull[(k + 1) % hull.len()]);
        (by - ay, ax - bx)
    };
    let beyond = |k: usize, p| along(normal(k), p) - along(normal(k), hull[k]);
    let mut best: Option<(f64, usize, i64)> = None;
    for &v in violations {
        // the side a concavity lies beyond is the one it is farthest beyond
        let outer = (0..hull.len())
            .map(|k| {
                (
                    beyond(k, v) as f64 / (along(normal(k), normal(k)) as f64).sqrt(),
                    k,
                )
            })
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        if let Some((distance, side)) = outer {
            if best.is_none_or(|b| distance < b.0) {
                best = Some((distance, side, beyond(side, v)));
            }
        }
    }
    if let Some((_, side, limit)) = best {
        shape.keep(|p| beyond(side, p) < limit);
    }
}

fn along(u: (i64, i64), p: (i64, i64)) -> i64 {
    u.0 * p.0 + u.1 * p.1
}

/// Hull of the kept pixels' centres, counter-clockwise; of `seed` alone if none are kept.
fn hull_of(shape: &Pixels, kept: Option<&dyn Fn(usize) -> bool>, seed: usize) -> Vec<(i64, i64)> {
    let w = shape.width;
    let Some(kept) = kept else {
        return vec![((seed % w) as i64, (seed / w) as i64)];
    };
    let mut ends = Vec::new();
    for y in 0..shape.height() {
        let mut row = (0..w).filter(|x| kept(y * w + x));
        if let Some(first) = row.next() {
            ends.push(Point::new(first as f64, y as f64));
            ends.push(Point::new(
                row.next_back().unwrap_or(first) as f64,
                y as f64,
            ));
        }
    }
    convex_hull(&ends)
        .into_iter()
        .map(|p| (p.x as i64, p.y as i64))
        .collect()
}

/// All pixels whose centre is in the hull, in integers.
fn pixels_of(hull: &[(i64, i64)]) -> impl Iterator<Item = (i64, i64)> + '_ {
    let low = hull.iter().map(|p| p.1).min().unwrap_or(0);
    let high = hull.iter().map(|p| p.1).max().unwrap_or(-1);
    (low..=high).flat_map(move |y| {
        let mut x0 = hull.iter().map(|p| p.0).min().unwrap_or(0);
        let mut x1 = hull.iter().map(|p| p.0).max().unwrap_or(-1);
        for (k, &(ax, ay)) in hull.iter().enumerate() {
            let (bx, by) = hull[(k + 1) % hull.len()];
            let (dx, dy) = (bx - ax, by - ay);
            // left of the side: dx (y - ay) >= dy (x - ax)
            let reach = dx * (y - ay);
            if dy > 0 {
                x1 = x1.min(ax + reach.div_euclid(dy));
            } else if dy < 0 {
                x0 = x0.max(ax - reach.div_euclid(-dy));
            }
        }
        (x0..=x1).map(move |x| (x, y))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(rows: &[&str]) -> Pixels {
        Pixels {
            width: rows[0].len(),
            inside: rows
                .iter()
                .flat_map(|r| r.chars().map(|c| c == '#'))
                .collect(),
        }
    }

    #[test]
    fn a_convex_shape_is_its_own_answer() {
        let square = image(&[".....", ".###.", ".###.", ".###.", "....."]);
        assert_eq!(convex_pixels(&square, Connectivity::Four), square);
        assert_eq!(hausdorff(&square, &square, Connectivity::Eight), Some(0));
    }

    #[test]
    fn the_arm_of_an_l_is_cut_off() {
        let shape = image(&["######..", "######..", "######..", "########", "########"]);
        let found = convex_pixels(&shape, Connectivity::Four);
        assert!(found
            .inside
            .iter()
            .zip(&shape.inside)
            .all(|(f, s)| !f || *s));
        assert_eq!(found.area(), 31);
        let places = |p: &Pixels| -> Vec<_> {
            (0..p.inside.len())
                .filter(|&k| p.inside[k])
                .map(|k| p.place(k))
                .collect()
        };
        let nearest = |a: (i64, i64)| {
            places(&found)
                .iter()
                .map(|b| (a.0 - b.0).abs() + (a.1 - b.1).abs())
                .min()
                .unwrap()
        };
        let farthest = places(&shape).into_iter().map(nearest).max().unwrap();
        assert_eq!(
            hausdorff(&shape, &found, Connectivity::Four),
            Some(-farthest)
        );
    }

    #[test]
    fn every_result_is_digitally_convex_and_inside() {
        let mut state = 7_u64;
        for _ in 0..200 {
            let (w, h) = (18, 14);
            let mut shape = Pixels {
                width: w,
                inside: vec![false; w * h],
            };
            for _ in 0..6 {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                let [x, y, a, b] = [33, 40, 47, 54].map(|s| (state >> s) as usize % 9);
                for j in y..(y + b + 1).min(h) {
                    for i in x..(x + a + 1).min(w) {
                        shape.inside[j * w + i] = true;
                    }
                }
            }
            let found = convex_pixels(&shape, Connectivity::Eight);
            assert!(found.area() > 0);
            let all = |k: usize| found.inside[k];
            let hull = hull_of(&found, Some(&all), 0);
            assert!(pixels_of(&hull).all(|(x, y)| found.has(x, y)));
            assert!(found
                .inside
                .iter()
                .zip(&shape.inside)
                .all(|(f, s)| !f || *s));
        }
    }
}
