//! Bytes and back.

use super::systems::*;
use fullbody::dynamics::{AttitudeChart, Settings, System};
use fullbody::error::Error;
use fullbody::integrate::{Scheme, Tolerance};
use fullbody::math::Vec3;
use fullbody::mutual::Method;
use fullbody::quadrature::Order;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{ARCHIVE_FORMAT, Integrator, Output, Simulation};

/// A run that goes on from bytes equals the unbroken one bit for bit: every integrator, chart and kind of
/// gravity.
#[test]
fn resumed_equals_unbroken() {
    for method in [Method::Focal, Method::Surface, Method::Multipole(4), Method::Point] {
        for chart in [AttitudeChart::Quaternion, AttitudeChart::TaitBryan] {
            let (system, state) = tumbling(method, chart);
            for integrator in all(1e-10, 0.05).into_iter().chain([Integrator::Verner98ToRoundoff]) {
                let Ok(mut unbroken) = Simulation::new(&system, &state, integrator) else {
                    assert_eq!(chart, AttitudeChart::TaitBryan);
                    continue;
                };
                // Stops in the middle of nowhere, between two steps and not at a time asked for.
                (0..7).for_each(|_| unbroken.step(4.0).unwrap());
                let mut resumed = read(&unbroken.to_bytes().unwrap()).unwrap();
                assert_eq!(resumed.state(), unbroken.state());
                let label = format!("{integrator:?} {method} {chart:?}");
                let [a, b] =
                    [&mut unbroken, &mut resumed].map(|s| integrate(s, 2.5, &Output::Spacing(0.3), false));
                assert_eq!(a, b, "{label}");
                assert_eq!(unbroken.statistics(), resumed.statistics(), "{label}");
                let [a, b] = [&mut unbroken, &mut resumed].map(|s| integrate(s, 1.0, &Output::Steps, false));
                assert_eq!(a, b, "{label}, backwards");
                assert_eq!(unbroken.to_bytes().unwrap(), resumed.to_bytes().unwrap(), "{label}");
            }
        }
    }
}

/// A run goes on bit for bit from its middle too, as an autosave from the hook sees it.
#[test]
fn a_run_resumed_from_its_middle_is_the_same() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let mut unbroken = Simulation::new(&system, &state, verner98(1e-11)).unwrap();
    let mut saved = unbroken.clone();
    (0..9).for_each(|_| saved.step(5.0).unwrap());
    let mut resumed = read(&saved.to_bytes().unwrap()).unwrap();
    integrate(&mut unbroken, 5.0, &Output::Spacing(0.1), false);
    integrate(&mut resumed, 5.0, &Output::Spacing(0.1), false);
    assert_eq!(unbroken.state(), resumed.state());
    assert_eq!(unbroken.statistics().steps, resumed.statistics().steps);
}

#[test]
fn refuses_what_it_did_not_write() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let bytes = Simulation::new(&system, &state, verner98(1e-11)).unwrap().to_bytes().unwrap();
    assert!(read(&bytes).is_ok());
    let refusal = |bytes: &[u8]| match read(bytes) {
        Err(Error::InvalidInput { value, .. }) => value,
        other => panic!("{other:?}"),
    };
    for length in 0..bytes.len() {
        refusal(&bytes[..length]);
    }
    for at in 0..bytes.len() {
        let mut altered = bytes.clone();
        altered[at] ^= 0x10;
        refusal(&altered);
    }
    assert!(refusal(&bytes[..bytes.len() - 1]).contains("truncated"));
    assert!(refusal(&[bytes.as_slice(), &[0]].concat()).contains("too long"));
    let mut altered = bytes.clone();
    altered[100] ^= 1;
    assert!(refusal(&altered).contains("altered"));
    altered = bytes.clone();
    altered[8] = 9;
    assert!(refusal(&altered).contains("of format 9"));
    assert_eq!(refusal(b"CDF\x01 and so on"), "something else");
}

/// A file of tests/data.
fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn another_format_is_refused_by_its_number() {
    let bytes = data("simulation.bin");
    for format in [0_u8, 1, 3] {
        let mut other = bytes.clone();
        other[8] = format;
        let refusal = read(&other).unwrap_err().to_string();
        assert!(refusal.contains(&format!("of format {format}; expected format 2")), "{refusal}");
    }
}

/// A file of the present format is read, so that the format cannot change unseen.
#[test]
fn an_archive_of_the_present_format_is_read() {
    let simulation = read(&data("simulation.bin")).unwrap();
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let mut again = Simulation::new(&system, &state, verner98(1e-11)).unwrap();
    integrate(&mut again, 1.0, &Output::Times(vec![]), false);
    assert_eq!(simulation.time(), 1.0);
    assert_eq!(simulation.description(), again.description());
    assert_eq!(simulation.notes, "kept");
    assert!(difference(&simulation.state(), &again.state()) < 1e-11);
}

#[test]
fn a_written_file_is_read() {
    // To replace the kept file for a new format: write one with KEEP set, then move it to tests/data.
    assert_eq!(ARCHIVE_FORMAT, 2, "a new format needs a file of its own");
    let path = std::env::temp_dir().join(format!("fullbody-simulation-{}.bin", std::process::id()));
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let mut simulation = Simulation::new(&system, &state, verner98(1e-11)).unwrap();
    simulation.notes = "kept".to_owned();
    integrate(&mut simulation, 1.0, &Output::Times(vec![]), false);
    std::fs::write(&path, simulation.to_bytes().unwrap()).unwrap();
    let again = read(&std::fs::read(&path).unwrap()).unwrap();
    if std::env::var_os("KEEP").is_none() {
        std::fs::remove_file(&path).unwrap();
    }
    assert_eq!(again.state(), simulation.state());
    assert_eq!(again.notes, simulation.notes);
}

/// Every number of the description stands once in an archive, as text: nothing can disagree with it.
#[test]
fn archives_hold_each_number_of_the_description_once() {
    let shape = Shape::ellipsoid([0.41, 0.352, 0.3003]).unwrap();
    let bodies = vec![
        Body::with_mass("A", shape, 0.80001).unwrap(),
        Body::with_mass("B", Shape::Point, 0.200002).unwrap(),
    ];
    let order = Some(Order { gauss: 397, angles: 793 });
    let settings = Settings { gravity_tolerance: 3.7e-13, order, ..Settings::default() };
    let system = System::new(bodies, 1.0003, settings).unwrap();
    let state = relative(Vec3::new(1.6, 0.1, 0.2), Vec3::new(0.02, 0.75, 0.1), 0.2);
    let tolerance = Tolerance::new(1.9e-11, 2.3e-12).unwrap();
    let adaptive = (Integrator::Verner87(tolerance), vec![1.9e-11, 2.3e-12]);
    let fixed = (Integrator::SymplecticSplitting { step: 0.01234, scheme: Scheme::Aba864 }, vec![0.01234]);
    for (integrator, settings) in [adaptive, fixed] {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        // Past its first step, so that nothing of the start is what the run goes on from.
        integrate(&mut simulation, 0.1, &Output::Times(vec![]), false);
        let bytes = simulation.to_bytes().unwrap();
        let found = |part: &[u8]| bytes.windows(part.len()).filter(|window| *window == part).count();
        for number in
            [0.41_f64, 0.352, 0.3003, 0.80001, 0.200002, 1.0003, 3.7e-13].into_iter().chain(settings)
        {
            let text = serde_json::to_string(&number).unwrap();
            assert_eq!((found(text.as_bytes()), found(&number.to_le_bytes())), (1, 0), "{text}");
        }
        assert_eq!(found(b"[397,793]"), 1);
    }
}
