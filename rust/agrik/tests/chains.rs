//! Random chains: forward kinematics against a plain product of matrices, the Jacobian
//! against differences, the reach bounds and the followers' limits against samples.

mod common;

use agrik::chain::{Chain, DhConvention, DhRow, Joint, JointKind, Reach, Tail};
use agrik::kinematics::{Workspace, tool_jacobians, tool_pose};
use common::random_chain::{chain, dh_row};
use common::{Sampler, difference_jacobian, plain_poses, random_q, size};
use nalgebra::{IsometryMatrix3, Matrix4, Rotation3, Translation3, Vector3};
use proptest::prelude::*;

fn config() -> ProptestConfig {
    ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() }
}

/// Largest difference of two poses, lengths relative to `size`.
fn difference(a: &Matrix4<f64>, b: &Matrix4<f64>, size: f64) -> f64 {
    let d = a - b;
    let rotation = d.fixed_view::<3, 3>(0, 0).amax();
    rotation.max(d.fixed_view::<3, 1>(0, 3).amax() / size)
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn poses_equal_the_plain_product(chain in chain(), seed in any::<u64>()) {
        let mut sampler = Sampler(seed);
        let mut workspace = Workspace::new(chain.compiled());
        for _ in 0..20 {
            let q = random_q(&chain, &mut sampler);
            let plain = plain_poses(&chain, &q);
            let links = chain.link_poses(&q);
            prop_assert_eq!(links.len(), plain.len());
            let size = size(&chain);
            for (link, exact) in links.iter().zip(&plain) {
                prop_assert!(difference(link, exact, size) < 1e-12);
            }
            let tool = tool_pose(&chain, &q, &mut workspace);
            let error = difference(&tool, &plain[plain.len() - 1], size);
            prop_assert!(error < 1e-12, "tool off by {error:e}");
        }
    }

    #[test]
    fn jacobian_equals_differences(chain in chain(), seed in any::<u64>()) {
        let mut sampler = Sampler(seed);
        let dof = chain.dof();
        let size = size(&chain);
        // Two rows go one by one, five in the lanes of a vector.
        for rows in [2, 5] {
            let q: Vec<f64> = (0..rows).flat_map(|_| random_q(&chain, &mut sampler)).collect();
            let mut jacobians = vec![f64::NAN; rows * 6 * dof];
            tool_jacobians(&chain, &q, &mut jacobians);
            for (q, jacobian) in q.chunks_exact(dof).zip(jacobians.chunks_exact(6 * dof)) {
                for (i, column) in difference_jacobian(&chain, q, 1e-5).iter().enumerate() {
                    for (row, numeric) in column.iter().enumerate() {
                        let exact = jacobian[row * dof + i];
                        let unit = if row < 3 { size } else { 1.0 };
                        prop_assert!(
                            (exact - numeric).abs() < 1e-6 * unit,
                            "row {row}, column {i}: {exact} and {numeric}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn reach_bounds_hold(chain in chain(), tail in (-1.0..1.0, -1.0..1.0, -1.0..1.0), seed in any::<u64>()) {
        let mut sampler = Sampler(seed);
        let mut workspace = Workspace::new(chain.compiled());
        let (compiled, variables) = (chain.compiled(), chain.variables());
        let tail = Tail { translation: [tail.0, tail.1, tail.2], ..compiled.tail };
        let of_tail = Reach::with_tail(compiled, variables, &tail);
        let of_joint = Reach::of_last_joint(compiled, variables);
        for _ in 0..200 {
            let q = random_q(&chain, &mut sampler);
            let pose = tool_pose(&chain, &q, &mut workspace);
            let point = [pose[(0, 3)], pose[(1, 3)], pose[(2, 3)]];
            let reach = chain.reach();
            prop_assert!(reach.excess(point) <= 1e-12, "outside by {:e}", reach.excess(point));
            let from_center = Vector3::from(point) - Vector3::from(reach.center);
            prop_assert!(from_center.norm() <= reach.radius + 1e-12);
            prop_assert!(from_center.norm() >= reach.inner_radius - 1e-12);
            for (k, x) in point.iter().enumerate() {
                prop_assert!(reach.lower[k] - 1e-12 <= *x && *x <= reach.upper[k] + 1e-12);
            }
            prop_assert!(of_tail.excess(workspace.tool_point(tail.translation)) <= 1e-12);
            if let Some(reach) = of_joint {
                prop_assert!(reach.excess(workspace.tool_point([0.0; 3])) <= 1e-12);
            }
        }
    }

    #[test]
    fn reach_bounds_are_not_absurd(chain in chain()) {
        // Nearly parallel axes have a common normal far away, which must not show.
        let reach = chain.reach();
        prop_assert!(reach.radius < 10.0 * size(&chain), "radius {}", reach.radius);
        prop_assert!(reach.lower.iter().zip(&reach.upper).all(|(a, b)| a <= b));
    }

    #[test]
    fn followers_keep_their_limits(chain in chain(), seed in any::<u64>()) {
        let mut sampler = Sampler(seed);
        let q = random_q(&chain, &mut sampler);
        prop_assert!(chain.within_limits(&q));
        for joint in chain.joints() {
            let Some(mimic) = joint.mimic.as_ref() else { continue };
            let i = chain.variables().iter().position(|v| v.name == mimic.source);
            let value = mimic.multiplier * q[i.expect("a variable")] + mimic.offset;
            prop_assert!(joint.lower - 1e-9 <= value && value <= joint.upper + 1e-9);
        }
    }

    #[test]
    fn dh_rows_equal_their_matrices(
        rows in prop::collection::vec((dh_row(), any::<bool>()), 1..=10),
        modified in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let convention = if modified { DhConvention::Modified } else { DhConvention::Standard };
        let joints = rows.iter().enumerate().map(|(i, (row, slides))| {
            let (kind, limit) =
                if *slides { (JointKind::Prismatic, 1.0) } else { (JointKind::Revolute, 3.0) };
            row.joint(convention, format!("j{i}"), kind, -limit, limit)
        });
        let identity = IsometryMatrix3::identity();
        let chain = Chain::new("dh", joints.collect(), identity, identity, None);
        let chain = chain.expect("a chain");
        let mut sampler = Sampler(seed);
        let mut workspace = Workspace::new(chain.compiled());
        for _ in 0..20 {
            let q = random_q(&chain, &mut sampler);
            let exact = rows.iter().zip(&q).fold(Matrix4::identity(), |pose, ((row, slides), q)| {
                let (turn, slide) = if *slides { (0.0, *q) } else { (*q, 0.0) };
                let moved = DhRow { theta: row.theta + turn, d: row.d + slide, ..*row };
                pose * dh_matrix(&moved, modified)
            });
            let error = difference(&tool_pose(&chain, &q, &mut workspace), &exact, size(&chain));
            prop_assert!(error < 1e-12, "off by {error:e}");
        }
    }
}

/// The matrix of a row, entry by entry as textbooks print it.
fn dh_matrix(row: &DhRow, modified: bool) -> Matrix4<f64> {
    let (st, ct) = row.theta.sin_cos();
    let (sa, ca) = row.alpha.sin_cos();
    let (a, d) = (row.a, row.d);
    if modified {
        #[rustfmt::skip]
        let m = Matrix4::new(
            ct,      -st,      0.0, a,
            st * ca, ct * ca,  -sa, -sa * d,
            st * sa, ct * sa,  ca,  ca * d,
            0.0,     0.0,      0.0, 1.0,
        );
        m
    } else {
        #[rustfmt::skip]
        let m = Matrix4::new(
            ct,  -st * ca, st * sa,  a * ct,
            st,  ct * ca,  -ct * sa, a * st,
            0.0, sa,       ca,       d,
            0.0, 0.0,      0.0,      1.0,
        );
        m
    }
}

#[test]
fn an_axis_close_to_z_keeps_its_tilt() {
    // The angle between nearly equal vectors is lost where it is taken from a cosine.
    for tilt in [1e-13_f64, 1e-10, 1e-8, 1e-6, 1e-3] {
        for z in [1.0, -1.0] {
            let mut joint = Joint::new("j", JointKind::Revolute, -3.0, 3.0);
            joint.axis = nalgebra::Unit::new_normalize(Vector3::new(tilt, 0.0, z));
            let identity = IsometryMatrix3::identity();
            let tool = IsometryMatrix3::from_parts(
                Translation3::new(0.3, 0.2, 0.1),
                Rotation3::identity(),
            );
            let chain = Chain::new("tilted", vec![joint], identity, tool, None).expect("a chain");
            let q = [2.0];
            let mut workspace = Workspace::new(chain.compiled());
            let tool = tool_pose(&chain, &q, &mut workspace);
            let exact = plain_poses(&chain, &q)[1];
            assert!(difference(&tool, &exact, 1.0) < 1e-15 * 8.0, "tilt {tilt:e}");
        }
    }
}
