//! Two trees that grow towards each other.

use super::ask::Ask;
use super::tree::Tree;

/// Extensions of a round. All of them start from the tree as it was before the round, and are
/// taken up in their order, so that what is found does not depend on how they are worked out.
const LANES: u32 = 8;

/// Which of a plan's streams draws samples.
const STREAM: u64 = 1;

/// What two trees came to.
#[derive(Debug, Clone)]
pub(super) struct Grown {
    /// Postures from the start to a root of the other tree, and which root that is.
    pub way: Option<(Vec<Vec<f64>>, usize)>,
    pub rounds: u32,
    /// The least distance of the trees, m of the metric.
    pub nearest: f64,
}

/// Grows a tree from `start` and one from all of `roots` until they meet.
pub(super) fn connect(ask: &mut Ask<'_>, start: &[f64], roots: &[&[f64]]) -> Grown {
    let dof = start.len();
    let (mut near, mut far) = (Tree::new(dof), Tree::new(dof));
    near.add(start, None);
    for root in roots {
        far.add(root, None);
    }
    let closest = roots.iter().map(|root| ask.metric.between(start, root));
    let mut nearest = closest.fold(f64::INFINITY, f64::min);
    let (mut sample, mut from, mut next) = (vec![0.0; dof], vec![0.0; dof], vec![0.0; dof]);
    let mut rounds = 0;
    while rounds < ask.settings.rounds && !ask.is_spent() {
        let forward = rounds % 2 == 0;
        let (tree, other) = if forward { (&mut near, &mut far) } else { (&mut far, &mut near) };
        let mut lanes = Vec::with_capacity(LANES as usize);
        for lane in 0..LANES {
            ask.sample(STREAM, rounds, lane, &mut sample);
            let parent = tree.nearest(&sample, &ask.metric);
            step(ask, tree.node(parent), &sample, &mut next);
            lanes.push((parent, next.clone()));
        }
        rounds += 1;
        for (parent, q) in lanes {
            if !ask.free(tree.node(parent), &q) {
                continue;
            }
            let tip = tree.add(&q, Some(parent));
            // The other tree comes as near as it can.
            let mut node = other.nearest(&q, &ask.metric);
            loop {
                from.copy_from_slice(other.node(node));
                let there = step(ask, &from, &q, &mut next);
                if !ask.free(&from, &next) {
                    break;
                }
                if there {
                    let (a, b) = if forward { (tip, node) } else { (node, tip) };
                    let way = joined(&near, a, &far, b);
                    return Grown { way: Some(way), rounds, nearest: 0.0 };
                }
                node = other.add(&next, Some(node));
            }
            nearest = nearest.min(ask.metric.between(other.node(node), &q));
        }
    }
    Grown { way: None, rounds, nearest }
}

/// Goes from one posture towards another, no farther than a step; true where it gets there.
fn step(ask: &Ask<'_>, from: &[f64], to: &[f64], next: &mut [f64]) -> bool {
    let away = ask.metric.between(from, to);
    let step = ask.settings.step;
    if away <= step {
        next.copy_from_slice(to);
        return true;
    }
    let share = step / away;
    for ((x, a), b) in next.iter_mut().zip(from).zip(to) {
        *x = a + share * (b - a);
    }
    false
}

/// The postures from the root of one tree over a node of each to a root of the other.
fn joined(near: &Tree, a: usize, far: &Tree, b: usize) -> (Vec<Vec<f64>>, usize) {
    let mut way: Vec<Vec<f64>> =
        near.to_root(a).into_iter().rev().map(|node| near.node(node).to_vec()).collect();
    let back = far.to_root(b);
    way.extend(back.iter().map(|node| far.node(*node).to_vec()));
    // Roots were added first.
    (way, back[back.len() - 1])
}
