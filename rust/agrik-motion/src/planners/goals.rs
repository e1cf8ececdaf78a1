//! Which of many goals are tried.

use super::metric::Metric;

/// Indices of at most `most` goals: the first, then always the one that is farthest from all
/// those taken; in the order given. So all branches are among them.
pub(super) fn thinned(goals: &[&[f64]], metric: &Metric, most: usize) -> Vec<usize> {
    if goals.len() <= most {
        return (0..goals.len()).collect();
    }
    let mut taken = vec![0];
    let mut away: Vec<f64> = goals.iter().map(|goal| metric.square(goal, goals[0])).collect();
    while taken.len() < most {
        let far = away.iter().enumerate().fold((0, -1.0), |best, (k, square)| {
            if *square > best.1 { (k, *square) } else { best }
        });
        taken.push(far.0);
        for (square, goal) in away.iter_mut().zip(goals) {
            *square = square.min(metric.square(goal, goals[far.0]));
        }
    }
    taken.sort_unstable();
    taken.dedup();
    taken
}
