//! `inner_polytopes`, and `SolidIndex` and `ConvexSet`: what holds a point.

use assetpipe_decompose::inner::{self, InnerSettings};
use assetpipe_geometry::bvh::{Bounds, Side};
use assetpipe_geometry::distance::{self, ConvexBody};
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::{mesh as checks, DVec3};
use glam::{DAffine3, DMat3};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;

use crate::arrays::{arrays, mesh, points};
use crate::errors::{decompose_error, engine_error, mesh_error, usage_error};
use crate::watch;

/// Vertices, faces and volume.
type PolytopeTuple<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>, f64);

/// Adds what this file offers to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<SolidIndex>()?;
    module.add_class::<ConvexSet>()?;
    module.add_function(wrap_pyfunction!(rigid_inverse, module)?)?;
    module.add_function(wrap_pyfunction!(boxes_apart, module)?)?;
    module.add_function(wrap_pyfunction!(inner_polytopes, module)?)
}

/// Convex polytopes inside a closed solid, largest first, as (vertices, faces,
/// volume), and the share of surface samples within `gap` of one.
#[pyfunction]
#[pyo3(signature = (vertices, faces, gap, most, most_vertices, samples, on_progress=None))]
#[allow(
    clippy::too_many_arguments,
    reason = "one Python call, no state between"
)]
pub fn inner_polytopes<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    gap: f64,
    most: usize,
    most_vertices: usize,
    samples: usize,
    on_progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Vec<PolytopeTuple<'py>>, f64)> {
    let solid = mesh(py, &vertices, &faces)?;
    checks::check_closed(&solid).map_err(|e| mesh_error(py, &e.to_string()))?;
    let settings = InnerSettings {
        gap,
        most,
        most_vertices,
        samples,
    };
    let result = watch::run(py, on_progress, move |control| {
        inner::inner_polytopes(&solid, &settings, control)
    })?;
    let (found, reached) = result.map_err(|e| decompose_error(py, &e))?;
    let polytopes = found
        .iter()
        .map(|polytope| {
            let (v, f) = arrays(py, &polytope.mesh);
            (v, f, polytope.volume)
        })
        .collect();
    Ok((polytopes, reached))
}

/// A closed solid, indexed for questions about points.
#[pyclass(frozen, module = "assetpipe._core")]
pub struct SolidIndex(distance::SolidIndex);

impl SolidIndex {
    fn holds(&self, q: DVec3) -> bool {
        self.0.bvh().side(q) != Side::Outside
    }
}

#[pymethods]
impl SolidIndex {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, i64>,
    ) -> PyResult<Self> {
        let solid = mesh(py, &vertices, &faces)?;
        checks::check_closed(&solid).map_err(|e| mesh_error(py, &e.to_string()))?;
        std::panic::catch_unwind(|| SolidIndex(distance::SolidIndex::new(&solid)))
            .map_err(|_| engine_error(py, "the index failed; please report it with this mesh"))
    }

    /// Whether each point (n, 3) is inside or on the surface; exact.
    fn contains<'py>(
        &self,
        py: Python<'py>,
        at: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        each(py, &at, |q| self.holds(q))
    }

    /// Whether any of the points (n, 3), moved by a pose (4, 4), is inside.
    fn holds_any(
        &self,
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        own_from_points: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<bool> {
        any(py, &points, &own_from_points, |q| self.holds(q))
    }
}

/// One polytope of a set: its box and its half-spaces.
struct Polytope {
    bounds: Bounds,
    half_spaces: Vec<(DVec3, f64)>,
}

/// Convex polytopes, moved out (or in, where `reach` is negative) by a length.
#[pyclass(frozen, module = "assetpipe._core")]
pub struct ConvexSet {
    polytopes: Vec<Polytope>,
}

impl ConvexSet {
    fn holds(&self, q: DVec3) -> bool {
        self.polytopes.iter().any(|p| {
            p.bounds.distance2(q) == 0.0 && p.half_spaces.iter().all(|(n, o)| n.dot(q) <= *o)
        })
    }
}

#[pymethods]
impl ConvexSet {
    #[new]
    fn new(
        py: Python<'_>,
        polytopes: Vec<PyReadonlyArray2<'_, f64>>,
        reach: f64,
    ) -> PyResult<Self> {
        let polytopes = polytopes
            .iter()
            .map(|vertices| {
                let hull = convex_hull(&points(py, vertices)?)
                    .map_err(|e| mesh_error(py, &e.to_string()))?;
                let body = ConvexBody::new(&hull);
                let Bounds { lo, hi } = body.bounds();
                let half_spaces = body.half_spaces().iter();
                Ok(Polytope {
                    bounds: Bounds {
                        lo: lo - reach,
                        hi: hi + reach,
                    },
                    half_spaces: half_spaces.map(|s| (s.normal, s.offset + reach)).collect(),
                })
            })
            .collect::<PyResult<_>>()?;
        Ok(ConvexSet { polytopes })
    }

    /// Whether each point (n, 3) is in one of the polytopes.
    fn contains<'py>(
        &self,
        py: Python<'py>,
        at: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        each(py, &at, |q| self.holds(q))
    }

    /// Whether any of the points (n, 3), moved by a pose (4, 4), is in one of them.
    fn holds_any(
        &self,
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        own_from_points: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<bool> {
        any(py, &points, &own_from_points, |q| self.holds(q))
    }
}

/// The answer for each point (n, 3).
fn each<'py>(
    py: Python<'py>,
    at: &PyReadonlyArray2<'py, f64>,
    holds: impl Fn(DVec3) -> bool,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let inside: Vec<bool> = points(py, at)?.into_iter().map(holds).collect();
    Ok(inside.to_pyarray(py))
}

/// Whether the answer is yes for any point (n, 3), moved by a pose (4, 4).
fn any(
    py: Python<'_>,
    at: &PyReadonlyArray2<'_, f64>,
    own_from_points: &PyReadonlyArray2<'_, f64>,
    holds: impl Fn(DVec3) -> bool,
) -> PyResult<bool> {
    let pose = affine(py, own_from_points)?;
    let mut moved = points(py, at)?
        .into_iter()
        .map(|q| pose.transform_point3(q));
    Ok(moved.any(holds))
}

/// A homogeneous matrix (4, 4).
fn affine(py: Python<'_>, matrix: &PyReadonlyArray2<'_, f64>) -> PyResult<DAffine3> {
    let m = matrix.as_array();
    if m.shape() != [4, 4] {
        return Err(usage_error(py, "a pose must have shape (4, 4)"));
    }
    let column = |k: usize| DVec3::new(m[[0, k]], m[[1, k]], m[[2, k]]);
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    })
}

/// The inverse of a rigid pose (4, 4).
#[pyfunction]
pub fn rigid_inverse<'py>(
    py: Python<'py>,
    pose: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let DAffine3 {
        matrix3: turn,
        translation,
    } = affine(py, &pose)?;
    let back = turn.transpose();
    let off = (turn * back - DMat3::IDENTITY).to_cols_array();
    // Not a number is no small number either.
    let orthogonal = off.iter().all(|x| x.abs() <= 1e-9);
    if !(orthogonal && turn.determinant() > 0.0 && translation.is_finite()) {
        return Err(usage_error(
            py,
            "a pose must be rigid: a rotation and a finite translation",
        ));
    }
    let at = -(back * translation);
    let rows = [back.row(0), back.row(1), back.row(2)];
    let inverse = Array2::from_shape_fn((4, 4), |(i, j)| match (i, j) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (_, 3) => at[i],
        _ => rows[i][j],
    });
    Ok(inverse.into_pyarray(py))
}

/// Whether two boxes, each (2, 3) lower and upper corner in its own frame, are
/// apart along an axis of either, by more than rounding; both poses are given.
#[pyfunction]
pub fn boxes_apart(
    py: Python<'_>,
    a: PyReadonlyArray2<'_, f64>,
    b: PyReadonlyArray2<'_, f64>,
    a_from_b: PyReadonlyArray2<'_, f64>,
    b_from_a: PyReadonlyArray2<'_, f64>,
) -> PyResult<bool> {
    let corners = |rows: Vec<DVec3>| match rows[..] {
        [lo, hi] => Ok((0.5 * (lo + hi), 0.5 * (hi - lo))),
        _ => Err(usage_error(py, "a box must have shape (2, 3)")),
    };
    let (a, b) = (corners(points(py, &a)?)?, corners(points(py, &b)?)?);
    let apart = |(centre, half): (DVec3, DVec3), (other, reach): (DVec3, DVec3), pose: DAffine3| {
        let m = pose.matrix3;
        let at = pose.transform_point3(other);
        let around = m.x_axis.abs() * reach.x + m.y_axis.abs() * reach.y + m.z_axis.abs() * reach.z;
        let rounding = 1e-9 * (half.max_element() + reach.max_element());
        ((at - centre).abs() - half - around).max_element() > rounding
    };
    Ok(apart(a, b, affine(py, &a_from_b)?) || apart(b, a, affine(py, &b_from_a)?))
}
