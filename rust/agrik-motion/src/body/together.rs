//! Hits of up to eight postures together: a sieve first, then doubles for what it lets through.

use agrik::kinematics::{FRAME, frames_abreast};
use agrik_compute::lanes::{Lanes, Level};
use agrik_solids::{Point, Pose, Solid, within};

use super::collider::Collider;
use super::sieve::{Bends, Question, Sifted};

impl Collider {
    /// Memory for eight postures.
    pub(crate) fn sifted(&self) -> Sifted {
        Sifted::new(self.bodies().chain().compiled().links.len())
    }

    /// Looks at the postures whose frames are in place for bodies that may be `clear` (m) or less
    /// away from an object, and pairs that may be `own` or less apart. `questions` is how many
    /// times this is done in all, as far as that is known; `pairs` are the self pairs, in
    /// another order of the two where that is needed. `alone` tells that all lanes hold one
    /// posture, whose answer is that of the first.
    pub(crate) fn sift(
        &self,
        room: &mut Sifted,
        (clear, own): (f64, f64),
        pairs: &[(usize, usize)],
        questions: usize,
        way: Option<Bends<'_>>,
        alone: bool,
    ) {
        let scene = self.scene();
        let question = Question {
            view: scene.view(questions),
            objects: scene.objects(),
            exempt: self.exemptions(),
            asked: self.asked(),
            pairs,
            clear,
            most: clear.max(scene.largest_clearance()),
            own,
            way,
            alone,
        };
        self.bodies().sieve().sift(Level::in_use(), &question, room);
    }

    /// [`Collider::hits`] of up to eight rows of joint values that are known to be sound, a bit
    /// each.
    pub(super) fn hits_together(
        &self,
        q: &[f64],
        clear: f64,
        questions: usize,
        room: &mut Sifted,
    ) -> Lanes {
        let bodies = self.bodies();
        let rows = q.len() / bodies.chain().dof();
        frames_abreast(bodies.chain(), q, &mut room.frames);
        self.sift(room, (clear, 0.0), bodies.self_pairs(), questions, None, rows == 1);
        let mut hits = 0;
        for row in 0..rows {
            hits |= Lanes::from(self.hits_in_lane(room, row, (clear, 0.0)).is_some()) << row;
        }
        hits
    }

    /// What is too near to something in one of eight postures, of all that may be by
    /// [`Collider::sift`] without a way: by its place among the bodies that are asked and, behind
    /// them, the self pairs.
    pub(crate) fn hits_in_lane(
        &self,
        room: &Sifted,
        lane: usize,
        (clear, own): (f64, f64),
    ) -> Option<usize> {
        let asked = self.asked();
        let hits = |place: usize| match asked.get(place) {
            Some(body) => {
                let solid = placed(self, room, lane, *body);
                let exempt = self.exemption_with(|| tool(self, room, lane), *body);
                self.solid_hits(*body, &solid, exempt, clear)
            }
            None => {
                let (i, j) = self.bodies().self_pairs()[place - asked.len()];
                within(&placed(self, room, lane, i), &placed(self, room, lane, j), own)
            }
        };
        let in_lane = room.maybe.iter().filter(|(_, lanes)| lanes >> lane & 1 != 0);
        in_lane.map(|(place, _)| *place).find(|place| hits(*place))
    }
}

/// Where the frame after so many moving joints lies, one or more.
fn pose(room: &Sifted, lane: usize, link: usize) -> Pose {
    let m = |k: usize| room.frames[FRAME * (link - 1) + k][lane];
    Pose {
        rotation: [[m(0), m(1), m(2)], [m(3), m(4), m(5)], [m(6), m(7), m(8)]],
        translation: [m(9), m(10), m(11)],
    }
}

/// A body where it lies.
fn placed(collider: &Collider, room: &Sifted, lane: usize, body: usize) -> Solid {
    let mount = &collider.bodies().mounts()[body];
    match mount.link {
        0 => mount.solid.clone(),
        link => mount.solid.placed(&pose(room, lane, link)),
    }
}

/// The tool point, m.
fn tool(collider: &Collider, room: &Sifted, lane: usize) -> Point {
    let chain = collider.bodies().chain().compiled();
    let tail = chain.tail.translation;
    match chain.links.len() {
        0 => collider.bodies().room().tool(),
        links => pose(room, lane, links).point(tail),
    }
}
