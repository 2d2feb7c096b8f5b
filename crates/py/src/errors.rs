//! The core's errors as the classes of `assetpipe.errors`.

use assetpipe_decompose::error::DecomposeError;
use pyo3::prelude::*;

fn raise(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let made = py
        .import("assetpipe.errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1((message,)));
    match made {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// `MeshError`.
pub fn mesh_error(py: Python<'_>, message: &str) -> PyErr {
    raise(py, "MeshError", message)
}

/// `UsageError`.
pub fn usage_error(py: Python<'_>, message: &str) -> PyErr {
    raise(py, "UsageError", message)
}

/// `InputError`.
pub fn input_error(py: Python<'_>, message: &str) -> PyErr {
    raise(py, "InputError", message)
}

/// `EngineError`: a fault of ours.
pub fn engine_error(py: Python<'_>, message: &str) -> PyErr {
    raise(py, "EngineError", message)
}

/// `CancelledError`.
pub fn cancelled_error(py: Python<'_>) -> PyErr {
    raise(py, "CancelledError", "cancelled")
}

/// A decomposition's error.
pub fn decompose_error(py: Python<'_>, error: &DecomposeError) -> PyErr {
    let class = match error {
        DecomposeError::Empty
        | DecomposeError::NotFinite { .. }
        | DecomposeError::NotClosed { .. }
        | DecomposeError::Flat { .. } => "MeshError",
        DecomposeError::Tolerance { .. } => "UsageError",
        DecomposeError::TooManyParts { .. } | DecomposeError::Reach { .. } => "LimitError",
        DecomposeError::Cancelled => "CancelledError",
        DecomposeError::Internal(_) => "EngineError",
    };
    raise(py, class, &error.to_string())
}
