//! Time of one interaction by method and vector path, for the first configuration of the reference file.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Vec3, rotation};
use fullbody::mutual::{Method, Pair, PartGravity, Pose};
use fullbody::shape::Shape;
use std::hint::black_box;
use std::sync::Arc;

fn pair(method: Method, tolerance: f64, path: VectorPath, pose: &Pose) -> Option<Pair> {
    let store = Arc::default();
    let body = |name, axes| Some(PartGravity::new(name, &Shape::ellipsoid(axes).ok()?, &store));
    let (alpha, beta) = (body("Alpha", [0.766, 0.7475, 0.6735])?, body("Beta", [0.285, 0.2315, 0.1745])?);
    let mut pair = Pair::new(alpha, beta, method, tolerance, None, path.arch()?);
    pair.prepare(pose, 0.0, &mut InterruptCheck::never()).ok()?;
    Some(pair)
}

fn interaction(c: &mut Criterion) {
    let pose = Pose {
        separation: Vec3::new(2.0, 1.2, 0.9),
        rotation_first: rotation::tait_bryan_matrix([0.2, -0.35, 0.9]),
        rotation_second: rotation::tait_bryan_matrix([-0.5, 0.4, 1.7]),
    };
    let mut group = c.benchmark_group("interaction");
    for method in
        [Method::Focal, Method::Surface, Method::Multipole(2), Method::Multipole(4), Method::Multipole(8)]
    {
        for path in VectorPath::available() {
            let Some(pair) = pair(method, 1e-13, path, &pose) else { continue };
            group.bench_function(BenchmarkId::new(method.to_string(), format!("{path:?}")), |b| {
                b.iter(|| pair.interaction(black_box(&pose)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, interaction);
criterion_main!(benches);
