//! How much of a core's floating-point peak the solver's loop reaches at each level.
//!
//! The peak is measured: independent chains of fused multiply-adds in registers. The loop's
//! operations are counted, not estimated: it runs once over a number type that counts, then
//! over the vectors against the clock. Only work for targets counts; lanes that idle, the
//! choice of start postures (single precision) and everything else lower the share.

mod common;

use std::hint::black_box;
use std::time::Instant;

use agrik::call::Answers;
use agrik::call::solve_at;
use agrik::lanes::{Kernel, Level, Real, dispatch};
use agrik::solve::{Plan, run};
use common::arms::{ARMS, arm, poses};
use common::counted::{Counted, take_operations};
use common::{Width, levels, pose_plan};

/// Chains of multiply-adds: enough to fill the pipelines, few enough for 16 registers.
const CHAINS: usize = 12;
const ROUNDS: u32 = 1 << 20;
/// Many short repeats: a busy machine interrupts some of them, rarely all.
const REPEATS: usize = 60;
const TARGETS: usize = 2_000;

/// `ROUNDS` multiply-adds in each chain.
struct MultiplyAdds;

impl Kernel for MultiplyAdds {
    type Output = f64;
    #[inline(always)]
    fn run<R: Real>(self) -> f64 {
        let factor = R::splat(black_box(0.999_999));
        let term = R::splat(black_box(1e-6));
        let mut sums = [R::splat(black_box(0.5)); CHAINS];
        for _ in 0..ROUNDS {
            for sum in &mut sums {
                *sum = sum.mul_add(factor, term);
            }
        }
        let mut total = R::zero();
        for sum in sums {
            total += sum;
        }
        // All lanes hold the same number, but the compiler is not to know.
        total.lane(black_box(0))
    }
}

/// The same on pairs of numbers, with baseline instructions.
fn pairs_of_multiply_adds() -> f64 {
    let (factor, term) = (black_box(0.999_999), black_box(1e-6));
    let mut sums = [[black_box(0.5); 2]; CHAINS];
    for _ in 0..ROUNDS {
        for sum in &mut sums {
            *sum = [sum[0] * factor + term, sum[1] * factor + term];
        }
    }
    sums.iter().fold(0.0, |total, sum| total + sum[black_box(0)])
}

/// The shortest of several times, s: what the machine does when it is left alone.
fn shortest(mut work: impl FnMut()) -> f64 {
    (0..REPEATS)
        .map(|_| {
            let started = Instant::now();
            work();
            started.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Operations per second of a level's multiply-adds on one core.
fn peak(level: Level) -> f64 {
    if level == Level::Scalar {
        // The solver's loop takes one number at a time there, but the baseline's registers
        // hold two; asked for pairs, the compiler uses them without repacking.
        return rate(2, pairs_of_multiply_adds);
    }
    rate(dispatch(level, Width), || dispatch(level, MultiplyAdds))
}

fn rate(lanes: usize, multiply_adds: impl Fn() -> f64) -> f64 {
    let operations = 2.0 * f64::from(ROUNDS) * (CHAINS * lanes) as f64;
    let seconds = shortest(|| {
        black_box(multiply_adds());
    });
    operations / seconds
}

/// Operations per target and per step of the loop.
fn count(plan: &Plan<'_>) -> (f64, f64) {
    let mut answers = Answers::new(plan.request().len(), plan.request().chain().dof());
    take_operations();
    let mut rows = Some(answers.as_mut());
    run::<Counted>(plan, &mut || rows.take(), &mut || true);
    let operations = take_operations() as f64;
    let steps: u32 = answers.iterations.iter().sum();
    (operations / plan.request().len() as f64, operations / f64::from(steps))
}

fn main() {
    println!("One core; operations are double-precision, a multiply-add counts two.");
    let peaks: Vec<_> = levels().into_iter().map(|level| (level, peak(level))).collect();
    println!("\n| level | peak, Gflop/s |\n|---|---:|");
    for (level, peak) in &peaks {
        println!("| {} | {:.1} |", level.name(), peak * 1e-9);
    }
    println!(
        "\n| robot, full pose | level | flop per target | flop per step | us per target \
         | solved | Gflop/s | share of peak |\n|---|---|---:|---:|---:|---:|---:|---:|"
    );
    for name in ARMS {
        let chain = arm(name);
        let targets = poses(&chain, TARGETS, 5);
        let plan = pose_plan(&chain, &targets);
        let (per_target, per_step) = count(&plan);
        for (level, peak) in &peaks {
            let mut solved = 0;
            let seconds = shortest(|| {
                if let Ok(answers) = solve_at(*level, &plan, 1, &mut || true) {
                    solved = (0..TARGETS).filter(|&row| answers.success(row)).count();
                }
            }) / TARGETS as f64;
            let rate = per_target / seconds;
            println!(
                "| {name} | {} | {per_target:.0} | {per_step:.0} | {:.3} | {:.3} % | {:.2} | {:.1} % |",
                level.name(),
                seconds * 1e6,
                100.0 * solved as f64 / TARGETS as f64,
                rate * 1e-9,
                100.0 * rate / peak,
            );
        }
    }
}
