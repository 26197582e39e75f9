//! Any bytes as an archive: an error, or a simulation that can be looked at, written, read again, and moved.

use fullbody::error::{Error, Result};
use fullbody::interrupt::{HOOK_INTERVAL, InterruptCheck};
use fullbody::trajectory::{ARCHIVE_FORMAT, Simulation};
use std::ops::ControlFlow;
use std::time::Instant;

const HEADER: usize = 24;

/// Opens the bytes as they stand, and with a sound header before what follows theirs.
pub fn check(bytes: &[u8]) {
    open(bytes);
    let contents =
        if bytes.starts_with(b"FULLBODY") { bytes.get(HEADER..).unwrap_or_default() } else { bytes };
    open(&sealed(contents));
}

/// Contents behind a header that says nothing wrong of them.
fn sealed(contents: &[u8]) -> Vec<u8> {
    let mut bytes = b"FULLBODY".to_vec();
    bytes.extend(ARCHIVE_FORMAT.to_le_bytes());
    bytes.extend((contents.len() as u64).to_le_bytes());
    bytes.extend(crc32fast::hash(contents).to_le_bytes());
    bytes.extend(contents);
    bytes
}

fn open(bytes: &[u8]) {
    let Ok(mut simulation) = bounded(|interrupt| Simulation::from_bytes(bytes, interrupt)) else { return };
    is_sound(&simulation);
    let written = simulation.to_bytes().expect("what was read can be written");
    let again =
        Simulation::from_bytes(&written, &mut InterruptCheck::never()).expect("what was written can be read");
    assert_eq!(again.to_bytes().unwrap(), written);
    for way in [1.0, -1.0, 0.1] {
        let before = simulation.state();
        match bounded(|interrupt| simulation.step_with(before.time() + way, interrupt)) {
            Ok(()) => is_sound(&simulation),
            Err(error) => {
                assert_eq!(simulation.state(), before, "{error}");
                assert!(!error.to_string().contains("NaN"), "{error}");
            }
        }
    }
}

/// As much as a hundred thousand units of work: from then on every look at the clock is too late.
fn bounded<T>(call: impl FnOnce(&mut InterruptCheck) -> Result<T>) -> Result<T> {
    let Some(long_ago) = Instant::now().checked_sub(2 * HOOK_INTERVAL) else {
        return Err(Error::Interrupted { time: 0.0 });
    };
    let mut hook = || ControlFlow::Break(());
    call(&mut InterruptCheck::since(long_ago, &mut hook))
}

fn is_sound(simulation: &Simulation) {
    let state = simulation.state();
    assert!(state.time().is_finite());
    for body in 0..state.bodies() {
        let vectors = [state.position()[body], state.velocity()[body], state.spin()[body]];
        assert!(vectors.iter().all(|v| v.iter().all(|x| x.is_finite())), "{state:?}");
        let square: f64 = state.attitude()[body].iter().map(|q| q * q).sum();
        assert!((square - 1.0).abs() < 1e-12, "{state:?}");
    }
    assert!(simulation.start().numbers().iter().all(|x| x.is_finite()));
}
