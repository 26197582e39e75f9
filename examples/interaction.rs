//! Evaluates one interaction many times: `interaction METHOD PATH COUNT`, for counting instructions.

use fullbody::math::lanes::VectorPath;
use fullbody::math::{Vec3, rotation};
use fullbody::mutual::{BodyGravity, Pair, Pose};
use fullbody::shape::Shape;
use std::hint::black_box;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [method, path, count] = arguments.as_slice() else {
        return Err("usage: interaction METHOD PATH COUNT".into());
    };
    let path = match path.as_str() {
        "portable" => VectorPath::Portable,
        "avx2" => VectorPath::Avx2,
        "avx512" => VectorPath::Avx512,
        other => return Err(format!("path is {other}; expected portable, avx2 or avx512").into()),
    };
    let alpha = BodyGravity::new("Alpha", &Shape::ellipsoid([0.766, 0.7475, 0.6735])?);
    let beta = BodyGravity::new("Beta", &Shape::ellipsoid([0.285, 0.2315, 0.1745])?);
    let pose = Pose {
        separation: Vec3::new(2.0, 1.2, 0.9),
        rotation_first: rotation::tait_bryan_matrix([0.2, -0.35, 0.9]),
        rotation_second: rotation::tait_bryan_matrix([-0.5, 0.4, 1.7]),
    };
    let arch = path.arch().ok_or("this machine lacks that path")?;
    let mut pair = Pair::new(alpha, beta, method.parse()?, 1e-14, None, arch);
    pair.prepare(&pose, 0.0)?;
    for _ in 0..count.parse::<usize>()? {
        black_box(pair.interaction(black_box(&pose)));
    }
    Ok(())
}
