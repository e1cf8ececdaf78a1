//! The two arms of the paper, its gains and the goal sets of the specification.

use agrik::chain::{Chain, DhConvention, DhRow, JointKind};
use agrik::solve::{GainUnits, Matrix, Pace, Settings, StartRule, StateSpace, Step};
use nalgebra::IsometryMatrix3;
use serde_json::Value;

use crate::common::Sampler;

const GAINS: &str = include_str!("../../../../tests/data/hydrolek/gains.json");
const REFERENCE: &str = include_str!("../../../../tests/data/hydrolek/reference.json");
const DEGREE: f64 = std::f64::consts::PI / 180.0;

pub fn gains() -> Value {
    serde_json::from_str(GAINS).expect("JSON")
}

pub fn reference() -> Value {
    serde_json::from_str(REFERENCE).expect("JSON")
}

/// Numbers of a JSON array of any depth, in order.
pub fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        other => other.as_f64().into_iter().collect(),
    }
}

fn chain(rows: &[[f64; 4]], limits_deg: &[[f64; 2]]) -> Chain {
    let joints = rows.iter().zip(limits_deg).enumerate().map(|(i, (row, limit))| {
        let [a, alpha, d, theta] = *row;
        let row = DhRow { a, alpha: alpha * DEGREE, d, theta: theta * DEGREE };
        let (lower, upper) = (limit[0] * DEGREE, limit[1] * DEGREE);
        let name = format!("joint_{}", i + 1);
        row.joint(DhConvention::Standard, name, JointKind::Revolute, lower, upper)
    });
    let identity = IsometryMatrix3::identity();
    Chain::new("arm", joints.collect(), identity, identity, None).expect("a chain")
}

pub fn hydrolek() -> Chain {
    chain(
        &[
            [0.070, 90.0, 0.0, 0.0],
            [0.5234, 0.0, 0.0, 0.0],
            [0.165, -90.0, 0.0, 0.0],
            [0.04445, 90.0, -0.212, 0.0],
            [0.184, -90.0, 0.0, -90.0],
            [0.0, 0.0, 0.2848, -90.0],
        ],
        &[
            [-27.07, 40.60],
            [-10.32, 65.64],
            [-42.01, 21.43],
            [-63.94, 114.97],
            [-81.52, -4.16],
            [-260.0, 260.0],
        ],
    )
}

/// Three links of 2 units, joints within 60 degrees.
pub fn planar() -> Chain {
    chain(&[[2.0, 0.0, 0.0, 0.0]; 3], &[[-60.0, 60.0]; 3])
}

/// A point of the paper's frame, mm, in the D-H base frame, m.
pub fn from_paper(p: &[f64]) -> [f64; 3] {
    [1e-3 * p[0], -1e-3 * p[2], 1e-3 * p[1]]
}

/// The published way: one attempt, full steps, saturation.
pub fn plain(step: Step, start: StartRule) -> Settings {
    Settings {
        step,
        max_iterations: 1000,
        max_restarts: 0,
        max_step: 1e9,
        plain: true,
        start,
        pace: Pace::Full,
    }
}

pub fn paper_units(length: f64) -> GainUnits {
    GainUnits {
        length,
        angle: DEGREE,
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        per_radian: None,
    }
}

/// A set of `gains.json`; columns are added to B up to three.
pub fn state_space(set: &Value, units: GainUnits) -> StateSpace {
    let a =
        Matrix { columns: set["A"][0].as_array().expect("rows").len(), values: numbers(&set["A"]) };
    let mut b = Vec::new();
    for row in set["B"].as_array().expect("rows") {
        let mut row = numbers(row);
        row.resize(3, 0.0);
        b.extend(row);
    }
    let c = Matrix { columns: a.columns, values: numbers(&set["C"]) };
    StateSpace { a, b: Matrix { columns: 3, values: b }, c, units }
}

/// The goal set J of the specification: tool points at postures drawn uniformly.
pub fn joint_uniform(chain: &Chain, count: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut stream = Sampler(seed);
    let mut workspace = agrik::kinematics::Workspace::new(chain.compiled());
    let mut goals = Vec::new();
    for _ in 0..count {
        let draw = |v: &agrik::chain::Variable| v.lower + (v.upper - v.lower) * stream.unit();
        let q: Vec<f64> = chain.variables().iter().map(draw).collect();
        let pose = agrik::kinematics::tool_pose(chain, &q, &mut workspace);
        goals.push([pose[(0, 3)], pose[(1, 3)], pose[(2, 3)]]);
    }
    goals
}
