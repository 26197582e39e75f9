//! Time of the brightness of ellipsoids: of one alone, and of a pair during an event, without and with
//! derivatives.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::photometry::{Law, Photometer, Surface, View};
use fullbody::shape::{Body, Shape};
use std::hint::black_box;

const EPOCHS: usize = 1000;

fn photometer(count: usize) -> Option<Photometer> {
    let axes = [("Alpha", [1.0, 0.8, 0.6]), ("Beta", [0.4, 0.35, 0.3])];
    let body = |(name, axes)| Body::with_mass(name, Shape::ellipsoid(axes).ok()?, 1.0).ok();
    let bodies = axes.into_iter().take(count).map(body).collect::<Option<Vec<_>>>()?;
    let surface = Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![1.0] };
    Photometer::new(bodies, vec![surface; count], true, 0.0).ok()
}

fn brightness(c: &mut Criterion) {
    // The second body passes before the first one, and its shadow follows.
    let positions_at = |k: usize| {
        let y = -1.3 + 2.6 * k as f64 / (EPOCHS - 1) as f64;
        [Vec3::zeros(), Vec3::new(3.0, y, 0.2)]
    };
    let (positions, attitudes): (Vec<_>, _) = ((0..EPOCHS).map(positions_at).collect(), [[0.9, 0.1, 0.3, 0.2]; 2]);
    let never = &mut InterruptCheck::never();
    let mut group = c.benchmark_group("brightness");
    group.throughput(Throughput::Elements(EPOCHS as u64));
    for count in [1, 2] {
        let Some(photometer) = photometer(count) else { continue };
        let views: Vec<_> = positions
            .iter()
            .map(|position| View {
                time: 0.0,
                position: &position[..count],
                attitude: &attitudes[..count],
                velocity: &[],
                to_observer: Vec3::x(),
                to_sun: Vec3::new(1.0, 0.15, 0.05),
                distant: true,
            })
            .collect();
        group.bench_function(BenchmarkId::new("values", count), |b| {
            b.iter(|| photometer.brightness_in(black_box(&views), never).is_ok());
        });
        group.bench_function(BenchmarkId::new("derivatives", count), |b| {
            b.iter(|| photometer.partials_in(black_box(&views), false, never).is_ok());
        });
    }
    group.finish();
}

criterion_group!(benches, brightness);
criterion_main!(benches);
