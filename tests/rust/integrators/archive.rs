//! Bytes and back.

use super::systems::*;
use fullbody::dynamics::AttitudeChart;
use fullbody::error::Error;
use fullbody::mutual::Method;
use fullbody::patience::Patience;
use fullbody::trajectory::{ARCHIVE_VERSION, Output, Simulation};

/// A run that goes on from bytes equals the unbroken one bit for bit: every integrator, chart and kind of gravity.
#[test]
fn resumed_equals_unbroken() {
    for method in [Method::Focal, Method::Surface, Method::Multipole(4), Method::Point] {
        for chart in [AttitudeChart::Quaternion, AttitudeChart::TaitBryan] {
            let (system, state) = tumbling(method, chart);
            for integrator in all(1e-10, 0.05) {
                let Ok(mut unbroken) = Simulation::new(&system, &state, integrator) else {
                    assert_eq!(chart, AttitudeChart::TaitBryan);
                    continue;
                };
                // Stops in the middle of nowhere, between two steps and not at a time asked for.
                (0..7).for_each(|_| unbroken.step(4.0, &mut Patience::endless()).unwrap());
                let mut resumed = Simulation::from_bytes(&unbroken.to_bytes().unwrap()).unwrap();
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

/// The same in the middle of a run, as an autosave from the hook sees it.
#[test]
fn resumed_mid_run() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let mut unbroken = Simulation::new(&system, &state, verner98(1e-11)).unwrap();
    let mut saved = unbroken.clone();
    (0..9).for_each(|_| saved.step(5.0, &mut Patience::endless()).unwrap());
    let mut resumed = Simulation::from_bytes(&saved.to_bytes().unwrap()).unwrap();
    integrate(&mut unbroken, 5.0, &Output::Spacing(0.1), false);
    integrate(&mut resumed, 5.0, &Output::Spacing(0.1), false);
    assert_eq!(unbroken.state(), resumed.state());
    assert_eq!(unbroken.statistics().steps, resumed.statistics().steps);
}

#[test]
fn refuses_what_it_did_not_write() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let bytes = Simulation::new(&system, &state, verner98(1e-11)).unwrap().to_bytes().unwrap();
    assert!(Simulation::from_bytes(&bytes).is_ok());
    let refusal = |bytes: &[u8]| match Simulation::from_bytes(bytes) {
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
    assert!(refusal(&altered).contains("layout 9"));
    assert_eq!(refusal(b"CDF\x01 and so on"), "something else");
}

/// A file of layout 1, written by the first version that had it.
fn file() -> String {
    format!("{}/tests/data/simulation-1.bin", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn reads_layout_1() {
    let simulation = Simulation::from_bytes(&std::fs::read(file()).unwrap()).unwrap();
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let mut again = Simulation::new(&system, &state, verner98(1e-11)).unwrap();
    integrate(&mut again, 1.0, &Output::Times(vec![]), false);
    assert_eq!(simulation.time(), 1.0);
    assert_eq!(simulation.system().bodies(), system.bodies());
    assert_eq!(simulation.integrator(), verner98(1e-11));
    assert!(difference(&simulation.state(), &again.state()) < 1e-11);
}

#[test]
fn a_written_file_is_read() {
    // The way to the kept file of a new layout: write it, then move it to tests/data beside the old ones.
    assert_eq!(ARCHIVE_VERSION, 1, "a new layout needs a file of its own; the old one stays");
    let path = std::env::temp_dir().join(format!("fullbody-simulation-{}.bin", std::process::id()));
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let mut simulation = Simulation::new(&system, &state, verner98(1e-11)).unwrap();
    integrate(&mut simulation, 1.0, &Output::Times(vec![]), false);
    std::fs::write(&path, simulation.to_bytes().unwrap()).unwrap();
    let read = Simulation::from_bytes(&std::fs::read(&path).unwrap()).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read.state(), simulation.state());
}
