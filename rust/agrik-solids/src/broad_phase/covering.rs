//! Spheres that lead to a solid that is none.

use agrik_compute::lanes::sub;

use crate::cover::{Cover, Split};
use crate::distance::norm;
use crate::shapes::{Core, Cuboid, Solid};

/// Most spheres that a capsule is covered by.
const ALONG: f64 = 24.0;

/// Level of the cover that leads to a box: 64 spheres.
const CELLS: usize = 2;

/// Covering spheres are larger by what rounding may have taken from them.
const ROUNDED: f64 = 1.0 + 1e-12;

/// Spheres (x, y, z, radius, m) that cover a solid with bounds between them.
pub(super) fn covering(solid: &Solid) -> Vec<[f64; 4]> {
    let more = solid.radius();
    match solid.core() {
        Core::Segment(segment) => {
            let length = norm(sub(segment.b, segment.a));
            let pieces = (length / (2.0 * more)).min(ALONG).ceil().max(1.0);
            let radius = length / (2.0 * pieces) + more;
            (0..pieces as u32)
                .map(|piece| {
                    let [x, y, z] = segment.at((f64::from(piece) + 0.5) / pieces);
                    [x, y, z, radius * ROUNDED]
                })
                .collect()
        }
        Core::Cuboid(cuboid) => cells(cuboid, more),
        Core::Hull(hull) => cells(&hull.bounding_box(), more),
        Core::Point(_) | Core::HalfSpace(_) => {
            let ([x, y, z], radius) = solid.bounding_sphere();
            vec![[x, y, z, radius]]
        }
    }
}

/// The spheres round the cells of a box.
fn cells(cuboid: &Cuboid, more: f64) -> Vec<[f64; 4]> {
    let cover = Cover::new(cuboid, Split::NearCubic);
    let radius = (cover.radius(CELLS) + more) * ROUNDED;
    let centres = cover.centres(CELLS).iter().map(|centre| cuboid.point(*centre));
    centres.map(|[x, y, z]| [x, y, z, radius]).collect()
}
