//! scratch tuning
use agrik::chain::*;
use agrik::solve::*;
use agrik::task::*;
use agrik::{batch, kinematics};
use nalgebra::IsometryMatrix3;
pub fn robot(name: &str) -> Chain {
    const P: f64 = std::f64::consts::FRAC_PI_2;
    let d2r = std::f64::consts::PI / 180.0;
    let (rows, lo, hi): (Vec<[f64; 4]>, Vec<f64>, Vec<f64>) = match name {
        "R7" => {
            let l: [f64; 7] = [170., 120., 170., 120., 170., 120., 175.];
            (
                vec![
                    [0., -P, 0.34, 0.],
                    [0., P, 0., 0.],
                    [0., -P, 0.4, 0.],
                    [0., P, 0., 0.],
                    [0., -P, 0.4, 0.],
                    [0., P, 0., 0.],
                    [0., 0., 0.126, 0.],
                ],
                l.iter().map(|x| -x * d2r).collect(),
                l.iter().map(|x| x * d2r).collect(),
            )
        }
        "H6" => (
            vec![
                [0.07, P, 0., 0.],
                [0.5234, 0., 0., 0.],
                [0.165, -P, 0., 0.],
                [0.04445, P, -0.212, 0.],
                [0.184, -P, 0., -P],
                [0., 0., 0.2848, -P],
            ],
            [-27.07, -10.32, -42.01, -63.94, -81.52, -260.].map(|x: f64| x * d2r).to_vec(),
            [40.60, 65.64, 21.43, 114.97, -4.16, 260.].map(|x: f64| x * d2r).to_vec(),
        ),
        "P6" => (
            vec![
                [0., P, 0.6718, 0.],
                [0.4318, 0., 0., 0.],
                [0.0203, -P, 0.15005, 0.],
                [0., P, 0.4318, 0.],
                [0., -P, 0., 0.],
                [0., 0., 0., 0.],
            ],
            [-160., -110., -135., -266., -100., -266.].map(|x: f64| x * d2r).to_vec(),
            [160., 110., 135., 266., 100., 266.].map(|x: f64| x * d2r).to_vec(),
        ),
        "UR5" => (
            vec![
                [0., P, 0.089159, 0.],
                [-0.425, 0., 0., 0.],
                [-0.39225, 0., 0., 0.],
                [0., P, 0.10915, 0.],
                [0., -P, 0.09465, 0.],
                [0., 0., 0.0823, 0.],
            ],
            vec![-2.0 * P; 6],
            vec![2.0 * P; 6],
        ),
        _ => (
            vec![
                [0., -P, 0.333, 0.],
                [0., P, 0., 0.],
                [0.0825, P, 0.316, 0.],
                [-0.0825, -P, 0., 0.],
                [0., P, 0.384, 0.],
                [0.088, P, 0., 0.],
                [0., 0., 0.107, 0.],
            ],
            vec![-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973],
            vec![2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973],
        ),
    };
    let joints = rows
        .iter()
        .enumerate()
        .map(|(i, r)| {
            DhRow { a: r[0], alpha: r[1], d: r[2], theta: r[3] }.joint(
                DhConvention::Standard,
                format!("j{i}"),
                JointKind::Revolute,
                lo[i],
                hi[i],
            )
        })
        .collect();
    Chain::new(name, joints, IsometryMatrix3::identity(), IsometryMatrix3::identity(), None)
        .unwrap()
}
pub fn targets(c: &Chain, n: usize) -> Vec<[f64; 16]> {
    let mut s: u64 = 12345;
    let mut u = || {
        s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let x = s >> 33;
        (x as f64) / ((1u64 << 31) as f64)
    };
    let mut w = kinematics::Workspace::new(c.compiled());
    (0..n)
        .map(|_| {
            let q: Vec<f64> =
                c.variables().iter().map(|v| v.lower + (v.upper - v.lower) * u()).collect();
            let t = kinematics::tool_pose(c, &q, &mut w);
            let mut a = [0.0; 16];
            for i in 0..4 {
                for j in 0..4 {
                    a[i * 4 + j] = t[(i, j)];
                }
            }
            a
        })
        .collect()
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: usize = args.get(1).map_or(20000, |x| x.parse().unwrap());
    let th: usize = std::env::var("TH").map_or(1, |x| x.parse().unwrap());
    let mut settings = Settings::default();
    if let Ok(d) = std::env::var("DAMP") {
        settings.step = Step::LevenbergMarquardt { damping: d.parse().unwrap() };
    }
    if let Ok(d) = std::env::var("IT") {
        settings.max_iterations = d.parse().unwrap();
    }
    if let Ok(d) = std::env::var("MS") {
        settings.max_step = d.parse().unwrap();
    }
    match std::env::var("STEP").as_deref() {
        Ok("dls") => settings = Settings::DAMPED,
        Ok("pinv") => settings = Settings::PSEUDO_INVERSE,
        Ok("jt") => settings = Settings::TRANSPOSE,
        _ => {}
    }
    let robots = std::env::var("ROBOTS").unwrap_or("R7,H6,P6,UR5,Panda".into());
    for name in robots.split(',') {
        let c = robot(name);
        let t = targets(&c, n);
        let task = if std::env::var("TASK").as_deref() == Ok("position") {
            Task::Position
        } else {
            Task::Pose
        };
        let pts: Vec<[f64; 3]> = t.iter().map(|m| [m[3], m[7], m[11]]).collect();
        let goals = if task == Task::Position {
            Goals::Positions { points: &pts, direction: None }
        } else {
            Goals::Poses(&t)
        };
        let plan =
            Plan::new(&c, task, settings, Tolerance::default(), goals, Starts::Free, None, 0, 0)
                .unwrap();
        let t0 = std::time::Instant::now();
        let a = batch::solve(&plan, th, &mut || true).unwrap();
        let dt = t0.elapsed().as_secs_f64();
        let ok = a.status.iter().filter(|s| **s == 0).count();
        let its = a.iterations.iter().map(|x| *x as f64).sum::<f64>() / n as f64;
        let rs = a.restarts.iter().map(|x| *x as f64).sum::<f64>() / n as f64;
        println!(
            "{name:6} {:.3} us/target  success {:.4}%  ({} missed) it {:.2} restarts {:.3}  ns/it {:.1}",
            dt / n as f64 * 1e6,
            ok as f64 / n as f64 * 100.0,
            n - ok,
            its,
            rs,
            dt / n as f64 * 1e9 / its
        );
    }
}
