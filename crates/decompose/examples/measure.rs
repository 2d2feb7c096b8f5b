//! Decompose OFF files and print hulls and CPU seconds:
//! `cargo run --release --example measure -- 0.05 key=value… file.off…`
//! (tolerance relative to half the longest side, as `CoACD`'s threshold; `threads=2` is two
//! threads, every other key a setting of the search).

use assetpipe_decompose::control::Control;
use assetpipe_decompose::decomposition::{decompose, Hull};
use assetpipe_decompose::settings::SearchSettings;
use assetpipe_geometry::Mesh;
use glam::DVec3;

fn read_off(path: &str) -> Option<Mesh> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut words = text.split_whitespace().skip(1);
    let n: usize = words.next()?.parse().ok()?;
    let m: usize = words.next()?.parse().ok()?;
    words.next();
    let mut number = || words.next().and_then(|w| w.parse::<f64>().ok());
    let mut mesh = Mesh::default();
    for _ in 0..n {
        mesh.vertices
            .push(DVec3::new(number()?, number()?, number()?));
    }
    for _ in 0..m {
        let k = number()? as usize;
        let face: Vec<u32> = (0..k).filter_map(|_| number().map(|x| x as u32)).collect();
        for i in 2..k {
            mesh.triangles.push([face[0], face[i - 1], face[i]]);
        }
    }
    Some(weld(&mesh))
}

/// Exactly equal vertices become one.
fn weld(mesh: &Mesh) -> Mesh {
    let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let key = |v: u32| (mesh.vertices[v as usize] + DVec3::ZERO).to_array();
    order.sort_by(|&a, &b| {
        key(a)
            .partial_cmp(&key(b))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut welded = Mesh::default();
    let mut index = vec![0; order.len()];
    for run in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &v in run {
            index[v as usize] = welded.vertices.len() as u32;
        }
        welded.vertices.push(mesh.vertices[run[0] as usize]);
    }
    welded.triangles = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| index[v as usize]))
        .collect();
    welded
        .triangles
        .retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    welded
}

/// A number that tells results apart (FNV-1a over all that leaves the engine).
fn fingerprint(hulls: &[Hull]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut add = |x: u64| {
        for byte in x.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for hull in hulls {
        let points = hull.mesh.vertices.iter().flat_map(DVec3::to_array);
        points.for_each(|x| add(x.to_bits()));
        let corners = hull.mesh.triangles.iter().flatten();
        corners.for_each(|&v| add(u64::from(v)));
        let bounds = std::iter::once(hull.thickening).chain(hull.concavity);
        bounds.for_each(|b| {
            add(b.lower.to_bits());
            add(b.upper.to_bits());
        });
    }
    hash
}

/// Processor seconds of this process so far (Linux), which other loads do not disturb.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Fields 14 and 15 (user and system time) in hundredths of a second, plus
    // the precise time of the main thread where the work is short.
    let after = text.rsplit(')').next().unwrap_or_default().to_owned();
    let mut fields = after
        .split_whitespace()
        .skip(11)
        .filter_map(|w| w.parse::<f64>().ok());
    (fields.next().unwrap_or(0.0) + fields.next().unwrap_or(0.0)) * 0.01
}

fn main() {
    let mut settings = SearchSettings::default();
    let mut threshold = 0.05;
    let mut threads = 1;
    let mut files = Vec::new();
    for arg in std::env::args().skip(1) {
        if let Ok(x) = arg.parse::<f64>() {
            threshold = x;
        } else if let Some(count) = arg.strip_prefix("threads=") {
            threads = count.parse().unwrap_or(1);
        } else if let Some((key, value)) = arg.split_once('=') {
            if let Err(message) = settings.set(key, value) {
                eprintln!("{message}");
            }
        } else {
            files.push(arg);
        }
    }
    for file in files {
        let Some(mesh) = read_off(&file) else {
            eprintln!("cannot read {file}");
            continue;
        };
        let (lo, hi) = mesh
            .vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
                (lo.min(p), hi.max(p))
            });
        let epsilon = threshold * 0.5 * (hi - lo).max_element();
        let start = processor_seconds();
        let wall = std::time::Instant::now();
        match decompose(&mesh, epsilon, &settings, threads, &Control::default()) {
            Ok(result) => {
                let hulls = &result.hulls[..result.leaves];
                let vertices: usize = hulls.iter().map(|h| h.mesh.vertices.len()).sum();
                let worst = hulls.iter().map(|h| h.thickening.upper).fold(0.0, f64::max) / epsilon
                    * threshold;
                let name = file.rsplit('/').next().unwrap_or(&file);
                let concavity = hulls
                    .iter()
                    .filter_map(|h| h.concavity)
                    .map(|c| c.upper)
                    .fold(0.0, f64::max)
                    / epsilon
                    * threshold;
                let bytes = fingerprint(&result.hulls);
                println!(
                    "{name:24} {:5} hulls {:7.3} s {vertices:6} vertices  wall {:.3} concavity {concavity:.4} thickening {:.5} bytes {bytes:016x}",
                    hulls.len(),
                    (processor_seconds() - start).max(0.001),
                    wall.elapsed().as_secs_f64(),
                    worst
                );
            }
            Err(error) => println!("{file}: {error}"),
        }
    }
}
