//! Derivatives of the brightness, by differences.

use super::{Pair, cases, hapke};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::photometry::{Law, Photometer, Surface, View};

/// The brightness of body `of` with one of the 24 numbers of the view shifted: positions, rotation vectors
/// and semi-axes of both bodies, the directions.
fn shifted(pair: &Pair, law: Law, of: usize, which: usize, by: f64) -> f64 {
    let mut moved = Pair {
        axes: pair.axes,
        position: pair.position.clone(),
        attitude: pair.attitude.clone(),
        to_observer: pair.to_observer,
        to_sun: pair.to_sun,
    };
    let i = which % 3;
    let mut unit = Vec3::zeros();
    unit[i] = by;
    match which / 3 {
        k @ (0 | 3) => moved.position[k / 3][i] += by,
        k @ (1 | 4) => {
            let half = (0.5 * by).sin();
            let turn = [(0.5 * by).cos(), unit.x / by * half, unit.y / by * half, unit.z / by * half];
            moved.attitude[k / 3] = rotation::product(pair.attitude[k / 3], turn);
        }
        k @ (2 | 5) => moved.axes[k / 3][i] += by,
        6 => moved.to_observer += unit - pair.to_observer * pair.to_observer[i] * by,
        _ => moved.to_sun += unit - pair.to_sun * pair.to_sun[i] * by,
    }
    moved.brightness(law, true)[of]
}

#[test]
fn derivatives_are_those_of_differences() {
    let hapke = hapke(0.0);
    for (index, (pair, _)) in cases().iter().enumerate() {
        for law in [Law::LOMMEL_SEELIGER, Law::LAMBERT, Law::Sum([1.0, 0.3]), hapke] {
            if law != Law::LOMMEL_SEELIGER && index != 13 {
                continue;
            }
            let photometer = pair.photometer(law, true);
            let alone = pair.brightness(law, false);
            let partials = photometer.partials(&pair.view(), &mut InterruptCheck::never()).unwrap();
            let plain = pair.brightness(law, true);
            for (body, (value, found)) in partials.iter().enumerate() {
                assert!((value - plain[body]).abs() < 1e-12 * alone[body], "{value} {}", plain[body]);
                let [first, second] = [found.by_body[0], found.by_body[1]];
                let all = [
                    first.position,
                    first.rotation,
                    first.semi_axes,
                    second.position,
                    second.rotation,
                    second.semi_axes,
                    found.by_direction[0],
                    found.by_direction[1],
                ];
                for which in 0..24 {
                    let h = 1e-5;
                    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| shifted(pair, law, body, which, k * h));
                    let difference = (a - 8.0 * b + 8.0 * c - d) / (12.0 * h);
                    let analytic = all[which / 3][which % 3];
                    let error = (difference - analytic).abs() / alone[body];
                    assert!(
                        error < 1e-7,
                        "case {index}, body {body}, {law:?}, {which}: {analytic} {difference} {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn derivatives_by_the_direction_to_a_disc_of_the_sun_are_those_of_differences() {
    let (pair, _) = &cases()[5];
    let surfaces = vec![Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![1.0] }; 2];
    let photometer = Photometer::new(pair.bodies(), surfaces, true, 0.2).unwrap();
    let partials = photometer.partials(&pair.view(), &mut InterruptCheck::never()).unwrap();
    let unit = pair.to_sun.normalize();
    for k in 0..3 {
        let mut shift = -unit * unit[k];
        shift[k] += 1.0;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|step| {
            let view = View { to_sun: unit + shift * (step * 1e-4), ..pair.view() };
            photometer.brightness(&view, &mut InterruptCheck::never()).unwrap()
        });
        for body in 0..2 {
            let difference = (a[body] - 8.0 * b[body] + 8.0 * c[body] - d[body]) / 12e-4;
            let found = partials[body].1.by_direction[1][k];
            let size = pair.brightness(Law::LOMMEL_SEELIGER, false)[body];
            assert!((difference - found).abs() < 1e-6 * size, "{body} {k}: {difference} {found}");
        }
    }
}
