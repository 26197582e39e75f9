//! Evaluates one interaction many times: `interaction METHOD TOLERANCE PATH COUNT`. Prints the number of
//! nodes and the seconds that one took; also for counting instructions.

use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Vec3, rotation};
use fullbody::mutual::{Pair, PartGravity, Pose};
use fullbody::names::Named;
use fullbody::shape::Shape;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [method, tolerance, path, count] = arguments.as_slice() else {
        return Err("usage: interaction METHOD TOLERANCE PATH COUNT".into());
    };
    let arch = VectorPath::named(path)?.arch().ok_or("this machine lacks that path")?;
    let count: u32 = count.parse()?;
    let store = Arc::default();
    let alpha = PartGravity::new("Alpha", &Shape::ellipsoid([0.766, 0.7475, 0.6735])?, &store);
    let beta = PartGravity::new("Beta", &Shape::ellipsoid([0.285, 0.2315, 0.1745])?, &store);
    let pose = Pose {
        separation: Vec3::new(2.0, 1.2, 0.9),
        rotation_first: rotation::tait_bryan_matrix([0.2, -0.35, 0.9]),
        rotation_second: rotation::tait_bryan_matrix([-0.5, 0.4, 1.7]),
    };
    let mut pair = Pair::new(alpha, beta, method.parse()?, tolerance.parse()?, None, arch);
    pair.prepare(&pose, 0.0, &mut InterruptCheck::never())?;
    let started = Instant::now();
    for _ in 0..count {
        black_box(pair.interaction(black_box(&pose)));
    }
    let seconds = started.elapsed().as_secs_f64() / f64::from(count.max(1));
    println!("{} {seconds:e}", pair.rule().map_or(0, |rule| rule.nodes()));
    Ok(())
}
