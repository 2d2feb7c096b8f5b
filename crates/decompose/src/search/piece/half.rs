//! The halves of a piece while they are being built.

use super::Piece;

/// One half of a piece while it is being built.
pub struct Half {
    /// What is there of it.
    pub piece: Piece,
    /// New index of each old point, or `u32::MAX`.
    index: Vec<u32>,
}

impl Half {
    pub fn new(points: usize) -> Self {
        Half {
            piece: Piece::default(),
            index: vec![u32::MAX; points],
        }
    }

    /// Its vertex for vertex `v` of the whole.
    pub fn old(&mut self, whole: &Piece, v: u32) -> u32 {
        let slot = &mut self.index[v as usize];
        if *slot == u32::MAX {
            *slot = self.piece.points.len() as u32;
            self.piece.points.push(whole.points[v as usize]);
        }
        *slot
    }
}

/// Crossing points of edges with the plane, one a whole-piece edge.
pub struct Crossings {
    /// (smaller, larger vertex, index in below, index in above), sorted.
    pub edges: Vec<(u32, u32, u32, u32)>,
}

impl Crossings {
    /// The crossing of an edge in below and in above.
    pub fn find(&self, a: u32, b: u32) -> (u32, u32) {
        let key = (a.min(b), a.max(b));
        match self.edges.binary_search_by(|e| (e.0, e.1).cmp(&key)) {
            Ok(at) => (self.edges[at].2, self.edges[at].3),
            Err(_) => (0, 0),
        }
    }
}
