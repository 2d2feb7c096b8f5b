//! Outlines of the sections in parallel planes.

use glam::DVec2;

use super::{Scratch, ON};
use crate::even;

/// Outlines of all sections, and what `pass` needs to know of each vertex.
pub fn sections(edges: &[(u32, u32)], offsets: &[f64], slack: f64, scratch: &mut Scratch) {
    let Scratch {
        local,
        low,
        high,
        order,
        sections,
        outline,
        ..
    } = scratch;
    low.clear();
    low.extend(local.iter().map(|p| p.z));
    high.clear();
    high.extend(local.iter().map(|p| p.z));
    sections.resize_with(offsets.len().max(sections.len()), Vec::new);
    for section in sections.iter_mut() {
        section.clear();
    }
    for &(u, v) in edges {
        let (a, b) = (local[u as usize], local[v as usize]);
        low[u as usize] = low[u as usize].min(b.z);
        low[v as usize] = low[v as usize].min(a.z);
        high[u as usize] = high[u as usize].max(b.z);
        high[v as usize] = high[v as usize].max(a.z);
        let (z0, z1) = (a.z.min(b.z), a.z.max(b.z));
        let mut k = offsets.partition_point(|&t| t <= z0 + ON);
        while k < offsets.len() && offsets[k] < z1 - ON {
            let p = a.lerp(b, (offsets[k] - a.z) / (b.z - a.z));
            sections[k].push(even::point(p).truncate());
            k += 1;
        }
    }
    order.clear();
    order.extend(0..local.len() as u32);
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (local[a as usize], local[b as usize]);
        p.z.total_cmp(&q.z)
            .then(p.x.total_cmp(&q.x))
            .then(p.y.total_cmp(&q.y))
    });
    for section in &mut sections[..offsets.len()] {
        convex_outline(section, slack, outline);
    }
}

/// Replace points by their convex hull, counter-clockwise, leaving out corners
/// that stand out by less than `slack`.
fn convex_outline(points: &mut Vec<DVec2>, slack: f64, outline: &mut Vec<DVec2>) {
    if points.len() < 4 {
        return;
    }
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    outline.clear();
    for upper in [false, true] {
        let start = outline.len();
        for i in 0..points.len() {
            let p = if upper {
                points[points.len() - 1 - i]
            } else {
                points[i]
            };
            while outline.len() >= start + 2 {
                let (a, b) = (outline[outline.len() - 2], outline[outline.len() - 1]);
                if (b - a).perp_dot(p - b) > 0.0 {
                    break;
                }
                outline.pop();
            }
            outline.push(p);
        }
        outline.pop();
    }
    points.clear();
    if outline.is_empty() {
        return;
    }
    // Each corner against the line from the last kept one to the next.
    let n = outline.len();
    for i in 0..n {
        let (b, c) = (outline[i], outline[(i + 1) % n]);
        if let Some(&a) = points.last() {
            let chord = c - a;
            if chord.perp_dot(b - a).abs() < slack * chord.length() {
                continue;
            }
        }
        points.push(b);
    }
}
