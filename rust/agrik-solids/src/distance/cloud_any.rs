//! A cloud and any core, sphere by sphere in lanes of doubles: for a few hundred of them, or
//! what is asked once. Many are better off in a [`crate::SphereTree`].

use agrik_compute::lanes::{Kernel, Level, Real, dispatch};

use super::{Closest, closest as closest_solids, norm, point_to_core};
use crate::probe::{CuboidProbe, PointProbe, Probe, SegmentProbe};
use crate::shapes::{Cloud, Core, Solid};

/// What lanes may be off by, in shares of the lengths that come into them.
const ROUNDINGS: f64 = 1e-14;

/// Where a cloud and a solid come nearest, and which of the spheres it is: the first of
/// several. None of an empty cloud.
pub fn closest(cloud: &Cloud, solid: &Solid) -> Option<(usize, Closest)> {
    closest_at(Level::in_use(), cloud, solid)
}

/// The same with the instructions of a level. The answer is the same at every level: lanes
/// find out which spheres come into question, and one by one decide.
pub fn closest_at(level: Level, cloud: &Cloud, solid: &Solid) -> Option<(usize, Closest)> {
    let mut rough = vec![0.0; cloud.len()];
    let (centre, size) = solid.core().bounding_sphere();
    let mut slack = 0.0;
    if let Core::Hull(_) | Core::HalfSpace(_) = solid.core() {
        for (distance, [x, y, z, r]) in rough.iter_mut().zip(cloud.spheres()) {
            *distance = point_to_core([x, y, z], solid.core()) - r;
        }
    } else {
        dispatch(level, Distances { cloud, core: solid.core(), into: &mut rough });
        let [x, y, z, r] = cloud
            .columns()
            .each_ref()
            .map(|column| column.iter().fold(0.0_f64, |most, value| most.max(value.abs())));
        slack = ROUNDINGS * (norm([x, y, z]) + r + norm(centre) + size);
    }
    let least = rough.iter().copied().fold(f64::INFINITY, f64::min);
    let mut best: Option<(usize, Closest)> = None;
    for (index, distance) in rough.into_iter().enumerate() {
        if distance <= least + slack {
            let [x, y, z, r] = cloud.sphere(index);
            let found = closest_solids(&Solid::known_sphere([x, y, z], r), solid);
            if best.is_none_or(|(_, best)| found.distance < best.distance) {
                best = Some((index, found));
            }
        }
    }
    best
}

/// Distance of every sphere from a core.
struct Distances<'a> {
    cloud: &'a Cloud,
    core: &'a Core,
    into: &'a mut [f64],
}

impl Kernel for Distances<'_> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        let origin = [0.0; 3];
        match self.core {
            Core::Point(p) => self.each::<R, _>(&PointProbe::new(*p, origin)),
            Core::Segment(segment) => self.each::<R, _>(&SegmentProbe::new(segment, origin)),
            Core::Cuboid(cuboid) => self.each::<R, _>(&CuboidProbe::new(cuboid, origin)),
            Core::Hull(_) | Core::HalfSpace(_) => {}
        }
    }
}

impl Distances<'_> {
    #[inline(always)]
    fn each<R: Real, P: Probe<R>>(self, probe: &P) {
        let [x, y, z, radius] = self.cloud.columns();
        let count = self.into.len();
        // The last lanes are those before once more.
        let mut first = 0;
        while first < count {
            if count < R::WIDTH {
                let lanes = |of: &[f64]| {
                    let mut all = R::zero();
                    for (lane, value) in of.iter().enumerate() {
                        all.set_lane(lane, *value);
                    }
                    all
                };
                let found = probe.square(&[lanes(x), lanes(y), lanes(z)]).sqrt() - lanes(radius);
                for (lane, to) in self.into.iter_mut().enumerate() {
                    *to = found.lane(lane);
                }
                return;
            }
            let at = first.min(count - R::WIDTH);
            let points = [R::load(&x[at..]), R::load(&y[at..]), R::load(&z[at..])];
            (probe.square(&points).sqrt() - R::load(&radius[at..])).store(&mut self.into[at..]);
            first += R::WIDTH;
        }
    }
}
