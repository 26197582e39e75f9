//! Contacts of outlines against closed forms: bodies that pass before each other on straight lines.

use crate::integrators::systems::verner98;
use crate::polyhedron::cuboid;
use fullbody::dynamics::{Settings, State, System};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::spline::Spline;
use fullbody::math::{Mat3, Vec3, rotation};
use fullbody::mutual::Method;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{
    Condition, Dense, Output, Run, Simulation, TangentOptions, Trajectory, Viewpoint,
};
use std::f64::consts::{PI, SQRT_2};
use std::ops::ControlFlow;

/// The speed along x of the body in front.
const SPEED: f64 = 1.0;

/// Two bodies that do not attract each other, seen from far along z. The first one rests at the origin.
struct Passage {
    shapes: [Shape; 2],
    /// The position of the second one at time zero.
    place: Vec3,
    attitude: [[f64; 4]; 2],
    spin: [Vec3; 2],
}

impl Passage {
    fn of(shapes: [Shape; 2], place: Vec3) -> Self {
        Self { shapes, place, attitude: [[1.0, 0.0, 0.0, 0.0]; 2], spin: [Vec3::zeros(); 2] }
    }

    /// The times at which an event of one body by another begins and ends, between -20 and 20. The run
    /// starts at -20, or at 20 and goes backwards; its steps are as long as the motion allows.
    fn times(&self, [body, by]: [usize; 2], total: bool, back: bool) -> Vec<f64> {
        let (system, dense) = self.run(SPEED, 20.0, back);
        let found = crossings(&system, &dense, [body, by], total);
        if back { found.into_iter().rev().collect() } else { found }
    }

    fn run(&self, speed: f64, until: f64, back: bool) -> (System, Dense) {
        let body = |(shape, name): (&Shape, &str)| Body::with_mass(name, shape.clone(), 1.0).unwrap();
        let bodies = self.shapes.iter().zip(["A", "B"]).map(body).collect();
        let settings = Settings { gravity: Method::Point, ..Settings::default() };
        let system = System::new(bodies, 1e-30, settings).unwrap();
        let start = if back { until } else { -until };
        let velocity = Vec3::new(speed, 0.0, 0.0);
        let state = State::new(
            start,
            vec![Vec3::zeros(), self.place + velocity * start],
            vec![Vec3::zeros(), velocity],
            self.attitude.to_vec(),
            self.spin.to_vec(),
        );
        let mut record = Trajectory::new(2);
        let tangent_options = &TangentOptions::default();
        let run = Run { output: &Output::Ends, events: &mut [], dense: true, tangent_options };
        let mut simulation = Simulation::new(&system, &state.unwrap(), verner98(1e-10)).unwrap();
        simulation.run(-start, run, &mut record, &mut |_, _| ControlFlow::Continue(())).unwrap();
        (system, record.dense.unwrap())
    }
}

fn crossings(system: &System, dense: &Dense, [body, by]: [usize; 2], total: bool) -> Vec<f64> {
    let times = [-100.0, -50.0, 50.0, 100.0];
    let path = Spline::new("times", &times, &[[0.0, 0.0, 1.0]; 4]).unwrap();
    let toward = Box::new(Viewpoint { path, bounded: true, distant: true, slowness: 0.0 });
    let (from, to) = dense.range();
    let condition = Condition::Occultation { body, by, total, viewpoint: toward };
    let span = [from.min(to), from.max(to)];
    let [found] = &dense.crossings(system, vec![condition], span, &mut InterruptCheck::never()).unwrap()[..]
    else {
        panic!()
    };
    assert!(found.at_start > 0.0);
    found.times.clone()
}

/// Compares times with those at which the second body is at these places along x, forwards and backwards.
#[track_caller]
fn expect(passage: &Passage, bodies: [usize; 2], total: bool, places: &[f64]) {
    for back in [false, true] {
        let found = passage.times(bodies, total, back);
        assert_eq!(found.len(), places.len(), "{found:?} {places:?}");
        for (time, place) in found.iter().zip(places) {
            let error = (passage.place.x + SPEED * time - place).abs();
            assert!(error < 1e-9, "{found:?} {places:?} {error:e}");
        }
    }
}

/// The matrix of an ellipsoid's outline in the plane of x and y, inverted.
fn inverse_outline(axes: [f64; 3], attitude: [f64; 4]) -> [f64; 3] {
    let turn = rotation::matrix(rotation::normalised(attitude));
    let matrix = turn * Mat3::from_diagonal(&Vec3::from(axes.map(|a| a * a))) * turn.transpose();
    let (xx, xy, yy) = (matrix[(0, 0)], matrix[(0, 1)], matrix[(1, 1)]);
    let below = xx * yy - xy * xy;
    [yy / below, -xy / below, xx / below]
}

/// The points at which p x^2 + 2 q x y + r y^2 = reach^2.
fn roots([p, q, r]: [f64; 3], y: f64, reach: f64) -> Vec<f64> {
    let rest = (q * y).powi(2) - p * (r * y * y - reach * reach);
    if rest <= 0.0 { Vec::new() } else { [-1.0, 1.0].map(|s| (-q * y + s * rest.sqrt()) / p).to_vec() }
}

/// Similar ellipsoids, turned alike, touch where their centres are 1 + k and 1 - k times the outline apart.
#[test]
fn similar_ellipsoids() {
    let attitudes = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.4, -0.6, 0.3], [0.2, -0.7, 0.1, 0.9]];
    for axes in [[1.0, 1.0, 1.0], [1.0, 0.7, 0.4], [1.0, 0.9, 0.02], [1.0, 0.05, 0.03]] {
        for attitude in attitudes.map(rotation::normalised) {
            for factor in [0.3, 1.0, 2.5] {
                for y in [0.0, 0.03, 0.4, 1.1] {
                    let shapes = [axes, axes.map(|a| a * factor)].map(|a| Shape::ellipsoid(a).unwrap());
                    let mut passage = Passage::of(shapes, Vec3::new(0.3, y, 5.0));
                    passage.attitude = [attitude; 2];
                    let outline = inverse_outline(axes, attitude);
                    expect(&passage, [0, 1], false, &roots(outline, y, 1.0 + factor));
                    let inside = if factor > 1.0 { roots(outline, y, factor - 1.0) } else { Vec::new() };
                    expect(&passage, [0, 1], true, &inside);
                    expect(&passage, [1, 0], false, &[]);
                    passage.place.z = -5.0;
                    let inside = if factor < 1.0 { roots(outline, y, 1.0 - factor) } else { Vec::new() };
                    expect(&passage, [1, 0], true, &inside);
                }
            }
        }
    }
}

#[test]
fn ellipses_across_each_other() {
    // Ellipses of semi-axes (1, 0.2) and (0.3, 2): they touch side by side on the axes.
    let shapes = [[1.0, 0.2, 0.5], [0.3, 2.0, 0.5]].map(|axes| Shape::ellipsoid(axes).unwrap());
    let passage = Passage::of(shapes, Vec3::new(0.0, 0.0, 5.0));
    expect(&passage, [0, 1], false, &[-1.3, 1.3]);
    expect(&passage, [0, 1], true, &[]);
    // A disc inside the ellipse (3, 1): at the centre up to a radius of one; from the radius b^2 / a on it touches
    // at two points, at a distance of a e sqrt(1 - r^2 / b^2).
    for radius in [0.2_f64, 0.5, 0.9] {
        let shapes = [Shape::sphere(radius).unwrap(), Shape::ellipsoid([3.0, 1.0, 0.5]).unwrap()];
        let passage = Passage::of(shapes, Vec3::new(0.1, 0.0, 5.0));
        let place = if radius < 1.0 / 3.0 { 3.0 - radius } else { (8.0 * (1.0 - radius * radius)).sqrt() };
        expect(&passage, [0, 1], true, &[-place, place]);
    }
}

#[test]
fn cubes_and_spheres() {
    let cube = || Shape::Polyhedron(cuboid([-1.0; 3], [2.0; 3]));
    let sphere = |radius| Shape::sphere(radius).unwrap();
    for (y, radius) in [(0.0, 0.4), (0.5, 0.4), (1.2, 0.4), (1.3, 2.0), (1.5, 0.4)] {
        let over = f64::max(y - 1.0, 0.0);
        let places = if over < radius {
            let place = 1.0 + f64::sqrt(radius * radius - over * over);
            vec![-place, place]
        } else {
            vec![]
        };
        let before = Passage::of([sphere(radius), cube()], Vec3::new(0.2, y, 5.0));
        expect(&before, [0, 1], false, &places);
        let inside = y + radius < 1.0;
        expect(&before, [0, 1], true, &if inside { vec![radius - 1.0, 1.0 - radius] } else { vec![] });
        let behind = Passage::of([cube(), sphere(radius)], Vec3::new(0.2, y, 5.0));
        expect(&behind, [0, 1], false, &places);
        // All corners are inside the circle.
        let rest = radius * radius - (1.0 + y) * (1.0 + y);
        let place = rest.max(0.0).sqrt() - 1.0;
        expect(&behind, [0, 1], true, &if place > 0.0 { vec![-place, place] } else { vec![] });
    }
    let large = Passage::of([cube(), sphere(2.0)], Vec3::new(0.2, 0.3, 5.0));
    let place = f64::sqrt(4.0 - 1.69) - 1.0;
    expect(&large, [0, 1], true, &[-place, place]);
    let point = Passage::of([Shape::Point, cube()], Vec3::new(0.2, 0.3, 5.0));
    for total in [false, true] {
        expect(&point, [0, 1], total, &[-1.0, 1.0]);
    }
    let mut cubes = Passage::of([cube(), cube()], Vec3::new(0.2, 0.0, 5.0));
    expect(&cubes, [0, 1], false, &[-2.0, 2.0]);
    cubes.attitude[1] = [(0.125 * PI).cos(), 0.0, 0.0, (0.125 * PI).sin()];
    expect(&cubes, [0, 1], false, &[-1.0 - SQRT_2, 1.0 + SQRT_2]);
    cubes.place.y = 2.0;
    // The lowest corner of the turned square meets the highest side of the other one: |x| = 1 + (sqrt 2 - 1).
    expect(&cubes, [0, 1], false, &[-SQRT_2, SQRT_2]);
}

/// A tilted plate stands before a ball although its centre is farther away.
#[test]
fn order_of_centres_is_not_that_of_bodies() {
    let half = 0.125 * PI;
    let mut passage = Passage::of(
        [Shape::ellipsoid([4.0, 4.0, 0.05]).unwrap(), Shape::sphere(0.3).unwrap()],
        Vec3::new(0.0, 0.0, 1.6),
    );
    passage.attitude[0] = [half.cos(), 0.0, -half.sin(), 0.0];
    // The ball moves at the height of 1.6 below the plane z = x of the plate from x = 1.6 + on; it is above it before.
    passage.place.x = 3.0;
    let (system, dense) = passage.run(0.2, 2.0, false);
    // Within these times the ball is below the plate, from x = 2.6 to 3.4; the plate ends at 4 / sqrt 2 = 2.83.
    let times = |bodies, total| {
        let toward = |sign: f64| {
            let path = Spline::new("times", &[-9.0, -5.0, 5.0, 9.0], &[[0.0, 0.0, sign]; 4]).unwrap();
            Box::new(Viewpoint { path, bounded: true, distant: true, slowness: 0.0 })
        };
        [1.0, -1.0].map(|sign| {
            let [body, by] = bodies;
            let condition = Condition::Occultation { body, by, total, viewpoint: toward(sign) };
            let found = dense.crossings(&system, vec![condition], [-2.0, 2.0], &mut InterruptCheck::never());
            found.unwrap()[0].clone()
        })
    };
    // From above, the plate hides the ball until the ball comes out at the plate's edge.
    let [above, below] = times([1, 0], false);
    assert!(above.at_start < 0.0);
    assert_eq!(above.times.len(), 1);
    assert!(below.at_start > 0.0 && below.times.is_empty());
    // From below it is the other way round, to the same time.
    let [above, below_again] = times([0, 1], false);
    assert!(above.at_start > 0.0 && above.times.is_empty());
    assert_eq!(below_again.times.len(), 1);
    // The ball's outline is a circle on the major plane of symmetry of the plate's, whose semi-axis along x has the square
    // 8 + 0.05^2 / 2.
    let edge = f64::sqrt(8.0 + 0.5 * 0.05 * 0.05) + 0.3;
    assert!((3.0 + 0.2 * below_again.times[0] - edge).abs() < 1e-9, "{:?}", below_again.times);
}

/// A needle that turns many times within a step of the integrator covers a sphere's edge for a moment each time.
#[test]
fn short_events_within_long_steps() {
    let shapes = [Shape::sphere(1.0).unwrap(), Shape::ellipsoid([2.0, 0.1, 0.1]).unwrap()];
    let mut passage = Passage::of(shapes, Vec3::new(0.0, 2.9999, 5.0));
    passage.spin[1] = Vec3::new(0.0, 0.0, 3.0);
    for until in [1.0, 7.0] {
        let (system, dense) = passage.run(0.0, until, false);
        let found = crossings(&system, &dense, [0, 1], false);
        // The run lasts twice that time; the needle points at the sphere at odd multiples of pi / 6 after its start.
        let expected = (12.0 * until / PI + 1.0).floor() as usize / 2;
        assert_eq!(found.len(), 2 * expected, "{found:?}");
        for (k, pair) in found.chunks(2).enumerate() {
            let middle = 0.5 * (pair[0] + pair[1]) + until;
            assert!((middle - (2 * k + 1) as f64 * PI / 6.0).abs() < 1e-6, "{middle}");
        }
    }
}
