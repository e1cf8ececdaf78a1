//! Branches whose joints may stand whole turns apart: each that the limits allow.

use std::f64::consts::TAU;

use super::any_arm::apart;
use super::branches::Branches;
use super::locked::Lock;
use super::warning;
use crate::call::Request;
use crate::chain::JointKind;
use crate::closed_form::geometry::limit::SLACK;

/// Most branches of a target.
const MOST: usize = 4096;

/// One posture of a target.
struct One {
    from: usize,
    q: Vec<f64>,
    far: f64,
}

/// The record with every representative of every valid branch within the limits, those nearest
/// to the start values (or the middle of the limits) first; locked joints stay.
pub(super) fn wrapped(request: &Request<'_>, locks: &[Lock<'_>], found: Branches) -> Branches {
    let chain = request.chain();
    let (dof, rows, count) = (chain.dof(), found.status.len(), found.branches);
    let variables = chain.variables();
    let turns = |variable: usize| {
        variables[variable].kind != JointKind::Prismatic
            && locks.iter().all(|lock| lock.variable != variable)
    };
    let middle: Vec<f64> = variables.iter().map(|v| v.middle()).collect();
    let mut most = count;
    let mut warnings = found.warnings.clone();
    warnings.resize(rows, 0);
    let mut all: Vec<Vec<One>> = Vec::with_capacity(rows);
    for row in 0..rows {
        let centre = match request.start(row) {
            Some(q0) => {
                let most = request.well_known(row);
                q0.iter().zip(variables).map(|(x, v)| v.reference(*x, most)).collect()
            }
            None => middle.clone(),
        };
        let mut list = Vec::new();
        for b in (row * count..(row + 1) * count).filter(|b| found.valid[*b]) {
            let q = &found.q[b * dof..(b + 1) * dof];
            let mut some = vec![q.to_vec()];
            for variable in (0..dof).filter(|variable| turns(*variable)) {
                let v = &variables[variable];
                if !(v.upper - v.lower).is_finite() {
                    continue;
                }
                let low = ((v.lower - SLACK - q[variable]) / TAU).ceil() as i64;
                let high = ((v.upper + SLACK - q[variable]) / TAU).floor() as i64;
                let mut next = Vec::new();
                for one in &some {
                    for turn in low..=high {
                        let mut other = one.clone();
                        other[variable] = (q[variable] + TAU * turn as f64).clamp(v.lower, v.upper);
                        next.push(other);
                    }
                    if next.len() > MOST {
                        break;
                    }
                }
                some = next;
            }
            list.extend(some.into_iter().map(|q| One { from: b, far: apart(&q, &centre), q }));
        }
        list.sort_by(|a, b| a.far.total_cmp(&b.far).then(a.from.cmp(&b.from)));
        if list.len() > MOST {
            list.truncate(MOST);
            warnings[row] |= warning::MORE;
        }
        most = most.max(list.len());
        all.push(list);
    }
    let mut out = Branches::new(rows, most);
    out.q = vec![0.0; rows * most * dof];
    out.values = if found.values.is_empty() { Vec::new() } else { vec![f64::NAN; rows * most] };
    out.numbers = vec![0; rows * most];
    for (row, list) in all.iter().enumerate() {
        for b in 0..most {
            let to = row * most + b;
            let one = list.get(b);
            let from = one.map_or(row * count + b % count.max(1), |one| one.from);
            let q = one.map_or(&found.q[from * dof..(from + 1) * dof], |one| &one.q);
            out.q[to * dof..(to + 1) * dof].copy_from_slice(q);
            (out.valid[to], out.reached[to]) = (one.is_some(), one.is_some());
            if one.is_some() {
                out.singular[to] = found.singular[from];
                if let Some(value) = found.values.get(from) {
                    out.values[to] = *value;
                }
            }
            let place = (from - row * count) as u32;
            out.numbers[to] = found.numbers.get(from).copied().unwrap_or(place);
        }
    }
    let Branches { status, free, left, off, .. } = found;
    Branches { status, warnings, free, left, off, ..out }
}
