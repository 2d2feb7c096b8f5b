//! Decompose OFF files and print hulls and CPU seconds:
//! `cargo run --release --example measure -- 0.05 key=value… file.off…`
//! (tolerance relative to half the longest side, as CoACD's threshold).

use std::time::Instant;

use assetpipe_decompose::control::Control;
use assetpipe_decompose::engine::{decompose_working, overall};
use assetpipe_decompose::settings::SearchSettings;
use assetpipe_geometry::distance::SolidIndex;
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
        mesh.vertices.push(DVec3::new(number()?, number()?, number()?));
    }
    for _ in 0..m {
        let k = number()? as usize;
        let face: Vec<u32> = (0..k).filter_map(|_| number().map(|x| x as u32)).collect();
        for i in 2..k {
            mesh.triangles.push([face[0], face[i - 1], face[i]]);
        }
    }
    Some(mesh)
}

fn main() {
    let mut settings = SearchSettings::default();
    let mut threshold = 0.05;
    let mut files = Vec::new();
    for arg in std::env::args().skip(1) {
        if let Ok(x) = arg.parse::<f64>() {
            threshold = x;
        } else if let Some((key, value)) = arg.split_once('=') {
            if let Err(message) = settings.set(key, value) {
                eprintln!("{message}");
            }
        } else {
            files.push(arg);
        }
    }
    for file in files {
        let Some(mut mesh) = read_off(&file) else {
            eprintln!("cannot read {file}");
            continue;
        };
        let (lo, hi) = mesh
            .vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let scale = 2.0 / (hi - lo).max_element();
        for p in &mut mesh.vertices {
            *p = (*p - 0.5 * (lo + hi)) * scale;
        }
        let start = Instant::now();
        let solid = SolidIndex::new(&mesh);
        match decompose_working(&mesh, &solid, threshold, &settings, &Control::default()) {
            Ok(hulls) => {
                let vertices: usize = hulls.iter().map(|h| h.hull.vertices.len()).sum();
                let name = file.rsplit('/').next().unwrap_or(&file);
                println!(
                    "{name:24} {:5} hulls {:7.3} s {vertices:6} vertices  {:.5}",
                    hulls.len(),
                    start.elapsed().as_secs_f64(),
                    overall(&hulls).upper
                );
            }
            Err(error) => println!("{file}: {error}"),
        }
    }
}
