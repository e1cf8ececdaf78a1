//! Postures per second, one thread, forward kinematics included: which hit, how far away they
//! are, and inverse kinematics that keeps clear.
//!
//! One iteration is many postures or targets, so that the reported rate is that of them.
#![allow(clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use agrik::call::{Aim, Goals, Guard, Prefer, Request, Starts, Tolerance, solve};
use agrik::kinematics::tool_poses;
use agrik::solvers::Solver;
use agrik::task::Task;
use agrik_motion::Free;
use common::{collider, random_postures};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

const POSTURES: usize = 2000;

/// The cap of the paper's cost, m.
const CAP: f64 = 0.075;

const SCENES: [(&str, &str); 2] =
    [("cucumber", "scene greenhouse1 greenhouse2"), ("panda", "bench wall greenhouse5")];

fn postures(criterion: &mut Criterion) {
    for (name, scenes) in SCENES {
        for scene in scenes.split(' ') {
            let collider = collider(name, scene);
            let chain = collider.bodies().chain();
            let q = random_postures(chain, POSTURES, 1);
            let hits = collider.collides(&q, 0.0, 1, &mut || true).unwrap();
            let free: Vec<f64> = q
                .chunks(chain.dof())
                .zip(&hits)
                .filter(|(_, hit)| !**hit)
                .flat_map(|(q, _)| q)
                .copied()
                .collect();
            let share = free.len() as f64 / q.len() as f64;
            println!("{name}/{scene}: {:.0} % of the postures are free", 100.0 * share);
            let mut group = criterion.benchmark_group(format!("{name}/{scene}"));
            group.sample_size(20);
            for (kind, q) in [("any", &q), ("free", &free)] {
                let id = |what: &str| BenchmarkId::new(what, kind);
                let rows = q.len() / chain.dof();
                group.throughput(Throughput::Elements(rows as u64));
                group.bench_function(id("hits"), |b| {
                    b.iter(|| collider.collides(q, 0.0, 1, &mut || true));
                });
                group.bench_function(id("capped"), |b| {
                    b.iter(|| collider.clearances(q, CAP, true, 1, &mut || true));
                });
                group.bench_function(id("distance"), |b| {
                    b.iter(|| collider.clearances(q, f64::INFINITY, false, 1, &mut || true));
                });
            }
            group.finish();
        }
    }
}

fn inverse_kinematics(criterion: &mut Criterion) {
    for (name, scenes) in SCENES {
        for scene in scenes.split(' ') {
            let collider = collider(name, scene);
            let chain = collider.bodies().chain();
            let q = random_postures(chain, 2 * POSTURES, 2);
            let hits = collider.collides(&q, 0.0, 1, &mut || true).unwrap();
            let free = q.chunks(chain.dof()).zip(&hits).filter(|(_, hit)| !**hit);
            let free: Vec<f64> = free.flat_map(|(q, _)| q).copied().collect();
            let mut poses = vec![0.0; free.len() / chain.dof() * 16];
            tool_poses(chain, &free, &mut poses);
            let goals = Goals::Poses(poses.as_chunks().0);
            let aim = Aim::new(chain, Task::Pose, Tolerance::default(), None).unwrap();
            let request = Request::new(chain, aim, goals, Starts::Free).unwrap();
            let mut group = criterion.benchmark_group(format!("{name}/{scene}/ik"));
            group.throughput(Throughput::Elements(request.len() as u64)).sample_size(10);
            let accept = Free::new(&collider, 0.0).unwrap();
            let mut of = |what: &str, request: Request<'_>| {
                group.bench_function(what, |b| {
                    b.iter(|| {
                        let call = Solver::default().call(request).unwrap();
                        solve(&call, 1, &mut || true)
                    });
                });
            };
            of("plain", request);
            for (prefer_name, prefer) in Prefer::ALL {
                of(prefer_name, request.with_guard(Guard { accept: &accept, prefer }));
            }
            group.finish();
        }
    }
}

criterion_group!(benches, postures, inverse_kinematics);
criterion_main!(benches);
