//! Gains of the feedback laws: as written, with their units and axes, and as the loop
//! uses them, in metres, radians and world axes.

use nalgebra::{DMatrix, Dyn, Matrix3, SVD};

use super::{Settings, Step};
use crate::allowed::check_measures;
use crate::call::{Aim, Measure};
use crate::chain::{Chain, JointKind, Tail};
use crate::error::{Error, Result};
use crate::kinematics::{Workspace, columns, forward};
use crate::task::{FramedRows, MaskFrame, PoseRows, PositionRows};

/// Singular values of a frozen Jacobian below this share of the largest are left out.
const FROZEN_CUTOFF: f64 = 1e-2;
/// Share of a full step that a frozen pseudo-inverse takes: far from where it was frozen
/// a full one overshoots.
const FROZEN_SHARE: f64 = 0.5;

/// Sweeps after which a decomposition is given up: far more than a Jacobian of a thousand joints
/// takes.
const SWEEPS: usize = 100_000;

/// A matrix, row by row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Matrix {
    /// Number of columns.
    pub columns: usize,
    /// All entries.
    pub values: Vec<f64>,
}

impl Matrix {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len().checked_div(self.columns).unwrap_or(0)
    }

    fn dense(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.rows(), self.columns, &self.values)
    }

    fn of(m: &DMatrix<f64>) -> Self {
        Self { columns: m.ncols(), values: m.transpose().as_slice().to_vec() }
    }

    fn check(&self, name: &str, rows: usize, columns: usize) -> Result<()> {
        if self.columns != columns || self.values.len() != rows * columns {
            let received = format!("{} x {}", self.rows(), self.columns);
            return Err(Error::argument(name, format!("a {rows} x {columns} matrix"), received));
        }
        check_measures(name, self.values.iter().copied())
    }
}

/// What a gain's numbers refer to.
#[derive(Debug, Clone, PartialEq)]
pub struct GainUnits {
    /// One unit of the position error, m; also of what prismatic joints are moved by.
    pub length: f64,
    /// One unit of what revolute joints are turned by, rad.
    pub angle: f64,
    /// Takes directions in the chain's base frame (of its first link) to the error's axes.
    pub rotation: [[f64; 3]; 3],
    /// Length that one radian of orientation error counts as, m; the loop's own if none.
    pub per_radian: Option<f64>,
}

impl Default for GainUnits {
    fn default() -> Self {
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { length: 1.0, angle: 1.0, rotation, per_radian: None }
    }
}

/// `dq = C x`, then `x <- A x + B e`, from `x = 0` (equations 14 and 15 of Burrell,
/// Montazeri, Monk and Taylor).
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    /// States by states.
    pub a: Matrix,
    /// States by rows of the error.
    pub b: Matrix,
    /// Joint values by states.
    pub c: Matrix,
    /// Units and axes.
    pub units: GainUnits,
}

/// `dq = K e`.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticGain {
    /// Joint values by rows of the error.
    pub gain: Matrix,
    /// Units and axes.
    pub units: GainUnits,
}

/// Which joint moves first in a sweep of IK-PID.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PidOrder {
    /// The one next to the tool.
    TipFirst,
    /// The one next to the base.
    BaseFirst,
}

/// The PID law of IK-PID, in rad per m of error (m per m for prismatic joints).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid {
    /// Share of the error's length.
    pub proportional: f64,
    /// Share of its running sum.
    pub integral: f64,
    /// Share of its last change.
    pub derivative: f64,
    /// Which joint moves first.
    pub order: PidOrder,
    /// As printed: the second try starts from where the first ended after saturation.
    pub literal: bool,
    /// Every try by a full pass of forward kinematics instead of turning the tool about
    /// one axis.
    pub full_passes: bool,
}

impl Pid {
    /// Published gains: 0.012, 1e-7, 0.08 degrees per mm.
    pub const PUBLISHED: Self = Self {
        proportional: 0.012 * DEGREES_PER_MM,
        integral: 1e-7 * DEGREES_PER_MM,
        derivative: 0.08 * DEGREES_PER_MM,
        order: PidOrder::TipFirst,
        literal: false,
        full_passes: false,
    };
    /// The published gains without the integral one, which keeps steps from getting shorter
    /// than some hundredths of a millimetre.
    pub const FINE: Self = Self { integral: 0.0, ..Self::PUBLISHED };

    pub(super) fn check(&self) -> Result<()> {
        check_measures("proportional", [self.proportional])?;
        check_measures("integral", [self.integral])?;
        check_measures("derivative", [self.derivative])
    }
}

/// One degree per millimetre, in rad per m.
const DEGREES_PER_MM: f64 = std::f64::consts::PI / 180.0 * 1000.0;

/// A matrix without its zeros: per row the columns and values of what is left.
#[derive(Debug, Clone, Default)]
pub struct Sparse {
    pub rows: Vec<Vec<(usize, f64)>>,
}

impl Sparse {
    fn of(m: &DMatrix<f64>) -> Self {
        let row = |i: usize| {
            (0..m.ncols()).map(|k| (k, m[(i, k)])).filter(|(_, value)| *value != 0.0).collect()
        };
        Self { rows: (0..m.nrows()).map(row).collect() }
    }
}

/// A feedback law ready for the loop: m, rad, world axes.
#[derive(Debug, Clone)]
pub enum Feedback {
    Descent,
    Pid(Pid),
    StateSpace { a: Sparse, b: Sparse, c: Sparse },
    Static { gain: Sparse },
    Broyden { gain: Vec<f64>, patience: f64 },
}

impl Feedback {
    /// The feedback law of the settings, if it is one.
    pub fn new(
        settings: &Settings,
        chain: &Chain,
        aim: &Aim,
        rotation_scale: f64,
    ) -> Result<Option<Self>> {
        let (measure, tail) = (aim.measure(rotation_scale), aim.tail());
        let around = Around { chain, measure, tail, rotation_scale };
        Ok(Some(match (&settings.step, measure) {
            (Step::CyclicCoordinateDescent, Measure::Position(_)) => Self::Descent,
            (Step::CyclicCoordinateDescent, _) => {
                let expected = "a position task with one tolerance, or another solver";
                let got = "ccd with orientations or single axes";
                return Err(Error::argument("solver", expected, got));
            }
            (Step::IkPid(pid), _) => Self::Pid(*pid),
            (Step::StateSpace(None), _) => {
                // What comes a step late swings already at half the gain.
                let gain = around.frozen()? * 0.5;
                let n = gain.nrows();
                Self::StateSpace {
                    a: Sparse::of(&DMatrix::zeros(n, n)),
                    b: Sparse::of(&gain),
                    c: Sparse::of(&DMatrix::identity(n, n)),
                }
            }
            (Step::StateSpace(Some(gains)), _) => {
                let states = gains.a.columns;
                gains.a.check("A", states, states)?;
                gains.b.check("B", states, around.rows()?)?;
                gains.c.check("C", chain.dof(), states)?;
                let b = around.error_side(gains.b.dense(), &gains.units)?;
                let c = around.joint_side(gains.c.dense(), &gains.units);
                // Units may have made them large.
                check_measures("B", b.iter().copied())?;
                check_measures("C", c.iter().copied())?;
                Self::StateSpace {
                    a: Sparse::of(&gains.a.dense()),
                    b: Sparse::of(&b),
                    c: Sparse::of(&c),
                }
            }
            (Step::StaticGain(gain), _) => {
                Self::Static { gain: Sparse::of(&around.gain(gain.as_deref())?) }
            }
            (Step::Broyden { gain, patience }, _) => Self::Broyden {
                gain: Matrix::of(&around.gain(gain.as_deref())?).values,
                patience: f64::from(*patience),
            },
            _ => return Ok(None),
        }))
    }
}

/// What gains are applied to.
struct Around<'a> {
    chain: &'a Chain,
    measure: Measure,
    tail: &'a Tail,
    rotation_scale: f64,
}

impl Around<'_> {
    /// Rows of an error that a matrix can stand on: along and about the world's axes.
    fn rows(&self) -> Result<usize> {
        match self.measure {
            Measure::Position(_) => Ok(3),
            Measure::Pose(_)
            | Measure::Framed(FramedRows { frame: MaskFrame::Base, axis: None, .. }) => Ok(6),
            _ => Err(Error::argument(
                "solver",
                "a position, pose or base-frame mask task, since gains stand on fixed axes",
                "gains with an axis or tool-frame task",
            )),
        }
    }

    fn gain(&self, gain: Option<&StaticGain>) -> Result<DMatrix<f64>> {
        let Some(gain) = gain else { return self.frozen() };
        gain.gain.check("K", self.chain.dof(), self.rows()?)?;
        let dense = self.error_side(gain.gain.dense(), &gain.units)?;
        let dense = self.joint_side(dense, &gain.units);
        // Units may have made them large.
        check_measures("K", dense.iter().copied())?;
        Ok(dense)
    }

    /// Columns for an error in the gain's units and axes, made ones for the loop's rows.
    fn error_side(&self, b: DMatrix<f64>, units: &GainUnits) -> Result<DMatrix<f64>> {
        for (name, value) in [
            ("length_unit", units.length),
            ("angle_unit", units.angle),
            ("rotation_length", units.per_radian.unwrap_or(1.0)),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::argument(name, "a finite number above 0", value));
            }
        }
        let rows: Vec<f64> = units.rotation.concat();
        let frame = Matrix3::from_row_slice(&rows);
        let off = (frame * frame.transpose() - Matrix3::identity()).amax();
        if off.is_nan() || off >= 1e-9 {
            return Err(Error::argument("frame", "a matrix with R R^T = 1", format!("{rows:?}")));
        }
        let from_world = frame * self.chain.base().rotation.matrix().transpose();
        let mut turned = b;
        for block in 0..turned.ncols() / 3 {
            let weight = if block == 0 {
                1.0
            } else {
                units.per_radian.map_or(1.0, |length| length / self.rotation_scale)
            };
            let part = turned.columns(3 * block, 3) * from_world * (weight / units.length);
            turned.columns_mut(3 * block, 3).copy_from(&part);
        }
        Ok(turned)
    }

    /// Rows for joint values in the gain's units, made ones in rad and m.
    fn joint_side(&self, mut c: DMatrix<f64>, units: &GainUnits) -> DMatrix<f64> {
        for (i, v) in self.chain.variables().iter().enumerate() {
            let unit = if v.kind == JointKind::Prismatic { units.length } else { units.angle };
            c.row_mut(i).scale_mut(unit);
        }
        c
    }

    /// A share of the pseudo-inverse in the middle of the limits, or where that is singular
    /// in the least singular of some postures about it: a gain that leaves a direction out
    /// reaches nothing.
    fn frozen(&self) -> Result<DMatrix<f64>> {
        let rows = self.rows()?;
        let judged = |q: Vec<f64>| -> Result<_> {
            let jacobian = self.jacobian(&q, rows);
            let values = decomposed(jacobian.clone(), false)?.singular_values;
            let floor = FROZEN_CUTOFF * values.max();
            let kept = values.iter().filter(|value| **value > floor);
            let least = kept.clone().fold(f64::INFINITY, |least, value| least.min(*value));
            Ok((kept.count(), least / values.max(), jacobian))
        };
        let in_middle = judged(middle(self.chain))?;
        let singular = in_middle.0 < rows.min(self.chain.dof());
        let others = about_middle(self.chain).take_while(|_| singular).map(judged);
        let others: Vec<_> = others.collect::<Result<_>>()?;
        let better = others.into_iter().filter(|other| other.0 > in_middle.0);
        let best = better.max_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (_, _, jacobian) = best.unwrap_or(in_middle);
        let svd = decomposed(jacobian, true)?;
        let floor = FROZEN_CUTOFF * svd.singular_values.max();
        let inverse = svd.pseudo_inverse(floor).map_err(no_inverse)?;
        Ok(inverse * FROZEN_SHARE)
    }

    /// The Jacobian of the task, in the loop's units.
    fn jacobian(&self, q: &[f64], rows: usize) -> DMatrix<f64> {
        let compiled = self.chain.compiled();
        let mut workspace = Workspace::<f64>::new(compiled);
        forward(compiled, q, &mut workspace);
        let mut jacobian = DMatrix::<f64>::zeros(rows, q.len());
        let point = workspace.tool_point(self.tail.translation);
        columns(compiled, &workspace, point, |variable, linear, angular| {
            for k in 0..3 {
                jacobian[(k, variable)] += linear[k];
                if rows == 6 {
                    jacobian[(3 + k, variable)] += self.rotation_scale * angular[k];
                }
            }
        });
        if let Measure::Framed(FramedRows { weights, .. }) = self.measure {
            for (k, weight) in weights.iter().enumerate() {
                jacobian.row_mut(k).scale_mut(*weight);
            }
        }
        jacobian
    }
}

fn no_inverse(why: impl ToString) -> Error {
    Error::argument("solver", "a chain with a Jacobian that can be inverted", why)
}

/// The singular value decomposition of a Jacobian, if it ends.
fn decomposed(jacobian: DMatrix<f64>, vectors: bool) -> Result<SVD<f64, Dyn, Dyn>> {
    // On what is no number it may go on for ever, or panic.
    if !jacobian.iter().all(|x| x.is_finite()) {
        return Err(no_inverse("one beyond all numbers"));
    }
    SVD::try_new(jacobian, vectors, vectors, 5.0 * f64::EPSILON, SWEEPS)
        .ok_or_else(|| no_inverse("one whose singular values do not settle"))
}

/// The gain that feedback laws without matrices start from: joint values (rad or m) by metres
/// of error along the axes of the chain's first link. With `per_radian` (m) for poses: three
/// more columns for the orientation, of which a radian counts as so many metres.
pub fn frozen_gain(chain: &Chain, per_radian: Option<f64>) -> Result<Matrix> {
    let tail = &chain.compiled().tail;
    let rotation_scale = per_radian.unwrap_or(1.0);
    let measure = match per_radian {
        Some(scale) => Measure::Pose(PoseRows { scale, onward: None }),
        None => Measure::Position(PositionRows),
    };
    let around = Around { chain, measure, tail, rotation_scale };
    let mut gain = around.frozen()?;
    for block in 0..gain.ncols() / 3 {
        let turned = gain.columns(3 * block, 3) * chain.base().rotation.matrix();
        gain.columns_mut(3 * block, 3).copy_from(&turned);
    }
    Ok(Matrix::of(&gain))
}

/// Postures a quarter of the range on either side of the middle, joint by joint in other
/// patterns: a handful, of which none is special.
fn about_middle(chain: &Chain) -> impl Iterator<Item = Vec<f64>> {
    (1u32..16).map(|pattern| {
        let value = |(i, v): (usize, &crate::chain::Variable)| {
            let (low, high) = if (v.upper - v.lower).is_finite() {
                (v.lower, v.upper)
            } else {
                (-std::f64::consts::PI, std::f64::consts::PI)
            };
            let side = if pattern >> (i % 4) & 1 == 1 { 0.75 } else { 0.4 };
            low + side * (high - low)
        };
        chain.variables().iter().enumerate().map(value).collect()
    })
}

/// The middle of the limits; zero for continuous joints.
pub fn middle(chain: &Chain) -> Vec<f64> {
    chain.variables().iter().map(crate::chain::Variable::middle).collect()
}
