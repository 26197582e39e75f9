//! What external forces are made of: an extended body's attraction, splines, places on an orbit.

use crate::support::*;
use fullbody::gravity::ExtendedAttraction;
use fullbody::math::Vec3;
use fullbody::math::spline::Spline;
use fullbody::orbit::{KeplerElements, OrbitPath};
use fullbody::shape::{Body, Shape};

const AXES: [f64; 3] = [1.0, 0.8, 0.5];

fn at(attraction: &mut ExtendedAttraction, x: &Vec3) -> Option<(Vec3, Vec3)> {
    let distance = x.norm();
    attraction.at(x, distance.powi(-2), distance.powi(-3), 1.0)
}

fn attraction(axes: [f64; 3]) -> ExtendedAttraction {
    ExtendedAttraction::new(&Shape::ellipsoid(axes).unwrap()).unwrap()
}

// (x, g + x/|x|^3, x cross g) of the ellipsoid above with GM = 1: mpmath with 50 digits, MacMillan's field in
// Carlson's form.
#[rustfmt::skip]
const FIELDS: [[[f64; 3]; 3]; 7] = [
    [[0.528, -0.66, 0.7040000000000001], [0.09930214078714582, -0.06595818366142732, -0.030908142925242136], [0.06683393562830464, 0.08622820657867851, 0.030713491946282617]],
    [[0.72, -0.8999999999999999, 0.96], [0.029871609293840678, -0.01667118965192705, -0.012267407995853206], [0.02704500926211785, 0.03750927867910136, 0.014881191815069134]],
    [[1.44, -1.7999999999999998, 1.92], [0.0019040967389070565, -0.0008582248216752566, -0.0009502191521580408], [0.003358186131500966, 0.005024181317809127, 0.0021915303868203315]],
    [[3.84, -4.8, 5.12], [3.774808193810646e-05, -1.5761340891492243e-05, -1.9804725118747113e-05], [0.00017576074593442643, 0.000269320323979094, 0.00012066724427958079]],
    [[24.0, -30.0, 32.0], [2.4744810058215473e-08, -1.019864912579001e-08, -1.3083972841716715e-08], [7.188759572767817e-07, 1.1058492700640963e-06, 4.97576722727504e-07]],
    [[4800.0, -6000.0, 6400.0], [1.5465599997662644e-17, -6.3720000538986514e-18, -8.179199957077616e-18], [8.985600008741707e-14, 1.3823999977901348e-13, 6.220799972726234e-14]],
    [[480000000.0, -600000000.0, 640000000.0], [1.5465599999999998e-37, -6.372000000000002e-38, -8.179200000000001e-38], [8.985600000000001e-29, 1.3824e-28, 6.220799999999999e-29]],
];

#[test]
fn the_pull_of_an_extended_body_against_arbitrary_precision() {
    let mut attraction = attraction(AXES);
    for [x, perturbation, moment] in FIELDS.map(|row| row.map(Vec3::from)) {
        let (more, turn) = at(&mut attraction, &x).unwrap();
        assert!(relative(&more, &perturbation) < 1e-14, "{x}: {more} is not {perturbation}");
        assert!(relative(&turn, &moment) < 5e-15, "{x}: {turn} is not {moment}");
    }
}

#[test]
fn the_pull_is_the_exterior_field_less_a_point() {
    for axes in [AXES, [0.5, 1.0, 0.8], [0.4, 1.0, 1.0], [1.0, 0.3, 0.3]] {
        let body = Body::with_mass("body", Shape::ellipsoid(axes).unwrap(), 1.0).unwrap();
        let (field, mut attraction) = (FieldOf::new(&body, 1.0), attraction(axes));
        for distance in [1.02, 1.7, 2.3, 4.0, 11.0] {
            let x = Vec3::new(0.48, -0.6, 0.64) * distance;
            let g = field.field(&x).unwrap();
            let (more, turn) = at(&mut attraction, &x).unwrap();
            let expected = g + x / x.norm().powi(3);
            assert!((more - expected).norm() < 1e-15 * g.norm(), "{axes:?} at {distance}");
            assert!((turn - x.cross(&g)).norm() < 2e-15 * g.norm() * distance, "{axes:?} at {distance}");
        }
    }
}

#[test]
fn the_pull_does_not_depend_on_what_was_asked_before() {
    let mut used = attraction(AXES);
    for distance in [1e6, 1.3, 40.0, 1.05, 3.0, 40.0] {
        let x = Vec3::new(0.48, -0.6, 0.64) * distance;
        assert_eq!(at(&mut used, &x), at(&mut attraction(AXES), &x));
    }
}

#[test]
fn spheres_and_points_pull_as_points_and_inside_is_nothing() {
    assert!(ExtendedAttraction::new(&Shape::ellipsoid([0.7; 3]).unwrap()).is_none());
    assert!(ExtendedAttraction::new(&Shape::Point).is_none());
    assert!(at(&mut attraction(AXES), &Vec3::new(0.0, 0.0, 0.499)).is_none());
    assert!(at(&mut attraction(AXES), &Vec3::new(0.0, 0.0, 0.501)).is_some());
    assert!(at(&mut attraction(AXES), &Vec3::zeros()).is_none());
}

#[test]
fn a_spline_through_a_cubic_is_the_cubic() {
    let cubic = |t: f64| [1.0 - 2.0 * t + 0.5 * t * t - 0.25 * t * t * t, t * t * t, 7.0];
    let slope = |t: f64| [-2.0 + t - 0.75 * t * t, 3.0 * t * t, 0.0];
    for places in [vec![-2.0, -0.5, 0.25, 3.0], vec![-2.0, -1.9, 0.0, 0.1, 2.0, 2.5, 3.0]] {
        let values: Vec<_> = places.iter().map(|t| cubic(*t)).collect();
        let spline = Spline::new("times", &places, &values).unwrap();
        assert_eq!(spline.range(), (-2.0, 3.0));
        // Also beyond the range, where the last piece goes on.
        for t in [-2.5, -2.0, -1.3, 0.0, 0.05, 1.7, 3.0, 3.5] {
            let (value, rate) = spline.at(t);
            for k in 0..3 {
                assert!((value[k] - cubic(t)[k]).abs() < 1e-13, "{t}: {value:?}");
                assert!((rate[k] - slope(t)[k]).abs() < 1e-12, "{t}: {rate:?}");
            }
        }
    }
}

#[test]
fn a_spline_is_that_of_scipy() {
    // scipy.interpolate.CubicSpline, whose ends are "not-a-knot" unless told otherwise: (t, value, slope).
    #[rustfmt::skip]
    const EXPECTED: [[f64; 3]; 7] = [
        [-1.0, 0.5, -10.660294117647057], [-0.75, -1.0860294117647056, -2.513970588235294],
        [0.0, 1.2720588235294117, 4.427941176470589], [0.5, 1.713344226579521, -2.7707516339869285],
        [1.75, 0.4384191176470591, 2.261764705882354], [2.9, 0.36047843137254965, -5.3638627450980385],
        [3.0, -0.25, -6.868137254901961],
    ];
    let places = [-1.0, -0.5, 0.25, 1.0, 2.5, 3.0];
    let values = [0.5, -1.0, 2.0, 0.0, 1.5, -0.25].map(|v| [v]);
    let spline = Spline::new("times", &places, &values).unwrap();
    for [t, value, slope] in EXPECTED {
        let (found, rate) = spline.at(t);
        assert!((found[0] - value).abs() < 1e-14, "{t}: {found:?}");
        assert!((rate[0] - slope).abs() < 5e-14, "{t}: {rate:?}");
    }
}

#[test]
fn tables_that_are_none_are_refused() {
    let refused = |places: &[f64], values: &[[f64; 1]]| {
        let error = Spline::new("times of Sun", places, values).unwrap_err().to_string();
        assert!(error.contains("times of Sun"), "{error}");
    };
    refused(&[0.0, 1.0, 2.0], &[[0.0]; 3]);
    refused(&[0.0, 1.0, 2.0, 3.0], &[[0.0]; 3]);
    refused(&[0.0, 1.0, 1.0, 3.0], &[[0.0]; 4]);
    refused(&[0.0, 2.0, 1.0, 3.0], &[[0.0]; 4]);
    refused(&[0.0, 1.0, f64::NAN, 3.0], &[[0.0]; 4]);
    refused(&[0.0, 1.0, 2.0, 3.0], &[[0.0], [f64::INFINITY], [0.0], [0.0]]);
}

#[test]
fn places_on_an_orbit_are_those_of_its_elements() {
    // By the elements of the same orbit with another mean anomaly, which the orbit's own tests hold against
    // mpmath.
    for (a, e) in [(3.0, 0.0), (3.0, 0.2), (0.5, 0.97), (-2.0, 1.01), (-0.3, 4.0)] {
        let mu: f64 = 1.7;
        let of = |mean: f64| KeplerElements::new(a, e, 0.5, 1.0, 2.0, mean).unwrap();
        let path = OrbitPath::new(&of(0.3), mu).unwrap();
        for time in [-20.0, -0.1, 0.0, 1.0, 77.0] {
            let motion = (mu / f64::abs(a).powi(3)).sqrt();
            let (r, v) = of(0.3 + motion * time).to_cartesian(mu).unwrap();
            let (place, speed) = path.after(time).unwrap();
            // The mean anomaly rounds at 1e-16 of its size, which is some tens.
            assert!(relative(&place, &r) < 2e-13, "{a}, {e} at {time}: {place} is not {r}");
            assert!(relative(&speed, &v) < 2e-12, "{a}, {e} at {time}: {speed} is not {v}");
            close(path.normal().dot(&r.cross(&v).normalize()), 1.0, 1e-15);
        }
    }
}

#[test]
fn orbits_that_are_none_are_refused() {
    let orbit = KeplerElements::new(3.0, 0.2, 0.0, 0.0, 0.0, 0.0).unwrap();
    assert!(OrbitPath::new(&orbit, 0.0).is_err());
    assert!(OrbitPath::new(&orbit, f64::NAN).is_err());
    assert!(OrbitPath::new(&orbit, 1.0).unwrap().after(f64::INFINITY).is_err());
}
