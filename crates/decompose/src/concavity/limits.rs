//! What a certified computation may spend.

/// Limits of one computation. Reaching one never makes a bound false: the
/// interval is wider, or the question stays unproven.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// Cells that may be examined.
    pub cells: usize,
    /// Asked now and then; `true` ends the computation early.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl Limits<'_> {
    /// How many cells pass between two looks at `cancelled`: well under a
    /// millisecond of work.
    const PATIENCE: usize = 256;

    /// At most `cells` cells, never cancelled.
    pub fn cells(cells: usize) -> Limits<'static> {
        Limits {
            cells,
            cancelled: &|| false,
        }
    }

    /// Whether to stop after `examined` cells.
    pub(crate) fn reached(&self, examined: usize) -> bool {
        examined >= self.cells
            || (examined % Self::PATIENCE == Self::PATIENCE - 1 && (self.cancelled)())
    }
}

impl Default for Limits<'_> {
    /// A million cells: seconds of work, far beyond what real parts need.
    fn default() -> Self {
        Limits::cells(1_000_000)
    }
}
