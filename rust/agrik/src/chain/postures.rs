//! Sampled postures of a chain with the frames they lead to, kept for choosing starts.

/// A table of joint values and of the last joint's frame at each, one column a number.
///
/// Frames are in single precision: they only rank starts, and half the bytes double the
/// rate at which a window of the table is searched.
#[derive(Debug, Clone, Default)]
pub struct Postures {
    /// Lower end and width of what each joint value is drawn from, rad or m.
    pub ranges: Vec<(f64, f64)>,
    /// Joint values, `dof` a posture.
    pub q: Vec<f64>,
    /// Position (3 rows), then the axes x, y, z (3 rows each) of the last joint's frame.
    pub frames: [Vec<f32>; 12],
}

impl Postures {
    /// How many postures.
    pub fn len(&self) -> usize {
        self.frames[0].len()
    }
    /// No posture at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
