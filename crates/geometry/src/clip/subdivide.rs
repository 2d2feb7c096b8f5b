//! Bringing points that the cap has put on its boundary into the triangles
//! on the other side.

use std::collections::BTreeMap;

/// A triangle and which of its sides (from each corner to the next) are
/// sides of the mesh, not seams inside a divided triangle.
type Item = ([u32; 3], [bool; 3]);

/// Splits triangles at points that the cap has put on their sides.
///
/// `subdivided` names section points, which `triangles` number from `first`
/// on. The boundary of the result is that of `triangles` with every
/// subdivided side replaced by its parts. It ends: a side's parts are
/// strictly shorter than the side, and seams are not subdivided, whatever
/// their ends.
pub fn subdivide(
    triangles: &[[u32; 3]],
    first: u32,
    subdivided: &BTreeMap<(u32, u32), u32>,
) -> Vec<[u32; 3]> {
    let via = |a: u32, b: u32| {
        let (a, b) = (a.min(b).checked_sub(first)?, a.max(b) - first);
        subdivided.get(&(a, b)).map(|point| first + point)
    };
    let mut result = Vec::with_capacity(triangles.len());
    let mut stack: Vec<Item> = Vec::new();
    for &t in triangles {
        stack.push((t, [true; 3]));
        while let Some(item) = stack.pop() {
            match turns(item).find_map(|turn| Some((turn, divide(turn, via)?))) {
                None => result.push(item.0),
                Some((([a, b, c], [_, bc, ca]), m)) if m != c => {
                    stack.push(([a, m, c], [true, false, ca]));
                    stack.push(([m, b, c], [true, bc, false]));
                }
                // The side runs through the opposite corner: nothing is left
                // but what its parts have and the other sides, as seams, lack.
                Some((([a, b, c], [_, bc, ca]), _)) => {
                    for (p, q, is_side) in [(c, b, bc), (a, c, ca)] {
                        if let Some(m) = via(p, q).filter(|_| !is_side) {
                            stack.push(([p, m, q], [true, true, false]));
                        }
                    }
                }
            }
        }
    }
    result
}

/// A triangle starting at each of its corners.
fn turns(([a, b, c], [ab, bc, ca]): Item) -> impl Iterator<Item = Item> {
    [
        ([a, b, c], [ab, bc, ca]),
        ([b, c, a], [bc, ca, ab]),
        ([c, a, b], [ca, ab, bc]),
    ]
    .into_iter()
}

/// The point that divides the first side, if it is a side.
fn divide((t, sides): Item, via: impl Fn(u32, u32) -> Option<u32>) -> Option<u32> {
    via(t[0], t[1]).filter(|_| sides[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The boundary as a sum of directed edges.
    fn boundary(triangles: &[[u32; 3]]) -> BTreeMap<(u32, u32), i32> {
        let mut sum = BTreeMap::new();
        for t in triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *sum.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        sum.retain(|_, times| *times != 0);
        sum
    }

    /// The same, with every edge replaced by its parts.
    fn expanded(triangles: &[[u32; 3]], parts: &BTreeMap<(u32, u32), u32>) -> Vec<[u32; 3]> {
        // Degenerate triangles [a, m, b] carry the difference as a chain.
        let mut chain = triangles.to_vec();
        let mut edges: Vec<((u32, u32), i32)> = boundary(triangles).into_iter().collect();
        while let Some(((a, b), times)) = edges.pop() {
            if let Some(&m) = parts.get(&(a, b)) {
                let flap = if times > 0 { [a, m, b] } else { [b, m, a] };
                chain.extend((0..times.abs()).map(|_| flap));
                for (p, q) in [(a, m), (m, b)] {
                    let sign = if p < q { times } else { -times };
                    edges.push(((p.min(q), p.max(q)), sign));
                }
            }
        }
        chain
    }

    #[test]
    fn boundaries_are_subdivided_whatever_the_seams_run_along() {
        let cases: [&[((u32, u32), u32)]; 6] = [
            &[((0, 1), 3)],
            &[((0, 1), 3), ((1, 2), 4), ((0, 2), 5)],
            &[((0, 1), 3), ((0, 3), 4), ((3, 4), 5)],
            // The seam from 3 to 2 is named by another side, through 0.
            &[((0, 1), 3), ((2, 3), 0)],
            &[((0, 1), 2)],
            &[((0, 1), 3), ((1, 3), 2), ((2, 3), 4)],
        ];
        for case in cases {
            let parts: BTreeMap<(u32, u32), u32> = case.iter().copied().collect();
            let whole = [[0, 1, 2]];
            let divided = subdivide(&whole, 0, &parts);
            assert_eq!(
                boundary(&divided),
                boundary(&expanded(&whole, &parts)),
                "{case:?}"
            );
        }
    }
}
