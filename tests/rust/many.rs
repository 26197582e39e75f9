//! The gravity of bodies at many points: outside and inside, with its gradient, in blocks.

use crate::support::*;
use fullbody::gravity::{Attractor, BodyField, Ellipsoidal, GravityOutput, Points};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::{BLOCK, Lanes, VectorPath, load_vector};
use fullbody::math::{Mat3, Vec3};
use fullbody::shape::{Body, InputPart, Shape};
use proptest::prelude::*;
use pulp::{Simd, WithSimd};
use std::f64::consts::PI;

fn of(axes: [f64; 3]) -> Body {
    Body::with_mass("body", Shape::ellipsoid(axes).unwrap(), 1.0).unwrap()
}

/// A composite of a ball, an ellipsoid, a void and a point.
fn club() -> Body {
    let part = |shape, mass, position, attitude| InputPart { shape, mass, position, attitude };
    let ellipsoid = Shape::ellipsoid([0.4, 0.9, 0.3]).unwrap();
    let given = vec![
        part(Shape::sphere(1.0).unwrap(), 4.0, [0.0; 3], [1.0, 0.0, 0.0, 0.0]),
        part(ellipsoid, 1.5, [1.1, 0.3, -0.2], [0.9, 0.1, -0.4, 0.2]),
        part(Shape::sphere(0.2).unwrap(), -0.1, [-0.4, 0.1, 0.0], [1.0, 0.0, 0.0, 0.0]),
        part(Shape::Point, 0.3, [0.2, 0.4, 1.4], [1.0, 0.0, 0.0, 0.0]),
    ];
    Body::composite("club", given).unwrap()
}

/// Potential, field and gradient at points with respect to a path.
fn gravity(bodies: &[(&Body, Vec3, Mat3)], points: &[Vec3], path: VectorPath) -> [Vec<f64>; 3] {
    let (arch, interrupt) = (path.arch().unwrap(), &mut InterruptCheck::never());
    let fields: Vec<_> =
        bodies.iter().map(|(body, ..)| BodyField::new(body, 1.0, arch, interrupt).unwrap()).collect();
    let attractors: Vec<_> = fields
        .iter()
        .zip(bodies)
        .map(|(field, &(_, position, rotation))| Attractor { field, position, rotation })
        .collect();
    let coordinates: Vec<f64> = points.iter().flat_map(|x| [x.x, x.y, x.z]).collect();
    let points = Points { coordinates: &coordinates, shape: &[points.len()], first_index: 0 };
    let count = coordinates.len() / 3;
    let mut out = [vec![0.0; count], vec![0.0; 3 * count], vec![0.0; 9 * count]];
    let [potential, field, gradient] = &mut out;
    points.gravity(&attractors, GravityOutput::Field(potential, field), arch, interrupt).unwrap();
    points.gravity(&attractors, GravityOutput::Gradient(gradient), arch, interrupt).unwrap();
    out
}

#[test]
fn differences_in_44_digits() {
    for case in data("derivatives.json")["fields"].as_array().unwrap() {
        let (x, field) = (Vec3::from(triple(&case["point"])), FieldOf::new(&of(triple(&case["axes"])), 1.0));
        close(field.potential(&x).unwrap(), number(&case["potential"]), 4e-15);
        close_vector(&field.field(&x).unwrap(), &Vec3::from(triple(&case["field"])), 4e-15);
        let expected = Mat3::from_fn(|i, j| number(&case["gradient"][i][j]));
        let error = (field.gradient(&x).unwrap() - expected).norm() / expected.norm();
        within(error, 4e-15, format!("gradient of {}", case["name"]));
    }
}

/// Maclaurin's closed form inside an oblate spheroid: Phi = pi G rho (I - sum A_i x_i^2), as in
/// Chandrasekhar's "Ellipsoidal figures of equilibrium", chapter 3.
fn maclaurin(a: f64, c: f64, x: &Vec3) -> (f64, Vec3, Mat3) {
    let e = (1.0 - c * c / (a * a)).sqrt();
    let (root, arc) = ((1.0 - e * e).sqrt(), e.asin());
    let across = root / e.powi(3) * (arc - e * root);
    let along = 2.0 / (e * e) - 2.0 * root / e.powi(3) * arc;
    let rho = 3.0 / (4.0 * PI * a * a * c);
    let factors = Vec3::new(across, across, along);
    let potential = PI * rho * (2.0 * a * a * root * arc / e - factors.dot(&x.component_mul(x)));
    (potential, -2.0 * PI * rho * factors.component_mul(x), Mat3::from_diagonal(&(-2.0 * PI * rho * factors)))
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn maclaurins_spheroid_inside(c in 0.1..0.9f64, u in direction(), depth in 0.0..1.0f64) {
        let x = u.component_mul(&Vec3::new(2.0, 2.0, 2.0 * c)) * depth;
        let body = FieldOf::new(&of([2.0, 2.0, 2.0 * c]), 1.0);
        let (potential, field, gradient) = maclaurin(2.0, 2.0 * c, &x);
        close(body.potential(&x).unwrap(), potential, 1e-13);
        within((body.field(&x).unwrap() - field).norm(), 1e-12 * field.amax().max(0.01), "field");
        within((body.gradient(&x).unwrap() - gradient).norm(), 1e-12 * gradient.norm(), "gradient");
    }

    #[test]
    fn axes_in_any_order_give_the_turned_gradient(
        axes in semi_axes(0.1), u in direction(), d in -0.9..3.0f64,
    ) {
        let x = u.component_mul(&Vec3::from(axes)) * (1.0 + d);
        let gradient = FieldOf::new(&of(axes), 1.0).gradient(&x).unwrap();
        for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let body = FieldOf::new(&of(order.map(|i| axes[i])), 1.0);
            let found = body.gradient(&Vec3::from(order.map(|i| x[i]))).unwrap();
            let expected = Mat3::from_fn(|i, j| gradient[(order[i], order[j])]);
            within((found - expected).norm(), 2e-15 * gradient.norm(), "gradient");
        }
    }
}

/// Balls, a void and a point by the formulas of the sphere, in the frame of the points.
fn balls() -> (Body, Vec<(f64, f64, Vec3)>) {
    let rows = [
        (4.0, 1.0, [0.0; 3]),
        (1.5, 0.7, [1.1, 0.3, -0.2]),
        (-0.1, 0.2, [-0.4, 0.1, 0.0]),
        (0.3, 0.0, [0.2, 0.4, 1.4]),
    ];
    let shape = |radius: f64| if radius > 0.0 { Shape::sphere(radius).unwrap() } else { Shape::Point };
    let part = |(mass, radius, position)| InputPart {
        shape: shape(radius),
        mass,
        position,
        attitude: [0.9, 0.1, -0.4, 0.2],
    };
    let body = Body::composite("balls", rows.map(part).to_vec()).unwrap();
    let placed =
        body.parts().iter().zip(rows).map(|(part, (mass, radius, _))| (mass, radius, part.position()));
    let placed = placed.collect();
    (body, placed)
}

fn ball(mass: f64, radius: f64, d: Vec3) -> (f64, Vec3, Mat3) {
    let r = d.norm();
    if r < radius {
        let cube = mass / radius.powi(3);
        return (cube * (3.0 * radius * radius - r * r) / 2.0, -cube * d, -cube * Mat3::identity());
    }
    let gradient = (3.0 * d * d.transpose() / (r * r) - Mat3::identity()) * (mass / r.powi(3));
    (mass / r, -d * (mass / r.powi(3)), gradient)
}

/// Points all about, from the centre to a thousand radii, in no order.
fn cloud() -> Vec<Vec3> {
    let point = |k: u32| {
        let t = f64::from(k);
        let z = 1.98 * (t * 0.618_033_988_75).fract() - 0.99;
        let (sin, cos) = (2.4 * t).sin_cos();
        let s = (1.0 - z * z).sqrt();
        Vec3::new(s * cos, s * sin, z) * (10f64.powf(4.0 * (t * 0.754_877_666).fract() - 1.0))
    };
    (1..600).map(point).collect()
}

fn rows<const N: usize>(values: &[f64], k: usize) -> &[f64] {
    &values[N * k..N * (k + 1)]
}

#[test]
fn parts_and_bodies_add_up_by_every_path() {
    let (body, parts) = balls();
    let turn = rotation_about(&Vec3::new(0.6, 0.0, 0.8), 2.0);
    let place = Vec3::new(0.5, -0.2, 0.1);
    let moon = Body::with_mass("moon", Shape::sphere(0.3).unwrap(), 0.7).unwrap();
    let aside = Vec3::new(-30.0, 2.0, 4.0);
    let points = cloud();
    for path in VectorPath::available() {
        let bodies = [(&body, place, turn), (&moon, aside, Mat3::identity())];
        let [potential, field, gradient] = gravity(&bodies, &points, path);
        for (k, x) in points.iter().enumerate() {
            let of_moon = ball(0.7, 0.3, x - aside);
            let sum = parts.iter().fold(of_moon, |(phi, g, m), (mass, radius, position)| {
                let part = ball(*mass, *radius, x - place - turn * position);
                (phi + part.0, g + part.1, m + part.2)
            });
            close(potential[k], sum.0, 4e-15);
            let g = Vec3::from_column_slice(rows::<3>(&field, k));
            within((g - sum.1).norm(), 2e-14 * sum.1.norm() + 1e-15 / x.norm().powi(2), "field");
            let m = Mat3::from_row_slice(rows::<9>(&gradient, k));
            within((m - sum.2).norm(), 1e-14 * sum.2.norm() + 1e-14 / x.norm().powi(3), "gradient");
        }
    }
}

#[test]
fn a_point_has_the_same_bits_alone_and_in_a_crowd() {
    let body = club();
    let bodies = [(&body, Vec3::new(0.3, 0.1, 0.0), rotation_about(&Vec3::new(0.6, 0.0, 0.8), 1.0))];
    let points = cloud();
    for path in VectorPath::available() {
        let all = gravity(&bodies, &points, path);
        for (k, x) in points.iter().enumerate().step_by(7) {
            let alone = gravity(&bodies, &[*x], path);
            assert_eq!(alone[0], rows::<1>(&all[0], k));
            assert_eq!(alone[1], rows::<3>(&all[1], k));
            assert_eq!(alone[2], rows::<9>(&all[2], k));
        }
    }
}

struct Lanewise<'a> {
    field: &'a Ellipsoidal,
    points: &'a [Vec<f64>; 3],
}

impl WithSimd for Lanewise<'_> {
    type Output = [Vec<f64>; 10];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut out = [(); 10].map(|()| vec![0.0; self.points[0].len()]);
        for block in 0..self.points[0].len() / BLOCK * Lanes::<S>::PER_BLOCK {
            let found = self.field.at(load_vector(simd, self.points, block));
            found.potential.store(&mut out[0], block);
            (0..3).for_each(|i| found.field[i].store(&mut out[1 + i], block));
            (0..6).for_each(|k| found.gradient[k].store(&mut out[4 + k], block));
        }
        out
    }
}

#[test]
fn lanes_of_points_as_they_come_have_the_same_bits() {
    // Points inside and outside, near and far share lanes.
    let (body, points) = (of([1.0, 0.8, 0.5]), cloud());
    let mut columns = [0, 1, 2].map(|i| points.iter().map(|x| x[i]).collect::<Vec<_>>());
    columns.iter_mut().for_each(|column| column.resize(points.len().next_multiple_of(BLOCK), 7.0));
    let own = Ellipsoidal::new(&body.parts()[0].shape, 1.0);
    for path in VectorPath::available() {
        let all = gravity(&[(&body, Vec3::zeros(), Mat3::identity())], &points, path);
        let found = path.arch().unwrap().dispatch(Lanewise { field: &own, points: &columns });
        for k in 0..points.len() {
            assert_eq!(found[0][k], all[0][k]);
            (0..3).for_each(|i| assert_eq!(found[1 + i][k], all[1][3 * k + i]));
            for (column, place) in [0, 1, 2, 4, 5, 8].into_iter().enumerate() {
                assert_eq!(found[4 + column][k], all[2][9 * k + place]);
            }
        }
    }
}
