//! Polyhedra against closed forms, exact integrals and independent formulas.

use crate::support::{parallel_gap, refusal};
use fullbody::dynamics::{Settings, State, System};
use fullbody::error::Error;
use fullbody::gravity::{Facets, Layer, LayerAttraction, PolyhedronGravity};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::harmonics::{count, index};
use fullbody::math::lanes::{Lanes, VectorPath};
use fullbody::math::logarithm::{angle, ln_one_plus};
use fullbody::math::{Vec3, triangle};
use fullbody::shape::{Body, Polyhedron, Shape};
use pulp::{Arch, Scalar};

/// A box of these sides from a corner.
pub fn cuboid(low: [f64; 3], sides: [f64; 3]) -> Polyhedron {
    let corner = |k: usize| Vec3::from_fn(|i, _| low[i] + if k >> i & 1 == 1 { sides[i] } else { 0.0 });
    let vertices: Vec<Vec3> = (0..8).map(corner).collect();
    Polyhedron::new(&vertices, &CUBE, &mut InterruptCheck::never()).unwrap()
}

const CUBE: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

fn arches() -> Vec<Arch> {
    VectorPath::available().into_iter().filter_map(VectorPath::arch).collect()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found:e} is not {expected:e} to {tolerance:e}");
}

/// The potential of a box of unit density (MacMillan 1930, section 42) at the origin of its coordinates.
fn box_potential(low: Vec3, high: Vec3) -> f64 {
    let mut sum = 0.0;
    for k in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|i| if k >> i & 1 == 1 { high[i] } else { low[i] });
        let sign = if (k as u32).count_ones() % 2 == 1 { 1.0 } else { -1.0 };
        let r = (x * x + y * y + z * z).sqrt();
        let log = |a: f64, b: f64, c: f64| a * b * (c + r).ln();
        let arc = |a: f64, b: f64, c: f64| 0.5 * a * a * (b * c / (a * r)).atan();
        sum +=
            sign * (log(x, y, z) + log(y, z, x) + log(z, x, y) - arc(x, y, z) - arc(y, z, x) - arc(z, x, y));
    }
    sum
}

#[test]
fn cuboids_have_macmillans_potential() {
    let sides = [2.0, 1.6, 1.0];
    let cube = cuboid([-1.0, -0.8, -0.5], sides);
    let half = Vec3::from(sides) / 2.0;
    let points = [
        [0.1, 0.2, 0.3],
        [1.7, 0.3, -0.2],
        [0.4, 1.3, 0.9],
        [-1.2, -1.1, 0.7],
        [0.999, 0.1, 0.2],
        [2.5, 1.0, 3.0],
    ];
    for arch in arches() {
        let facets = Facets::new(&cube, 1.0);
        for x in points.map(Vec3::from) {
            let expected = box_potential(-half - x, half - x) / 3.2;
            let found = facets.at(arch, &x);
            close(found.potential, expected, 2e-14 * expected);
            let inside = (0..3).all(|k| x[k].abs() < half[k]);
            let turns = if inside { 4.0 * std::f64::consts::PI } else { 0.0 };
            close(found.solid_angle, turns, 1e-13);
            // Poisson's equation: the trace is -4 pi times the density.
            close(found.gradient.trace(), -turns / 3.2, 1e-13);
            let step = 1e-5;
            for k in 0..3 {
                let at = |s: f64| facets.at(arch, &(x + Vec3::ith(k, s * step)));
                close(found.field[k], (at(1.0).potential - at(-1.0).potential) / (2.0 * step), 3e-9);
                let change = (at(1.0).field - at(-1.0).field) / (2.0 * step);
                assert!((found.gradient.column(k) - change).norm() < 1e-6, "{x} {change}");
            }
        }
    }
}

#[test]
fn points_on_faces_edges_and_corners_have_a_finite_field() {
    let cube = cuboid([-1.0; 3], [2.0; 3]);
    for arch in arches() {
        let facets = Facets::new(&cube, 1.0);
        // By symmetry a cube of half-length 1 about one of its corners is an eighth of one of half-length 2
        // about its centre.
        let corner = facets.at(arch, &Vec3::new(1.0, 1.0, 1.0)).potential;
        let centre = facets.at(arch, &Vec3::zeros()).potential;
        close(corner, centre / 2.0, 1e-15);
        for x in [[1.0, 0.3, 0.2], [1.0, 1.0, 0.2], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [-1.0, 0.0, 0.0]]
            .map(Vec3::from)
        {
            let (on, off) = (facets.at(arch, &x), facets.at(arch, &(x * (1.0 + 1e-11))));
            close(on.potential, off.potential, 1e-10);
            assert!((on.field - off.field).norm() < 1e-8, "{x}");
        }
    }
}

#[test]
fn logarithms_and_angles_have_all_digits() {
    let mut x = 1e-280_f64;
    while x < 1e70 {
        for scale in [1.0, 1e-9, 3e8] {
            let found = ln_one_plus(Lanes::splat(Scalar, x * scale), Lanes::splat(Scalar, scale)).first();
            close(found, x.ln_1p(), 6e-16 * x.ln_1p());
        }
        x *= 1.37;
    }
    for k in 0..4000 {
        let turn = f64::from(k) * 1.571e-3 - std::f64::consts::PI;
        let (y, x) = ((2.7 * turn).exp() * turn.sin(), (2.7 * turn).exp() * turn.cos());
        let found = angle(Lanes::splat(Scalar, y), Lanes::splat(Scalar, x)).first();
        close(found, y.atan2(x), 5e-16);
    }
    for y in [1e-300, 1e-20, 1e-9] {
        close(angle(Lanes::splat(Scalar, y), Lanes::splat(Scalar, 2.0)).first() / (y / 2.0), 1.0, 3e-16);
    }
}

#[test]
fn rules_on_triangles_are_exact() {
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    for n in 1..20 {
        for degree in 0..=2 * n as u32 - 2 {
            for i in 0..=degree {
                // Mean of s^i t^j over a triangle: 2 i! j! / (i + j + 2)!.
                let j = degree - i;
                let term = |p: &triangle::TriangleNode| {
                    p.weight * p.shares[0].powi(i as i32) * p.shares[2].powi(j as i32)
                };
                let found: f64 = triangle::rule(n).iter().map(term).sum();
                let expected = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
                close(found, expected, 1e-13 * expected);
            }
        }
    }
}

#[test]
fn harmonic_moments_of_a_box_are_those_of_its_integrals() {
    let body = cuboid([0.0; 3], [2.0, 1.4, 0.6]);
    let square = |side: f64| side * side / 12.0;
    let (xx, yy, zz) = (square(2.0), square(1.4), square(0.6));
    let fourth = |side: f64| (side / 2.0).powi(4) / 5.0;
    let r2 = body.circumradius().powi(2);
    for arch in arches() {
        let moments = body.harmonic_moments(30, arch, &mut InterruptCheck::never()).unwrap();
        close(moments[0], 1.0, 1e-14);
        close(moments[index(2, 0)], (zz - 0.5 * (xx + yy)) / r2, 1e-15);
        close(moments[index(2, 2)], 0.75_f64.sqrt() * (xx - yy) / r2, 1e-15);
        // S_40 = (35 z^4 - 30 z^2 r^2 + 3 r^4) / 8.
        let (x4, y4, z4) = (fourth(2.0), fourth(1.4), fourth(0.6));
        let r4 = x4 + y4 + z4 + 2.0 * (xx * yy + yy * zz + zz * xx);
        let s40 = (35.0 * z4 - 30.0 * (z4 + zz * (xx + yy)) + 3.0 * r4) / 8.0;
        close(moments[index(4, 0)], s40 / r2 / r2, 1e-15);
        assert!(moments.len() >= count(30));
        // Harmonics that are odd in a coordinate, and sines, vanish over a box.
        for n in 0..=30 {
            for m in -(n as isize)..=n as isize {
                if m < 0 || m % 2 == 1 || (n as isize - m) % 2 == 1 {
                    close(moments[index(n, m)], 0.0, 1e-15);
                }
            }
        }
    }
}

#[test]
fn a_layer_attracts_like_its_body() {
    let body = cuboid([0.3, -0.2, 5.0], [2.0, 1.4, 0.6]);
    let radius = body.circumradius();
    let u = Vec3::new(0.48, -0.6, 0.64);
    for arch in arches() {
        let facets = Facets::new(&body, 1.0);
        for (degree, ratio) in [(30, 3.5), (20, 5.0), (12, 12.0)] {
            let layer = Layer::new(&body, degree, arch, &mut InterruptCheck::never()).unwrap();
            close(layer.weights.iter().sum(), 1.0, 1e-14);
            let x = u * (ratio * radius);
            let (potential, field, gradient) = layer.at(arch, &x);
            let exact = facets.at(arch, &x);
            let rounding = 4e-15 * ratio * ratio;
            close(potential, exact.potential, rounding * exact.potential);
            assert!((field - exact.field).norm() <= rounding * field.norm());
            assert!((gradient - exact.gradient).norm() <= rounding * gradient.norm());
        }
        // From any distance the sum of both is the monopole and MacCullagh's quadrupole.
        let anywhere = PolyhedronGravity::new(&body, arch, &mut InterruptCheck::never()).unwrap();
        for r in [1e4, 1e8, 1e120] {
            let x = u * r;
            let moment = body.inertia_per_mass();
            let along = moment.component_mul(&u).dot(&u);
            let quadrupole = 0.5 * (moment.sum() - 3.0 * along) / r / r;
            close(anywhere.at(&x).potential * r, 1.0 + quadrupole, 1e-14);
        }
    }
}

#[test]
fn a_pull_is_the_field_less_that_of_a_point() {
    let body = cuboid([-1.0, -0.7, -0.3], [2.0, 1.4, 0.6]);
    let attraction = LayerAttraction::new(&body);
    let facets = Facets::new(&body, 1.0);
    for r in [1.4, 3.0, 7.0, 12.0, 40.0] {
        let x = Vec3::new(0.48, -0.6, 0.64) * r;
        let (square, cube) = (1.0 / (r * r), 1.0 / (r * r * r));
        let (perturbation, moment) = attraction.at(&x, square, cube).unwrap();
        let field = facets.field(Arch::Scalar, &x).field;
        let rounding = 1e-15 * r * r;
        assert!((perturbation - (field + x * cube)).norm() <= rounding * square, "{r} {perturbation}");
        assert!((moment - x.cross(&field)).norm() <= rounding / r, "{r} {moment}");
    }
    // Far away the moment is 3 u cross (I u) / r^3, with all its digits.
    for r in [1e5, 1e9] {
        let u = Vec3::new(0.48, -0.6, 0.64);
        let (_, moment) = attraction.at(&(u * r), 1.0 / (r * r), 1.0 / (r * r * r)).unwrap();
        let expected = -3.0 * u.cross(&body.inertia_per_mass().component_mul(&u)) / r.powi(3);
        assert!((moment - expected).norm() <= 1e-9 * expected.norm(), "{moment} {expected}");
    }
    assert!(attraction.at(&Vec3::new(0.1, 0.2, 0.1), 1.0, 1.0).is_none());
}

#[test]
fn gaps_are_distances() {
    let cube = Shape::Polyhedron(cuboid([-1.0; 3], [2.0; 3]));
    let ball = Shape::sphere(0.5).unwrap();
    let between = |other: &Shape, r: [f64; 3]| parallel_gap([&cube, other], r);
    close(between(&ball, [2.0, 0.3, 0.4]), 0.5, 1e-15);
    close(between(&ball, [2.0, 2.0, 0.4]), 2.0_f64.sqrt() - 0.5, 1e-15);
    close(between(&ball, [2.0, 2.0, 2.0]), 3.0_f64.sqrt() - 0.5, 1e-15);
    close(between(&Shape::Point, [1.0, 3.0, 0.0]), 2.0, 1e-15);
    assert!(between(&ball, [1.4, 0.0, 0.0]) < 0.0 && between(&ball, [0.1, 0.0, 0.0]) < 0.0);
    // One cube beside another, face to face, edge to edge, within, and crossing.
    close(between(&cube, [2.5, 0.1, 0.2]), 0.5, 1e-15);
    close(between(&cube, [3.0, 3.0, 0.2]), 2.0_f64.sqrt(), 1e-15);
    assert!(between(&cube, [1.5, 0.3, 0.2]) < 0.0);
    let small = Shape::Polyhedron(cuboid([-0.1; 3], [0.2; 3]));
    assert!(between(&small, [0.2, 0.1, 0.0]) < 0.0);
    assert!(parallel_gap([&small, &cube], [0.2, 0.1, 0.0]) < 0.0);
    // Beside an ellipsoid the bound is below the distance, and has its sign.
    let egg = Shape::ellipsoid([0.9, 0.5, 0.3]).unwrap();
    let bound = between(&egg, [2.0, 0.0, 0.0]);
    assert!(0.0 < bound && bound <= 0.1 + 1e-15, "{bound}");
    assert!(between(&egg, [1.89, 0.0, 0.0]) < 0.0 && between(&egg, [1.91, 0.0, 0.0]) > 0.0);
}

#[test]
fn bad_meshes_name_the_face() {
    let cube: Vec<Vec3> = (0..8).map(|k| Vec3::from_fn(|i, _| f64::from(k >> i & 1))).collect();
    let refused = |vertices: &[Vec3], faces: &[[u32; 3]], what: &str, value: &str| match Polyhedron::new(
        vertices,
        faces,
        &mut InterruptCheck::never(),
    ) {
        Err(Error::InvalidInput { what: found, value: about, .. }) => {
            assert!(
                (found == what || what.is_empty() && found.starts_with("face ")) && about.contains(value),
                "{found} is {about}, not {what}: {value}"
            );
        }
        other => panic!("{what}: {other:?}"),
    };
    let with = |place: usize, face: [u32; 3]| {
        let mut faces = CUBE.to_vec();
        faces[place] = face;
        faces
    };
    refused(&cube, &CUBE[..11], "face 4", "alone at the edge");
    refused(&cube, &with(3, [4, 6, 7]), "face 8", "turned against face 3");
    refused(&cube, &with(0, [0, 2, 9]), "face 0", "(0, 2, 9)");
    refused(&cube, &with(0, [0, 2, 2]), "face 0", "(0, 2, 2)");
    refused(&cube, &[&CUBE[..], &CUBE[4..5]].concat(), "face 12", "the same three vertices as face 4");
    refused(&cube, &CUBE.map(|[a, b, c]| [a, c, b]), "face 0", "turned inward");
    refused(&cube, &CUBE[..3], "number of faces", "3");
    let mut flat = cube.clone();
    flat[7] = flat[6];
    refused(&flat, &CUBE, "face 3", "(4, 7, 6)");
    let mut nan = cube.clone();
    nan[5].y = f64::NAN;
    refused(&nan, &CUBE, "vertex 5, component 1,", "NaN");
    // A corner pushed through the opposite faces.
    let mut crossing = cube.clone();
    crossing[7] = Vec3::new(0.5, 0.5, -0.5);
    refused(&crossing, &CUBE, "", "crossing or touching face");
    // A description is looked into before the shape is used.
    let corners: Vec<[f64; 3]> = crossing.iter().map(|&v| v.into()).collect();
    let described = serde_json::json!({ "vertices": corners, "faces": CUBE });
    let body = Body::with_mass("A", serde_json::from_value(described).unwrap(), 1.0).unwrap();
    let system = System::new(vec![body], 1.0, Settings::default()).unwrap();
    let still = vec![Vec3::zeros()];
    let state = State::new(0.0, still.clone(), still.clone(), vec![[1.0, 0.0, 0.0, 0.0]], still).unwrap();
    let used = system.interactions(&state);
    assert!(refusal(used).contains("crossing or touching face"));
    // Two cubes that share space; one within another one that is not a hollow.
    let shifted = |d: f64, size: f64| cube.iter().map(move |v| v * size + Vec3::repeat(d));
    let both = |d: f64, size: f64| cube.iter().copied().chain(shifted(d, size)).collect::<Vec<_>>();
    let second = CUBE.map(|face| face.map(|v| v + 8));
    refused(&both(0.5, 1.0), &[CUBE, second].concat(), "", "crossing or touching face");
    refused(&both(0.25, 0.5), &[CUBE, second].concat(), "face 12", "within another one");
    let turned = second.map(|[a, b, c]| [a, c, b]);
    refused(&both(2.0, 0.5), &[CUBE, turned].concat(), "face 12", "turned inward");
    // A hollow and a second piece are welcome.
    let hollow =
        Polyhedron::new(&both(0.25, 0.5), &[CUBE, turned].concat(), &mut InterruptCheck::never()).unwrap();
    close(hollow.volume(), 1.0 - 0.125, 1e-15);
    let field = Facets::new(&hollow, 1.0).at(Arch::Scalar, &Vec3::zeros());
    close(field.solid_angle, 0.0, 1e-14);
    let two =
        Polyhedron::new(&both(2.0, 1.0), &[CUBE, second].concat(), &mut InterruptCheck::never()).unwrap();
    close(two.volume(), 2.0, 1e-15);
}

/// Divides each face into four, this often, in its plane.
fn divided(polyhedron: &Polyhedron, levels: usize) -> Polyhedron {
    let (mut vertices, mut faces) = (polyhedron.vertices().collect::<Vec<_>>(), polyhedron.faces().to_vec());
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                vertices.push(0.5 * (vertices[i as usize] + vertices[j as usize]));
                vertices.len() as u32 - 1
            })
        };
        let quarters = |[a, b, c]: [u32; 3]| {
            let [d, e, f] = [middle(b, c), middle(c, a), middle(a, b)];
            [[a, f, e], [f, b, d], [e, d, c], [d, e, f]]
        };
        faces = faces.into_iter().flat_map(quarters).collect();
    }
    Polyhedron::new(&vertices, &faces, &mut InterruptCheck::never()).unwrap()
}

/// The rule over fragments against that over the faces of the same solids with few faces.
#[test]
fn boxes_of_many_faces_attract_as_those_of_few() {
    let boxes = [cuboid([-0.5, -0.45, -0.4], [1.0, 0.9, 0.8]), cuboid([-0.3, -0.25, -0.2], [0.6, 0.5, 0.4])];
    let system = |levels: [usize; 2], gravity_tolerance: f64| {
        let body = |k: usize| {
            let shape = Shape::Polyhedron(divided(&boxes[k], levels[k]));
            Body::with_mass(["A", "B"][k], shape, [2.0, 0.3][k]).unwrap()
        };
        let settings = Settings { gravity_tolerance, ..Settings::default() };
        System::new(vec![body(0), body(1)], 1.0, settings).unwrap()
    };
    for (position, turn) in [
        (Vec3::new(0.83, 0.1, -0.05), [1.0, 0.0, 0.0, 0.0]),
        (Vec3::new(0.1, -0.3, 0.77), [1.0, 0.0, 0.0, 0.0]),
        (Vec3::new(0.85, 0.65, 0.5), [0.8, 0.2, -0.4, 0.4]),
    ] {
        let (position, still) = (vec![Vec3::zeros(), position], vec![Vec3::zeros(); 2]);
        let attitude = vec![[1.0, 0.0, 0.0, 0.0], turn];
        let state = State::new(0.0, position, still.clone(), attitude, still).unwrap();
        let expected = system([0, 0], 1e-11).interactions(&state).unwrap();
        let size = expected.force[0].norm();
        for tolerance in [1e-3, 1e-6] {
            let found = system([3, 2], tolerance).interactions(&state).unwrap();
            let error = found.truncation_error;
            assert!(error > 0.0 && error <= tolerance, "{error}");
            let allowed = (error + 1e-10) * size;
            for k in 0..2 {
                assert!((found.force[k] - expected.force[k]).norm() < allowed);
                // Errors of torques are relative to the force times the circumradius.
                assert!((found.torque[k] - expected.torque[k]).norm() < allowed);
            }
        }
    }
}
