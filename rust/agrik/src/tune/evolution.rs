//! CMA-ES: evolution strategy with covariance matrix adaptation, the standard form with
//! rank-one and rank-mu updates (Hansen, "The CMA evolution strategy: a tutorial").

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{Judge, Reader, SWEEPS, sequence};
use crate::error::{Error, Result};

/// The strategy's state and constants.
#[derive(Debug, Clone)]
pub struct Evolution {
    seed: u64,
    generation: u64,
    evaluations: u64,
    members: usize,
    sigma: f64,
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    path: DVector<f64>,
    sigma_path: DVector<f64>,
    best_x: Vec<f64>,
    best_cost: f64,
    constants: Constants,
}

#[derive(Debug, Clone)]
struct Constants {
    weights: Vec<f64>,
    /// Variance-effective number of parents.
    effective: f64,
    path: f64,
    sigma_path: f64,
    rank_one: f64,
    rank_mu: f64,
    damping: f64,
    /// Expected length of a standard normal vector.
    length: f64,
}

impl Constants {
    fn new(dimension: usize, members: usize) -> Self {
        let n = dimension as f64;
        let parents = members / 2;
        let half = (members as f64 + 1.0) / 2.0;
        let raw: Vec<f64> = (1..=parents).map(|i| half.ln() - (i as f64).ln()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let sigma_path = (effective + 2.0) / (n + effective + 5.0);
        let rank_one = 2.0 / ((n + 1.3).powi(2) + effective);
        let rank_mu = 2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0).powi(2) + effective);
        let excess = (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0);
        Self {
            weights,
            effective,
            path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            sigma_path,
            rank_one,
            rank_mu: rank_mu.min(1.0 - rank_one),
            damping: 1.0 + 2.0 * excess + sigma_path,
            length: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

impl Evolution {
    /// `members` a generation around `start` with deviation `sigma`.
    pub fn new(start: &[f64], members: usize, sigma: f64, seed: u64) -> Self {
        let n = start.len();
        Self {
            seed,
            generation: 0,
            evaluations: 0,
            members,
            sigma,
            mean: DVector::from_column_slice(start),
            covariance: DMatrix::identity(n, n),
            path: DVector::zeros(n),
            sigma_path: DVector::zeros(n),
            best_x: start.to_vec(),
            best_cost: f64::INFINITY,
            constants: Constants::new(n, members),
        }
    }

    /// Samples, judges and adapts. The start itself is judged first of all.
    pub fn advance(&mut self, judge: &mut Judge<'_>) -> Result<()> {
        let mut next = self.clone();
        let n = next.mean.len();
        if next.generation == 0 {
            let cost = judge(next.mean.as_slice(), f64::INFINITY)?;
            next.evaluations += 1;
            next.note(cost, next.mean.clone().as_slice());
        }
        let covariance = next.covariance.clone();
        let eigen = Some(covariance)
            .filter(|covariance| covariance.iter().all(|x| x.is_finite()))
            .and_then(|covariance| SymmetricEigen::try_new(covariance, f64::EPSILON, SWEEPS))
            .ok_or_else(|| {
                let expected = "a search whose covariance has axes";
                Error::argument("state", expected, "one that grew beyond all numbers")
            })?;
        let scales = eigen.eigenvalues.map(|value| value.max(1e-20).sqrt());
        let mut members = Vec::with_capacity(next.members);
        // The costs of the best so far, as many as become parents, in rising order.
        let mut parents = vec![f64::INFINITY; next.constants.weights.len()];
        for member in 0..next.members {
            let mut stream = sequence(next.seed, next.generation, member as u64);
            let z = DVector::from_fn(n, |k, _| scales[k] * stream.normal());
            let y = &eigen.eigenvectors * z;
            let x = &next.mean + &y * next.sigma;
            let bound = parents.last().copied().unwrap_or(f64::INFINITY);
            let cost = judge(x.as_slice(), bound)?;
            next.evaluations += 1;
            if cost < bound {
                parents.pop();
                parents.insert(parents.partition_point(|other| *other <= cost), cost);
            }
            next.note(cost, x.as_slice());
            members.push((cost, y));
        }
        members.sort_by(|a, b| a.0.total_cmp(&b.0));
        next.adapt(&members, &eigen.eigenvectors, &scales);
        next.generation += 1;
        *self = next;
        Ok(())
    }

    fn note(&mut self, cost: f64, x: &[f64]) {
        if cost < self.best_cost {
            self.best_cost = cost;
            self.best_x.copy_from_slice(x);
        }
    }

    fn adapt(
        &mut self,
        members: &[(f64, DVector<f64>)],
        axes: &DMatrix<f64>,
        scales: &DVector<f64>,
    ) {
        let c = &self.constants;
        let n = self.mean.len();
        let mut way = DVector::zeros(n);
        for (weight, (_, y)) in c.weights.iter().zip(members) {
            way += y * *weight;
        }
        self.mean += &way * self.sigma;
        let mut whitened = axes.transpose() * &way;
        whitened.component_div_assign(scales);
        let gain = (c.sigma_path * (2.0 - c.sigma_path) * c.effective).sqrt();
        self.sigma_path = &self.sigma_path * (1.0 - c.sigma_path) + axes * whitened * gain;
        let length = self.sigma_path.norm();
        let steps = 2.0 * (self.generation as f64 + 1.0);
        let usual = length / (1.0 - (1.0 - c.sigma_path).powf(steps)).sqrt();
        // Without this pause the axes grow along with a step length that is too small.
        let steady = f64::from(usual < (1.4 + 2.0 / (n as f64 + 1.0)) * c.length);
        let gain = steady * (c.path * (2.0 - c.path) * c.effective).sqrt();
        self.path = &self.path * (1.0 - c.path) + &way * gain;
        let lost = (1.0 - steady) * c.path * (2.0 - c.path);
        self.covariance *= 1.0 - c.rank_one - c.rank_mu + c.rank_one * lost;
        self.covariance += &self.path * self.path.transpose() * c.rank_one;
        for (weight, (_, y)) in c.weights.iter().zip(members) {
            self.covariance += y * y.transpose() * (c.rank_mu * weight);
        }
        self.sigma *= (c.sigma_path / c.damping * (length / c.length - 1.0)).exp();
    }

    pub(super) fn best(&self) -> Option<(&[f64], f64)> {
        self.best_cost.is_finite().then_some((&self.best_x, self.best_cost))
    }

    pub(super) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    pub(super) fn state(&self) -> Vec<f64> {
        let mut state =
            vec![self.generation as f64, self.evaluations as f64, self.sigma, self.best_cost];
        for part in [&self.mean, &self.path, &self.sigma_path] {
            state.extend_from_slice(part.as_slice());
        }
        state.extend_from_slice(self.covariance.as_slice());
        state.extend_from_slice(&self.best_x);
        state
    }

    pub(super) fn restore(&mut self, state: &[f64]) {
        let mut from = Reader(state);
        self.generation = from.one() as u64;
        self.evaluations = from.one() as u64;
        self.sigma = from.one();
        self.best_cost = from.one();
        for part in [&mut self.mean, &mut self.path, &mut self.sigma_path] {
            from.fill(part.as_mut_slice());
        }
        from.fill(self.covariance.as_mut_slice());
        from.fill(&mut self.best_x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's bent valley.
    fn valley(x: &[f64]) -> f64 {
        x.windows(2).map(|p| 100.0 * (p[1] - p[0] * p[0]).powi(2) + (1.0 - p[0]).powi(2)).sum()
    }

    #[test]
    fn the_bottom_of_a_bent_valley_is_found() {
        let mut search = Evolution::new(&[0.0; 5], 12, 0.3, 3);
        for _ in 0..400 {
            search.advance(&mut |x, _| Ok(valley(x))).expect("no error");
        }
        let (_, cost) = search.best().expect("a best");
        assert!(cost < 1e-10, "{cost}");
    }

    #[test]
    fn what_is_not_judged_to_its_end_changes_nothing() {
        let start = || Evolution::new(&[0.0; 4], 12, 0.3, 7);
        let (mut whole, mut hasty, mut cut) = (start(), start(), 0);
        for _ in 0..30 {
            whole.advance(&mut |x, _| Ok(valley(x))).expect("no error");
            let mut judge = |x: &[f64], bound: f64| {
                cut += u32::from(valley(x) > bound);
                Ok(if valley(x) < bound { valley(x) } else { bound })
            };
            hasty.advance(&mut judge).expect("no error");
        }
        assert_eq!(whole.state(), hasty.state());
        assert!(cut > 50, "{cut}");
    }

    #[test]
    fn a_stored_search_goes_on_as_if_never_stopped() {
        let mut whole = Evolution::new(&[0.0; 4], 8, 0.3, 7);
        for _ in 0..5 {
            whole.advance(&mut |x, _| Ok(valley(x))).expect("no error");
        }
        let mut resumed = Evolution::new(&[0.0; 4], 8, 0.3, 7);
        resumed.restore(&whole.state());
        for search in [&mut whole, &mut resumed] {
            search.advance(&mut |x, _| Ok(valley(x))).expect("no error");
        }
        assert_eq!(whole.state(), resumed.state());
    }
}
