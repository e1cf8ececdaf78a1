//! The point of a point, line, triangle or tetrahedron that is nearest to the origin.

use agrik_compute::lanes::{axpy, cross, dot, scale, sub};

use crate::shapes::Point;

/// A corner: the difference of a point of one core and a point of another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub difference: Point,
    pub on_a: Point,
    pub on_b: Point,
}

/// Corners with weights that add up to 1: a point of the simplex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighted {
    pub corners: [usize; 4],
    pub weights: [f64; 4],
    pub count: usize,
    /// The point itself.
    pub point: Point,
    /// The square of its distance from the origin.
    pub square: f64,
    /// Where it lies from the origin, perpendicular to the edge or face that it lies on: close
    /// to the origin the point itself is mostly what rounding left of it.
    pub direction: Point,
}

impl Weighted {
    fn of(simplex: &[Corner], corners: &[usize], weights: &[f64]) -> Self {
        let mut made = Self {
            corners: [0; 4],
            weights: [0.0; 4],
            count: 0,
            point: [0.0; 3],
            square: 0.0,
            direction: [0.0; 3],
        };
        for (corner, weight) in corners.iter().zip(weights) {
            if *weight > 0.0 {
                made.corners[made.count] = *corner;
                made.weights[made.count] = *weight;
                made.count += 1;
                made.point = axpy(simplex[*corner].difference, *weight, made.point);
            }
        }
        made.square = dot(made.point, made.point);
        made.direction = made.point;
        made
    }

    /// The point of either core: the same mix of what the corners hold.
    pub fn on_core(&self, simplex: &[Corner], of: fn(&Corner) -> Point) -> Point {
        (0..self.count)
            .fold([0.0; 3], |sum, i| axpy(of(&simplex[self.corners[i]]), self.weights[i], sum))
    }
}

/// The nearest point of the hull of up to four corners, among those in which the last corner
/// has a part: the best of what the edges and faces at it and the inside have to offer, each
/// a true mix of the corners, so that a corner which adds hardly anything to the volume does
/// no harm.
pub(super) fn nearest(simplex: &[Corner]) -> Weighted {
    let last = simplex.len() - 1;
    let mut best = Weighted::of(simplex, &[last], &[1.0]);
    let mut take = |found: Option<Weighted>| {
        if let Some(found) = found
            && found.square < best.square
        {
            best = found;
        }
    };
    for i in 0..last {
        take(Some(on_edge(simplex, [i, last])));
        for j in 0..i {
            take(on_face(simplex, [i, j, last]));
        }
    }
    if last == 3 {
        take(inside(simplex));
    }
    best
}

/// The foot of the perpendicular from the origin, or an end.
fn on_edge(simplex: &[Corner], [i, j]: [usize; 2]) -> Weighted {
    let (a, b) = (simplex[i].difference, simplex[j].difference);
    let way = sub(b, a);
    let square = dot(way, way);
    let t = if square > 0.0 { (-dot(a, way) / square).clamp(0.0, 1.0) } else { 0.0 };
    let mut made = Weighted::of(simplex, &[i, j], &[1.0 - t, t]);
    if made.count == 2 {
        made.direction = axpy(way, -dot(made.point, way) / square, made.point);
    }
    made
}

/// The foot of the perpendicular from the origin, where it lies within the face.
fn on_face(simplex: &[Corner], face: [usize; 3]) -> Option<Weighted> {
    let [a, b, c] = face.map(|corner| simplex[corner].difference);
    let normal = cross(sub(b, a), sub(c, a));
    let square = dot(normal, normal);
    if square <= 0.0 {
        return None;
    }
    let height = scale(normal, dot(normal, a) / square);
    let [p, q, r] = [sub(a, height), sub(b, height), sub(c, height)];
    let weights = [dot(normal, cross(q, r)), dot(normal, cross(r, p)), dot(normal, cross(p, q))];
    let mut made = positive(simplex, &face, &weights)?;
    if made.count == 3 {
        made.direction = height;
    }
    Some(made)
}

/// The origin, where it lies within the tetrahedron.
fn inside(simplex: &[Corner]) -> Option<Weighted> {
    let corner = |k: usize| simplex[k].difference;
    let [a, b, c, d] = [corner(0), corner(1), corner(2), corner(3)];
    let volume = |p, q, r| dot(p, cross(q, r));
    let weights = [volume(b, d, c), volume(a, c, d), volume(a, d, b), volume(a, b, c)];
    let sign = if weights.iter().sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
    positive(simplex, &[0, 1, 2, 3], &weights.map(|w| w * sign))
}

/// The mix with these weights, once they add up to 1, if none is negative.
fn positive(simplex: &[Corner], corners: &[usize], weights: &[f64]) -> Option<Weighted> {
    let sum: f64 = weights.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) || weights.iter().any(|w| *w < 0.0) {
        return None;
    }
    let mut shares = [0.0; 4];
    for (share, weight) in shares.iter_mut().zip(weights) {
        *share = weight / sum;
    }
    Some(Weighted::of(simplex, corners, &shares[..corners.len()]))
}
