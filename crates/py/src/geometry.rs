//! Cuts, for those who want a core piece by itself.

use assetpipe_geometry::{clip, mesh, DVec3, Plane};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::arrays::{arrays, mesh as from_arrays, Arrays};
use crate::errors::{engine_error, mesh_error};

type Pieces<'py> = (Option<Arrays<'py>>, Option<Arrays<'py>>);

/// Cuts a closed mesh by the plane normal · x = offset: (below, above), each
/// (vertices, faces) or None.
#[pyfunction]
pub fn split<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    normal: [f64; 3],
    offset: f64,
) -> PyResult<Pieces<'py>> {
    let solid = from_arrays(py, &vertices, &faces)?;
    let plane = Plane {
        normal: DVec3::from(normal),
        offset,
    };
    let cut = py
        .detach(|| {
            std::panic::catch_unwind(|| {
                mesh::check_closed(&solid).map_err(|e| e.to_string())?;
                clip::split(&solid, &plane).map_err(|e| e.to_string())
            })
        })
        .map_err(|_| engine_error(py, "the cut failed; please report it with this mesh"))?
        .map_err(|e| mesh_error(py, &e))?;
    Ok((
        cut.below.map(|piece| arrays(py, &piece)),
        cut.above.map(|piece| arrays(py, &piece)),
    ))
}
