//! The interaction of a pair against arbitrary precision.

use crate::support::*;
use fullbody::math::Vec3;
use fullbody::math::lanes::VectorPath;
use fullbody::mutual::{BodyGravity, Method, Pair, Pose};
use fullbody::quadrature::Order;
use fullbody::shape::Shape;

fn pair(a: [f64; 3], b: [f64; 3], method: Method, order: Option<Order>) -> Pair {
    let gravity = |name, axes| BodyGravity::new(name, &Shape::ellipsoid(axes).unwrap());
    Pair::new(gravity("A", a), gravity("B", b), method, 1e-15, order, VectorPath::Auto.arch().unwrap())
}

#[test]
fn reference_values() {
    for case in data("mutual_forces.json").as_array().unwrap() {
        let pose = Pose {
            separation: Vec3::from(triple(&case["separation"])),
            rotation_first: attitude(&case["angles_a"]),
            rotation_second: attitude(&case["angles_b"]),
        };
        for method in [Method::Surface, Method::Focal, Method::Multipole(16)] {
            let mut pair = pair(triple(&case["axes_a"]), triple(&case["axes_b"]), method, None);
            pair.prepare(&pose, 0.0).unwrap();
            let f = pair.interaction(&pose);
            println!(
                "{} {method} nodes {:?}: F {:.1e} Ta {:.1e} Tb {:.1e} U {:.1e}",
                case["name"],
                pair.rule().map(|r| (r.nodes(), r.integrated)),
                relative(&f.force_on_first, &Vec3::from(triple(&case["force_on_a_inertial"]))),
                relative(&f.torque_first, &Vec3::from(triple(&case["torque_on_a_body"]))),
                relative(&f.torque_second, &Vec3::from(triple(&case["torque_on_b_body"]))),
                pair.potential_energy(&pose) / number(&case["potential_energy"]) - 1.0
            );
        }
    }
}
