//! Limbs of polyhedra against the rectangle that is the outline of a box, and against differences.

use crate::facet_light::step_block;
use crate::polyhedron::cuboid;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Vec3, rotation};
use fullbody::photometry::{Limb, LimbDistance};
use fullbody::shape::Polyhedron;

/// A box about the origin with these halves of its sides.
fn centred(halves: [f64; 3]) -> Polyhedron {
    cuboid(halves.map(|half| -half), halves.map(|half| 2.0 * half))
}

fn distances(limb: &Limb, points: &[Vec3], directions: &[Vec3]) -> Vec<LimbDistance> {
    limb.distances(points, directions, &mut InterruptCheck::never()).unwrap()
}

/// The halves of the sides of a box along the axes of its own frame.
fn halves(solid: &Polyhedron) -> Vec3 {
    solid.vertices().fold(Vec3::zeros(), |most, v| most.zip_map(&v, |m, x| f64::max(m, x.abs())))
}

#[test]
fn distances_from_the_outline_of_a_box_are_those_from_a_rectangle() {
    let solid = centred([1.0, 2.0, 3.0]);
    let (limb, half) = (Limb::new(solid.clone()), halves(&solid));
    // A direction that is a little off the axis chooses one of the two edges behind each other.
    let u = Vec3::new(1e-9, 2e-9, 1.0).normalize();
    let rectangle = |x: f64, y: f64| {
        let (dx, dy) = (x.abs() - half.x, y.abs() - half.y);
        if dx <= 0.0 && dy <= 0.0 { dx.max(dy) } else { dx.max(0.0).hypot(dy.max(0.0)) }
    };
    for (x, y) in
        [(0.1, 0.3), (-0.9, 0.2), (2.0 * half.x, 0.4), (0.3, -3.0 * half.y), (half.x + 0.3, half.y + 0.4)]
    {
        let ray = distances(&limb, &[Vec3::new(x, y, -7.0)], &[u])[0];
        let expected = rectangle(x + 7.0 * 1e-9, y + 7.0 * 2e-9);
        assert!((ray.distance - expected).abs() < 2e-8, "{x} {y}: {} {expected}", ray.distance);
    }
}

#[test]
fn derivatives_of_the_distance_are_differences() {
    let solid = centred([1.0, 1.7, 2.9]);
    let limb = Limb::new(solid);
    let step = 1e-6;
    for (u, point) in [
        (Vec3::new(0.3, 0.5, 0.8), Vec3::new(0.2, -0.1, 0.4)),
        (Vec3::new(-0.6, 0.2, 0.7), Vec3::new(3.0, 1.0, -2.0)),
        // The nearest point is a corner.
        (Vec3::new(0.1, -0.2, 0.9), Vec3::new(4.0, 5.0, 1.0)),
    ] {
        let u = u.normalize();
        let ray = distances(&limb, &[point], &[u])[0];
        for k in 0..3 {
            let shift = Vec3::from_fn(|i, _| if i == k { step } else { 0.0 });
            let along = |point: Vec3, u: Vec3| distances(&limb, &[point], &[u])[0].distance;
            let by_point = (along(point + shift, u) - along(point - shift, u)) / (2.0 * step);
            assert!((ray.by_point[k] - by_point).abs() < 1e-8);
            // The direction stays a unit vector to first order across it.
            let across = shift - u * u.dot(&shift);
            let turned = |sign: f64| along(point, (u + across * sign).normalize());
            let by_direction = (turned(1.0) - turned(-1.0)) / (2.0 * step);
            assert!((ray.by_direction.dot(&across) / step - by_direction).abs() < 1e-7);
        }
    }
}

/// A step is seen from above, so that its riser is turned away: its edge and its foot are within the outline.
#[test]
fn edges_within_the_outline_do_not_count() {
    let depth = 100.0;
    let solid = step_block(depth, 1.0, 2.0);
    // The polyhedron's own frame is that of its principal axes.
    let frame = solid.working_frame();
    let rotation = rotation::matrix(frame.attitude);
    let slope = -0.3_f64;
    let u = rotation * Vec3::new(slope, 0.0, 1.0).normalize();
    // The height across u of (x, z) is (x + 0.3 z) / 1.09^(1/2): the outline goes from 0 to 2.3, the riser from 1.3
    // to 1.6.
    let scale = (1.0 + slope * slope).sqrt();
    let limb = Limb::new(solid);
    for height in [0.4, 1.2, 1.4, 1.5, 1.7, 2.2, 2.6] {
        let point = rotation * Vec3::new(height, 0.5 * depth, 0.0) + frame.position;
        let expected = f64::max(-height, height - 2.3) / scale;
        let ray = distances(&limb, &[point], &[u])[0];
        assert!((ray.distance - expected).abs() < 1e-9, "{height}: {} {expected}", ray.distance);
    }
}

#[test]
fn a_path_across_a_box_crosses_two_of_its_edges() {
    let solid = centred([1.0, 2.0, 3.0]);
    let (limb, half) = (Limb::new(solid.clone()), halves(&solid));
    let u = Vec3::new(1e-12, 2e-12, 1.0).normalize();
    let start = [Vec3::new(-4.0, 0.3, 0.0), Vec3::new(-4.0, 9.0, 0.0)];
    let way = [Vec3::new(8.0, 0.0, 0.0); 2];
    let (rays, shares) = limb.crossings(&start, &[u, u], &way, &mut InterruptCheck::never()).unwrap();
    assert_eq!(rays, [0, 0]);
    for (share, x) in shares.iter().zip([-half.x, half.x]) {
        assert!((share - (x + 4.0) / 8.0).abs() < 1e-10);
    }
    // The rectangle has four sides, and those of a box that is seen askew are six.
    let length: f64 = limb.edges(&u).iter().map(|[a, b]| (b - a - u * u.dot(&(b - a))).norm()).sum();
    assert!((length - 4.0 * (half.x + half.y)).abs() < 1e-9);
    assert_eq!(limb.edges(&Vec3::new(0.5, 0.6, 0.7).normalize()).len(), 6);
}

#[test]
fn rays_with_one_direction_and_with_many_have_the_same_distances() {
    let limb = Limb::new(centred([1.0, 2.0, 3.0]));
    let [u, v] = [Vec3::new(0.3, 0.5, 0.8).normalize(), Vec3::new(-0.6, 0.2, 0.7).normalize()];
    let points: Vec<Vec3> = (0..6).map(|k| Vec3::new(0.7 * f64::from(k), 0.2, -0.4)).collect();
    let directions = [u, u, v, v, u, v];
    let together = distances(&limb, &points, &directions);
    for (k, distance) in together.iter().enumerate() {
        assert_eq!(*distance, distances(&limb, &points[k..=k], &directions[k..=k])[0]);
    }
}
