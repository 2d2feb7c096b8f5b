//! Cuts and sides, for those who want a core piece by itself.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::{clip, crossing, mesh, DVec3, Plane};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{arrays, mesh as from_arrays, points as points_of, Arrays};
use crate::errors::{engine_error, mesh_error};

type Closest<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f64>>,
);
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

/// Pairs of faces that cross, (k, 2), coordinates of one at most; None if the boxes of more than
/// `most` pairs overlap. `second` is where the faces of a second surface begin.
#[pyfunction]
#[pyo3(signature = (vertices, faces, most, second=None))]
pub fn crossings<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    most: usize,
    second: Option<usize>,
) -> PyResult<Option<Bound<'py, PyArray2<i64>>>> {
    let surface = from_arrays(py, &vertices, &faces)?;
    let found = py.detach(|| crossing::crossing_pairs(&surface, second, most));
    found
        .map(|pairs| {
            let each = pairs.iter().flatten().map(|face| i64::from(*face));
            PyArray1::from_iter(py, each).reshape([pairs.len(), 2])
        })
        .transpose()
}

/// A surface to ask for distances and, if it is closed, which points belong to its solid.
#[pyclass(frozen)]
pub struct Solid(SolidIndex);

impl Solid {
    /// Distance, face and nearest point; infinitely far from a surface without faces.
    fn nearest(&self, q: DVec3) -> (f64, i64, DVec3) {
        let tree = self.0.bvh();
        self.0.surface(q).map_or((f64::INFINITY, -1, q), |near| {
            let face = i64::from(tree.original(near.slot));
            let foot = tree.triangle(near.slot).closest(q);
            (near.distance2.sqrt(), face, foot)
        })
    }
}

#[pymethods]
impl Solid {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, i64>,
    ) -> PyResult<Solid> {
        let solid = from_arrays(py, &vertices, &faces)?;
        Ok(Solid(py.detach(|| SolidIndex::new(&solid))))
    }

    /// Which of (n, 3) points are inside; exact but for points of the surface.
    fn contains<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let asked = points_of(py, &points)?;
        let found = py.detach(|| asked.iter().map(|q| self.0.contains(*q)).collect());
        Ok(PyArray1::from_vec(py, found))
    }

    /// Of each of (n, 3) points the distance from the surface, the nearest face, and its point
    /// there.
    fn closest<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Closest<'py>> {
        let asked = points_of(py, &points)?;
        let found: Vec<_> = py.detach(|| asked.iter().map(|q| self.nearest(*q)).collect());
        let foot = found.iter().flat_map(|(_, _, p)| p.to_array());
        Ok((
            PyArray1::from_iter(py, found.iter().map(|(distance, _, _)| *distance)),
            PyArray1::from_iter(py, found.iter().map(|(_, face, _)| *face)),
            PyArray1::from_iter(py, foot).reshape([found.len(), 3])?,
        ))
    }

    /// How often the surface goes around each of (n, 3) points; once for points on it.
    fn winding<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let asked = points_of(py, &points)?;
        let around = |q: &DVec3| i64::from(self.0.bvh().winding_number(*q).unwrap_or(1));
        let found = py.detach(|| asked.iter().map(around).collect());
        Ok(PyArray1::from_vec(py, found))
    }
}
