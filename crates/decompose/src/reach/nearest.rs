//! Distances between lattice points.

use rayon::prelude::*;

use super::lattice::Lattice;

/// The square of each point's distance to the nearest marked one, in spacings,
/// exactly; at most `most`².
///
/// Axis after axis, as in Saito and Toriwaki, *New algorithms for Euclidean distance
/// transformation*, 1994: min over d of f(x + d) + d².
pub(super) fn squares(lattice: &Lattice, marked: &[bool], most: usize) -> Vec<u16> {
    let [nx, ny, _] = lattice.size;
    let most = most.min(255);
    let cap = (most * most) as u16;
    let mut along_x = vec![cap; lattice.len()];
    along_x
        .par_chunks_mut(nx)
        .zip(marked.par_chunks(nx))
        .for_each(|(row, marks)| {
            let mut since = most;
            for (value, &mark) in row.iter_mut().zip(marks) {
                since = if mark { 0 } else { (since + 1).min(most) };
                *value = (since * since) as u16;
            }
            since = most;
            for (value, &mark) in row.iter_mut().zip(marks).rev() {
                since = if mark { 0 } else { (since + 1).min(most) };
                *value = (*value).min((since * since) as u16);
            }
        });
    let along_y = nearest_rows(&along_x, nx, ny, most);
    nearest_rows(&along_y, nx * ny, lattice.size[2], most)
}

/// min over d of f(k + d) + d², between the rows of each group of `count` rows.
fn nearest_rows(from: &[u16], row: usize, count: usize, most: usize) -> Vec<u16> {
    let mut to = from.to_vec();
    to.par_chunks_mut(row).enumerate().for_each(|(k, out)| {
        let group = k / count * count;
        for step in 1..most {
            let add = (step * step) as u16;
            let here = k - group;
            let beside = [here.checked_sub(step), Some(here + step)];
            for other in beside.into_iter().flatten().filter(|&o| o < count) {
                let values = &from[(group + other) * row..(group + other + 1) * row];
                for (value, &next) in out.iter_mut().zip(values) {
                    *value = (*value).min(next.saturating_add(add));
                }
            }
        }
    });
    to
}
