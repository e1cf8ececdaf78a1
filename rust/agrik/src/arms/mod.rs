//! The papers' own arms, which need masses, servos and rules that a chain does not have.

pub mod strawberry;
pub mod tomato;

/// How far two points are apart.
fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
