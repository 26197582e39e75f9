//! Contact of thin bodies, against 70 digits (tests/data/make_contact.py) and closed forms.

use crate::support::*;
use fullbody::math::{Mat3, Vec3, rotation};
use fullbody::shape::{Growth, Shape};
use serde_json::Value;

const STRAIGHT: Mat3 = Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);

fn ellipsoid(axes: [f64; 3]) -> Shape {
    Shape::ellipsoid(axes).unwrap()
}

fn of_case(case: &Value, swapped: bool) -> Growth {
    let turn = |key: &str| rotation::matrix([0, 1, 2, 3].map(|i| number(&case[key][i])));
    let body = |key: &str| ellipsoid(triple(&case[key]));
    let r = Vec3::from(triple(&case["separation"]));
    let (p, q) = (turn("attitude_first"), turn("attitude_second"));
    if swapped {
        growth(&body("second"), &body("first"), &-r, &q, &p)
    } else {
        growth(&body("first"), &body("second"), &r, &p, &q)
    }
}

#[test]
fn growth_of_thin_bodies_in_any_attitude() {
    let (mut apart, mut overlapping) = (0, 0);
    for case in data("contact.json").as_array().unwrap() {
        let (expected, condition) = (number(&case["growth"]), number(&case["condition"]));
        for swapped in [false, true] {
            let actual = of_case(case, swapped);
            let error = (actual.factor / expected - 1.0).abs();
            // As good as its inputs' rounding allows, and no better than promised.
            within(error, actual.uncertainty, format!("{case}"));
            within(error, 4.0 * f64::EPSILON * condition, format!("{case}"));
            within(
                (actual.uncertainty / (8.0 * f64::EPSILON * condition) - 1.0).abs(),
                0.02,
                format!("{case}"),
            );
            if (expected - 1.0).abs() > 2.0 * actual.uncertainty {
                let overlap = actual.overlap("Alpha", "Beta").unwrap();
                assert_eq!(overlap, expected < 1.0, "{case}");
                if overlap { overlapping += 1 } else { apart += 1 }
            }
        }
    }
    assert!(apart > 200 && overlapping > 90, "{apart} apart, {overlapping} overlapping");
}

#[test]
fn sizes_a_thousand_million_million_times_apart() {
    // A grain on a planet, on the end of any axis: g = d / (a + b) along the axis.
    let planet = ellipsoid([1.0, 0.9, 0.7]);
    for size in [1e-3, 1e-9, 1e-15, 1e-18, 1e-30] {
        let grain = ellipsoid([size, 0.5 * size, 0.1 * size]);
        for (i, unit) in [Vec3::x(), Vec3::y(), Vec3::z()].into_iter().enumerate() {
            let sum = planet.semi_axes()[i] + grain.semi_axes()[i];
            for factor in [0.5, 1.0 - 1e-12, 1.0 + 1e-12, 3.0] {
                for (first, second) in [(&planet, &grain), (&grain, &planet)] {
                    let actual = growth(first, second, &(unit * sum * factor), &STRAIGHT, &STRAIGHT);
                    close(actual.factor, factor, 4e-15);
                    assert_eq!(actual.overlap("Alpha", "Beta"), Ok(factor < 1.0));
                }
            }
        }
    }
}

#[test]
fn bodies_too_thin_to_tell_say_so_only_where_they_nearly_touch() {
    let turn = rotation::matrix([0.5, -0.3, 0.7, 0.4]);
    let normal = turn.column(2).into_owned();
    for thickness in [1e-13, 1e-15, 1e-18, 1e-200, 1e-310] {
        let disc = ellipsoid([1.0, 1.0, thickness]);
        let at = |r: Vec3| growth(&disc, &disc, &r, &turn, &turn);
        let refused = refusal(at(normal * (2.0 * thickness)).overlap("Alpha", "Beta"));
        assert!(refused.starts_with("gap between Alpha and Beta is "), "{refused}");
        assert!(refused.contains("too thin to tell whether they overlap"), "{refused}");
        // Clearly apart, and on top of each other.
        assert_eq!(at(normal).overlap("Alpha", "Beta"), Ok(false));
        assert_eq!(at(Vec3::zeros()).overlap("Alpha", "Beta"), Ok(true));
    }
    // A hundred times thicker than the thinnest that is refused: told to a hundredth.
    let disc = ellipsoid([1.0, 1.0, 1e-11]);
    for factor in [0.99, 1.01] {
        let actual = growth(&disc, &disc, &(normal * (2e-11 * factor)), &turn, &turn);
        assert_eq!(actual.overlap("Alpha", "Beta"), Ok(factor < 1.0));
    }
}

#[test]
fn rim_to_rim_thickness_does_not_count() {
    let turn = rotation::matrix([0.5, -0.3, 0.7, 0.4]);
    let rim = turn.column(0).into_owned();
    for thickness in [0.5, 1e-3, 1e-6, 1e-9] {
        let disc = ellipsoid([1.0, 1.0, thickness]);
        for factor in [1.0 - 1e-11, 1.0 + 1e-11] {
            let actual = growth(&disc, &disc, &(rim * (2.0 * factor)), &turn, &turn);
            assert_eq!(actual.overlap("Alpha", "Beta"), Ok(factor < 1.0), "{actual:?}");
        }
    }
}

#[test]
fn no_separation_or_size_leaves_the_range_of_doubles() {
    for scale in [1e-300, 1e-200, 1.0, 1e150, 1e300] {
        let (first, second) = (ellipsoid([scale, 0.8 * scale, 0.5 * scale]), ellipsoid([0.5 * scale; 3]));
        close(growth(&first, &second, &(Vec3::x() * (3.0 * scale)), &STRAIGHT, &STRAIGHT).factor, 2.0, 1e-15);
        let far = growth(&first, &second, &(Vec3::new(1e307, -1e307, 1e307)), &STRAIGHT, &STRAIGHT);
        assert!(far.factor > 1e6 && far.overlap("Alpha", "Beta") == Ok(false), "{far:?}");
        let near = growth(&first, &second, &(Vec3::x() * 5e-324), &STRAIGHT, &STRAIGHT);
        assert!(near.factor < 1e-22 && near.overlap("Alpha", "Beta") == Ok(true), "{near:?}");
    }
}
