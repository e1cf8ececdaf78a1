//! Motions along ways: the law of one segment, limits by finite differences, rests, bad input.

use agrik::chain::MotionLimits;
use agrik_motion::time_law::{Motion, Path};
use proptest::prelude::*;

fn limits(rows: &[[f64; 3]]) -> Vec<MotionLimits> {
    rows.iter()
        .map(|&[velocity, acceleration, jerk]| MotionLimits { velocity, acceleration, jerk })
        .collect()
}

fn at(motion: &Motion, time: f64) -> Vec<[f64; 4]> {
    let mut rows = vec![[0.0; 4]; motion.path().dof()];
    motion.at(time, |joint, values| rows[joint] = values);
    rows
}

/// Duration from rest to rest over a length of 1, as the field writes it.
fn published(v: f64, a: f64, j: f64) -> f64 {
    let tj = if v * j >= a * a { a / j } else { (v / j).sqrt() };
    let ta = tj + v / (j * tj);
    if v * ta <= 1.0 {
        return 2.0 * ta + (1.0 / v - ta);
    }
    let tj = a / j;
    let ta = tj / 2.0 + (tj * tj / 4.0 + 1.0 / a).sqrt();
    if ta >= 2.0 * tj { 2.0 * ta } else { 4.0 * (1.0 / (2.0 * j)).cbrt() }
}

/// Goes through a motion and checks the limits, that the derivatives are those of what stands
/// before them, that it begins and ends at rest where it should, and that time runs on.
fn check(motion: &Motion, limits: &[MotionLimits], first: &[f64], last: &[f64]) {
    let rests = [(0.0, first), (motion.duration(), last)];
    for (time, wanted) in rests {
        for (row, q) in at(motion, time).iter().zip(wanted) {
            assert!((row[0] - q).abs() < 1e-12, "{} {q}", row[0]);
            assert!(row[1].abs() < 1e-12 && row[2].abs() < 1e-9, "{row:?}");
        }
    }
    assert!(motion.times().windows(2).all(|pair| pair[0] < pair[1]));
    let steps = 2000;
    let h = 1e-6 * motion.duration();
    for i in 1..steps {
        let time = motion.duration() * f64::from(i) / f64::from(steps);
        let (before, now, after) = (at(motion, time - h), at(motion, time), at(motion, time + h));
        for (joint, limit) in limits.iter().enumerate() {
            let [_, v, a, j] = now[joint];
            assert!(v.abs() <= limit.velocity * (1.0 + 1e-9), "velocity {v}");
            assert!(a.abs() <= limit.acceleration * (1.0 + 1e-9), "acceleration {a}");
            assert!(j.abs() <= limit.jerk * (1.0 + 1e-9), "jerk {j}");
            let difference = |k: usize| (after[joint][k] - before[joint][k]) / (2.0 * h);
            // Jerk steps between phases, so that accelerations differ by a step of it.
            let rough = limit.jerk.min(1e6) * h;
            assert!((difference(0) - v).abs() <= 1e-6 * limit.velocity + rough * h, "{v}");
            assert!((difference(1) - a).abs() <= 1e-6 * limit.acceleration + rough, "{a}");
            assert!(difference(2).abs() <= limit.jerk * (1.0 + 1e-4), "jerk by differences");
        }
    }
}

proptest! {
    #[test]
    fn one_segment_takes_as_long_as_the_published_law(
        v in 0.05..20.0_f64, a in 0.05..50.0_f64, j in 0.05..500.0_f64,
    ) {
        let path = Path::with_corners(1, &[2.0, 3.0], &[1.0], &[0.0, 0.0]).unwrap();
        let limits = limits(&[[v, a, j]]);
        let motion = Motion::new(path, &limits, f64::INFINITY).unwrap();
        let wanted = published(v, a, j);
        prop_assert!((motion.duration() - wanted).abs() <= 1e-12 * wanted);
        check(&motion, &limits, &[2.0], &[3.0]);
    }

    #[test]
    fn ways_with_corners_keep_every_limit(
        points in proptest::collection::vec(-2.0..2.0_f64, 3 * 2..3 * 9),
        blend in prop_oneof![Just(0.0), 0.02..0.5_f64],
        seed in 0.1..10.0_f64,
    ) {
        let count = points.len() / 3;
        let points = &points[..3 * count];
        let lengths: Vec<f64> = points
            .windows(6)
            .step_by(3)
            .map(|w| (0..3).map(|k| (w[k + 3] - w[k]).powi(2)).sum::<f64>().sqrt())
            .collect();
        prop_assume!(lengths.iter().all(|l| *l > 1e-3));
        let blends: Vec<f64> = (0..count)
            .map(|i| match i {
                0 => 0.0,
                i if i == count - 1 => 0.0,
                i => blend * lengths[i - 1].min(lengths[i]),
            })
            .collect();
        let path = Path::with_corners(3, points, &lengths, &blends).unwrap();
        let limits = limits(&[[1.0 * seed, 2.0, 20.0], [2.0, 1.0, 30.0 * seed], [0.5, 4.0, 15.0]]);
        let motion = Motion::new(path, &limits, f64::INFINITY).unwrap();
        check(&motion, &limits, &points[..3], &points[3 * (count - 1)..]);
    }

    #[test]
    fn smooth_ways_go_through_every_point_and_keep_every_limit(
        turns in 0.2..4.0_f64, count in 3_usize..60, width in 0.1..2.0_f64,
    ) {
        let of = |i: usize| {
            let t = i as f64 / (count - 1) as f64;
            [width * (turns * t).sin(), t * t, (turns * t).cos()]
        };
        let points: Vec<f64> = (0..count).flat_map(of).collect();
        let lengths = vec![1.0 / (count - 1) as f64; count - 1];
        let path = Path::smooth(3, &points, &lengths).unwrap();
        for i in 0..count {
            path.at(0, i as f64 / (count - 1) as f64, |joint, values| {
                assert!((values[0] - of(i)[joint]).abs() < 1e-12);
            });
        }
        let limits = limits(&[[1.0, 2.0, 20.0]; 3]);
        let motion = Motion::new(path, &limits, f64::INFINITY).unwrap();
        check(&motion, &limits, &of(0), &of(count - 1));
    }
}

/// A square with rounded corners: not resting pays.
#[test]
fn rounded_corners_are_quicker_than_rests_and_stay_near() {
    let points = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    let limits = limits(&[[1.0, 4.0, 40.0]; 2]);
    let with = |blend: f64| {
        let path = Path::with_corners(2, &points, &[1.0; 3], &[0.0, blend, blend, 0.0]).unwrap();
        Motion::new(path, &limits, f64::INFINITY).unwrap()
    };
    let (resting, rounded) = (with(0.0), with(0.2));
    assert!((resting.duration() - 3.0 * published(1.0, 4.0, 40.0)).abs() < 1e-12);
    assert!(rounded.duration() < 0.85 * resting.duration(), "{}", rounded.duration());
    assert!((rounded.path().deviation() - 3.0 / 16.0 * 0.2).abs() < 1e-15);
    let times = (0..=4000).map(|i| rounded.duration() * f64::from(i) / 4000.0);
    let nearest = times
        .map(|time| at(&rounded, time))
        .map(|q| (q[0][0] - 1.0).hypot(q[1][0]))
        .fold(f64::INFINITY, f64::min);
    assert!((nearest - 3.0 / 16.0 * 0.2 * 2.0_f64.sqrt()).abs() < 1e-4, "{nearest}");
}

/// Many short pieces of one line: what rests at every waypoint takes several times as long.
#[test]
fn a_line_in_pieces_is_nearly_as_quick_as_in_one() {
    let count = 19;
    let points: Vec<f64> = (0..=count).flat_map(|i| [f64::from(i) * 0.02, 0.1]).collect();
    let limits = limits(&[[0.5, 1.0, 10.0]; 2]);
    let lengths = vec![0.02; count as usize];
    let mut blends = vec![0.01; count as usize + 1];
    (blends[0], blends[count as usize]) = (0.0, 0.0);
    let path = Path::with_corners(2, &points, &lengths, &blends).unwrap();
    let pieces = Motion::new(path, &limits, f64::INFINITY).unwrap();
    let one = published(0.5 / 0.38, 1.0 / 0.38, 10.0 / 0.38);
    assert!(pieces.duration() < 1.02 * one, "{} {one}", pieces.duration());
}

#[test]
fn a_speed_along_the_way_is_kept() {
    let path = Path::smooth(1, &[0.0, 1.0, 2.0, 3.0], &[0.1; 3]).unwrap();
    let motion = Motion::new(path, &limits(&[[50.0, 1e4, 1e6]]), 0.05).unwrap();
    let fastest = (0..=1000)
        .map(|i| motion.place(motion.duration() * f64::from(i) / 1000.0)[1])
        .fold(0.0, f64::max);
    assert!((fastest - 0.05).abs() < 1e-12);
}

#[test]
fn what_does_not_move_takes_no_time() {
    let limits = limits(&[[1.0, f64::INFINITY, 1.0]; 2]);
    for points in [vec![1.0, 2.0], vec![1.0, 2.0, 1.0, 2.0, 1.0, 2.0]] {
        let count = points.len() / 2;
        let path =
            Path::with_corners(2, &points, &vec![0.0; count - 1], &vec![0.0; count]).unwrap();
        let motion = Motion::new(path, &limits, f64::INFINITY).unwrap();
        assert_eq!(motion.duration(), 0.0);
        assert_eq!(at(&motion, 0.0), [[1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]]);
    }
}

#[test]
fn without_a_limit_of_jerk_the_speed_is_a_trapezoid() {
    let path = Path::with_corners(1, &[0.0, 2.0], &[1.0], &[0.0, 0.0]).unwrap();
    let limits = limits(&[[1.0, 2.0, f64::INFINITY]]);
    let motion = Motion::new(path, &limits, f64::INFINITY).unwrap();
    assert!((motion.duration() - 2.5).abs() < 1e-12);
    assert_eq!(motion.phases().len(), 3);
}

#[test]
fn bad_input_is_refused() {
    let message = |made: agrik_motion::Result<Path>| made.unwrap_err().to_string();
    let points = [0.0, 1.0, 2.0];
    for (made, wanted) in [
        (Path::with_corners(1, &[], &[], &[]), "waypoints: expected rows of 1 numbers, got 0"),
        (Path::with_corners(1, &points, &[1.0], &[0.0; 3]), "lengths: expected 2 numbers, got 1"),
        (Path::with_corners(1, &points, &[1.0, 0.0], &[0.0; 3]), "lengths[1]: expected a finite"),
        (Path::with_corners(1, &[0.0, f64::NAN], &[1.0], &[0.0; 2]), "waypoints: expected finite"),
        (Path::with_corners(1, &points, &[1.0; 2], &[0.0, -1.0, 0.0]), "blends: expected finite"),
        (
            Path::with_corners(1, &points, &[1.0; 2], &[0.0, 1.5, 0.0]),
            "blends: expected at most 1 on segment 0, both ends, got 1.5",
        ),
    ] {
        let got = message(made);
        assert!(got.starts_with(wanted), "{got}");
    }
    let refused = |rows: &[[f64; 3]], most: f64| {
        let path = Path::with_corners(1, &[0.0, 1.0], &[1.0], &[0.0; 2]).unwrap();
        Motion::new(path, &limits(rows), most).unwrap_err().to_string()
    };
    let none = f64::INFINITY;
    assert!(refused(&[], none).starts_with("limits: expected 1 limits, got 0"));
    assert!(refused(&[[0.0, 1.0, 1.0]], none).starts_with("velocity[0]: expected a number > 0"));
    assert!(refused(&[[1.0, none, 1.0]], none).starts_with("acceleration[0]: expected a finite"));
    assert!(refused(&[[1.0, 1.0, f64::NAN]], none).starts_with("jerk[0]: expected a number > 0"));
    assert!(refused(&[[1.0; 3]], 0.0).starts_with("speed: expected a number > 0"));
}
