//! The exterior potential and field against the paper's formulas, arbitrary precision and the laws of a
//! potential.

use crate::support::*;
use ellip::{ellipeinc, ellipf};
use fullbody::gravity::{FarSeries, FieldKernel, Near, kappa};
use fullbody::math::Vec3;
use fullbody::math::lanes::{BLOCK, Lanes, Total, VectorPath};
use fullbody::shape::{Body, Ellipsoid, Shape};
use proptest::prelude::*;
use pulp::{Scalar, Simd, WithSimd};

fn field_of(axes: [f64; 3]) -> FieldOf {
    FieldOf::new(&Body::with_mass("body", Shape::ellipsoid(axes).unwrap(), 1.0).unwrap(), 1.0)
}

fn outer_root(x: &Vec3, axes: [f64; 3]) -> f64 {
    let square = |v: f64| -> Lanes<Scalar> { Lanes::splat(Scalar, v * v) };
    kappa([square(x.x), square(x.y), square(x.z)], axes.map(|a| a * a)).first()
}

/// The paper's `eq:Potential_elliptic` and its appendix for GM = 1, that is 4/3 pi rho abc = 1; a > b > c.
fn paper_ellipsoid([a, b, c]: [f64; 3], x: &Vec3) -> (f64, Vec3) {
    let (ab, bc, ac) = (a * a - b * b, b * b - c * c, a * a - c * c);
    let kappa = bisected_kappa([a, b, c], x);
    let (amplitude, parameter) = ((ac / (a * a + kappa)).sqrt().asin(), ab / ac);
    let (f, e) = (ellipf(amplitude, parameter).unwrap(), ellipeinc(amplitude, parameter).unwrap());
    let root = ac.sqrt() / ((a * a + kappa) * (b * b + kappa) * (c * c + kappa)).sqrt();
    let (xx, yy, zz) = (x.x * x.x, x.y * x.y, x.z * x.z);
    let potential = 1.5 / ac.sqrt()
        * ((1.0 - xx / ab + yy / ab) * f
            + (xx / ab - ac * yy / (ab * bc) + zz / bc) * e
            + ((c * c + kappa) / bc * yy - (b * b + kappa) / bc * zz) * root);
    let field = 3.0 / ac.sqrt()
        * Vec3::new(
            x.x * (e - f) / ab,
            x.y * (f / ab - ac * e / (ab * bc) + (c * c + kappa) / bc * root),
            x.z * (e / bc - (b * b + kappa) / bc * root),
        );
    (potential, field)
}

/// The paper's `eq:Oblate_spheroid` and its appendix for GM = 1; a = b > c.
pub fn paper_oblate([a, c]: [f64; 2], x: &Vec3) -> (f64, Vec3) {
    let ac = a * a - c * c;
    let kappa = bisected_kappa([a, a, c], x);
    let angle = (ac / (a * a + kappa)).sqrt().asin();
    let (rho2, zz) = (x.x * x.x + x.y * x.y, x.z * x.z);
    let root = (c * c + kappa).sqrt();
    let potential = 1.5 / ac.sqrt() * (1.0 - (rho2 - 2.0 * zz) / (2.0 * ac)) * angle
        + 0.75 * root / ac * rho2 / (a * a + kappa)
        - 0.75 / ac * 2.0 * zz / root;
    let across = 1.5 / ac * (root / (a * a + kappa) - angle / ac.sqrt());
    let along = 3.0 / ac * (angle / ac.sqrt() - 1.0 / root);
    (potential, Vec3::new(x.x * across, x.y * across, x.z * along))
}

/// `eq:kappa_eq` by halving intervals.
fn bisected_kappa(axes: [f64; 3], x: &Vec3) -> f64 {
    let s = |k: f64| (0..3).map(|i| x[i] * x[i] / (axes[i] * axes[i] + k)).sum::<f64>();
    let (mut low, mut high) = (0.0, x.norm_squared());
    while {
        let middle = 0.5 * (low + high);
        if s(middle) > 1.0 {
            low = middle
        } else {
            high = middle
        }
        middle != 0.5 * (low + high)
    } {}
    low
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn the_papers_ellipsoid(
        b in 0.5..0.85f64, flat in 0.3..0.8f64, u in direction(), distance in 0.0..2.0f64,
    ) {
        let axes = [1.0, b, b * flat];
        // From the surface outwards; farther away F - E loses digits, not the code.
        let x = u.component_mul(&Vec3::from(axes)) * (1.0 + 1e-12 + distance);
        let (potential, field) = paper_ellipsoid(axes, &x);
        let body = field_of(axes);
        close(body.potential(&x).unwrap(), potential, 5e-14);
        close_vector(&body.field(&x).unwrap(), &field, 1e-13);
    }

    #[test]
    fn the_papers_oblate_spheroid(c in 0.1..0.8f64, u in direction(), distance in 0.0..2.0f64) {
        let axes = [1.0, 1.0, c];
        let x = u.component_mul(&Vec3::from(axes)) * (1.0 + 1e-12 + distance);
        let (potential, field) = paper_oblate([1.0, c], &x);
        let body = field_of(axes);
        close(body.potential(&x).unwrap(), potential, 5e-14);
        close_vector(&body.field(&x).unwrap(), &field, 1e-13);
    }

    #[test]
    fn the_field_is_the_gradient_and_has_no_source(
        axes in semi_axes(0.1), u in direction(), d in 0.2..4.0f64,
    ) {
        let x = u.component_mul(&Vec3::from(axes)) * (1.0 + d);
        let body = field_of(axes);
        // Central differences to eighth order, a step well within the clearance.
        let h = 0.02 * d * axes.iter().copied().fold(1.0, f64::min);
        let weights = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];
        let slope = |f: &dyn Fn(f64) -> f64| {
            (1..=4)
                .zip(weights)
                .map(|(k, w)| w * (f(f64::from(k) * h) - f(-f64::from(k) * h)) / h)
                .sum::<f64>()
        };
        let unit = [Vec3::x(), Vec3::y(), Vec3::z()];
        let gradient = Vec3::from(unit.map(|e| slope(&|s| body.potential(&(x + s * e)).unwrap())));
        let field = body.field(&x).unwrap();
        let round_off = 1e-15 * body.potential(&x).unwrap() / h;
        within((gradient - field).norm() / field.norm(), 3e-12 + 5.0 * round_off / field.norm(), "gradient");
        let jacobian =
            unit.map(|e| Vec3::from([0, 1, 2].map(|i| slope(&|s| body.field(&(x + s * e)).unwrap()[i]))));
        let size = jacobian[0].norm() + jacobian[1].norm() + jacobian[2].norm();
        within(
            (jacobian[0].x + jacobian[1].y + jacobian[2].z).abs() / size,
            1e-11 + 1e-15 * field.norm() / h / size,
            "divergence",
        );
        within((jacobian[0].y - jacobian[1].x).abs() / size, 1e-11 + 1e-15 * field.norm() / h / size, "curl");
    }

    #[test]
    fn axes_in_any_order_give_the_turned_field(axes in semi_axes(0.02), u in direction(), d in 0.0..30.0f64) {
        let x = u.component_mul(&Vec3::from(axes)) * (1.0 + 1e-12 + d);
        let (potential, field) = (field_of(axes).potential(&x).unwrap(), field_of(axes).field(&x).unwrap());
        for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let permuted = |v: &Vec3| Vec3::from(order.map(|i| v[i]));
            let body = field_of(order.map(|i| axes[i]));
            // Sums in another order: the canonical frame differs by a turned-round axis at most.
            close(body.potential(&permuted(&x)).unwrap(), potential, 1e-15);
            close_vector(&body.field(&permuted(&x)).unwrap(), &permuted(&field), 1e-15);
        }
    }

    #[test]
    fn the_unit_of_length_does_not_matter(
        axes in semi_axes(0.1), u in direction(), power in -6.0..4.0f64, scale in -20..20i32,
    ) {
        // Metres, kilometres or astronomical units; a power of two keeps every digit.
        let scale = 2f64.powi(4 * scale);
        let x = u.component_mul(&Vec3::from(axes)) * (1.0 + 10f64.powf(power));
        let (body, scaled) = (field_of(axes), field_of(axes.map(|a| a * scale)));
        close(scaled.potential(&(x * scale)).unwrap() * scale, body.potential(&x).unwrap(), 1e-15);
        let field = scaled.field(&(x * scale)).unwrap() * scale * scale;
        close_vector(&field, &body.field(&x).unwrap(), 1e-15);
    }

    #[test]
    fn kappa_solves_its_equation(axes in semi_axes(0.01), u in direction(), power in -16.0..6.0f64) {
        let mut sorted = axes;
        sorted.sort_by(|a, b| b.total_cmp(a));
        let x = u.component_mul(&Vec3::from(sorted)) * (1.0 + 10f64.powf(power));
        let root = outer_root(&x, sorted);
        let terms = [0, 1, 2].map(|i| x[i] * x[i] / (sorted[i] * sorted[i] + root));
        prop_assert!(root >= 0.0);
        within((terms.iter().sum::<f64>() - 1.0).abs(), 2e-15, "residual");
    }

    #[test]
    fn far_and_near_kernels_agree(axes in semi_axes(0.02), u in direction(), d in 0.0..20.0f64) {
        let e = Ellipsoid::new(axes).unwrap();
        let [a, _, _] = e.sorted();
        // The series' nearest point for this shape, and beyond.
        let series = FarSeries::new(&Shape::Ellipsoid(e));
        let reach = (1..)
            .map(|k| a * 1.1f64.powi(k))
            .find(|r| series.truncation_for(r * r - a * a, 1e-17).is_some())
            .unwrap();
        let r = reach + d * a;
        let x = [u * r];
        let truncation = series.truncation_for(r * r - a * a, 1e-17).unwrap();
        let far = values(VectorPath::Portable, series.truncated(truncation), &x)[0];
        let near = values(VectorPath::Portable, Near::new(&e, r * r - a * a), &x)[0];
        close(1.0 / r + far.perturbation, 1.0 / r + near.perturbation, 2e-15);
        for i in 0..3 {
            close(far.rd[i], near.rd[i], 5e-15);
            // The differences are small; the near kernel gets them by subtraction.
            within((far.difference[i] - near.difference[i]).abs() * r.powi(3), 1e-14, "difference");
        }
    }
}

#[test]
fn arbitrary_precision_on_hard_shapes() {
    for case in data("exterior_field.json").as_array().unwrap() {
        let (name, axes) = (case["name"].as_str().unwrap(), triple(&case["axes"]));
        let (x, expected) = (Vec3::from(triple(&case["point"])), Vec3::from(triple(&case["field"])));
        let body = field_of(axes);
        let potential = body.potential(&x).unwrap() / number(&case["potential"]) - 1.0;
        within(potential.abs(), 2e-15, format!("potential of {name}"));
        // At a needle's tip or a disc's rim the last digit of x is worth a part in 1e12 of c^2 + kappa.
        let sharp = sorted(axes)[2] < 0.1;
        let tolerance = if sharp { 1e-14 } else { 2e-15 };
        within(relative(&body.field(&x).unwrap(), &expected), tolerance, format!("field of {name}"));
        // kappa by its own condition: the confocal coordinate of a point known to round-off.
        let size = x.norm_squared();
        let root = outer_root(&Ellipsoid::new(axes).map(|e| e.canonical() * x).unwrap(), sorted(axes));
        within((root - number(&case["kappa"])).abs() / size, 2e-15, format!("kappa of {name}"));
    }
}

fn sorted(mut axes: [f64; 3]) -> [f64; 3] {
    axes.sort_by(|a, b| b.total_cmp(a));
    axes
}

/// The values of a kernel at one point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Values {
    perturbation: f64,
    rd: [f64; 3],
    difference: [f64; 3],
}

struct Evaluate<'a, K> {
    kernel: K,
    points: &'a [Vec<f64>; 3],
}

impl<K: FieldKernel> WithSimd for Evaluate<'_, K> {
    type Output = Vec<Values>;

    fn with_simd<S: Simd>(self, simd: S) -> Vec<Values> {
        let [x, y, z] = self.points;
        let blocks = |values| Lanes::<S, 2>::blocks(simd, values);
        let points = blocks(x).zip(blocks(y)).zip(blocks(z));
        let length = size_of::<[S::f64s; 2]>() / size_of::<f64>();
        let mut out = vec![[0.0; 7]; x.len()];
        for (k, ((x, y), z)) in points.enumerate() {
            let (field, (perturbation, other)) =
                (self.kernel.field([x, y, z]), self.kernel.potential_perturbation([x, y, z]));
            let all = [perturbation].into_iter().chain(field.rd).chain(field.rd_difference);
            for (column, value) in all.enumerate() {
                for lane in 0..length {
                    // The sum over a block that is one in this lane and zero elsewhere.
                    let mut one = [0.0; BLOCK];
                    one[lane] = 1.0;
                    let mut total = Total::zero(simd);
                    Lanes::blocks(simd, &one).take(1).for_each(|one| total.add_product(value, one));
                    out[k * length + lane][column] = total.value();
                }
            }
            // Both calls have the same R_i, up to the order of rounding.
            for (one, other) in other.rd.into_iter().zip(field.rd) {
                assert!((one - other).abs().reduce_max() <= 4e-15 * one.reduce_max());
            }
        }
        out.into_iter()
            .map(|[perturbation, r1, r2, r3, d1, d2, d3]| Values {
                perturbation,
                rd: [r1, r2, r3],
                difference: [d1, d2, d3],
            })
            .collect()
    }
}

fn values(path: VectorPath, kernel: impl FieldKernel, x: &[Vec3]) -> Vec<Values> {
    let mut points = [0, 1, 2].map(|i| x.iter().map(|x| x[i]).collect::<Vec<_>>());
    // Whole vectors: the first point fills the rest.
    points.iter_mut().for_each(|p| p.resize(x.len().next_multiple_of(BLOCK), p[0]));
    let mut out = path.arch().unwrap().dispatch(Evaluate { kernel, points: &points });
    out.truncate(x.len());
    out
}

#[test]
fn every_path_gives_the_same_numbers() {
    let e = Ellipsoid::new([1.0, 0.6, 0.25]).unwrap();
    let series = FarSeries::new(&Shape::Ellipsoid(e));
    // Points that need different numbers of Newton steps share a vector.
    let spiral = |k: i32, r: f64| {
        let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
        let z = f64::from(k) / 50.0 - 0.99;
        Vec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z) * r
    };
    let near: Vec<_> = (0..100).map(|k| spiral(k, 1.001 + f64::from((k * k) % 17))).collect();
    let far: Vec<_> = near.iter().map(|x| x * 3.0).collect();
    let truncation = series.truncation_for(8.0, 1e-17).unwrap();
    let (near_kernel, far_kernel) = (Near::new(&e, 0.0), series.truncated(truncation));
    let portable =
        [values(VectorPath::Portable, near_kernel, &near), values(VectorPath::Portable, far_kernel, &far)];
    for path in VectorPath::available() {
        let now = [values(path, near_kernel, &near), values(path, far_kernel, &far)];
        for (kind, (now, portable)) in now.iter().zip(&portable).enumerate() {
            for ((now, portable), x) in now.iter().zip(portable).zip([&near, &far][kind]) {
                if path == VectorPath::Portable {
                    assert_eq!(now, portable);
                }
                let r = x.norm();
                within(
                    (now.perturbation - portable.perturbation).abs() * r,
                    1e-15,
                    format!("{path:?} potential"),
                );
                for i in 0..3 {
                    close(now.rd[i], portable.rd[i], 4e-15);
                    let error = (now.difference[i] - portable.difference[i]).abs() / portable.rd[i];
                    within(error, 6e-15, format!("{path:?} difference"));
                }
            }
        }
    }
    // A vector of points and one point alone have the same bits on the portable path.
    let alone = values(VectorPath::Portable, near_kernel, &near[7..8])[0];
    assert_eq!(alone, portable[0][7]);
}

#[test]
fn a_sphere_and_a_point_are_monopoles() {
    let x = Vec3::new(1.2, -0.5, 3.4);
    let r = x.norm();
    for shape in [Shape::sphere(1.0).unwrap(), Shape::sphere(3.0).unwrap(), Shape::Point] {
        let body = FieldOf::new(&Body::with_mass("ball", shape, 4.0).unwrap(), 0.5);
        close(body.potential(&x).unwrap(), 2.0 / r, 4e-16);
        close_vector(&body.field(&x).unwrap(), &(-2.0 * x / (r * r * r)), 1e-15);
    }
}

#[test]
fn far_away_the_oblateness_is_all_that_is_left() {
    // Phi = GM/r (1 - J2 (a/r)^2 P2(sin latitude)), J2 = (1 - c^2/a^2)/5, and the next term J4 is below
    // (a/r)^4 / 10.
    let (a, c) = (2.0, 1.2);
    let body = field_of([a, a, c]);
    let j2 = (1.0 - c * c / (a * a)) / 5.0;
    for r in [20.0, 200.0, 2000.0, 2e6] {
        for latitude in [-1.4, -0.3, 0.0, 0.6, 1.1, 1.57f64] {
            let x = r * Vec3::new(latitude.cos() * 0.6, latitude.cos() * 0.8, latitude.sin());
            let p2 = 1.5 * latitude.sin().powi(2) - 0.5;
            let ratio = (a / r) * (a / r);
            let rest = 0.1 * ratio * ratio + 8e-16;
            within((body.potential(&x).unwrap() * r - (1.0 - j2 * ratio * p2)).abs(), rest, "J2");
            // g = -GM/r^3 [ x (1 - 3/2 J2 (a/r)^2 (5 sin^2 - 1)) + z 3 J2 (a/r)^2 ].
            let inner = 1.0 - 1.5 * j2 * ratio * (5.0 * latitude.sin().powi(2) - 1.0);
            let expected = -(x * inner + Vec3::z() * (x.z * 3.0 * j2 * ratio)) / r.powi(3);
            within(relative(&body.field(&x).unwrap(), &expected), 5.0 * rest, "field");
        }
    }
}

#[test]
fn no_outer_point_is_nan() {
    for axes in
        [[1.0; 3], [1.0, 1.0, 0.02], [1.0, 0.02, 0.02], [1.0, 0.4, 1e-6], [1e-9, 2e-9, 1e-9], [1e9, 7e8, 7e8]]
    {
        let body = field_of(axes);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            for factor in [1.0, 1.0 + 1e-15, 1.0 + 1e-7, 1e3, 1e12, 1e60] {
                let (mut on_axis, mut in_plane) = (Vec3::zeros(), Vec3::zeros());
                on_axis[i] = -axes[i] * factor;
                (in_plane[i], in_plane[j]) = (0.6 * axes[i] * factor, 0.8 * axes[j] * factor);
                for x in [on_axis, in_plane] {
                    let (potential, field) = (body.potential(&x).unwrap(), body.field(&x).unwrap());
                    assert!(potential > 0.0 && potential.is_finite(), "{axes:?} {x:?} {potential}");
                    assert!(
                        field.iter().all(|v| v.is_finite()) && field.dot(&x) < 0.0,
                        "{axes:?} {x:?} {field:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_point_beyond_the_square_of_the_largest_double_is_no_nan() {
    for axes in [[1.0; 3], [1.0, 0.7, 0.5]] {
        let body = field_of(axes);
        close(body.potential(&Vec3::new(3e200, 0.0, 4e200)).unwrap(), 2e-201, 1e-15);
        close(body.field(&Vec3::new(0.0, 1e160, 0.0)).unwrap().y, -1e-320, 1e-3);
    }
}

#[test]
fn points_that_have_no_field_are_refused() {
    let alpha = Body::with_mass("Alpha", Shape::ellipsoid([0.5, 2.0, 1.0]).unwrap(), 1.0).unwrap();
    for value in [f64::NAN, f64::INFINITY] {
        let message = refusal(FieldOf::new(&alpha, 1.0).potential(&Vec3::new(3.0, value, 0.0)));
        assert_eq!(message, format!("point, component 1, is {value}; expected a finite number"));
    }
    let point = FieldOf::new(&Body::with_mass("dust", Shape::Point, 1.0).unwrap(), 1.0);
    assert!(refusal(point.field(&Vec3::zeros())).contains("away from the point mass of dust"));
    assert!(refusal(point.gradient(&Vec3::zeros())).contains("away from the point mass of dust"));
    let heavy = FieldOf::new(&Body::with_mass("heavy", Shape::Point, 1e300).unwrap(), 1.0);
    assert!(refusal(heavy.field(&Vec3::new(1e-9, 0.0, 0.0))).contains("choose units"));
}

#[test]
fn density_and_constant_scale_the_field() {
    // The paper writes rho, and G = 1.
    let (axes, density, g) = ([1.0, 0.8, 0.5], 2.5, 6.6743e-11);
    let body = Body::with_density("rock", Shape::ellipsoid(axes).unwrap(), density).unwrap();
    let x = Vec3::new(0.9, -1.1, 0.7);
    let gm = g * density * 4.0 / 3.0 * std::f64::consts::PI * (1.0 * 0.8 * 0.5);
    let (potential, field) = paper_ellipsoid(axes, &x);
    let actual = FieldOf::new(&body, g);
    close(actual.potential(&x).unwrap(), gm * potential, 1e-14);
    close_vector(&actual.field(&x).unwrap(), &(gm * field), 1e-13);
}
