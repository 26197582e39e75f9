//! Kepler's orbits against closed forms, arbitrary precision and rebound.
// Angles that happen to be a constant are data like the others.
#![allow(clippy::approx_constant)]

use crate::support::*;
use fullbody::math::Vec3;
use fullbody::orbit::KeplerElements;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};

fn elements(values: [f64; 6]) -> KeplerElements {
    let [a, e, i, node, periapsis, mean] = values;
    KeplerElements::new(a, e, i, node, periapsis, mean).unwrap()
}

fn values(k: &KeplerElements) -> [f64; 6] {
    [
        k.semi_major_axis,
        k.eccentricity,
        k.inclination,
        k.longitude_of_node,
        k.argument_of_periapsis,
        k.mean_anomaly,
    ]
}

fn osculating(r: [f64; 3], v: [f64; 3], mu: f64) -> [f64; 6] {
    values(&KeplerElements::from_cartesian(&Vec3::from(r), &Vec3::from(v), mu).unwrap())
}

/// Fails unless every angle or number is within `tolerance` of the expected one.
#[track_caller]
fn near(actual: &[f64], expected: &[f64], tolerance: f64) {
    for (k, (x, y)) in actual.iter().zip(expected).enumerate() {
        assert!((x - y).abs() <= tolerance, "[{k}]: {x:e} is not {y:e} ({:.1e})", (x - y).abs());
    }
}

// (e, M, E or H, true anomaly): mpmath with 60 digits, bisection of E - e sin E = M or e sinh H - H = M for
// the doubles e and M as they stand, then tan(nu) from the semi-axes.
#[rustfmt::skip]
const KEPLER: [[f64; 4]; 26] = [
    [0.0, 1.25, 1.25, 1.25],
    [1e-12, 2.0, 2.0000000000009095, 2.0000000000018185],
    [0.0126, 0.7, 0.7081958528830751, 0.7164313940551176],
    [0.3, 3.0, 3.0326254934859693, 3.0615960934651567],
    [0.5, 6.25, 6.216863302880942, 6.168396310274618],
    [0.9, 1e-08, 9.999999999999853e-08, 4.3588989435405443e-07],
    [0.9, 0.3, 1.103517720303087, 2.4280629640306612],
    [0.99, 0.001, 0.08854859633018196, 1.1171615954822827],
    [0.999999, 1e-09, 0.0008846222865528374, 1.11794963028892],
    [0.999999999, 1e-14, 9.841150584934475e-06, 0.43320518697456273],
    [0.999999999, 0.0001, 0.0843532458843972, 3.140532947271648],
    [0.999999999, 3.0, 3.0707667271066126, 3.1415910692115867],
    [0.9999999999999999, 1e-12, 0.0001817120581612554, 3.141428645088979],
    [0.9999999999999999, 1.0, 1.934563210752024, 3.141592643318288],
    [1.0000000000000002, 1e-12, 0.00018171205673929685, 3.1413607105410257],
    [1.0000000000000002, 5.0, 2.744239106173595, 3.141592629620231],
    [1.000000001, 1e-14, 9.841149542506768e-06, 0.43320511940951734],
    [1.000000001, 0.0001, 0.08433324584824747, 3.140531438435144],
    [1.000000001, 1000.0, 7.6084823886503585, 3.1415478878227185],
    [1.0001, 0.5, 1.3960850910867963, 3.1181461680720406],
    [1.5, 1e-08, 1.9999999999999997e-08, 4.4721359549995777e-08],
    [1.5, 20.0, 3.4432882371324482, 2.2518541203060063],
    [10.0, 3.0, 0.3268334578092115, 0.35438933385742766],
    [1000000.0, 0.001, 1.000001000001e-09, 1.0000020000025e-09],
    [1000000.0, 1000000000.0, 7.600902717142888, 1.5697973271353312],
    [1.2, 1e+200, 461.02784422257514, 2.5559071101326425],
];

#[test]
fn anomalies_against_arbitrary_precision() {
    for [e, mean, eccentric, truth] in KEPLER {
        let a = if e < 1.0 { 1.0 } else { -1.0 };
        let k = elements([a, e, 0.1, 0.2, 0.3, mean]);
        close(k.eccentric_anomaly().unwrap(), eccentric, 8e-16);
        close(k.true_anomaly().unwrap(), truth, 8e-16);
        // The other side of periapsis mirrors this one.
        let k = elements([a, e, 0.1, 0.2, 0.3, -mean]);
        let wrap = if e < 1.0 { TAU } else { 0.0 };
        near(&[k.eccentric_anomaly().unwrap()], &[wrap - eccentric], 1e-15 * eccentric.max(1.0));
        near(&[k.true_anomaly().unwrap()], &[wrap - truth], 1e-15 * truth.max(1.0));
    }
}

#[test]
fn many_turns_do_not_matter() {
    // mpmath: E of e = 0.3 and M = 1e15 + 0.5 modulo 2 pi, with all digits of pi.
    let k = elements([1.0, 0.3, 0.0, 0.0, 0.0, 1e15 + 0.5]);
    close(k.eccentric_anomaly().unwrap(), 2.729779565023762, 1e-15);
}

// (elements, position, velocity) with mu = 1.7: mpmath, as above, for the doubles as they stand.
#[rustfmt::skip]
const STATES: [([f64; 6], [f64; 3], [f64; 3]); 8] = [
    ([1.0, 0.999999999, 0.4, 1.1, 2.2, 1e-14],
     [-8.343335155468445e-10, -6.02979821446023e-10, 1.9873600787519344e-10],
     [17859.928567744326, -51463.16835018003, -16599.028073228405]),
    ([3.0, 0.999999999, 2.5, 5.0, 0.3, 0.9],
     [-0.1694591804491026, 3.78764352743557, -0.6812191342665201],
     [-0.02470590793052838, 0.5526881668619096, -0.09941793936404716]),
    ([-2.0, 1.000000001, 1.0, 4.0, 1.5, -1e-10],
     [-3.063200928594979e-07, 2.3134530114833936e-07, -5.965513096487356e-07],
     [869.7661686480326, -802.3332237588265, 1841.9168371266533]),
    ([-1.0, 1.000000001, 0.2, 0.1, 6.0, 50.0],
     [-52.775277629467034, 9.487617850514955, 2.981652903875885],
     [-1.3049296793174983, 0.23459122392249956, 0.0737245925747272]),
    ([-0.01, 100000.0, 3.0, 2.0, 1.0, 400000.0],
     [3878.8580261337675, -1332.2890885315917, 423.7349562018288],
     [10.907293254405657, -7.074141546991387, 0.9941327147760187]),
    ([-1.0, 1.3, 0.7, 0.8, 0.9, 1000000000000.0],
     [-569177951488.1595, -811500250181.5737, -132301940836.51651],
     [-0.7421172540459077, -1.0580668765340835, -0.17250062617906656]),
    ([2.54, 1e-09, 1e-09, 3.0, 4.0, 5.0],
     [2.143389051958705, -1.3628952154451985, 1.0467809566555507e-09],
     [0.4389715277466577, 0.6903588463908809, -7.453977434223721e-10]),
    ([1.0, 0.2, 3.14159265, 1.0, 2.0, 6.2],
     [0.5148631480955297, -0.61371324055441, 2.7455924570009575e-09],
     [-1.2434338763797832, -0.999072708987312, -1.8182741090584719e-09]),
];

#[test]
fn states_against_arbitrary_precision() {
    for (given, position, velocity) in STATES {
        let (r, v) = elements(given).to_cartesian(1.7).unwrap();
        close_vector(&r, &Vec3::from(position), 2e-15);
        close_vector(&v, &Vec3::from(velocity), 2e-15);
    }
}

// (position, velocity, elements) with mu = 1: mpmath with 60 digits, from the eccentricity vector, for the
// doubles as they stand: nearly circular, nearly equatorial, nearly radial, far out on a hyperbola; the last
// three are parabolic but for their rounding.
#[rustfmt::skip]
const ELEMENTS: [([f64; 3], [f64; 3], [f64; 6]); 12] = [
    ([1.0, 0.25, -0.5], [-0.125, 0.75, 0.375],
     [0.9737163557256185, 0.21730894582596927, 0.6247538687650431, 0.982793723247329, 1.79452167704725, 3.890598208756246]),
    ([1.0, 0.001, 0.0], [0.0, 1.0, 1e-12],
     [1.00000100000025, 0.0009999996250002422, 1.000000499999875e-12, 0.0009999996666668668, 4.711888980551357, 1.569296327211563]),
    ([1.0, 0.0, 1e-14], [1e-09, 1.0, 1e-13],
     [1.0, 1e-09, 1.0049875620125853e-13, 6.183516654678524, 4.812057632885753, 1.5707963247948966]),
    ([2.0, 1.0, 0.5], [-0.001, -0.0005, -0.00024],
     [1.145645639966531, 0.9999999997817824, 1.5707963267948966, 0.4636476090008061, 3.3615806054166706, 3.146488258374435]),
    ([0.5, 0.5, 0.25], [-1.0, 1.25, 0.75],
     [-2.1818181818181817, 1.326990937390556, 0.5092133747625667, 0.09966865249116202, 0.33641186668119816, 0.05280029294500321]),
    ([1.0, 2.0, 3.0], [40.0, -20.0, 5.0],
     [-0.0004939575463775771, 7545.7334007465715, 2.2096614710303077, 2.5948038127005457, 1.4319296144281404, 674.8215831510412]),
    ([1.0, -2.0, 0.5], [0.7, 0.5, -0.25],
     [14.21028589654574, 0.8463017668027419, 0.3296244074207427, 2.746801533890032, 2.857495760964348, 6.262312749691611]),
    ([1000000.0, 1.0, 3.0], [-0.1, 1e-07, 1e-06],
     [-100.02000399069601, 1.0086111936726423, 1.4181469983996533, 5.384615384614865e-07, 3.010816710318686, -9989.105136973816]),
    ([1.0, 0.5, 0.0], [-0.25, 0.001, -0.9],
     [1.0912820530193488, 0.2400920124296954, 1.446224913008499, 3.6052402625905993, 5.0529410870566265, 4.848944509299593]),
    ([-0.4, -0.94, 0.73], [-0.07846569919789863, 0.6300769905369206, 1.0907455854327113],
     [-3145126237564121.5, 1.0000000000000004, 1.780217261647835, 4.462534435808546, 0.3383568758847153, 1.6507643214205681e-24]),
    ([-0.41, 0.54, 0.75], [-0.9799712626124432, 0.24623988426766383, -0.9783584036153283],
     [-2670024308782672.0, 1.0000000000000004, 1.261763727858141, 5.722735116918499, 2.5298277184007127, -1.4393422841863047e-24]),
    ([-0.96, -0.88, 0.35], [1.0691557362661952, -0.5743273018364403, -0.10081712628105556],
     [-3538706937223053.0, 1.0000000000000004, 0.2626094982139695, 2.3344867481182123, 2.240909863618175, -3.29091214473819e-24]),
];

#[test]
fn elements_against_arbitrary_precision() {
    for (r, v, expected) in ELEMENTS {
        let actual = osculating(r, v, 1.0);
        // a, e, i and a hyperbola's M to relative precision, the other angles as parts of a turn.
        for k in 0..3 {
            close(actual[k], expected[k], 1e-15);
        }
        near(&actual[3..], &expected[3..], 2e-15 * expected[5].abs().max(1.0));
    }
}

// (elements, position, velocity) with mu = 1, from rebound 5.2.2:
// sim.add(m=1); sim.add(a=, e=, inc=, Omega=, omega=, M=), then .x ... .vz of the second particle.
#[rustfmt::skip]
const REBOUND: [([f64; 6], [f64; 3], [f64; 3]); 8] = [
    ([1.0, 0.1, 1.004, 0.947, 4.088, 0.455],
     [0.3590419245119484, -0.3376906267742554, -0.7678033053490326],
     [0.6897369049944589, 0.8392418662007125, -0.10938348536820472]),
    ([2.5, 0.0126, 1.661, 2.297, 0.364, 3.187],
     [1.475120828750541, -1.7973235837864978, -1.0009887131187185],
     [-0.2034705996700267, 0.1513656483260464, -0.5707394026184209]),
    ([0.3, 0.6, 0.116, 2.723, 0.439, 0.57],
     [0.05050233561317632, -0.21254036581087105, 0.020235648275764784],
     [2.2496215927149112, -0.8495074008452083, -0.016109604082110585]),
    ([7.0, 0.95, 1.316, 5.193, 0.777, 1.402],
     [-5.479505681545726, 7.131300373710929, -5.9963631753320445],
     [-0.0903646465833211, 0.079604143290015, -0.1663412921586579]),
    ([-1.0, 1.2, 1.945, 5.952, 3.624, -0.509],
     [-0.11254707358384544, -0.35252629199878227, 0.9420898861632201],
     [-0.44290985878340317, 0.7670456825381077, -1.4803503272513097]),
    ([-3.0, 4.0, 3.026, 0.293, 5.391, -1.181],
     [-0.8839485110567535, 9.779609167518622, -1.1167630736932752],
     [0.7001680842911093, -0.20808087452105306, 0.04661122440766786]),
    ([1.5, 0.0, 0.447, 0.74, 1.937, 5.125],
     [0.14774212797939792, 1.4215248827697125, 0.45545501565651236],
     [-0.7768931662614046, 0.00025858446103823056, 0.2512043152835411]),
    ([-0.2, 25.0, 0.56, 3.652, 4.012, -0.661],
     [1.308783085967125, 4.210274302734709, -1.9023359648987372],
     [-2.172900139872626, 0.24183791865929935, -0.7978230088022435]),
];

#[test]
fn agrees_with_rebound() {
    for (given, position, velocity) in REBOUND {
        let (r, v) = elements(given).to_cartesian(1.0).unwrap();
        close_vector(&r, &Vec3::from(position), 1e-14);
        close_vector(&v, &Vec3::from(velocity), 1e-14);
        let mut actual = osculating(position, velocity, 1.0);
        if given[1] == 0.0 {
            // On a circle only the sum is defined.
            let latitude = given[4] + given[5];
            actual[5] = (actual[4] + actual[5]).rem_euclid(TAU);
            near(&actual, &[given[0], 0.0, given[2], given[3], actual[4], latitude.rem_euclid(TAU)], 1e-14);
        } else {
            near(&actual, &given, 1e-13);
        }
    }
}

#[test]
fn closed_forms() {
    // At E = pi/2: M = pi/2 - e, x = -a e, y = b.
    let k = elements([2.0, 0.5, 0.0, 0.0, 0.0, FRAC_PI_2 - 0.5]);
    close(k.eccentric_anomaly().unwrap(), FRAC_PI_2, 4e-16);
    close(k.true_anomaly().unwrap(), 2.0 * FRAC_PI_3, 4e-16);
    let (r, v) = k.to_cartesian(8.0).unwrap();
    close_vector(&r, &Vec3::new(-1.0, 3f64.sqrt(), 0.0), 5e-16);
    close_vector(&v, &Vec3::new(-2.0, 0.0, 0.0), 5e-16);
    // Periapsis and apoapsis, with the speeds of vis-viva.
    let turn = |mean| elements([1.0, 0.6, 0.0, 0.0, FRAC_PI_2, mean]).to_cartesian(1.0).unwrap();
    let (r, v) = turn(0.0);
    close_vector(&r, &Vec3::new(0.0, 0.4, 0.0), 5e-16);
    close_vector(&v, &Vec3::new(-2.0, 0.0, 0.0), 5e-16);
    let (r, v) = turn(PI);
    close_vector(&r, &Vec3::new(0.0, -1.6, 0.0), 5e-16);
    close_vector(&v, &Vec3::new(0.5, 0.0, 0.0), 5e-16);
    // The vertex of a hyperbola: q = a (1 - e), v^2 = mu (1 + e) / q.
    let k = elements([-1.0, 2.0, FRAC_PI_2, FRAC_PI_2, 0.0, 0.0]);
    let (r, v) = k.to_cartesian(3.0).unwrap();
    close_vector(&r, &Vec3::new(0.0, 1.0, 0.0), 5e-16);
    close_vector(&v, &Vec3::new(0.0, 0.0, 3.0), 5e-16);
    close(k.periapsis_distance(), 1.0, 1e-16);
    // Kepler's third law.
    let k = elements([4.0, 0.25, 0.0, 0.0, 0.0, 0.0]);
    close(k.period(16.0).unwrap(), 4.0 * PI, 4e-16);
    close(k.mean_motion(16.0).unwrap(), 0.5, 4e-16);
    close(k.periapsis_distance(), 3.0, 4e-16);
}

#[test]
fn conventions_at_the_degenerate_orbits() {
    let s = 0.5f64.sqrt();
    // A polar circle at its highest point: the mean anomaly counts from the node.
    near(
        &osculating([0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], 1.0),
        &[1.0, 0.0, FRAC_PI_2, 0.0, 0.0, FRAC_PI_2],
        4e-16,
    );
    // A circle in the plane of reference: it counts from x.
    near(&osculating([-s, -s, 0.0], [s, -s, 0.0], 1.0), &[1.0, 0.0, 0.0, 0.0, 0.0, 1.25 * PI], 1e-15);
    // An ellipse there: so does the argument of periapsis.
    near(
        &osculating([0.0, 1.0, 0.0], [-1.25, 0.0, 0.0], 1.25),
        &[4.0 / 3.0, 0.25, 0.0, 0.0, FRAC_PI_2, 0.0],
        1e-15,
    );
    // Clockwise: a quarter turn in the direction of motion from x is -y.
    near(
        &osculating([0.0, -1.0, 0.0], [-1.25, 0.0, 0.0], 1.25),
        &[4.0 / 3.0, 0.25, PI, 0.0, FRAC_PI_2, 0.0],
        1e-15,
    );
    near(&osculating([0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], 1.0), &[1.0, 0.0, PI, 0.0, 0.0, FRAC_PI_2], 1e-15);
    // One rounding before periapsis is within [0, 2 pi) all the same.
    let mean = osculating([1.0, 0.0, 0.0], [-1e-30, 1.1, 0.0], 1.0)[5];
    assert!((0.0..TAU).contains(&mean));
}

#[test]
fn nearly_parabolic_motion_follows_barker() {
    // D + D^3/3 = sqrt(mu / (2 q^3)) t, D = tan(nu/2): here q = 1, mu = 2, so that t = D + D^3/3.
    for from_one in [2f64.powi(-40), -(2f64.powi(-40))] {
        for d in [-3.0, -0.5, 1e-3, 0.75, 2.0] {
            let time = d + d * d * d / 3.0;
            let mut k = elements([1.0 / from_one, 1.0 - from_one, 0.0, 0.0, 0.0, 0.0]);
            k.mean_anomaly = k.mean_motion(2.0).unwrap() * time;
            let (r, v) = k.to_cartesian(2.0).unwrap();
            let stretch = 1.0 + d * d;
            close_vector(&r, &Vec3::new(1.0 - d * d, 2.0 * d, 0.0), 1e-10);
            close_vector(&v, &Vec3::new(-2.0 * d / stretch, 2.0 / stretch, 0.0), 1e-10);
        }
    }
}

/// Signed distance of e from 1: mostly ordinary, sometimes tiny.
fn ellipse() -> impl Strategy<Value = KeplerElements> {
    let e = prop_oneof![
        0.0..0.9,
        (-18.0..-1.0).prop_map(exponential),
        (-9.0..-0.5).prop_map(|x| 1.0 - exponential(x))
    ];
    orbit(e, 1.0, (0.0..TAU).boxed())
}

fn hyperbola() -> impl Strategy<Value = KeplerElements> {
    let mean =
        (-12.0..12.0, prop::bool::ANY).prop_map(|(x, early)| exponential(x) * if early { -1.0 } else { 1.0 });
    orbit((-9.0..8.0).prop_map(|x| 1.0 + exponential(x)), -1.0, mean.boxed())
}

fn orbit(
    e: impl Strategy<Value = f64>,
    sign: f64,
    mean: BoxedStrategy<f64>,
) -> impl Strategy<Value = KeplerElements> {
    let i = prop_oneof![
        4 => 0.0..PI,
        1 => (-20.0..-1.0).prop_map(exponential),
        1 => (-16.0..-1.0).prop_map(|x| PI - exponential(x)),
        1 => prop::sample::select(vec![0.0, PI]),
    ];
    ((-2.0..2.0).prop_map(exponential), e, i, 0.0..TAU, 0.0..TAU, mean)
        .prop_map(move |(a, e, i, node, periapsis, mean)| elements([sign * a, e, i, node, periapsis, mean]))
}

fn exponential(x: f64) -> f64 {
    10f64.powf(x)
}

/// The error that rounding the six numbers alone may cause, in units of a few roundings.
fn conditioning(k: &KeplerElements) -> f64 {
    let from_one = (1.0 - k.eccentricity).abs().min(1.0);
    let late = k.eccentricity < 1.0 && k.mean_anomaly > PI;
    if late { from_one.powf(-1.5) } else { 1.0 / from_one }
}

fn check_round_trip(k: &KeplerElements, mu: f64) {
    let (r, v) = k.to_cartesian(mu).unwrap();
    let found = KeplerElements::from_cartesian(&r, &v, mu).unwrap();
    let (again_r, again_v) = found.to_cartesian(mu).unwrap();
    let allowed = 6e-15 * conditioning(&found);
    close_vector(&again_r, &r, allowed);
    close_vector(&again_v, &v, allowed);
    let [_, e, i, node, periapsis, mean] = values(&found);
    assert!((0.0..TAU).contains(&node) && (0.0..TAU).contains(&periapsis) && (0.0..=PI).contains(&i));
    assert!(e > 1.0 || (0.0..TAU).contains(&mean));
    if e < 1.0 {
        // Far out on a hyperbola the state's own rounding hides the eccentricity.
        near(&[e], &[k.eccentricity], 4e-15);
    }
}

/// Energy, angular momentum and eccentricity vector, each by its own formula.
fn check_invariants(k: &KeplerElements, mu: f64) {
    let (r, v) = k.to_cartesian(mu).unwrap();
    let [a, e, i, node, periapsis, _] = values(k);
    let kinetic = 0.5 * v.norm_squared();
    let allowed = 16.0 * f64::EPSILON * (kinetic + mu / r.norm());
    near(&[kinetic - mu / r.norm()], &[-mu / (2.0 * a)], allowed);
    let h = (mu * a * (1.0 - e) * (1.0 + e)).sqrt();
    let pole = Vec3::new(node.sin() * i.sin(), -node.cos() * i.sin(), i.cos());
    near((r.cross(&v) - pole * h).as_slice(), &[0.0; 3], 1e-14 * r.norm() * v.norm());
    let towards = Vec3::new(
        periapsis.cos() * node.cos() - periapsis.sin() * i.cos() * node.sin(),
        periapsis.cos() * node.sin() + periapsis.sin() * i.cos() * node.cos(),
        periapsis.sin() * i.sin(),
    );
    let vector = v.cross(&r.cross(&v)) / mu - r.normalize();
    near((vector - towards * e).as_slice(), &[0.0; 3], 2e-14 * (1.0 + r.norm() * v.norm_squared() / mu));
}

proptest! {
    #![proptest_config(cases(4000))]

    #[test]
    fn ellipses_come_back(k in ellipse(), mu in 1e-3..1e3) {
        check_round_trip(&k, mu);
    }

    #[test]
    fn hyperbolae_come_back(k in hyperbola(), mu in 1e-3..1e3) {
        check_round_trip(&k, mu);
    }

    #[test]
    fn invariants_of_ellipses(k in ellipse(), mu in 1e-3..1e3) {
        check_invariants(&k, mu);
    }

    #[test]
    fn invariants_of_hyperbolae(k in hyperbola(), mu in 1e-3..1e3) {
        check_invariants(&k, mu);
    }

    #[test]
    fn any_bound_state_comes_back(
        r in prop::array::uniform3(-1.0..1.0), v in prop::array::uniform3(-0.7..0.7), small in -20.0..0.0
    ) {
        // Nearly in the plane, to any degree.
        let tilt = Vec3::new(1.0, 1.0, exponential(small));
        let (r, v) = (Vec3::from(r).component_mul(&tilt), Vec3::from(v).component_mul(&tilt));
        let k = KeplerElements::from_cartesian(&r, &v, 1.0).unwrap();
        let (again_r, again_v) = k.to_cartesian(1.0).unwrap();
        close_vector(&again_r, &r, 6e-15 * conditioning(&k));
        close_vector(&again_v, &v, 6e-15 * conditioning(&k));
    }

    #[test]
    fn velocity_is_the_rate_of_position(e in prop_oneof![0.0..0.8, 1.3..4.0], mean in -3.0..3.0) {
        let k = elements([if e < 1.0 { 1.5 } else { -1.5 }, e, 0.4, 1.0, 2.0, mean]);
        let step = 1e-3;
        let at = |steps: f64| {
            let k = KeplerElements { mean_anomaly: mean + steps * step, ..k };
            k.to_cartesian(2.0).unwrap().0
        };
        // Five points, error of the fourth order.
        let slope = ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * step);
        let velocity = k.to_cartesian(2.0).unwrap().1;
        close_vector(&(slope * k.mean_motion(2.0).unwrap()), &velocity, 1e-6);
    }
}

/// Fails unless the message names every one of the words.
#[track_caller]
fn refused<T: std::fmt::Debug>(outcome: fullbody::error::Result<T>, words: &[&str]) {
    let message = outcome.unwrap_err().to_string();
    assert!(words.iter().all(|word| message.contains(word)), "{message} lacks one of {words:?}");
}

#[test]
fn what_is_no_orbit_is_refused() {
    let new = KeplerElements::new;
    refused(new(1.0, 1.0, 0.0, 0.0, 0.0, 0.0), &["eccentricity is 1", "parabola"]);
    refused(new(1.0, -0.1, 0.0, 0.0, 0.0, 0.0), &["eccentricity is -0.1", "zero or above"]);
    refused(new(-1.0, 0.1, 0.0, 0.0, 0.0, 0.0), &["semi-major axis is -1", "above zero", "ellipse"]);
    refused(new(0.0, 0.1, 0.0, 0.0, 0.0, 0.0), &["semi-major axis is 0", "above zero"]);
    refused(new(1.0, 1.1, 0.0, 0.0, 0.0, 0.0), &["semi-major axis is 1", "below zero", "hyperbola"]);
    refused(new(1.0, 0.1, 3.2, 0.0, 0.0, 0.0), &["inclination is 3.2", "[0, pi]"]);
    refused(new(1.0, 0.1, 0.0, 0.0, f64::NAN, 0.0), &["argument of periapsis is NaN", "finite"]);
    refused(new(1.0, 0.1, 0.0, 0.0, 0.0, f64::INFINITY), &["mean anomaly is inf", "finite"]);
    let k = elements([-1.0, 1.5, 0.0, 0.0, 0.0, 0.0]);
    refused(k.period(1.0), &["period", "1.5", "hyperbolic"]);
    for mu in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(k.to_cartesian(mu), &["mu is", "above zero"]);
        refused(k.mean_motion(mu), &["mu is", "above zero"]);
    }
    refused(KeplerElements { mean_anomaly: 1.7e308, ..k }.true_anomaly(), &["hyperbolic anomaly is inf"]);
    // The fields are public: what is put there is checked as well.
    refused(KeplerElements { eccentricity: f64::NAN, ..k }.to_cartesian(1.0), &["eccentricity is NaN"]);
    refused(
        KeplerElements { semi_major_axis: -1e308, mean_anomaly: 9.0, ..k }.to_cartesian(1.0),
        &["position", "inf"],
    );

    let from =
        |r: [f64; 3], v: [f64; 3], mu| KeplerElements::from_cartesian(&Vec3::from(r), &Vec3::from(v), mu);
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    refused(from(x, y, 0.0), &["mu is 0"]);
    refused(from([f64::NAN, 0.0, 0.0], y, 1.0), &["position, component 0", "NaN"]);
    refused(from(x, [0.0, 0.0, f64::INFINITY], 1.0), &["velocity, component 2", "inf"]);
    refused(from([0.0; 3], y, 1.0), &["distance is 0"]);
    refused(from(x, [0.0; 3], 1.0), &["angular momentum is 0", "straight line"]);
    refused(from([1.0, 2.0, 3.0], [-0.5, -1.0, -1.5], 1.0), &["angular momentum is 0", "straight line"]);
    refused(from(x, [0.0, 2.0, 0.0], 2.0), &["orbital energy is 0", "parabola"]);
    refused(from([0.0, 1.0, 0.0], [1.0, 1.0, 0.0], 1.0), &["orbital energy is 0", "parabola"]);
    refused(from(x, [-0.5, 1e-12, 0.0], 1.0), &["eccentricity is 1 to the last digit", "straight line"]);
    refused(from([1e200, 0.0, 0.0], y, 1.0), &["finite"]);
}
