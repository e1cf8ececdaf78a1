//! The smallest translation of the platform that brings a target in reach.

use super::sets::Window;
use super::{Arm, Interval, SLIDE_TOLERANCE};
use crate::lanes::hypotenuse;

/// Steps of the scan over beta before its best place is refined.
const SCAN: usize = 128;
/// Added to a shift so that the target ends inside and not on the edge of rounding, m.
const MARGIN: f64 = 1e-9;

impl Arm {
    /// The smallest translation of the platform (m, base frame) that brings a target in
    /// reach, along the axes that may move; zero for a target in reach, `None` where no
    /// such translation does or the target is not finite.
    ///
    /// The reachable set is the box of the slides, moved along the surface that theta and
    /// beta draw. At a given beta that surface is an arc, and the arc's point nearest to
    /// the slides' window is one of a few (see `arc_gap`); beta itself is scanned and
    /// refined, to about 1e-9 m.
    pub fn suggest_base_shift(&self, target: [f64; 3], may_move: [bool; 3]) -> Option<[f64; 3]> {
        if !target.iter().all(|x| x.is_finite()) {
            return None;
        }
        if self.exact(target).is_ok() {
            return Some([0.0; 3]);
        }
        let p = &self.parameters;
        let betas = Interval::new(p.lower[4], p.upper[4]);
        let window = self.window(target);
        let straight = target[1] - p.l1 + p.d[1];
        let slide = Interval::new(p.lower[0], p.upper[0]);
        let gap = |beta: f64| {
            let s10 = straight - p.l3 * beta.sin();
            let y = s10 - slide.nearest(s10);
            let [x, z] = self.arc_gap(&window, self.reach(beta), may_move)?;
            // Rounding of the sines is no gap.
            let y = if y.abs() <= SLIDE_TOLERANCE { 0.0 } else { y };
            (y == 0.0 || may_move[1]).then_some([x, y, z])
        };
        let length2 =
            |beta: f64| gap(beta).map_or(f64::INFINITY, |g| g.iter().map(|v| v * v).sum());
        let step = (betas.high - betas.low) / SCAN as f64;
        let at = |i: usize| betas.nearest(betas.low + step * i as f64);
        let mut best = (f64::INFINITY, betas.low);
        let mut keep = |beta: f64| {
            let value = length2(beta);
            if value < best.0 {
                best = (value, beta);
            }
            value
        };
        // The betas where s10 just reaches are corners of the distance.
        let corner = |s10: f64| ((straight - s10) / p.l3).clamp(-1.0, 1.0).asin();
        for beta in [corner(slide.low), corner(slide.high)] {
            keep(betas.nearest(beta));
        }
        let values: Vec<f64> = (0..=SCAN).map(|i| keep(at(i))).collect();
        for i in 0..=SCAN {
            let (left, right) = (i.saturating_sub(1), (i + 1).min(SCAN));
            if values[i] <= values[left] && values[i] <= values[right] && values[i].is_finite() {
                golden(Interval::new(at(left), at(right)), &mut keep);
            }
        }
        let (_, beta) = best;
        let shift = gap(beta)?;
        let length = shift.iter().map(|v| v * v).sum::<f64>().sqrt();
        (length.is_finite()).then(|| shift.map(|v| v * (1.0 + MARGIN / length.max(MARGIN))))
    }

    /// Distance in x and z of the slides' window from the points that the arm reaches with
    /// a reach in an interval, m: of 17 reaches the best, refined.
    pub(super) fn window_distance(&self, window: &Window, r: Interval) -> f64 {
        let mut least = f64::INFINITY;
        let mut keep = |r: f64| {
            let length = self
                .arc_gap(window, r, [true; 3])
                .map_or(f64::INFINITY, |g| hypotenuse(g[0], g[1]));
            least = least.min(length);
            length
        };
        if r.low == r.high {
            keep(r.low);
            return least;
        }
        let step = (r.high - r.low) / 16.0;
        let at = |i: usize| r.nearest(r.low + step * i as f64);
        let values: [f64; 17] = std::array::from_fn(|i| keep(at(i)));
        let best = (0..17).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
        golden(Interval::new(at(best.saturating_sub(1)), at((best + 1).min(16))), &mut keep);
        least
    }

    /// What x and z lack at a reach, as the translation (x, z) of the platform of least
    /// length; `None` where that needs an axis that may not move.
    ///
    /// Along the arc the squared distance to the window is smooth between the angles
    /// where the arc crosses a line of the window; between them it is constant zero, the
    /// distance to a line (stationary at theta = 0 only) or to a corner (stationary at
    /// the corner's own angle). So the least is at one of these angles or at a limit.
    fn arc_gap(&self, window: &Window, r: f64, may_move: [bool; 3]) -> Option<[f64; 2]> {
        let p = &self.parameters;
        let joint = Interval::new(p.lower[3], p.upper[3]);
        let (u, w) = (window.u, window.w);
        let mut best: Option<([f64; 2], f64)> = None;
        let mut consider = |theta: f64| {
            let (sin, cos) = joint.nearest(theta).sin_cos();
            let settle = |gap: f64| if gap.abs() <= SLIDE_TOLERANCE { 0.0 } else { gap };
            // The slide would be at `limit + gap`: the platform makes up for it.
            let x = settle(r * sin - u.nearest(r * sin));
            let z = settle(r * cos - w.nearest(r * cos));
            if (x != 0.0 && !may_move[0]) || (z != 0.0 && !may_move[2]) {
                return;
            }
            let length = x * x + z * z;
            if best.is_none_or(|(_, least)| length < least) {
                best = Some(([x, z], length));
            }
        };
        consider(joint.low);
        consider(joint.high);
        consider(0.0);
        for a in [u.low, u.high] {
            consider((a / r).clamp(-1.0, 1.0).asin());
            for b in [w.low, w.high] {
                consider(a.atan2(b));
            }
        }
        for b in [w.low, w.high] {
            let theta = (b / r).clamp(-1.0, 1.0).acos();
            consider(theta);
            consider(-theta);
        }
        best.map(|(gap, _)| gap)
    }
}

/// Golden-section search; every value goes through `keep`.
fn golden(mut part: Interval, keep: &mut impl FnMut(f64) -> f64) {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let mut c = part.high - RATIO * (part.high - part.low);
    let mut d = part.low + RATIO * (part.high - part.low);
    let (mut at_c, mut at_d) = (keep(c), keep(d));
    for _ in 0..48 {
        if at_c <= at_d {
            part.high = d;
            (d, at_d) = (c, at_c);
            c = part.high - RATIO * (part.high - part.low);
            at_c = keep(c);
        } else {
            part.low = c;
            (c, at_c) = (d, at_d);
            d = part.low + RATIO * (part.high - part.low);
            at_d = keep(d);
        }
    }
}
