//! `decompose_polygon` and the convex sets inside polygons.

use std::panic::{catch_unwind, AssertUnwindSafe};

use assetpipe_polygon::inclusion::discrete::{self, Connectivity, Pixels};
use assetpipe_polygon::inclusion::{convex_subset, distance_to_kernel, hv, kernel, Origin};
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
    module.add_function(wrap_pyfunction!(decompose_polygon, module)?)?;
    module.add_function(wrap_pyfunction!(convex_subset_polygon, module)?)?;
    module.add_function(wrap_pyfunction!(polygon_kernel, module)?)?;
    module.add_function(wrap_pyfunction!(convex_pixels, module)?)?;
    module.add_function(wrap_pyfunction!(pixel_hausdorff, module)?)?;
    module.add_function(wrap_pyfunction!(hv_regions, module)?)?;
    module.add_function(wrap_pyfunction!(hv_convex_pixels, module)?)
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
    let weights = DiagonalWeights {
        concavity: weights.0,
        distance: weights.1,
    };
    let parameters = Parameters {
        tolerance,
        measure,
        hole_axis,
        weights,
    };
    guarded(py, || decompose(&rings, &parameters)).map(PolygonHierarchy)
}

/// A large convex polygon inside, and whether it came from the kernel of the
/// whole outline ("kernel") or from what a point sees ("visibility").
#[pyfunction]
pub fn convex_subset_polygon<'py>(
    py: Python<'py>,
    rings: Vec<PyReadonlyArray2<'py, f64>>,
) -> PyResult<(Ring<'py>, &'static str)> {
    let rings = points(py, &rings)?;
    let (polygon, origin) = guarded(py, || convex_subset(&rings))?;
    let origin = match origin {
        Origin::Kernel => "kernel",
        Origin::Visibility => "visibility",
    };
    Ok((array(py, &polygon), origin))
}

/// The kernel of a counter-clockwise simple ring, empty if it has no area, and
/// the distance of every vertex to it.
#[pyfunction]
pub fn polygon_kernel<'py>(
    py: Python<'py>,
    ring: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Ring<'py>, Vec<f64>)> {
    let ring = points(py, &[ring])?.remove(0);
    let (kernel, distances) = guarded(py, || {
        let kernel = kernel(&ring);
        let walk = if kernel.is_empty() {
            Vec::new()
        } else {
            distance_to_kernel(&ring, &kernel)
        };
        Ok((kernel, walk.into_iter().map(|(d, _)| d).collect()))
    })?;
    Ok((array(py, &kernel), distances))
}

type Image<'py, T> = Bound<'py, PyArray2<T>>;

/// The discrete method on an image; `connectivity` is 4 or 8.
#[pyfunction]
pub fn convex_pixels<'py>(
    py: Python<'py>,
    shape: PyReadonlyArray2<'py, bool>,
    connectivity: u8,
) -> PyResult<Image<'py, bool>> {
    let (shape, connectivity) = (pixels(&shape), neighbours(py, connectivity)?);
    let found = guarded(py, || Ok(discrete::convex_pixels(&shape, connectivity)))?;
    Ok(image(py, found.width, found.inside))
}

/// Minus the Hausdorff distance of two images, or None if one is empty.
#[pyfunction]
pub fn pixel_hausdorff(
    py: Python<'_>,
    p: PyReadonlyArray2<'_, bool>,
    q: PyReadonlyArray2<'_, bool>,
    connectivity: u8,
) -> PyResult<Option<i64>> {
    let (p, q, connectivity) = (pixels(&p), pixels(&q), neighbours(py, connectivity)?);
    if p.width != q.width || p.inside.len() != q.inside.len() {
        return Err(usage_error(py, "the two images must have the same shape"));
    }
    guarded(py, || Ok(discrete::hausdorff(&p, &q, connectivity)))
}

type Graph = Vec<Vec<bool>>;

/// (labels, weights, adjacency graph, incompatibility graph) of an image.
#[pyfunction]
pub fn hv_regions<'py>(
    py: Python<'py>,
    shape: PyReadonlyArray2<'py, bool>,
) -> PyResult<(Image<'py, u32>, Image<'py, u32>, Graph, Graph)> {
    let shape = pixels(&shape);
    let found = guarded(py, || Ok(hv::regions(&shape)))?;
    Ok((
        image(py, shape.width, found.labels),
        image(py, shape.width, found.weights),
        found.adjacent,
        found.incompatible,
    ))
}

/// The largest h-v convex union of regions (image, regions, whether proven optimal).
#[pyfunction]
pub fn hv_convex_pixels<'py>(
    py: Python<'py>,
    shape: PyReadonlyArray2<'py, bool>,
    steps: usize,
) -> PyResult<(Image<'py, bool>, Vec<usize>, bool)> {
    let shape = pixels(&shape);
    let found = guarded(py, || Ok(hv::largest_hv_convex(&shape, steps)))?;
    Ok((
        image(py, shape.width, found.pixels.inside),
        found.regions,
        found.optimal,
    ))
}

fn pixels(shape: &PyReadonlyArray2<'_, bool>) -> Pixels {
    let shape = shape.as_array();
    Pixels {
        width: shape.ncols(),
        inside: shape.iter().copied().collect(),
    }
}

fn neighbours(py: Python<'_>, connectivity: u8) -> PyResult<Connectivity> {
    match connectivity {
        4 => Ok(Connectivity::Four),
        8 => Ok(Connectivity::Eight),
        other => Err(usage_error(
            py,
            &format!("connectivity must be 4 or 8, got {other}"),
        )),
    }
}

fn image<T: numpy::Element>(py: Python<'_>, width: usize, values: Vec<T>) -> Image<'_, T> {
    let height = values.len().checked_div(width).unwrap_or(0);
    let rows: Vec<Vec<T>> = {
        let mut values = values.into_iter();
        (0..height)
            .map(|_| values.by_ref().take(width).collect())
            .collect()
    };
    PyArray2::from_vec2(py, &rows).unwrap_or_else(|_| PyArray2::zeros(py, [0, width], false))
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
            Ok(ring
                .rows()
                .into_iter()
                .map(|row| Point::new(row[0], row[1]))
                .collect())
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
