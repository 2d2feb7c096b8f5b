//! Meshes as numpy arrays.

use assetpipe_geometry::{DVec3, Mesh};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::errors::mesh_error;

/// (n, 3) float64 and (m, 3) int64 to a mesh.
pub fn mesh(
    py: Python<'_>,
    vertices: &PyReadonlyArray2<'_, f64>,
    faces: &PyReadonlyArray2<'_, i64>,
) -> PyResult<Mesh> {
    let vertices = points(py, vertices)?;
    let faces = faces.as_array();
    if faces.ncols() != 3 {
        return Err(mesh_error(py, "faces must have shape (m, 3)"));
    }
    let count = vertices.len() as i64;
    let mut triangles = Vec::with_capacity(faces.nrows());
    for row in faces.rows() {
        let mut corners = [0u32; 3];
        for (corner, &v) in corners.iter_mut().zip(row) {
            if v < 0 || v >= count || v > i64::from(u32::MAX) {
                return Err(mesh_error(
                    py,
                    &format!("face names vertex {v}, but the mesh has {count}"),
                ));
            }
            *corner = v as u32;
        }
        triangles.push(corners);
    }
    Ok(Mesh {
        vertices,
        triangles,
    })
}

/// (n, 3) float64 to points.
pub fn points(py: Python<'_>, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<DVec3>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        return Err(mesh_error(py, "vertices must have shape (n, 3)"));
    }
    Ok(array
        .rows()
        .into_iter()
        .map(|r| DVec3::new(r[0], r[1], r[2]))
        .collect())
}

/// Vertices (n, 3) and faces (m, 3).
pub type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>);

/// A mesh to arrays.
pub fn arrays<'py>(py: Python<'py>, mesh: &Mesh) -> Arrays<'py> {
    let mut vertices = Array2::zeros((mesh.vertices.len(), 3));
    for (mut row, p) in vertices.rows_mut().into_iter().zip(&mesh.vertices) {
        for (x, value) in row.iter_mut().zip(p.to_array()) {
            *x = value;
        }
    }
    let mut faces = Array2::zeros((mesh.triangles.len(), 3));
    for (mut row, t) in faces.rows_mut().into_iter().zip(&mesh.triangles) {
        for (x, value) in row.iter_mut().zip(t) {
            *x = i64::from(*value);
        }
    }
    (vertices.into_pyarray(py), faces.into_pyarray(py))
}
