//! The seam between the core and Python: the only crate that knows Python.
//! Arrays in and out, typed errors, the GIL released around every long call.

use pyo3::prelude::*;

/// The native module `assetpipe._core`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))
}
