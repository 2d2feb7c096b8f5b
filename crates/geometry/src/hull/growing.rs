//! A hull to which points are added one by one.

use glam::DVec3;

use super::quickhull::{Builder, Work, NONE};
use super::HullError;
use crate::mesh::Mesh;

/// A hull, its points, and a facet at each of its vertices. Every point ever
/// added stays inside or on the hull.
pub(super) struct Growing {
    points: Vec<DVec3>,
    extent: DVec3,
    builder: Builder,
    /// A facet at each point that is a vertex.
    facet_at: Vec<u32>,
    vertex_count: usize,
}

impl Growing {
    /// The hull of `points`; points added later must keep all differences of
    /// coordinates within `extent`.
    pub(super) fn new(points: &[DVec3], extent: f64) -> Result<Self, HullError> {
        let mut this = Self {
            points: points.to_vec(),
            extent: DVec3::splat(extent),
            builder: Builder::default(),
            facet_at: vec![NONE; points.len()],
            vertex_count: 0,
        };
        this.builder.grow(points, this.extent)?;
        let facets = this.builder.facets.iter().enumerate();
        for (f, facet) in facets.filter(|(_, facet)| facet.alive) {
            for corner in facet.corners {
                this.facet_at[corner as usize] = f as u32;
            }
        }
        this.vertex_count = this.facet_at.iter().filter(|f| **f != NONE).count();
        Ok(this)
    }

    /// How many vertices the hull has, those inside of edges and faces included.
    pub(super) fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    pub(super) fn is_edge(&self, a: u32, b: u32) -> bool {
        [a, b].iter().all(|v| self.facet_at[*v as usize] != NONE)
            && self
                .star(a)
                .any(|(f, i)| self.builder.facets[f as usize].corners[(i + 1) % 3] == b)
    }

    pub(super) fn at(&self, point: u32) -> DVec3 {
        self.points[point as usize]
    }

    /// All edges, lesser end first.
    pub(super) fn edges(&self) -> Vec<(u32, u32)> {
        let facets = self.builder.facets.iter().filter(|f| f.alive);
        facets
            .flat_map(|f| {
                let [a, b, c] = f.corners;
                [(a, b), (b, c), (c, a)]
            })
            .filter(|(a, b)| a < b)
            .collect()
    }

    /// Facets at a vertex with the vertex's place among the corners, around it.
    fn star(&self, vertex: u32) -> impl Iterator<Item = (u32, usize)> + '_ {
        let first = self.facet_at[vertex as usize];
        let place = move |f: u32| {
            let corners = self.builder.facets[f as usize].corners;
            corners.iter().position(|c| *c == vertex).unwrap_or(0)
        };
        std::iter::successors(Some((first, place(first))), move |&(f, i)| {
            let next = self.builder.facets[f as usize].across[i];
            (next != first).then(|| (next, place(next)))
        })
    }

    /// The vertices that share an edge with `vertex`.
    pub(super) fn neighbours(&self, vertex: u32) -> Vec<u32> {
        self.star(vertex)
            .map(|(f, i)| self.builder.facets[f as usize].corners[(i + 1) % 3])
            .collect()
    }

    fn facets_around(&self, a: u32, b: u32) -> Vec<u32> {
        let around_b = self.star(b);
        let mut facets: Vec<u32> = self.star(a).chain(around_b).map(|(f, _)| f).collect();
        facets.sort_unstable();
        facets.dedup();
        facets
    }

    /// The triangles at either of two vertices.
    pub(super) fn faces_around(&self, a: u32, b: u32) -> Vec<[DVec3; 3]> {
        self.facets_around(a, b)
            .into_iter()
            .map(|f| self.builder.facets[f as usize].corners.map(|c| self.at(c)))
            .collect()
    }

    /// Adds `point` if it is strictly outside of all facets at `a` and `b`,
    /// so that these vertices vanish inside; returns its index.
    pub(super) fn replace(&mut self, a: u32, b: u32, point: DVec3) -> Option<u32> {
        let around = self.facets_around(a, b);
        let added = self.points.len() as u32;
        self.points.push(point);
        self.builder.make_room(self.points.len());
        let mut work = Work {
            points: &self.points,
            extent: self.extent,
            builder: &mut self.builder,
        };
        if !around.iter().all(|&f| work.height(f, added).is_some()) {
            self.points.pop();
            return None;
        }
        work.see(around[0], added);
        work.cone(added);
        self.facet_at.push(NONE);
        let Builder {
            facets,
            free,
            visible,
            fresh,
            ..
        } = &mut self.builder;
        for &hidden in visible.iter() {
            for corner in facets[hidden as usize].corners {
                let facet = &mut self.facet_at[corner as usize];
                self.vertex_count -= usize::from(*facet != NONE);
                *facet = NONE;
            }
        }
        for &f in fresh.iter() {
            for corner in facets[f as usize].corners {
                let facet = &mut self.facet_at[corner as usize];
                self.vertex_count += usize::from(*facet == NONE);
                *facet = f;
            }
        }
        free.extend_from_slice(visible);
        Some(added)
    }

    /// The hull as a mesh.
    pub(super) fn finish(mut self) -> Mesh {
        self.builder.canonical(&self.points)
    }
}
