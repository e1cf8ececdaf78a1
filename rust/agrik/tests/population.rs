//! Population solvers: every variant finds what it should, whatever goes wrong is said.
#![allow(clippy::panic, reason = "helpers of tests say what they take for granted")]

mod common;

use agrik::call::{Answers, Goals, Request, Starts, Status, Tolerance};
use agrik::chain::{Chain, DhConvention, DhRow, Joint, JointKind, Reach};
use agrik::kinematics::Workspace;
use agrik::lanes::{Kernel, Level, Real, dispatch};
use agrik::random::Stream;
use agrik::solve::Follow;
use agrik::solve::population::{
    Adaptation, Algorithm, Boundary, Differential, Evolution, Fitness, Gene, Mutation, Orientation,
    Redraw, Settings, minimise,
};
use agrik::task::Task;
use common::{Sampler, plain_poses, random_q};

/// The paper's arm, Table I.
fn redundant7() -> Chain {
    let pi = std::f64::consts::PI;
    let turns = [-0.5, 0.5, -0.5, 0.5, -0.5, 0.5, 0.0];
    let lengths = [0.34, 0.0, 0.4, 0.0, 0.4, 0.0, 0.126];
    let limits =
        [17.0 / 18.0, 2.0 / 3.0, 17.0 / 18.0, 2.0 / 3.0, 17.0 / 18.0, 2.0 / 3.0, 35.0 / 36.0];
    let joints: Vec<Joint> = (0..7)
        .map(|i| {
            let limit = limits[i] * pi;
            let row = DhRow { a: 0.0, alpha: turns[i] * pi, d: lengths[i], theta: 0.0 };
            let name = format!("q{}", i + 1);
            row.joint(DhConvention::Standard, name, JointKind::Revolute, -limit, limit)
        })
        .collect();
    let identity = nalgebra::IsometryMatrix3::identity();
    Chain::new("redundant7", joints, identity, identity, None).expect("a chain")
}

fn reachable(chain: &Chain, count: usize, seed: u64) -> Vec<[f64; 16]> {
    let mut sampler = Sampler(seed);
    (0..count)
        .map(|_| {
            let pose =
                *plain_poses(chain, &random_q(chain, &mut sampler)).last().expect("the tool");
            let mut m = [0.0; 16];
            m.copy_from_slice(pose.transpose().as_slice());
            m
        })
        .collect()
}

fn request<'a>(chain: &'a Chain, poses: &'a [[f64; 16]], starts: Starts<'a>) -> Request<'a> {
    let tolerance = Tolerance { position: 1e-4, orientation: 1e-3, ..Tolerance::default() };
    common::arms::request(chain, Task::Pose, tolerance, Goals::Poses(poses), starts).with_seed(3, 0)
}

fn solve(chain: &Chain, poses: &[[f64; 16]], settings: Settings, threads: usize) -> Answers {
    let evolution =
        Evolution::new(request(chain, poses, Starts::Free), settings).expect("settings");
    agrik::call::solve(&evolution, threads, &mut || true).expect("answers")
}

fn share(answers: &Answers) -> f64 {
    (0..answers.len()).filter(|i| answers.success(*i)).count() as f64 / answers.len() as f64
}

fn differential(settings: Settings) -> Differential {
    match settings.algorithm {
        Algorithm::Differential(it) => it,
        Algorithm::Genetic(_) => panic!("differential evolution"),
    }
}

fn varied(change: impl Fn(&mut Settings, &mut Differential)) -> Settings {
    let mut settings = Settings::PUBLISHED;
    let mut it = differential(settings);
    change(&mut settings, &mut it);
    settings.algorithm = Algorithm::Differential(it);
    settings
}

#[test]
fn the_default_solves_everything_and_its_answers_are_true() {
    let chain = redundant7();
    let poses = reachable(&chain, 150, 1);
    for settings in [Settings::DIFFERENTIAL, Settings::GENETIC] {
        let answers = solve(&chain, &poses, settings, 1);
        assert_eq!(share(&answers), 1.0);
        for (q, pose) in answers.q.chunks_exact(7).zip(&poses) {
            assert!(chain.within_limits(q));
            let got = *plain_poses(&chain, q).last().expect("the tool");
            let way = (0..3).map(|k| (got[(k, 3)] - pose[4 * k + 3]).powi(2)).sum::<f64>().sqrt();
            assert!(way <= 1e-4, "{way}");
        }
    }
}

#[test]
fn answers_do_not_depend_on_threads_or_slices() {
    let chain = redundant7();
    let poses = reachable(&chain, 40, 2);
    for settings in [
        Settings::DIFFERENTIAL,
        varied(|s, _| s.generations = 30),
        varied(|s, it| (s.generations, it.adaptation) = (30, Adaptation::LShade)),
        Settings { generations: 10, ..Settings::GENETIC },
    ] {
        let one = solve(&chain, &poses, settings, 1);
        assert_eq!(one, solve(&chain, &poses, settings, 2));
        assert_eq!(one, solve(&chain, &poses, settings, 5));
        // A target's neighbours do not matter either.
        let head = solve(&chain, &poses[..7], settings, 1);
        assert_eq!(one.q[..49], head.q[..]);
    }
}

#[test]
fn every_variant_of_the_recipe_succeeds_as_often_as_it_should() {
    let chain = redundant7();
    let poses = reachable(&chain, 200, 4);
    let base = |change: &dyn Fn(&mut Settings, &mut Differential)| {
        varied(|s, it| {
            it.redraw = Redraw::Individual;
            change(s, it);
        })
    };
    // Shares on random targets; the bounds leave three standard deviations.
    let cases: [(&str, Settings, f64, f64); 9] = [
        ("published", Settings::PUBLISHED, 0.85, 0.98),
        ("per generation", base(&|_, it| it.redraw = Redraw::Generation), 0.83, 1.0),
        ("clamp", base(&|_, it| it.boundary = Boundary::Clamp), 0.6, 0.98),
        ("reflect", base(&|_, it| it.boundary = Boundary::Reflect), 0.75, 0.99),
        ("redraw", base(&|_, it| it.boundary = Boundary::Redraw), 0.85, 1.0),
        ("rand/1 is slow", base(&|_, it| it.mutation = Mutation::Rand1), 0.0, 0.05),
        ("current-to-best", base(&|_, it| it.mutation = Mutation::CurrentToBest1), 0.8, 1.0),
        ("jDE", base(&|_, it| it.adaptation = Adaptation::Jde), 0.75, 1.0),
        ("rotation vector", base(&|s, _| s.orientation = Orientation::RotationVector), 0.85, 1.0),
    ];
    for (name, settings, low, high) in cases {
        let share = share(&solve(&chain, &poses, settings, 2));
        assert!((low..=high).contains(&share), "{name}: {share}");
    }
}

#[test]
fn a_trace_falls_and_ends_where_the_run_does() {
    let chain = redundant7();
    let poses = reachable(&chain, 3, 5);
    let evolution = Evolution::new(request(&chain, &poses, Starts::Free), Settings::PUBLISHED)
        .expect("settings");
    let trace = evolution.trace(Level::in_use(), 1, &mut || true).expect("a trace");
    assert_eq!(trace.len(), 201);
    assert!(trace.windows(2).all(|pair| pair[1] <= pair[0]));
    assert!(trace[200] < 1e-2 * trace[0]);
}

#[test]
fn runs_end_when_told_and_say_when_they_stand_still() {
    let chain = redundant7();
    let poses = reachable(&chain, 60, 6);
    let answers = solve(&chain, &poses, varied(|s, _| s.generations = 3), 1);
    assert!(answers.iterations.iter().all(|n| *n == 3));
    assert!(answers.status.iter().all(|s| *s == Status::NotFound as u8));
    // Half the weight on nothing but angles: most runs get stuck.
    let stuck = varied(|s, _| (s.stagnation, s.position_weight) = (20, 1e6));
    let answers = solve(&chain, &poses, stuck, 1);
    assert!(answers.status.contains(&(Status::Stalled as u8)));
    assert!(answers.iterations.iter().any(|n| *n < 200));
    let aimed = varied(|s, _| s.target_cost = 1.0);
    assert!(solve(&chain, &poses, aimed, 1).iterations.iter().filter(|n| **n < 100).count() > 40);
}

#[test]
fn unreachable_and_broken_targets_are_told_apart() {
    let chain = redundant7();
    let mut poses = reachable(&chain, 3, 7);
    poses[0][3] = 9.0;
    poses[2][0] = f64::NAN;
    let answers = solve(&chain, &poses, Settings::DIFFERENTIAL, 1);
    let expected = [Status::OutOfReach, Status::Converged, Status::BadInput];
    assert_eq!(answers.status, expected.map(|s| s as u8));
    assert_eq!((answers.restarts[0], answers.restarts[2]), (0, 0));
    assert!(answers.position_error[2].is_infinite());
    assert!(answers.q.chunks_exact(7).all(|q| chain.within_limits(q)));
}

#[test]
fn a_wrist_too_near_for_the_elbow_is_out_of_reach() {
    let chain = redundant7();
    let wrist = Reach::of_last_joint(chain.compiled(), chain.variables()).expect("a wrist");
    // Two lengths of 400 mm, and an elbow that folds to 60 degrees.
    assert!((wrist.inner_radius - 0.4).abs() < 1e-9 && (wrist.radius - 0.8).abs() < 1e-9);
    assert!((chain.reach().inner_radius - (0.4 - 0.126)).abs() < 1e-9);
    // An upright tool above the shoulder, which is 340 mm high.
    let upright = |distance: f64| {
        let mut pose = [0.0; 16];
        (pose[0], pose[5], pose[10], pose[15]) = (1.0, 1.0, 1.0, 1.0);
        pose[11] = 0.34 + distance + 0.126;
        pose
    };
    let poses = [0.2, 0.399, 0.401, 0.799, 0.801].map(upright);
    let answers = solve(&chain, &poses, Settings::DIFFERENTIAL, 1);
    let told: Vec<bool> = answers.status.iter().map(|s| *s == Status::OutOfReach as u8).collect();
    assert_eq!(told, [true, true, false, false, true]);
}

#[test]
fn start_values_are_kept_near() {
    let chain = redundant7();
    let mut sampler = Sampler(8);
    let near: Vec<f64> = (0..20).flat_map(|_| random_q(&chain, &mut sampler)).collect();
    let mut starts = near.clone();
    starts.iter_mut().for_each(|x| *x = (*x + 0.02).clamp(-2.0, 2.0));
    let poses: Vec<[f64; 16]> = near
        .chunks_exact(7)
        .map(|q| {
            let mut m = [0.0; 16];
            let pose = plain_poses(&chain, q).last().expect("the tool").transpose();
            m.copy_from_slice(pose.as_slice());
            m
        })
        .collect();
    let way = |settings: Settings, starts: Starts<'_>| -> f64 {
        let evolution =
            Evolution::new(request(&chain, &poses, starts), settings).expect("settings");
        let answers = agrik::call::solve(&evolution, 1, &mut || true).expect("answers");
        assert!(share(&answers) > 0.9);
        answers.q.iter().zip(&near).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let free = way(Settings::DIFFERENTIAL, Starts::Free);
    let warm = Settings { start_weight: 0.01, ..Settings::DIFFERENTIAL };
    let kept = way(warm, Starts::Each(&starts));
    assert!(kept < 0.4 * free, "{kept} of {free}");
}

/// The sphere about a point, or nonsense.
#[derive(Clone, Copy)]
struct Bowl {
    center: f64,
    broken: bool,
}

impl<R: Real> Fitness<R> for Bowl {
    #[inline(always)]
    fn cost(&self, q: &[R], _: &Workspace<R>) -> R {
        let mut sum = R::zero();
        for x in q {
            let d = *x - R::splat(self.center);
            sum = d.mul_add(d, sum);
        }
        if self.broken { R::splat(f64::NAN) } else { sum }
    }
}

struct Search<'a> {
    chain: &'a Chain,
    fitness: Bowl,
    settings: Settings,
}

impl Kernel for Search<'_> {
    type Output = (f64, Vec<f64>);
    #[inline(always)]
    fn run<R: Real>(self) -> Self::Output {
        let genes = Gene::of(self.chain, None);
        let mut best = vec![0.0; genes.len()];
        let compiled = self.chain.compiled();
        let mut stream = Stream::new(1);
        let (fitness, settings) = (self.fitness, &self.settings);
        let cost =
            minimise::<R, _>(compiled, &genes, fitness, settings, None, &mut stream, &mut best);
        (cost, best)
    }
}

#[test]
fn any_fitness_can_be_minimised_at_every_level() {
    let chain = redundant7();
    for settings in [
        varied(|_, _| ()),
        varied(|_, it| it.adaptation = Adaptation::LShade),
        varied(|_, it| it.adaptation = Adaptation::Jde),
        Settings { population: 100, generations: 200, ..Settings::GENETIC },
        Settings { population: 5, generations: 400, ..varied(|_, _| ()) },
    ] {
        for level in Level::ALL {
            let fitness = Bowl { center: 0.3, broken: false };
            let (cost, best) = dispatch(level, Search { chain: &chain, fitness, settings });
            let small = if settings.population < 10 { 10.0 } else { 0.05 };
            assert!(cost < small, "{cost} {settings:?}");
            assert!(chain.within_limits(&best));
            let again: f64 = best.iter().map(|x| (x - 0.3) * (x - 0.3)).sum();
            assert!((again - cost).abs() < 1e-12);
        }
    }
}

#[test]
fn a_fitness_of_nan_counts_as_infinite() {
    let chain = redundant7();
    for adaptation in [Adaptation::None, Adaptation::LShade] {
        let settings = varied(|s, it| (s.generations, it.adaptation) = (5, adaptation));
        let fitness = Bowl { center: 0.0, broken: true };
        let search = Search { chain: &chain, fitness, settings };
        let (cost, best) = dispatch(Level::in_use(), search);
        assert_eq!(cost, f64::INFINITY);
        assert!(chain.within_limits(&best));
    }
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let chain = redundant7();
    let poses = reachable(&chain, 1, 9);
    let cases: [(&str, Settings); 8] = [
        ("population", varied(|s, _| s.population = 0)),
        ("population", varied(|s, _| s.population = 3)),
        ("generations", varied(|s, _| s.generations = 0)),
        ("position_weight", varied(|s, _| s.position_weight = f64::NAN)),
        ("start_weight", varied(|s, _| s.start_weight = -1.0)),
        ("weight", varied(|_, it| it.weight = 0.0)),
        ("crossover", varied(|_, it| it.crossover = (0.5, 0.4))),
        ("elites", Settings { population: 4, ..with_elites(4) }),
    ];
    for (name, settings) in cases {
        let error = Evolution::new(request(&chain, &poses, Starts::Free), settings)
            .map(|_| ())
            .expect_err("out of range");
        assert!(error.to_string().starts_with(&format!("{name}: ")), "{error}");
    }
}

fn with_elites(elites: u32) -> Settings {
    let Algorithm::Genetic(it) = Settings::GENETIC.algorithm else { panic!("genetic") };
    let algorithm = Algorithm::Genetic(agrik::solve::population::Genetic { elites, ..it });
    Settings { algorithm, ..Settings::GENETIC }
}

#[test]
fn a_path_is_followed_in_small_steps_and_jumps_are_told() {
    let chain = redundant7();
    let mut sampler = Sampler(10);
    let (from, to) = (random_q(&chain, &mut sampler), random_q(&chain, &mut sampler));
    let pose = |share: f64| {
        let q: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + share * (b - a)).collect();
        let mut m = [0.0; 16];
        let pose = plain_poses(&chain, &q).last().expect("the tool").transpose();
        m.copy_from_slice(pose.as_slice());
        m
    };
    let mut poses: Vec<[f64; 16]> = (1..=100).map(|i| pose(f64::from(i) / 100.0)).collect();
    let follow = |poses: &[[f64; 16]]| {
        Follow::new(request(&chain, poses, Starts::Free), Some(&from), vec![0.2; 7], 0.5)
            .expect("a path")
            .run(Level::in_use(), &mut || true)
            .expect("answers")
    };
    let path = follow(&poses);
    assert_eq!(share(&path.answers), 1.0);
    assert!(path.jumps.iter().all(|jump| !jump));
    let mut before: &[f64] = &from;
    for q in path.answers.q.chunks_exact(7) {
        assert!(q.iter().zip(before).all(|(a, b)| (a - b).abs() <= 0.2));
        before = q;
    }
    // The second half backwards: its first pose is no step from the one before.
    poses[50..].reverse();
    let path = follow(&poses);
    assert_eq!(share(&path.answers), 1.0);
    assert!(path.jumps[50] || path.speeds[50] > 1.0);
    assert!(path.jumps[..50].iter().all(|jump| !jump));
    // A target out of reach: the arm waits.
    poses[20][3] = 9.0;
    let path = follow(&poses);
    assert_eq!(path.answers.status[20], Status::OutOfReach as u8);
    assert!(path.jumps[20] && !path.jumps[19]);
    assert_eq!(path.answers.q[20 * 7..21 * 7], path.answers.q[19 * 7..20 * 7]);
}

#[test]
fn paths_with_wrong_numbers_are_refused() {
    let chain = redundant7();
    let poses = reachable(&chain, 2, 11);
    let new = |q0: &[f64], steps: Vec<f64>, pull: f64| {
        Follow::new(request(&chain, &poses, Starts::Free), Some(q0), steps, pull)
            .map(|_| ())
            .expect_err("refused")
            .to_string()
    };
    let zero = [0.0; 7];
    assert!(new(&zero, vec![0.1; 6], 0.5).starts_with("max_joint_step: expected 7 numbers"));
    assert!(new(&zero, vec![0.0; 7], 0.5).starts_with("max_joint_step: expected finite"));
    assert!(new(&zero, vec![0.1; 7], 2.0).starts_with("pull: "));
    assert!(new(&[9.0; 7], vec![0.1; 7], 0.5).starts_with("q0: "));
    assert!(new(&[0.0; 3], vec![0.1; 7], 0.5).starts_with("q0: "));
}
