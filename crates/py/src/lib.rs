//! The seam between the core and Python: the only crate that knows Python.
//! Arrays in and out, typed errors, the GIL released around every long call.

#![allow(
    clippy::needless_pass_by_value,
    reason = "a Python function owns its extracted arrays: their borrow of the buffer ends with the call"
)]

mod arrays;
mod decomposition;
mod errors;
mod geometry;
mod inner;
mod polygon;
mod primitive;
mod watch;

use pyo3::prelude::*;

/// The native module `assetpipe._core`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    polygon::register(module)?;
    inner::register(module)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(decomposition::decompose, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::parts, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::thickening, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::concavity_terms, module)?)?;
    module.add_function(wrap_pyfunction!(primitive::enclosing_shapes, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::thickening_within, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::simplify_within, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::connections, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::folds, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::unreachable, module)?)?;
    module.add_function(wrap_pyfunction!(decomposition::convex_hull, module)?)?;
    module.add_class::<geometry::Solid>()?;
    module.add_function(wrap_pyfunction!(geometry::crossings, module)?)?;
    module.add_function(wrap_pyfunction!(geometry::split, module)?)
}
