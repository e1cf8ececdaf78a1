//! The ring of six joints and the goal, cut so that the goal link lies between the two joints
//! that are eliminated: the goal makes the pair generic, whatever the arm.
//!
//! For joints `g1 ... g6 = D` the ring is read as `g6' g1 g2 g3 g4 g5 = D` with `g6` seen from
//! the goal. What `g2 g3 g4` do to the line of `g5` then depends on the arm alone, and
//! `g1^-1 g6'^-1 D` does the same to it.

use super::line::{Line, SIZE, STILL, THIRDS, TURNED, line, moved, parts};
use crate::closed_form::geometry::mirrors::{inner, mirror, reflect};
use crate::closed_form::geometry::rigid::{Rigid, turned_about};
use crate::closed_form::geometry::screws::{Screw, Screws};
use crate::closed_form::geometry::turn::unit_pair;
use crate::lanes::{Real, V3, cross, dot, splat3, sub};

/// Terms of three angles of first degree each.
pub const TERMS: usize = 27;
/// Equations without the first and the last joint.
pub const ROWS: usize = 6;

/// Six equations, `[part of the hidden angle][power of x, power of y][equation]`.
pub type Equations<R> = [[[R; ROWS]; 9]; 3];

/// A cut of an arm, with all that does not depend on the goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// The arm is read from its tool.
    pub reversed: bool,
    /// From the base frame to the one whose z is the axis of `g1`.
    into: Rigid<f64>,
    /// Tool at `q = 0` in that frame, inverse.
    untool: Rigid<f64>,
    /// The axes in that frame.
    joints: [Screw; 6],
    /// A direction across the axis of `g5`.
    across: V3<f64>,
    /// What `g6^-1` makes of the line of `g5`: constant, cosine and sine part.
    last: [Line<f64>; 3],
    /// What `g2 g3 g4` make of it: for each number the products of `(1, cos, sin)` of `g2` and of
    /// powers of the tangents of half the angles of `g3` and `g4`.
    powers: Box<[[f64; TERMS]; SIZE]>,
}

/// The line of `g5` from the goal's side, in `(1, cos, sin)` of `g6`.
#[derive(Clone, Copy)]
pub struct Far<R> {
    parts: [Line<R>; 3],
}

impl Cut {
    /// A cut of an arm of six joints with lengths of about 1.
    pub fn new(screws: &Screws, reversed: bool) -> Self {
        let arm = if reversed { screws.reversed() } else { screws.clone() }.gathered();
        let first = arm.joints[0];
        let guess = if first.axis[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let y = unit(cross(first.axis, guess));
        let frame = Rigid { axes: [cross(y, first.axis), y, first.axis], shift: first.point };
        let into = frame.inverse();
        let arm = arm.moved(&into);
        let joint = |k: usize| arm.joints[k];
        let ahead = line(joint(4).axis, joint(4).point);
        let powers = powers(&[1, 2, 3].map(joint), &ahead);
        let at = THIRDS.map(|q| moved(&joint(5).turn(-q), &ahead, 1.0));
        let mut last = [[0.0; SIZE]; 3];
        for i in 0..SIZE {
            for (k, x) in parts([at[0][i], at[1][i], at[2][i]]).into_iter().enumerate() {
                last[k][i] = x;
            }
        }
        let w = joint(4).axis;
        let guess = if w[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        Self {
            reversed,
            into,
            untool: arm.tool.inverse(),
            joints: [0, 1, 2, 3, 4, 5].map(joint),
            across: unit(cross(w, guess)),
            last,
            powers,
        }
    }

    /// What the six joints have to bring about for a tool pose: `D`.
    #[inline(always)]
    pub fn wanted<R: Real>(&self, pose: &Rigid<R>) -> Rigid<R> {
        let pose = if self.reversed { pose.inverse() } else { *pose };
        Rigid::splat(&self.into).after(&pose).after(&Rigid::splat(&self.untool))
    }

    /// The line of `g5` seen from the goal.
    #[inline(always)]
    pub fn far<R: Real>(&self, wanted: &Rigid<R>) -> Far<R> {
        let mut parts = [[R::zero(); SIZE]; 3];
        for (k, part) in parts.iter_mut().enumerate() {
            let mut from = [R::zero(); SIZE];
            for i in 0..SIZE {
                from[i] = R::splat(self.last[k][i]);
            }
            *part = moved(wanted, &from, if k == 0 { 1.0 } else { 0.0 });
        }
        Far { parts }
    }

    /// The six equations that are left when `g6` and `g1` are eliminated.
    #[inline(always)]
    pub fn equations<R: Real>(&self, far: &Far<R>) -> Equations<R> {
        let mut out = [[R::zero(); TERMS]; ROWS];
        self.still_rows(far, &mut out);
        self.turned_rows(far, &mut out);
        orthonormal(&mut out);
        let mut equations = [[[R::zero(); ROWS]; 9]; 3];
        for (i, row) in out.iter().enumerate() {
            for (k, x) in row.iter().enumerate() {
                equations[k / 9][k % 9][i] = *x;
            }
        }
        equations
    }

    /// Four equations of the numbers that `g1` leaves alone.
    #[inline(always)]
    fn still_rows<R: Real>(&self, far: &Far<R>, out: &mut [[R; TERMS]; ROWS]) {
        let (mut one, mut two, mut constant) = ([R::zero(); 6], [R::zero(); 6], [R::zero(); 6]);
        for (k, i) in STILL.into_iter().enumerate() {
            constant[k] = far.parts[0][i];
            one[k] = far.parts[1][i];
            two[k] = far.parts[2][i];
        }
        let v = mirror::<R, 6, 0>(&mut one);
        reflect::<R, 6, 0>(&v, &mut two);
        let w = mirror::<R, 6, 1>(&mut two);
        for row in 0..4 {
            // Row of the null space: the mirrors on a unit vector.
            let mut n = [R::zero(); 6];
            n[2 + row] = R::splat(1.0);
            reflect::<R, 6, 1>(&w, &mut n);
            reflect::<R, 6, 0>(&v, &mut n);
            let mut offset = R::zero();
            for (k, i) in STILL.into_iter().enumerate() {
                offset = n[k].mul_add(constant[k], offset);
                let factors = &self.powers[i];
                for term in 0..TERMS {
                    out[row][term] = n[k].mul_add(R::splat(factors[term]), out[row][term]);
                }
            }
            // The constant times (1 + x^2)(1 + y^2).
            for term in [0, 2, 6, 8] {
                out[row][term] -= offset;
            }
        }
    }

    /// Two equations of those that it turns: one, in complex numbers.
    #[inline(always)]
    fn turned_rows<R: Real>(&self, far: &Far<R>, out: &mut [[R; TERMS]; ROWS]) {
        let mut columns = [[(R::zero(), R::zero()); 4]; 3];
        for (column, part) in columns.iter_mut().zip(&far.parts) {
            for (x, (re, im)) in column.iter_mut().zip(TURNED) {
                *x = (part[re], part[im]);
            }
        }
        let n = across_three(&mut columns);
        for (k, (re, im)) in TURNED.into_iter().enumerate() {
            let (x, y) = (&self.powers[re], &self.powers[im]);
            let (a, b) = n[k];
            for term in 0..TERMS {
                let (x, y) = (R::splat(x[term]), R::splat(y[term]));
                // conj(n) (x + i y)
                out[4][term] = a.mul_add(x, b.mul_add(y, out[4][term]));
                out[5][term] = a.mul_add(y, (-b).mul_add(x, out[5][term]));
            }
        }
    }

    /// Joint values `g1 ... g6`, as sine and cosine, from those of `g2, g3, g4`.
    #[inline(always)]
    pub fn complete<R: Real>(
        &self,
        wanted: &Rigid<R>,
        far: &Far<R>,
        known: [(R, R); 3],
    ) -> [(R, R); 6] {
        // What g2 g3 g4 make of the line of g5.
        let (mut along, mut at) = (splat3(self.joints[4].axis), splat3(self.joints[4].point));
        for k in [2, 1, 0] {
            let joint = &self.joints[1 + k];
            let (axis, point) = (splat3(joint.axis), splat3(joint.point));
            along = turned_about(axis, known[k], along);
            let way = turned_about(axis, known[k], sub(at, point));
            at = [way[0] + point[0], way[1] + point[1], way[2] + point[2]];
        }
        let near = line(along, at);
        // g6 from the numbers that g1 leaves alone, by least squares.
        let [constant, cosine, sine] = &far.parts;
        let (mut cc, mut cs, mut ss, mut cr, mut sr) =
            (R::zero(), R::zero(), R::zero(), R::zero(), R::zero());
        for i in STILL {
            let left = near[i] - constant[i];
            cc = cosine[i].mul_add(cosine[i], cc);
            cs = cosine[i].mul_add(sine[i], cs);
            ss = sine[i].mul_add(sine[i], ss);
            cr = cosine[i].mul_add(left, cr);
            sr = sine[i].mul_add(left, sr);
        }
        let sixth = unit_pair(cc * sr - cs * cr, ss * cr - cs * sr);
        // g1 from those that it turns.
        let (mut along, mut aside) = (R::zero(), R::zero());
        for (re, im) in TURNED {
            let x = sine[re].mul_add(sixth.0, cosine[re].mul_add(sixth.1, constant[re]));
            let y = sine[im].mul_add(sixth.0, cosine[im].mul_add(sixth.1, constant[im]));
            along = x.mul_add(near[re], y.mul_add(near[im], along));
            aside = y.mul_add(near[re], (-x).mul_add(near[im], aside));
        }
        let first = unit_pair(aside, along);
        // g5 from what is left of a direction across its axis.
        let start = splat3::<R>(self.across);
        let v = wanted.turn(turned_about(splat3(self.joints[5].axis), back(sixth), start));
        let v = turned_about(splat3(self.joints[0].axis), back(first), v);
        let v = turned_about(splat3(self.joints[1].axis), back(known[0]), v);
        let v = turned_about(splat3(self.joints[2].axis), back(known[1]), v);
        let v = turned_about(splat3(self.joints[3].axis), back(known[2]), v);
        let fifth = unit_pair(dot(splat3(self.joints[4].axis), cross(start, v)), dot(start, v));
        [first, known[0], known[1], known[2], fifth, sixth]
    }
}

/// What three joints make of a line, in products of `(1, cos, sin)` of the first angle and powers
/// of the tangents of half the two others.
fn powers(joints: &[Screw; 3], ahead: &Line<f64>) -> Box<[[f64; TERMS]; SIZE]> {
    let mut lines = [[0.0; SIZE]; TERMS];
    lines[0] = *ahead;
    // One joint after the other: constant, cosine and sine part of each line so far.
    let mut count = 1;
    for joint in joints.iter().rev() {
        let turns = [joint.turn(THIRDS[1]), joint.turn(THIRDS[2])];
        for k in 0..count {
            let still = lines[k];
            let constant = if k == 0 { 1.0 } else { 0.0 };
            let [plus, minus] = [0, 1].map(|i| moved(&turns[i], &still, constant));
            for i in 0..SIZE {
                let found = parts([still[i], plus[i], minus[i]]);
                for (part, x) in found.into_iter().enumerate() {
                    lines[k + count * part][i] = x;
                }
            }
        }
        count *= 3;
    }
    let mut out = Box::new([[0.0; TERMS]; SIZE]);
    for (i, row) in out.iter_mut().enumerate() {
        for (x, line) in row.iter_mut().zip(&lines) {
            *x = line[i];
        }
        for stride in [3, 1] {
            for start in (0..TERMS).filter(|i| i / stride % 3 == 0) {
                // (1, cos, sin)(1 + x^2) = (1 + x^2, 1 - x^2, 2 x).
                let [k, c, s] = [row[start], row[start + stride], row[start + 2 * stride]];
                row[start] = k + c;
                row[start + stride] = 2.0 * s;
                row[start + 2 * stride] = k - c;
            }
        }
    }
    out
}

#[inline(always)]
fn back<R: Real>((s, c): (R, R)) -> (R, R) {
    (-s, c)
}

fn unit(v: V3<f64>) -> V3<f64> {
    let size = dot(v, v).sqrt();
    [v[0] / size, v[1] / size, v[2] / size]
}

/// A unit vector across three columns of complex numbers.
#[inline(always)]
fn across_three<R: Real>(columns: &mut [[(R, R); 4]; 3]) -> [(R, R); 4] {
    let mut mirrors = [([(R::zero(), R::zero()); 4], R::zero()); 3];
    for k in 0..3 {
        let column = columns[k];
        let mut square = R::zero();
        for (re, im) in &column[k..] {
            square = re.mul_add(*re, im.mul_add(*im, square));
        }
        let (re, im) = column[k];
        let size = square.sqrt();
        let head = re.mul_add(re, im * im).max(R::splat(f64::MIN_POSITIVE)).sqrt();
        let share = size / head;
        // x + (x0 / |x0|) |x| e0; where x0 = 0 any phase does, but not none at all.
        let open = head.lt(R::splat(1e-150));
        let mut normal = column;
        normal[k] = (R::select(open, size, re.mul_add(share, re)), im.mul_add(share, im));
        let whole = square + size * R::select(open, R::zero(), head);
        let weight = R::splat(1.0) / whole.max(R::splat(f64::MIN_POSITIVE));
        mirrors[k] = (normal, weight);
        for later in k + 1..3 {
            complex_reflect(&mirrors[k], &mut columns[later], k);
        }
    }
    let mut n = [(R::zero(), R::zero()); 4];
    n[3].0 = R::splat(1.0);
    for k in [2, 1, 0] {
        complex_reflect(&mirrors[k], &mut n, k);
    }
    n
}

#[inline(always)]
fn complex_reflect<R: Real>(
    (normal, weight): &([(R, R); 4], R),
    column: &mut [(R, R); 4],
    from: usize,
) {
    let (mut re, mut im) = (R::zero(), R::zero());
    for i in from..4 {
        let ((a, b), (x, y)) = (normal[i], column[i]);
        re = a.mul_add(x, b.mul_add(y, re));
        im = a.mul_add(y, (-b).mul_add(x, im));
    }
    (re, im) = (re * *weight, im * *weight);
    for i in from..4 {
        let (a, b) = normal[i];
        column[i].0 -= a * re - b * im;
        column[i].1 -= a * im + b * re;
    }
}

/// Rows made of unit length and across one another.
#[inline(always)]
fn orthonormal<R: Real>(rows: &mut [[R; TERMS]; ROWS]) {
    for i in 0..ROWS {
        let (done, rest) = rows.split_at_mut(i);
        let row = &mut rest[0];
        for other in done.iter() {
            let along = inner::<R, TERMS, 0>(other, row);
            for k in 0..TERMS {
                row[k] = other[k].neg_mul_add(along, row[k]);
            }
        }
        let square = inner::<R, TERMS, 0>(row, row);
        let inverse = R::splat(1.0) / square.max(R::splat(f64::MIN_POSITIVE)).sqrt();
        for x in row.iter_mut() {
            *x *= inverse;
        }
    }
}
