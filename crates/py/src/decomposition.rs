//! `decompose`, `thickening`, `convex_hull`.

use assetpipe_decompose::concavity::thickening::{bounds, decide};
use assetpipe_decompose::concavity::{wei, Decision, Gap, Interval, Limits};
use assetpipe_decompose::decomposition::{self as core, Decomposition};
use assetpipe_decompose::edges;
use assetpipe_decompose::reach;
use assetpipe_decompose::settings::SearchSettings;
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::Mesh;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{arrays, mesh, points};
use crate::errors::{decompose_error, engine_error, mesh_error, usage_error};
use crate::watch;

type Bounds = (f64, f64);
/// Vertices and faces.
type MeshTuple<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>);
type HullTuple<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<i64>>,
    f64,
    Bounds,
    Option<Bounds>,
    Option<(u32, u32)>,
);

fn pair(interval: Interval) -> Bounds {
    (interval.lower, interval.upper)
}

/// Meshes with so many faces are looked at on the caller's thread first: well under a
/// tenth of a second.
const QUICK: usize = 100_000;

/// Decompose a closed solid.
///
/// Returns (hulls, leaves): each hull is (vertices, faces, volume, thickening,
/// concavity or None, children or None); the first `leaves` are the result,
/// the others the coarser levels.
#[pyfunction]
#[pyo3(signature = (vertices, faces, epsilon, settings, threads, on_progress=None))]
pub fn decompose<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    epsilon: f64,
    settings: &Bound<'py, PyDict>,
    threads: usize,
    on_progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Vec<HullTuple<'py>>, usize)> {
    let solid = mesh(py, &vertices, &faces)?;
    let settings = read_settings(py, settings)?;
    // A small convex mesh is not worth a thread.
    let own = if solid.triangles.len() <= QUICK {
        py.detach(|| core::at_once(&solid, epsilon, &settings))
            .map_err(|e| decompose_error(py, &e))?
    } else {
        None
    };
    let Decomposition { hulls, leaves } = match own {
        Some(found) => found,
        None => watch::run(py, on_progress, move |control| {
            core::decompose(&solid, epsilon, &settings, threads, control)
        })?
        .map_err(|e| decompose_error(py, &e))?,
    };
    let hulls = hulls
        .iter()
        .map(|h| {
            let (v, f) = arrays(py, &h.mesh);
            (
                v,
                f,
                h.volume,
                pair(h.thickening),
                h.concavity.map(pair),
                h.children.map(|c| (c[0], c[1])),
            )
        })
        .collect();
    Ok((hulls, leaves))
}

/// The parts that the hulls of `decompose` cover: for each of its leaves a list of
/// closed meshes (vertices, faces). For checks; nothing else needs them.
#[pyfunction]
pub fn parts<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    epsilon: f64,
    settings: &Bound<'py, PyDict>,
    threads: usize,
) -> PyResult<Vec<Vec<MeshTuple<'py>>>> {
    let solid = mesh(py, &vertices, &faces)?;
    let settings = read_settings(py, settings)?;
    let result = watch::run(py, None, move |control| {
        core::parts(&solid, epsilon, &settings, threads, control)
    })?;
    let found = result.map_err(|e| decompose_error(py, &e))?;
    Ok(found
        .iter()
        .map(|group| group.iter().map(|part| arrays(py, part)).collect())
        .collect())
}

fn read_settings(py: Python<'_>, given: &Bound<'_, PyDict>) -> PyResult<SearchSettings> {
    let mut settings = SearchSettings::default();
    for (key, value) in given {
        let key: String = key.extract()?;
        let text = if let Ok(text) = value.extract::<String>() {
            text
        } else {
            value.str()?.to_string()
        };
        settings
            .set(&key, &text)
            .map_err(|message| usage_error(py, &message))?;
    }
    Ok(settings)
}

/// Certified thickening (lower, upper) of each hull towards a solid. Hulls are
/// point sets: their convex hulls are measured.
#[pyfunction]
#[pyo3(signature = (vertices, faces, hulls, on_progress=None))]
pub fn thickening<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    hulls: Vec<PyReadonlyArray2<'py, f64>>,
    on_progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Vec<Bounds>> {
    let solid = mesh(py, &vertices, &faces)?;
    let meshes = convex_meshes(py, &hulls)?;
    let result = watch::run(py, on_progress, move |control| {
        let cancelled = || control.is_cancelled();
        let limits = Limits {
            cells: 1_000_000,
            cancelled: &cancelled,
        };
        let index = SolidIndex::new(&solid);
        let gap = Gap {
            relative: 0.005,
            absolute: 1e-9 * index.bvh().bounds().diagonal(),
        };
        meshes
            .iter()
            .map(|hull| pair(bounds(&index, hull, gap, &limits)))
            .collect::<Vec<_>>()
    })?;
    Ok(result)
}

/// `H_b` (Eq. 2), `H_i` (Eq. 3) and `R_v` (Eq. 5 of Wei et al. 2022) of a closed solid and its
/// hull, each as a certified (lower, upper).
#[pyfunction]
#[pyo3(signature = (vertices, faces, on_progress=None))]
pub fn concavity_terms<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    on_progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bounds, Bounds, Bounds)> {
    let solid = mesh(py, &vertices, &faces)?;
    let hull = assetpipe_geometry::hull::convex_hull(&solid.vertices)
        .map_err(|e| mesh_error(py, &e.to_string()))?;
    watch::run(py, on_progress, move |control| {
        let cancelled = || control.is_cancelled();
        let limits = Limits {
            cells: 100_000,
            cancelled: &cancelled,
        };
        let index = SolidIndex::new(&solid);
        let gap = Gap {
            relative: 0.02,
            absolute: 1e-6 * index.bvh().bounds().diagonal(),
        };
        let both = wei::bounds(&index, &hull, gap, &limits);
        let ball = wei::volume_radius(&solid, &hull);
        (pair(both.boundary), pair(both.interior), pair(ball))
    })
}

/// Certified thickening (lower, upper) of each hull that is proved to stay within
/// `epsilon` of the solid; `None` for the others. Hulls are point sets, as in `thickening`.
#[pyfunction]
#[pyo3(signature = (vertices, faces, hulls, epsilon, on_progress=None))]
pub fn thickening_within<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    hulls: Vec<PyReadonlyArray2<'py, f64>>,
    epsilon: f64,
    on_progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Vec<Option<Bounds>>> {
    let solid = mesh(py, &vertices, &faces)?;
    let meshes = convex_meshes(py, &hulls)?;
    watch::run(py, on_progress, move |control| {
        let cancelled = || control.is_cancelled();
        let limits = Limits {
            cells: 20_000,
            cancelled: &cancelled,
        };
        let index = SolidIndex::new(&solid);
        let gap = Gap {
            relative: 0.05,
            absolute: 0.01 * epsilon,
        };
        let proved = |hull| {
            let Decision::Within(known) = decide(&index, hull, epsilon, &limits) else {
                return None;
            };
            let found = bounds(&index, hull, gap, &limits);
            Some((found.lower.max(known.lower), found.upper.min(known.upper)))
        };
        meshes.iter().map(proved).collect::<Vec<_>>()
    })
}

/// What no ball of `radius` can enter from outside: a closed surface around the pockets
/// as (vertices, faces), how many there are, and the spacing of the lattice.
#[pyfunction]
#[pyo3(signature = (vertices, faces, radius, threads, on_progress=None))]
pub fn unreachable<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    radius: f64,
    threads: usize,
    on_progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(MeshTuple<'py>, usize, f64)> {
    let solid = mesh(py, &vertices, &faces)?;
    let found = watch::run(py, on_progress, move |control| {
        reach::unreachable(&solid, radius, threads, control)
    })?
    .map_err(|e| decompose_error(py, &e))?;
    Ok((arrays(py, &found.pockets), found.count, found.spacing))
}

/// A polytope with fewer vertices around the convex hull of points, at most `reach` beyond
/// it: (vertices, faces).
#[pyfunction]
pub fn simplify_within<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    reach: f64,
) -> PyResult<MeshTuple<'py>> {
    let points = points(py, &vertices)?;
    let hull = assetpipe_geometry::hull::convex_hull(&points)
        .map_err(|e| mesh_error(py, &e.to_string()))?;
    let made = std::panic::catch_unwind(|| assetpipe_geometry::hull::simplify_within(&hull, reach))
        .map_err(|_| engine_error(py, "a hull could not be simplified; please report it"))?;
    Ok(arrays(
        py,
        &made.map_err(|e| mesh_error(py, &e.to_string()))?,
    ))
}

/// How faces are connected: (whether they are a closed chain, number of edges, component of each,
/// number of folds).
#[pyfunction]
pub fn connections<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
) -> PyResult<(bool, usize, Bound<'py, PyArray1<i64>>, usize)> {
    let surface = mesh(py, &vertices, &faces)?;
    let found = py.detach(|| edges::connections(&surface));
    let component = found.component.into_iter().map(i64::from);
    Ok((
        found.closed,
        found.edges,
        PyArray1::from_iter(py, component),
        found.folds,
    ))
}

/// Folded edges of a surface, for coordinates in multiples of `unit`.
#[pyfunction]
pub fn folds<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
    faces: PyReadonlyArray2<'py, i64>,
    unit: f64,
) -> PyResult<Vec<(u32, u32)>> {
    let surface = mesh(py, &vertices, &faces)?;
    let found = py.detach(|| assetpipe_decompose::folds::folds(&surface, unit));
    Ok(found.into_iter().map(|[a, b]| (a, b)).collect())
}

/// Convex hull of (n, 3) points: (vertices, faces).
#[pyfunction]
pub fn convex_hull<'py>(
    py: Python<'py>,
    vertices: PyReadonlyArray2<'py, f64>,
) -> PyResult<MeshTuple<'py>> {
    let points = points(py, &vertices)?;
    let made = std::panic::catch_unwind(|| assetpipe_geometry::hull::convex_hull(&points))
        .map_err(|_| engine_error(py, "the hull failed; please report it with these points"))?;
    let hull = made.map_err(|e| mesh_error(py, &e.to_string()))?;
    Ok(arrays(py, &hull))
}

/// Exact hulls of point sets.
fn convex_meshes(py: Python<'_>, hulls: &[PyReadonlyArray2<'_, f64>]) -> PyResult<Vec<Mesh>> {
    let hull = |(index, at): (usize, &PyReadonlyArray2<'_, f64>)| {
        assetpipe_geometry::hull::convex_hull(&points(py, at)?)
            .map_err(|e| mesh_error(py, &format!("hull {index}: {e}")))
    };
    hulls.iter().enumerate().map(hull).collect()
}
