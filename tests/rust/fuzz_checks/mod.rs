//! The checks of the targets in fuzz/, with all of their corpora and some inputs of chance, always the same
//! ones.
mod archive;
mod pairs;

use crate::integrators::systems::{all, tumbling};
use crate::support::cases;
use fullbody::dynamics::AttitudeChart;
use fullbody::mutual::Method;
use fullbody::trajectory::Simulation;
use proptest::prelude::*;

/// The folder of a target's corpus.
fn corpus(target: &str) -> String {
    format!("{}/fuzz/corpus/{target}", env!("CARGO_MANIFEST_DIR"))
}

fn replay(target: &str, check: impl Fn(&[u8])) {
    let files = std::fs::read_dir(corpus(target)).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files.collect();
    assert!(files.len() > 3);
    files.sort();
    for file in files {
        println!("{}", file.display());
        check(&std::fs::read(file).unwrap());
    }
}

#[test]
fn corpora_pass() {
    replay("archive", archive::check);
    replay("pairs", pairs::check);
}

/// Archives of every integrator, from which others are made by damage.
fn archives() -> Vec<Vec<u8>> {
    let mut archives = Vec::new();
    for (method, chart) in
        [(Method::Focal, AttitudeChart::Quaternion), (Method::Multipole(4), AttitudeChart::TaitBryan)]
    {
        let (system, state) = tumbling(method, chart);
        for integrator in all(1e-8, 0.05) {
            let Ok(mut simulation) = Simulation::new(&system, &state, integrator) else { continue };
            simulation.step(4.0).unwrap();
            archives.push(simulation.to_bytes().unwrap());
        }
    }
    archives
}

#[test]
fn damaged_archives_are_refused() {
    let archives = archives();
    // With KEEP set, writes the corpus of a new format.
    if std::env::var_os("KEEP").is_some() {
        for (k, bytes) in archives.iter().enumerate() {
            std::fs::write(format!("{}/sound-{k:02}.bin", corpus("archive")), bytes).unwrap();
        }
    }
    archives.iter().for_each(|bytes| archive::check(bytes));
    let bytes = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4);
    proptest!(cases(400), |(which in 0..archives.len(), bytes in bytes, cut in any::<bool>())| {
        let mut damaged = archives[which].clone();
        for (at, value) in &bytes {
            let at = at.index(damaged.len());
            damaged[at] = *value;
        }
        if cut {
            damaged.truncate(bytes[0].0.index(damaged.len()));
        }
        archive::check(&damaged);
    });
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn random_bytes_are_no_archive(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        archive::check(&bytes);
    }

    #[test]
    fn random_pairs_pass(bytes in prop::collection::vec(any::<u8>(), 70)) {
        pairs::check(&bytes);
    }
}
