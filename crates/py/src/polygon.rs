//! `decompose_polygon` and the convex sets inside polygons.

use std::panic::{catch_unwind, AssertUnwindSafe};

use assetpipe_polygon::{
    decompose, DiagonalWeights, Hierarchy, HoleAxis, Measure, OutlineError, Parameters, Point,
};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::errors::{engine_error, input_error, usage_error};

type Ring<'py> = Bound<'py, PyArray2<f64>>;

/// Adds what this file offers to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PolygonHierarchy>()?;
    module.add_function(wrap_pyfunction!(decompose_polygon, module)?)
}

/// A polygon decomposition with all its coarser levels.
#[pyclass(frozen, module = "assetpipe._core")]
pub struct PolygonHierarchy(Hierarchy);

#[pymethods]
impl PolygonHierarchy {
    /// Parts at a tolerance as (rings, concavity), outer ring first, and the
    /// convexity of Eq. 9.
    fn at<'py>(&self, py: Python<'py>, tolerance: f64) -> (Vec<(Vec<Ring<'py>>, f64)>, f64) {
        let (parts, convexity) = py.detach(|| {
            let parts = self.0.at(tolerance);
            let convexity = Hierarchy::convexity(&parts);
            (parts, convexity)
        });
        let parts = parts
            .iter()
            .map(|part| {
                let rings = std::iter::once(&part.outer).chain(&part.holes);
                (rings.map(|ring| array(py, ring)).collect(), part.concavity)
            })
            .collect();
        (parts, convexity)
    }

    /// Per part that a diagonal split off, its concavity and that of the part before.
    fn descents(&self) -> Vec<(f64, f64)> {
        self.0.descents()
    }
}

/// Decompose the even-odd interior of rings of shape (n, 2).
#[pyfunction]
pub fn decompose_polygon(
    py: Python<'_>,
    rings: Vec<PyReadonlyArray2<'_, f64>>,
    tolerance: f64,
    concavity: &str,
    hole_axis: &str,
    weights: (f64, f64),
) -> PyResult<PolygonHierarchy> {
    let rings = points(py, &rings)?;
    let measure = match concavity {
        "sl" => Measure::StraightLine,
        "sp" => Measure::ShortestPath,
        "h1" => Measure::Hybrid1,
        "h2" => Measure::Hybrid2,
        other => return Err(usage_error(py, &format!("concavity '{other}' not found"))),
    };
    let hole_axis = match hole_axis {
        "principal" => HoleAxis::Principal,
        "medial" => HoleAxis::Medial,
        other => return Err(usage_error(py, &format!("hole axis '{other}' not found"))),
    };
    let weights = DiagonalWeights { concavity: weights.0, distance: weights.1 };
    let parameters = Parameters { tolerance, measure, hole_axis, weights };
    guarded(py, || decompose(&rings, &parameters)).map(PolygonHierarchy)
}

/// Runs `work` without the GIL; a panic becomes an `EngineError`.
fn guarded<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, OutlineError> + Send,
) -> PyResult<T> {
    match py.detach(|| catch_unwind(AssertUnwindSafe(work))) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error @ OutlineError::Parameter { .. })) => Err(usage_error(py, &error.to_string())),
        Ok(Err(error)) => Err(input_error(py, &format!("outline: {error}"))),
        Err(_) => Err(engine_error(py, "the polygon core failed on this outline")),
    }
}

fn points(py: Python<'_>, rings: &[PyReadonlyArray2<'_, f64>]) -> PyResult<Vec<Vec<Point>>> {
    rings
        .iter()
        .map(|ring| {
            let ring = ring.as_array();
            if ring.ncols() != 2 {
                return Err(usage_error(py, "a ring must have shape (n, 2)"));
            }
            Ok(ring.rows().into_iter().map(|row| Point::new(row[0], row[1])).collect())
        })
        .collect()
}

fn array<'py>(py: Python<'py>, ring: &[Point]) -> Ring<'py> {
    let mut array = Array2::zeros((ring.len(), 2));
    for (mut row, p) in array.rows_mut().into_iter().zip(ring) {
        row[0] = p.x;
        row[1] = p.y;
    }
    array.into_pyarray(py)
}
