//! Frames and points of eight postures, in singles.

use agrik::kinematics::FRAME;
use agrik_compute::lanes::{Real32, WIDEST};
use agrik_solids::Point;

/// One number of each lane.
pub(super) type Eight = [f32; WIDEST];

/// The axes of a frame and its origin, in lanes.
pub(super) struct Frame<R> {
    m: [R; FRAME],
}

impl<R: Real32> Frame<R> {
    #[inline(always)]
    pub fn load(frames: &[Eight], link: usize) -> Self {
        let from = &frames[link * FRAME..(link + 1) * FRAME];
        let mut m = [R::splat(0.0); FRAME];
        for (to, from) in m.iter_mut().zip(from) {
            *to = R::load(from);
        }
        Self { m }
    }

    /// Where the middle of a ball is.
    #[inline(always)]
    pub fn place(&self, [x, y, z, _]: &[f32; 4]) -> [R; 3] {
        self.point([one(*x), one(*y), one(*z)])
    }

    /// Where points of the frame are.
    #[inline(always)]
    pub fn point(&self, [x, y, z]: [R; 3]) -> [R; 3] {
        let m = &self.m;
        [
            m[0].mul_add(x, m[1].mul_add(y, m[2].mul_add(z, m[9]))),
            m[3].mul_add(x, m[4].mul_add(y, m[5].mul_add(z, m[10]))),
            m[6].mul_add(x, m[7].mul_add(y, m[8].mul_add(z, m[11]))),
        ]
    }

    /// Where a direction of the frame points to.
    #[inline(always)]
    pub fn turned(&self, [x, y, z]: &[f32; 3]) -> [R; 3] {
        let (m, [x, y, z]) = (&self.m, [one(*x), one(*y), one::<R>(*z)]);
        [
            m[0].mul_add(x, m[1].mul_add(y, m[2] * z)),
            m[3].mul_add(x, m[4].mul_add(y, m[5] * z)),
            m[6].mul_add(x, m[7].mul_add(y, m[8] * z)),
        ]
    }

    /// Coordinates in the frame.
    #[inline(always)]
    pub fn inner(&self, p: &[R; 3]) -> [R; 3] {
        let m = &self.m;
        let [x, y, z] = [p[0] - m[9], p[1] - m[10], p[2] - m[11]];
        [
            m[0].mul_add(x, m[3].mul_add(y, m[6] * z)),
            m[1].mul_add(x, m[4].mul_add(y, m[7] * z)),
            m[2].mul_add(x, m[5].mul_add(y, m[8] * z)),
        ]
    }
}

#[inline(always)]
pub(super) fn one<R: Real32>(x: f32) -> R {
    R::splat(f64::from(x))
}

#[inline(always)]
pub(super) fn load<R: Real32>(at: &[Eight; 3]) -> [R; 3] {
    [R::load(&at[0]), R::load(&at[1]), R::load(&at[2])]
}

#[inline(always)]
pub(super) fn store<R: Real32>(from: [R; 3], to: &mut [Eight; 3]) {
    for (to, from) in to.iter_mut().zip(from) {
        from.store(to);
    }
}

/// Frames as singles from an origin, before them the world's; the largest coordinate of an
/// origin of them, m.
#[inline(always)]
pub(super) fn singles<R: Real32>(frames: &[[f64; WIDEST]], origin: Point, to: &mut [Eight]) -> f32 {
    let mut away = one::<R>(0.0);
    for (k, to) in to[..FRAME].iter_mut().enumerate() {
        let turn = if k < 9 && k % 4 == 0 { 1.0 } else { 0.0 };
        let number = if k < 9 { turn } else { -origin[k - 9] as f32 };
        away = if k < 9 { away } else { away.max(one(number.abs())) };
        *to = [number; WIDEST];
    }
    for (frame, to) in frames.chunks_exact(FRAME).zip(to[FRAME..].chunks_exact_mut(FRAME)) {
        for (k, (from, to)) in frame.iter().zip(to).enumerate() {
            let off = if k < 9 { 0.0 } else { origin[k - 9] };
            for (to, from) in to.iter_mut().zip(from) {
                *to = (from - off) as f32;
            }
            away = if k < 9 { away } else { away.max(R::load(to).abs()) };
        }
    }
    let mut each = [0.0_f32; WIDEST];
    away.store(&mut each);
    each.into_iter().fold(0.0, f32::max)
}
