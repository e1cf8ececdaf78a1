//! Vectors, and turns from quaternions, for the tests.

#![allow(dead_code, reason = "each test uses a part")]

pub mod arm;

use agrik_solids::Point;

pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(a: Point, s: f64) -> Point {
    a.map(|x| x * s)
}

pub fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// The rows of the rotation of a quaternion (w first), which need not be of unit length.
pub fn rotation([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    let length = (w * w + x * x + y * y + z * z).sqrt().max(1e-3);
    let [w, x, y, z] = [w, x, y, z].map(|q| q / length);
    // What the length was too short for is made up for by the real part.
    let w = w.signum() * (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Numbers that are the same each time: SplitMix64.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * ((self.word() >> 11) as f64 / 9_007_199_254_740_992.0)
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.word() % count as u64) as usize
    }
}
