//! Simple shapes around points.

use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::primitive::{fit_box, fit_capsule, fit_cylinder, fit_sphere};
use glam::{DMat3, DVec3};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::arrays::points;
use crate::errors::mesh_error;

/// Kind; the columns of a rotation; centre; half lengths of a box, or radius and half the
/// length of its axis (of a capsule: between the centres of its caps); slack.
type Shape = (&'static str, [[f64; 3]; 3], [f64; 3], [f64; 3], f64);

/// A rotation whose third column is `axis`.
fn around(axis: DVec3) -> [[f64; 3]; 3] {
    let (x, y) = axis.any_orthonormal_pair();
    let turned = DMat3::from_cols(x, y, axis);
    if turned.determinant() < 0.0 {
        DMat3::from_cols(y, x, axis).to_cols_array_2d()
    } else {
        turned.to_cols_array_2d()
    }
}

/// A box, a cylinder, a capsule and a sphere that enclose the points; none of their
/// points is farther than `slack` from the points' convex hull.
#[pyfunction]
pub fn enclosing_shapes<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
) -> PyResult<Vec<Shape>> {
    let points = points(py, &vertices)?;
    let hull = convex_hull(&points).map_err(|e| mesh_error(py, &e.to_string()))?;
    let cuboid = fit_box(&hull).map(|fit| {
        let shape = fit.shape;
        let axes = shape.axes.to_cols_array_2d();
        let half = shape.half.to_array();
        ("box", axes, shape.centre.to_array(), half, fit.slack)
    });
    let cylinder = fit_cylinder(&hull).map(|fit| {
        let shape = fit.shape;
        let lengths = [shape.radius, shape.half_height, 0.0];
        let centre = shape.centre.to_array();
        ("cylinder", around(shape.axis), centre, lengths, fit.slack)
    });
    let capsule = fit_capsule(&hull).and_then(|fit| {
        let [a, b] = fit.shape.ends;
        // Without a length it is a sphere.
        let axis = (b - a).try_normalize()?;
        let lengths = [fit.shape.radius, 0.5 * a.distance(b), 0.0];
        let centre = a.midpoint(b).to_array();
        Some(("capsule", around(axis), centre, lengths, fit.slack))
    });
    let sphere = fit_sphere(&hull).map(|fit| {
        let lengths = [fit.shape.radius, 0.0, 0.0];
        let axes = DMat3::IDENTITY.to_cols_array_2d();
        let centre = fit.shape.centre.to_array();
        ("sphere", axes, centre, lengths, fit.slack)
    });
    let found = [cuboid, cylinder, capsule, sphere];
    Ok(found.into_iter().flatten().collect())
}
