//! Borders of caps: cut in two, closed along the line of both planes, cancelled.

use assetpipe_geometry::Plane;

use super::half::{Crossings, Half};
use super::{Cap, Piece};

/// Divide a cap's border; the line in which both planes meet closes both
/// halves and becomes part of the new cap's border.
pub fn split_cap(
    whole: &Piece,
    cap: &Cap,
    plane: Plane,
    sides: &[i8],
    crossings: &Crossings,
    (below, above): (&mut Half, &mut Half),
    (border_below, border_above): (&mut Vec<[u32; 2]>, &mut Vec<[u32; 2]>),
) {
    let mut low = Vec::new();
    let mut high = Vec::new();
    // Where the border passes a line just below, and one just above, the line
    // of intersection: (position along it, +1 upwards / -1 downwards, vertex).
    let along = cap.plane.normal.cross(plane.normal);
    let (mut leave, mut enter): (Passages, Passages) = (Vec::new(), Vec::new());
    for &[a, b] in &cap.border {
        let (sa, sb) = (sides[a as usize], sides[b as usize]);
        if sa == 0 && sb == 0 {
            continue;
        }
        if sa * sb < 0 {
            let (l, h) = crossings.find(a, b);
            if sa < 0 {
                low.push([below.old(whole, a), l]);
                high.push([h, above.old(whole, b)]);
            } else {
                high.push([above.old(whole, a), h]);
                low.push([l, below.old(whole, b)]);
            }
            let position = along.dot(below.piece.points[l as usize]);
            leave.push((position, i32::from(sb), l));
            enter.push((position, i32::from(sb), h));
        } else {
            let half = if sa < 0 || sb < 0 {
                &mut *below
            } else {
                &mut *above
            };
            let segment = [half.old(whole, a), half.old(whole, b)];
            let (list, passages) = if sa < 0 || sb < 0 {
                (&mut low, &mut leave)
            } else {
                (&mut high, &mut enter)
            };
            list.push(segment);
            if sa == 0 {
                passages.push((
                    along.dot(whole.points[a as usize]),
                    i32::from(sb),
                    segment[0],
                ));
            } else if sb == 0 {
                passages.push((
                    along.dot(whole.points[b as usize]),
                    -i32::from(sa),
                    segment[1],
                ));
            }
        }
    }
    close(leave, 1, &mut low, border_below);
    close(enter, -1, &mut high, border_above);
    if !low.is_empty() {
        below.piece.caps.push(Cap {
            plane: cap.plane,
            border: low,
        });
    }
    if !high.is_empty() {
        above.piece.caps.push(Cap {
            plane: cap.plane,
            border: high,
        });
    }
}

/// (position along the line, direction, vertex).
type Passages = Vec<(f64, i32, u32)>;

/// Close a cap's border along the line, where the running sum says that the
/// region is inside; the new cap gets the same segments the other way round.
fn close(
    mut passages: Passages,
    sense: i32,
    border: &mut Vec<[u32; 2]>,
    other: &mut Vec<[u32; 2]>,
) {
    passages.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.2.cmp(&y.2)));
    let mut winding = 0;
    for pair in passages.windows(2) {
        winding += sense * pair[0].1;
        let (from, to) = if winding > 0 {
            (pair[0].2, pair[1].2)
        } else {
            (pair[1].2, pair[0].2)
        };
        if from != to {
            for _ in 0..winding.abs() {
                border.push([from, to]);
                other.push([to, from]);
            }
        }
    }
}

/// Leave out segments that are there in both directions.
pub fn cancel(border: &mut Vec<[u32; 2]>) {
    let name = |s: &[u32; 2]| (s[0].min(s[1]), s[0].max(s[1]));
    border.sort_unstable_by_key(|s| (name(s), *s));
    let mut kept = Vec::with_capacity(border.len());
    for run in border.chunk_by(|s, t| name(s) == name(t)) {
        let forward = run.iter().filter(|s| s[0] < s[1]).count();
        let back = run.len() - forward;
        // Backward ones were sorted behind.
        let both = forward.min(back);
        kept.extend_from_slice(&run[both..run.len() - both]);
    }
    *border = kept;
}
