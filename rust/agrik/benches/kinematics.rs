//! Forward kinematics and the Jacobian: one posture at a time, and a batch of postures in
//! the lanes of each instruction set.

mod common;

use std::hint::black_box;

use agrik::chain::Chain;
use agrik::kinematics::{Workspace, columns, forward, tool_jacobians, tool_pose};
use agrik::lanes::{Kernel, Real, dispatch};
use common::arms::{ARMS, arm, postures};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const POSTURES: usize = 1024;

/// The tool's pose, and with `jacobian` its derivative too, at every posture.
struct Batch<'a> {
    chain: &'a Chain,
    /// One joint after the other, all postures of each.
    q: &'a [f64],
    jacobian: bool,
    /// What keeps the compiler from leaving results out.
    sum: &'a mut f64,
}

impl Kernel for Batch<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let compiled = self.chain.compiled();
        let mut workspace = Workspace::<R>::new(compiled);
        let mut q = vec![R::zero(); compiled.dof];
        let mut sum = R::zero();
        for first in (0..POSTURES).step_by(R::WIDTH) {
            for (joint, value) in q.iter_mut().enumerate() {
                for lane in 0..R::WIDTH {
                    value.set_lane(lane, self.q[joint * POSTURES + first + lane]);
                }
            }
            forward(compiled, &q, &mut workspace);
            let point = workspace.tool_point(compiled.tail.translation);
            if self.jacobian {
                columns(compiled, &workspace, point, |_, linear, angular| {
                    for k in 0..3 {
                        sum += linear[k] + angular[k];
                    }
                });
            }
            let axes = workspace.tool_axes(&compiled.tail.rotation);
            for k in 0..3 {
                sum += point[k] + axes[0][k] + axes[1][k] + axes[2][k];
            }
        }
        for lane in 0..R::WIDTH {
            *self.sum += sum.lane(lane);
        }
    }
}

fn kinematics(criterion: &mut Criterion) {
    for name in ARMS {
        let chain = arm(name);
        let dof = chain.dof();
        let rows = postures(&chain, POSTURES, 1);
        let mut workspace = Workspace::new(chain.compiled());

        let mut group = criterion.benchmark_group(format!("{name}/one posture"));
        group.bench_function("fk", |bench| {
            let mut next = rows.chunks(dof).cycle();
            bench.iter(|| next.next().map(|q| tool_pose(&chain, black_box(q), &mut workspace)));
        });
        group.bench_function("jacobian", |bench| {
            let mut next = rows.chunks(dof).cycle();
            let mut out = vec![0.0; 6 * dof];
            bench.iter(|| {
                if let Some(q) = next.next() {
                    tool_jacobians(&chain, black_box(q), &mut out);
                }
                out[0]
            });
        });
        group.finish();

        let by_joint: Vec<f64> =
            (0..dof).flat_map(|joint| rows.iter().skip(joint).step_by(dof).copied()).collect();
        for (what, jacobian) in [("fk", false), ("fk and jacobian", true)] {
            let mut group = criterion.benchmark_group(format!("{name}/{what}, batch"));
            group.throughput(Throughput::Elements(POSTURES as u64));
            for level in common::levels() {
                group.bench_function(level.name(), |bench| {
                    bench.iter(|| {
                        let mut sum = 0.0;
                        let q = black_box(&by_joint[..]);
                        dispatch(level, Batch { chain: &chain, q, jacobian, sum: &mut sum });
                        sum
                    });
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, kinematics);
criterion_main!(benches);
