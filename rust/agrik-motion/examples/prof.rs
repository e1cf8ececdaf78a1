#![allow(clippy::unwrap_used, missing_docs)]
#[path = "../tests/common/mod.rs"]
mod common;
use agrik::call::*;
use agrik::kinematics::tool_poses;
use agrik::solvers::Solver;
use agrik::task::Task;
use agrik_motion::Free;
use common::{collider, random_postures};
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap()
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let (name, scene, what) = (&a[1], &a[2], &a[3]);
    let reps: usize = a[4].parse().unwrap();
    let c = collider(name, scene);
    let chain = c.bodies().chain().clone();
    let q = random_postures(&chain, 4000, 1);
    let hits = c.collides(&q, 0.0, 1, &mut || true).unwrap();
    let free: Vec<f64> =
        q.chunks(7).zip(&hits).filter(|(_, h)| !**h).flat_map(|(q, _)| q).copied().collect();
    let mut poses = vec![0.0; free.len() / 7 * 16];
    tool_poses(&chain, &free, &mut poses);
    let goals = Goals::Poses(poses.as_chunks().0);
    let aim = Aim::new(&chain, Task::Pose, Tolerance::default(), None).unwrap();
    let request = Request::new(&chain, aim, goals, Starts::Free).unwrap();
    let accept = Free::new(&c, 0.0).unwrap();
    let t = cpu();
    let mut n = 0;
    for _ in 0..reps {
        match &what[..] {
            "any" => {
                n += q.len() / 7;
                c.collides(&q, 0.0, 1, &mut || true).unwrap();
            }
            "free" => {
                n += free.len() / 7;
                c.collides(&free, 0.0, 1, &mut || true).unwrap();
            }
            "scene" => {
                n += free.len() / 7;
                let mut p = c.bodies().room();
                for q in free.chunks(7) {
                    c.bodies().place(q, &mut p).unwrap();
                    std::hint::black_box(c.hits_scene(&p, 0.0));
                }
            }
            "own" => {
                n += free.len() / 7;
                let mut p = c.bodies().room();
                for q in free.chunks(7) {
                    c.bodies().place(q, &mut p).unwrap();
                    std::hint::black_box(c.hits_itself(&p));
                }
            }
            "place" => {
                n += free.len() / 7;
                let mut p = c.bodies().room();
                for q in free.chunks(7) {
                    c.bodies().place(q, &mut p).unwrap();
                    std::hint::black_box(&p);
                }
            }
            "one" => {
                n += free.len() / 7;
                for q in free.chunks(7) {
                    std::hint::black_box(accept.accepts(q));
                }
            }
            "capped" => {
                n += q.len() / 7;
                c.clearances(&q, 0.075, true, 1, &mut || true).unwrap();
            }
            "dist" => {
                n += q.len() / 7;
                c.clearances(&q, f64::INFINITY, false, 1, &mut || true).unwrap();
            }
            "plain" => {
                n += request.len();
                solve(&Solver::default().call(request).unwrap(), 1, &mut || true).unwrap();
            }
            "ik" => {
                n += request.len();
                let r = solve(
                    &Solver::default()
                        .call(request.with_guard(Guard { accept: &accept, prefer: Prefer::First }))
                        .unwrap(),
                    1,
                    &mut || true,
                )
                .unwrap();
                if n == request.len() {
                    println!("restarts {}", r.restarts.iter().sum::<u32>() as f64 / n as f64);
                }
            }
            _ => panic!(),
        }
    }
    println!("{name} {scene} {what}: {:.0} ns", (cpu() - t) / n as f64);
}
