//! Bounds hold, and searches find what many starts find.

use std::f64::consts::{PI, TAU};

use super::look::Bound;
use super::*;
use crate::lanes::Level;
use crate::random::Sequence;

/// An arm of random lines with a random tool, and one of its poses.
fn arm(random: &mut Sequence, turning: usize, wish: Wish, slides: bool) -> (Short, Rigid<f64>) {
    let mut vector = || [0; 3].map(|_| random.normal());
    let mut joint = || {
        let (v, point) = (vector(), vector());
        Screw { axis: scale(v, 1.0 / norm(v)), point: scale(point, 0.4) }
    };
    let joints: Vec<Screw> = (0..turning).map(|_| joint()).collect();
    let tool = Rigid { shift: vector(), ..Rigid::identity() };
    let screws = Screws { joints, tool };
    let q: Vec<f64> = (0..turning).map(|_| TAU * (random.uniform() - 0.5)).collect();
    let goal = screws.pose(&q);
    let lines = Lines { slide: slides.then_some([0.3, 0.8, -0.1]), screws, order: Vec::new() };
    let short = Short::new(&lines, &Rigid::identity(), (wish, 0.5), 2.0).unwrap();
    (short, goal)
}

fn anywhere(random: &mut Sequence) -> [f64; TURNING] {
    [0; TURNING].map(|_| TAU * (random.uniform() - 0.5))
}

#[test]
fn no_posture_in_a_cell_is_nearer_than_its_bound() {
    let mut random = Sequence::new(3);
    for case in 0..4_000 {
        let turning = 1 + case % TURNING;
        let wish = [Wish::Point, Wish::Axis, Wish::Pose][case / 4 % 3];
        let (short, goal) = arm(&mut random, turning, wish, case % 5 == 0);
        let range = if case % 2 == 0 { (-0.2, 0.3) } else { (f64::NEG_INFINITY, f64::INFINITY) };
        let size = 10_f64.powf(-3.0 * random.uniform());
        let mut half = [0; TURNING].map(|_| size * random.uniform());
        half[..TURNING - turning].fill(0.0);
        let mut middle = anywhere(&mut random);
        middle[..TURNING - turning].fill(0.0);
        // Near a posture that reaches the goal too, where bounds are small.
        if case % 3 == 0 {
            middle = short.descend(&goal, &Room::FREE, &middle).q;
        }
        let mut bounds: Vec<Bound> = Vec::new();
        short.bounds(Level::in_use(), (&goal, range), half, &[middle], &mut bounds);
        for _ in 0..20 {
            let mut q = middle;
            for k in 0..TURNING {
                // Corners as well.
                q[k] += half[k] * (4.0 * random.uniform() - 2.0).clamp(-1.0, 1.0);
            }
            let mut there: Vec<Bound> = Vec::new();
            short.bounds(Level::in_use(), (&goal, range), [0.0; TURNING], &[q], &mut there);
            let (least, error) = (bounds[0].least, there[0].error);
            assert!(error >= least - 1e-12, "case {case}: {error} {least}");
        }
    }
}

#[test]
fn steps_end_where_no_neighbour_is_nearer() {
    let mut random = Sequence::new(4);
    for case in 0..200 {
        let (short, mut goal) = arm(&mut random, 1 + case % TURNING, Wish::Pose, case % 3 == 0);
        goal.shift = [goal.shift[0] + 0.3, goal.shift[1] - 0.2, goal.shift[2] + 0.1];
        let room = Room { lower: [-1.5; 4], upper: [1.0; 4], slide: (-0.1, 0.1) };
        let found = short.descend(&goal, &room, &anywhere(&mut random));
        for _ in 0..50 {
            let mut q = found.q;
            for k in short.moving() {
                let by = 1e-3 * random.normal();
                q[k] = (q[k] + by).clamp(room.lower[k], room.upper[k]);
            }
            let mut there: Vec<Bound> = Vec::new();
            short.bounds(Level::in_use(), (&goal, room.slide), [0.0; 4], &[q], &mut there);
            assert!(there[0].error >= found.error - 1e-12, "{} {}", there[0].error, found.error);
        }
    }
}

#[test]
fn searches_find_what_many_starts_find() {
    let mut random = Sequence::new(5);
    for case in 0..24 {
        let (short, mut goal) = arm(&mut random, 1 + case % TURNING, Wish::Pose, case % 3 == 0);
        let exact = short.exact(Level::in_use(), &goal, &Room::FREE, &[PI; TURNING], 1e-6);
        assert!(!exact.unproven && exact.free.is_none());
        assert!(!exact.postures.is_empty());
        goal.shift = [goal.shift[0] + 0.2, goal.shift[1] - 0.1, goal.shift[2] + 0.3];
        let least = short.least(Level::in_use(), &goal, &Room::FREE, &[0.0; TURNING]);
        let none = short.exact(Level::in_use(), &goal, &Room::FREE, &[0.0; TURNING], 1e-6);
        assert_eq!(none.postures.is_empty(), least.best() > 1e-6);
        for _ in 0..100 {
            let other = short.descend(&goal, &Room::FREE, &anywhere(&mut random));
            assert!(least.best() <= other.error + 1e-9, "{} {}", least.best(), other.error);
        }
    }
}
