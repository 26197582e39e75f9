//! Volume, inertia, refusals, contact and overlap.

use crate::support::*;
use fullbody::math::{Mat3, Vec3, rotation};
use fullbody::shape::{Body, Ellipsoid, InputCoefficients, Shape, StokesCoefficients};
use proptest::prelude::*;
use std::f64::consts::PI;

const STRAIGHT: Mat3 = Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);

fn ellipsoid(axes: [f64; 3]) -> Shape {
    Shape::ellipsoid(axes).unwrap()
}

fn contact(first: &Shape, second: &Shape, separation: Vec3) -> f64 {
    contact_function(first, second, &separation, &STRAIGHT, &STRAIGHT)
}

#[test]
fn mass_and_inertia_of_the_papers_integrals() {
    // I_11 = 4 pi rho abc (b^2 + c^2) / 15 and its cyclic partners, for every order of the axes.
    let density = 2.7;
    for [a, b, c] in [[3.0, 2.0, 0.5], [0.5, 2.0, 3.0], [2.0, 3.0, 0.5], [1.5, 1.5, 0.2], [0.2, 1.5, 1.5]] {
        let body = Body::with_density("body", ellipsoid([a, b, c]), density).unwrap();
        close(body.mass(), 4.0 * PI / 3.0 * density * (a * b * c), 4e-16);
        let factor = 4.0 * PI * density * a * b * c / 15.0;
        let expected = factor * Vec3::new(b * b + c * c, c * c + a * a, a * a + b * b);
        for i in 0..3 {
            close(body.inertia()[i], expected[i], 8e-16);
        }
    }
    let sphere = Body::with_mass("sphere", Shape::sphere(2.0).unwrap(), 5.0).unwrap();
    for moment in sphere.inertia().iter() {
        close(*moment, 0.4 * 5.0 * 4.0, 4e-16);
    }
    let point = Body::with_mass("point", Shape::Point, 3.0).unwrap();
    assert_eq!((point.inertia(), point.circumradius(), point.semi_axes()), (Vec3::zeros(), 0.0, [0.0; 3]));
}

#[test]
fn volume_by_counting_and_frame_by_turning() {
    for axes in
        [[3.0, 2.0, 1.0], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0], [1.0, 3.0, 2.0], [1.0, 1.0, 2.0], [1.0; 3]]
    {
        let e = Ellipsoid::new(axes).unwrap();
        let [a, b, c] = e.sorted();
        assert!(a >= b && b >= c && e.semi_axes() == axes);
        close(e.volume(), 4.0 / 3.0 * PI * axes.iter().product::<f64>(), 4e-16);
        // The canonical frame is a rotation that carries the squares of the axes into their order.
        let turn = e.canonical();
        assert_eq!(turn.determinant(), 1.0);
        assert_eq!(turn * turn.transpose(), STRAIGHT);
        let spread = Mat3::from_diagonal(&Vec3::from(axes.map(|v| v * v)));
        assert_eq!(turn * spread * turn.transpose(), Mat3::from_diagonal(&Vec3::new(a * a, b * b, c * c)));
        let [p, q] = e.focal_axes();
        assert_eq!([p * p, q * q].map(|v| v.round()), [a * a - c * c, b * b - c * c]);
    }
    // Nearly equal axes keep their digits: (1 - c)(1 + c) with c = 1 - 2^-40.
    let [p, _] = Ellipsoid::new([1.0, 1.0, 1.0 - 2f64.powi(-40)]).unwrap().focal_axes();
    close(p * p, 2f64.powi(-39) - 2f64.powi(-80), 4e-16);
}

#[test]
fn nothing_unphysical_is_a_body() {
    for (value, printed) in [(0.0, "0"), (-1.5, "-1.5"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        for (axis, label) in ["a", "b", "c"].into_iter().enumerate() {
            let mut axes = [1.0; 3];
            axes[axis] = value;
            let expected = format!("semi-axis {label} is {printed}; expected a finite number above zero");
            assert_eq!(refusal(Shape::ellipsoid(axes)), expected);
        }
        let message = |what: &str| format!("{what} is {printed}; expected a finite number above zero");
        assert_eq!(refusal(Shape::sphere(value)), message("radius"));
        assert_eq!(refusal(Body::with_mass("Beta", Shape::Point, value)), message("mass of Beta"));
        assert_eq!(
            refusal(Body::with_density("Beta", ellipsoid([1.0; 3]), value)),
            message("density of Beta")
        );
    }
    let message = refusal(Body::with_density("Beta", Shape::Point, 2.5));
    assert_eq!(message, "density of Beta is 2.5; expected a mass: its shape has no volume");
}

#[test]
fn a_density_that_overflows_is_refused() {
    let message = refusal(Body::with_density("Beta", ellipsoid([1e120; 3]), 1.0));
    assert!(message.contains("mass of Beta is inf"), "{message}");
}

#[test]
fn contact_of_two_spheres_is_the_square_of_their_distance_over_the_radii() {
    for (r1, r2) in [(1.0, 1.0), (3.0, 0.2), (0.05, 2.0), (1.0, 1e-4)] {
        for d in [0.3, 1.0, 1.7, 40.0, 1e6] {
            let separation = Vec3::new(0.48, -0.6, 0.64) * d;
            let spheres = [r1, r2].map(|r| Shape::sphere(r).unwrap());
            close(contact(&spheres[0], &spheres[1], separation), (d / (r1 + r2)).powi(2), 1e-14);
        }
    }
}

#[test]
fn contact_of_a_large_and_a_tiny_sphere() {
    // A boulder beside a dwarf planet: what matters is the gap in units of the boulder.
    for radius in [1e-3, 1e-6, 1e-9] {
        let (large, tiny) = (Shape::sphere(1.0).unwrap(), Shape::sphere(radius).unwrap());
        close(contact(&large, &tiny, Vec3::new(0.6, 0.0, 0.8) * (1.0 + radius)), 1.0, 1e-14);
        close(
            contact(&tiny, &large, Vec3::new(0.6, 0.0, 0.8) * 1.3),
            (1.3f64 / (1.0 + radius)).powi(2),
            1e-13,
        );
    }
}

#[test]
fn contact_along_an_axis() {
    let triaxial = ellipsoid([2.0, 1.2, 0.7]);
    let other = ellipsoid([0.5, 0.9, 0.3]);
    let sphere = Shape::sphere(0.4).unwrap();
    let unit = [Vec3::x(), Vec3::y(), Vec3::z()];
    for (i, unit) in unit.into_iter().enumerate() {
        let (a, b) = (triaxial.semi_axes()[i], other.semi_axes()[i]);
        for d in [0.1, 1.0, 2.0, 7.0] {
            // By symmetry the grown bodies touch on the axis.
            close(contact(&triaxial, &other, unit * d), (d / (a + b)).powi(2), 1e-14);
        }
        // A sphere beside an end whose curvature is gentler than its own, or anywhere on an axis at distance.
        close(contact(&triaxial, &sphere, unit * (a + 0.4)), 1.0, 1e-14);
        close(contact(&triaxial, &Shape::Point, unit * 3.0), (3.0 / a).powi(2), 8e-16);
        close(contact(&Shape::Point, &triaxial, unit * -3.0), (3.0 / a).powi(2), 8e-16);
    }
    let x = Vec3::new(1.0, -0.5, 2.0);
    close(
        contact(&triaxial, &Shape::Point, x),
        (0.5f64).powi(2) + (0.5f64 / 1.2).powi(2) + (2f64 / 0.7).powi(2),
        1e-15,
    );
    assert_eq!(contact(&Shape::Point, &Shape::Point, x), f64::INFINITY);
}

fn overlap(first: &Shape, second: &Shape, separation: &Vec3, ra: &Mat3, rb: &Mat3) -> bool {
    growth(first, second, separation, ra, rb).overlap("Alpha", "Beta").unwrap()
}

#[test]
fn touching_is_not_overlap() {
    let (disc, needle) = (ellipsoid([1.0, 1.0, 0.02]), ellipsoid([1.0, 0.02, 0.02]));
    let sphere = Shape::sphere(0.3).unwrap();
    for (first, second, touching) in [
        (&disc, &disc, Vec3::new(0.0, 0.0, 0.04)),
        (&disc, &disc, Vec3::new(1.2, 1.6, 0.0)),
        (&disc, &needle, Vec3::new(2.0, 0.0, 0.0)),
        (&needle, &needle, Vec3::new(0.0, 0.04, 0.0)),
        (&sphere, &disc, Vec3::new(0.0, 0.0, -0.32)),
        (&sphere, &Shape::Point, Vec3::new(0.0, 0.3, 0.0)),
        (&Shape::Point, &disc, Vec3::new(1.0, 0.0, 0.0)),
    ] {
        let at = |factor: f64| overlap(first, second, &(touching * factor), &STRAIGHT, &STRAIGHT);
        assert!(!at(1.0), "{first:?} touches {second:?}");
        assert!(!at(1.0 + 1e-12), "{first:?} is outside {second:?}");
        assert!(at(1.0 - 1e-11), "{first:?} is inside {second:?}");
        assert!(at(0.3) && at(0.0) && !at(1e6));
    }
    assert!(!overlap(&Shape::Point, &Shape::Point, &Vec3::x(), &STRAIGHT, &STRAIGHT));
}

/// Points of the surface of an ellipsoid about `centre`, over a grid of directions.
fn surface(shape: &Shape, centre: &Vec3, turn: &Mat3) -> Vec<Vec3> {
    let axes = Vec3::from(shape.semi_axes());
    let mut points = Vec::new();
    for i in 0..60 {
        let z: f64 = (f64::from(i) + 0.5) / 30.0 - 1.0;
        for k in 0..90 {
            let (sin, cos) = (f64::from(k) * PI / 45.0).sin_cos();
            let s = (1.0 - z * z).sqrt();
            points.push(centre + turn * axes.component_mul(&Vec3::new(s * cos, s * sin, z)));
        }
    }
    points
}

/// Smallest x^T A^-1 x of one body over the surface of another.
fn smallest_gauge(shape: &Shape, turn: &Mat3, points: &[Vec3]) -> f64 {
    let axes = Vec3::from(shape.semi_axes());
    points.iter().map(|x| (turn.transpose() * x).component_div(&axes).norm_squared()).fold(f64::MAX, f64::min)
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn overlap_agrees_with_sampled_surfaces(
        a in semi_axes(0.2), b in semi_axes(0.2), ra in turn(), rb in turn(), u in direction(),
        d in 0.3..2.0f64,
    ) {
        let (first, second, separation) = (ellipsoid(a), ellipsoid(b), u * d);
        let f = contact_function(&first, &second, &separation, &ra, &rb);
        // A sampled point of the second inside the first proves overlap.
        let points = surface(&second, &separation, &rb);
        let gauge = smallest_gauge(&first, &ra, &points);
        let inside =
            smallest_gauge(&second, &rb, &[-separation]).min(smallest_gauge(&first, &ra, &[separation]));
        if gauge < 1.0 || inside < 1.0 {
            prop_assert!(
                f < 1.0 && overlap(&first, &second, &separation, &ra, &rb),
                "F = {f}, gauge {gauge}"
            );
        } else if gauge > 1.1 {
            // The grid's spacing is worth less than that.
            prop_assert!(
                f > 1.0 && !overlap(&first, &second, &separation, &ra, &rb),
                "F = {f}, gauge {gauge}"
            );
        }
    }

    #[test]
    fn grown_by_the_root_of_the_function_the_bodies_touch(
        a in semi_axes(0.2), b in semi_axes(0.2), ra in turn(), rb in turn(), u in direction(),
    ) {
        let (first, second, separation) = (ellipsoid(a), ellipsoid(b), u * 3.0);
        let growth = contact_function(&first, &second, &separation, &ra, &rb).sqrt();
        let [first, second] = [a, b].map(|axes| ellipsoid(axes.map(|v| v * growth)));
        close(contact_function(&first, &second, &separation, &ra, &rb), 1.0, 1e-14);
        let gauge = smallest_gauge(&first, &ra, &surface(&second, &separation, &rb));
        prop_assert!((1.0 - 1e-12..1.1).contains(&gauge), "gauge {gauge}");
    }

    #[test]
    fn contact_knows_neither_frame_nor_order(
        a in semi_axes(0.05), b in semi_axes(0.05), ra in turn(), rb in turn(), frame in turn(),
        u in direction(), d in 0.1..5.0f64, scale in -8..8i32,
    ) {
        let (first, second, separation) = (ellipsoid(a), ellipsoid(b), u * d);
        let f = contact_function(&first, &second, &separation, &ra, &rb);
        let turned = contact_function(&first, &second, &(frame * separation), &(frame * ra), &(frame * rb));
        close(turned, f, 2e-14);
        close(contact_function(&second, &first, &-separation, &rb, &ra), f, 2e-14);
        let scale = 10f64.powi(scale);
        let [first, second] = [a, b].map(|axes| ellipsoid(axes.map(|v| v * scale)));
        close(contact_function(&first, &second, &(separation * scale), &ra, &rb), f, 2e-14);
    }
}

/// The second moments of an ellipsoid, turned about every axis, give coefficients of degree two in closed form (Kaula
/// 1966, Theory of Satellite Geodesy, section 1.2), from which its radius and its moments of inertia come back.
#[test]
fn stokes_coefficients_of_an_ellipsoid_have_its_moments_of_inertia() {
    let squares = Vec3::new(1.0, 0.64, 0.36) / 5.0;
    let turn = rotation::tait_bryan_matrix([0.4, -0.7, 1.1]);
    let second = turn * Mat3::from_diagonal(&squares) * turn.transpose();
    let reference_radius: f64 = 1.3;
    let at = |i: usize, j: usize| second[(i, j)] / reference_radius.powi(2);
    let root = |square: f64| f64::sqrt(square);
    // In the order S22, S21, C20, C21, C22, each divided by its factor of the normalisation to 4 pi.
    let degree_two = [
        0.5 * at(0, 1) / root(5.0 / 12.0),
        at(1, 2) / root(5.0 / 3.0),
        (at(2, 2) - 0.5 * (at(0, 0) + at(1, 1))) / root(5.0),
        at(0, 2) / root(5.0 / 3.0),
        0.25 * (at(0, 0) - at(1, 1)) / root(5.0 / 12.0),
    ];
    let coefficients = [vec![1.0, 0.0, 0.0, 0.0], degree_two.to_vec()].concat();
    let mean_inertia = 2.0 / 3.0 * squares.sum();
    let input = InputCoefficients { coefficients, reference_radius, mean_inertia, radius: 1.1 };
    let stokes = StokesCoefficients::new(input).unwrap();
    assert_eq!((stokes.radius(), stokes.degree()), (1.1, 2));
    let mut found = stokes.inertia_per_mass();
    found.as_mut_slice().sort_by(f64::total_cmp);
    let [x, y, z] = squares.into();
    assert!((found - Vec3::new(y + z, x + z, x + y)).norm() < 1e-15, "{found}");
}
