//! Random chains of 1 to 10 moving joints, with fixed joints and followers between them.

use std::f64::consts::{FRAC_PI_2, PI};

use agrik::chain::{Chain, DhConvention, DhRow, Joint, JointKind, Mimic};
use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Unit, Vector3};
use proptest::prelude::*;

/// Angles as robots have them: none, right, straight, almost none, any.
fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![
        2 => Just(0.0),
        2 => prop_oneof![Just(FRAC_PI_2), Just(-FRAC_PI_2), Just(PI)],
        2 => (nearly_zero(), any::<bool>()).prop_map(|(x, pi)| if pi { PI + x } else { x }),
        2 => -PI..PI,
    ]
}

/// 1e-13 to 1e-2, of either sign.
fn nearly_zero() -> impl Strategy<Value = f64> {
    (-13.0..-2.0, any::<bool>()).prop_map(|(power, negative)| {
        let x = 10_f64.powf(power);
        if negative { -x } else { x }
    })
}

fn length() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), -1.0..1.0]
}

/// A D-H row with any of these angles and lengths.
pub fn dh_row() -> impl Strategy<Value = DhRow> {
    (length(), angle(), length(), angle()).prop_map(|(a, alpha, d, theta)| DhRow {
        a,
        alpha,
        d,
        theta,
    })
}

// Boxed from here on: the strategies hold one another by value and outgrow the stack.
fn transform() -> BoxedStrategy<IsometryMatrix3<f64>> {
    ((length(), length(), length()), (angle(), angle(), angle()))
        .prop_map(|(t, r)| {
            IsometryMatrix3::from_parts(
                Translation3::new(t.0, t.1, t.2),
                Rotation3::from_euler_angles(r.0, r.1, r.2),
            )
        })
        .boxed()
}

fn axis() -> BoxedStrategy<Unit<Vector3<f64>>> {
    let along = prop_oneof![
        Just(Vector3::x()),
        Just(Vector3::y()),
        Just(Vector3::z()),
        Just(-Vector3::x()),
        Just(-Vector3::z()),
    ];
    let tilted = (nearly_zero(), nearly_zero(), any::<bool>())
        .prop_map(|(x, y, up)| Vector3::new(x, y, if up { 1.0 } else { -1.0 }));
    let any_way = (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("a direction", |v| v.norm() > 0.01);
    prop_oneof![along, tilted, any_way].prop_map(Unit::new_normalize).boxed()
}

/// A moving joint without a name.
fn moving() -> BoxedStrategy<Joint> {
    let kind = prop_oneof![
        3 => Just(JointKind::Revolute),
        1 => Just(JointKind::Continuous),
        2 => Just(JointKind::Prismatic),
    ];
    let general = (transform(), axis()).prop_map(|(origin, axis)| (origin, axis, None));
    let dh = (dh_row(), any::<bool>()).prop_map(|(row, modified)| {
        let convention = if modified { DhConvention::Modified } else { DhConvention::Standard };
        let joint = row.joint(convention, "", JointKind::Fixed, 0.0, 0.0);
        (joint.origin, joint.axis, Some(joint.after))
    });
    (kind, prop_oneof![general.boxed(), dh.boxed()], -2.0..2.0, 0.0..4.0)
        .prop_map(|(kind, (origin, axis, after), lower, span)| {
            let (lower, upper) = match kind {
                JointKind::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
                _ => (lower, lower + span),
            };
            let mut joint = Joint::new("", kind, lower, upper);
            joint.origin = origin;
            joint.axis = axis;
            joint.after = after.unwrap_or_else(IsometryMatrix3::identity);
            joint
        })
        .boxed()
}

/// What may follow a moving joint: nothing, a fixed joint, a follower of it or of a joint
/// that is not on the chain.
#[derive(Debug, Clone)]
enum Extra {
    Nothing,
    Fixed(IsometryMatrix3<f64>),
    Follower { joint: Box<Joint>, multiplier: f64, offset: f64, share: f64, elsewhere: bool },
}

fn extra() -> BoxedStrategy<Extra> {
    let follower = (moving(), -2.0..2.0, -1.0..1.0, 0.3..1.5, any::<bool>()).prop_map(
        |(joint, multiplier, offset, share, elsewhere)| Extra::Follower {
            joint: Box::new(joint),
            multiplier,
            offset,
            share,
            elsewhere,
        },
    );
    prop_oneof![4 => Just(Extra::Nothing), 1 => transform().prop_map(Extra::Fixed), 1 => follower]
        .boxed()
}

/// A chain with a base and a tool.
pub fn chain() -> BoxedStrategy<Chain> {
    let joints = prop::collection::vec((moving(), extra()), 1..=10);
    (joints, transform(), transform())
        .prop_map(|(parts, base, tool)| {
            let mut joints = Vec::new();
            for (i, (mut joint, extra)) in parts.into_iter().enumerate() {
                joint.name = format!("joint{i}");
                let leader = joint.clone();
                joints.push(joint);
                match extra {
                    Extra::Nothing => {}
                    Extra::Fixed(origin) => {
                        let mut fixed = Joint::new(format!("fixed{i}"), JointKind::Fixed, 0.0, 0.0);
                        fixed.origin = origin;
                        joints.push(fixed);
                    }
                    Extra::Follower { mut joint, multiplier, offset, share, elsewhere } => {
                        joint.name = format!("follower{i}");
                        let limits =
                            if elsewhere { (-1.0, 0.5) } else { (leader.lower, leader.upper) };
                        (joint.lower, joint.upper) = part_of(limits, multiplier, offset, share);
                        if joint.kind == JointKind::Continuous {
                            joint.kind = JointKind::Revolute;
                        }
                        joint.mimic = Some(Mimic {
                            source: if elsewhere { format!("elsewhere{i}") } else { leader.name },
                            multiplier,
                            offset,
                            source_limits: elsewhere.then_some(limits),
                        });
                        // A follower may come before its source.
                        let place = if i % 2 == 0 { joints.len() } else { joints.len() - 1 };
                        joints.insert(place, *joint);
                    }
                }
            }
            Chain::new("random", joints, base, tool, None).expect("a valid chain")
        })
        .boxed()
}

/// A share (or more than all) of the values that a follower can take.
fn part_of(limits: (f64, f64), multiplier: f64, offset: f64, share: f64) -> (f64, f64) {
    let (lower, upper) = if limits.0.is_finite() { limits } else { (-2.0, 2.0) };
    let (a, b) = (multiplier * lower + offset, multiplier * upper + offset);
    let (middle, half) = (0.5 * (a + b), 0.5 * share * (b - a).abs());
    // A thousandth more, so that rounding leaves an overlap where the source cannot move.
    (middle - half - 1e-3, middle + half + 1e-3)
}
