//! The solver: one Levenberg-Marquardt step, one target, a batch of targets, each with the
//! instructions of every level of this machine.

mod common;

use std::hint::black_box;

use agrik::call::solve_at;
use agrik::chain::Chain;
use agrik::kinematics::{Workspace, columns, forward};
use agrik::lanes::{Kernel, Real, dispatch};
use agrik::solve::{Lengths, Settings};
use common::arms::{ARMS, arm, poses, postures};
use common::{Width, levels, pose_plan};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const STEPS: usize = 256;
const TARGETS: usize = 4096;

/// Steps from one and the same posture, the error a little different each time.
struct Steps<'a> {
    chain: &'a Chain,
    q: &'a [f64],
    sum: &'a mut f64,
}

impl Kernel for Steps<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let compiled = self.chain.compiled();
        let mut workspace = Workspace::<R>::new(compiled);
        let mut q = Vec::with_capacity(self.q.len());
        for x in self.q {
            q.push(R::splat(*x));
        }
        forward(compiled, &q, &mut workspace);
        let tool = workspace.tool_point(compiled.tail.translation);
        let mut jacobian = vec![[R::zero(); 6]; compiled.dof];
        columns(compiled, &workspace, tool, |variable, linear, angular| {
            let [a, b, c] = linear;
            let [d, e, f] = angular;
            jacobian[variable] = [a, b, c, d, e, f];
        });
        let mut change = vec![R::zero(); compiled.dof];
        let mut error = [R::splat(0.1); 6];
        let step = Settings::LEVENBERG_MARQUARDT.step;
        let lengths = Lengths::new(1.0, false);
        for _ in 0..STEPS {
            step.compute(&jacobian, &error, &lengths, &mut change);
            error[0] = change[0];
        }
        *self.sum += error[0].lane(0);
    }
}

fn step(criterion: &mut Criterion) {
    for name in ARMS {
        let chain = arm(name);
        let q = postures(&chain, 1, 2);
        let mut group = criterion.benchmark_group(format!("{name}/lm step, all lanes"));
        for level in levels() {
            group.throughput(Throughput::Elements((STEPS * dispatch(level, Width)) as u64));
            group.bench_function(level.name(), |bench| {
                bench.iter(|| {
                    let mut sum = 0.0;
                    dispatch(level, Steps { chain: &chain, q: black_box(&q), sum: &mut sum });
                    sum
                });
            });
        }
        group.finish();
    }
}

fn one_target(criterion: &mut Criterion) {
    for name in ARMS {
        let chain = arm(name);
        let targets = poses(&chain, TARGETS, 3);
        let mut group = criterion.benchmark_group(format!("{name}/one target"));
        for level in levels() {
            group.bench_function(level.name(), |bench| {
                // A different target each time: the mean over them is what is measured.
                let mut next = targets.chunks(1).cycle();
                bench.iter(|| {
                    next.next().map(|one| {
                        let plan = pose_plan(&chain, black_box(one));
                        solve_at(level, &plan, 1, &mut || true)
                    })
                });
            });
        }
        group.finish();
    }
}

fn batches(criterion: &mut Criterion) {
    for name in ARMS {
        let chain = arm(name);
        let targets = poses(&chain, TARGETS, 4);
        let plan = pose_plan(&chain, &targets);
        let mut group = criterion.benchmark_group(format!("{name}/batch"));
        group.throughput(Throughput::Elements(TARGETS as u64));
        group.sample_size(20);
        for level in levels() {
            let solve = |threads| solve_at(level, &plan, threads, &mut || true);
            if let Ok(answers) = solve(1) {
                let solved = (0..answers.len()).filter(|&row| answers.success(row)).count();
                println!("{name}, {}: {solved} of {TARGETS} targets solved", level.name());
            }
            for threads in [1, 2] {
                group.bench_function(format!("{}, threads={threads}", level.name()), |bench| {
                    bench.iter(|| solve(threads));
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, step, one_target, batches);
criterion_main!(benches);
