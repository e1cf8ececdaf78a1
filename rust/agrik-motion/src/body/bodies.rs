//! The bodies of an arm, and where they are at a posture.

use std::sync::Arc;

use agrik::chain::{Chain, JointKind};
use agrik::kinematics::{FRAME, moving_frames};
use agrik_solids::{Core, Point, Pose, Solid};
use nalgebra::{IsometryMatrix3, Matrix4, Rotation3, Translation3};

use super::placed::Placed;
use super::self_pairs::{self, Excluded, Pairs};
use super::shape::{Body, Shape};
use super::sieve::Sieve;
use crate::{Error, Result};

/// Largest angle of a joint, rad: some 1,600 turns.
const TURNED: f64 = 1e4;

/// An arm with bodies on its frames.
#[derive(Debug, Clone)]
pub struct Bodies {
    chain: Arc<Chain>,
    bodies: Vec<Body>,
    mounts: Vec<Mount>,
    pairs: Pairs,
    sieve: Arc<Sieve>,
    /// Levers of the moving joints, one body after another; see [`Bodies::levers`].
    levers: Arc<[f64]>,
}

/// How a body stands on the chain that the lanes work on.
#[derive(Debug, Clone)]
pub(crate) struct Mount {
    /// How many of the moving joints move it.
    pub link: usize,
    /// The solid in the frame of the last of them, or in the world where none does.
    pub solid: Solid,
    /// Points whose hull its core is, in the same frame, m.
    pub points: Vec<Point>,
}

impl Bodies {
    /// The bodies of an arm; `pairs` are those that may hit each other, by default all but the
    /// ones that stand on one link or on neighbours, and those that structure makes hit (see
    /// [`Reason`](super::Reason)).
    ///
    /// # Errors
    ///
    /// A name is empty or there twice, a frame is none of the chain's, a body has no bounds, a
    /// pair names no body or one body twice.
    pub fn new(
        chain: Arc<Chain>,
        bodies: Vec<Body>,
        pairs: Option<&[(usize, usize)]>,
    ) -> Result<Self> {
        for (i, body) in bodies.iter().enumerate() {
            if body.name.is_empty() {
                let expected = "a name of one character or more";
                return Err(Error::argument(format!("names[{i}]"), expected, "\"\""));
            }
            if bodies[..i].iter().any(|other| other.name == body.name) {
                let received = format!("{:?} twice", body.name);
                return Err(Error::argument(
                    "names",
                    "names that differ from each other",
                    received,
                ));
            }
            let last = chain.joints().len() + 1;
            if body.frame > last {
                let expected = format!("a frame of {:?}, 0 to {last}", chain.name());
                return Err(Error::argument(format!("frames[{i}]"), expected, body.frame));
            }
            if let Shape::Exact(solid) = &body.shape
                && let Core::HalfSpace(_) = solid.core()
            {
                let received = format!("{:?}, a half-space", body.name);
                return Err(Error::argument("bodies", "bodies with bounds", received));
            }
        }
        let mounts = mounts(&chain, &bodies)?;
        let sieve = Arc::new(Sieve::new(&bodies, &mounts));
        let (pairs_of_none, levers) = (Pairs::default(), Arc::from([]));
        let mut made = Self { chain, bodies, mounts, pairs: pairs_of_none, sieve, levers };
        made.levers = made.levers_of_joints().into();
        made.pairs = match pairs {
            Some(given) => self_pairs::given(given, made.len())?,
            None => self_pairs::by_the_rules(&made),
        };
        Ok(made)
    }

    /// The same arm with tools or held objects as well, whose pairs with all other bodies are
    /// found by the rules; those before stay as they are.
    ///
    /// # Errors
    ///
    /// As [`Bodies::new`].
    pub fn with_attached(&self, more: impl IntoIterator<Item = Body>) -> Result<Self> {
        let mut bodies = self.bodies.clone();
        bodies.extend(more.into_iter().map(|body| Body { attached: true, ..body }));
        let mut made = Self::new(Arc::clone(&self.chain), bodies, None)?;
        let before = self.len();
        let (mut all, new) = (self.pairs.clone(), made.pairs);
        all.asked.extend(new.asked.into_iter().filter(|(_, j)| *j >= before));
        all.excluded.extend(new.excluded.into_iter().filter(|e| e.pair.1 >= before));
        made.pairs = all;
        Ok(made)
    }

    /// The same arm with its bodies, its base moved by so much, m; pairs stay as they are.
    ///
    /// # Errors
    ///
    /// A number is not finite, or too large.
    pub fn moved(&self, by: Point) -> Result<Self> {
        let base = Translation3::from(by) * self.chain.base();
        let mut made =
            Self::new(Arc::new(self.chain.with_base(base)?), self.bodies.clone(), Some(&[]))?;
        made.pairs = self.pairs.clone();
        Ok(made)
    }

    /// The arm.
    pub fn chain(&self) -> &Arc<Chain> {
        &self.chain
    }

    /// How many bodies there are.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// True where there is none.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// The bodies, in the order given.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Which body has this name.
    pub fn body(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.name == name)
    }

    /// Pairs of bodies that are asked whether they hit each other, the lower index of each
    /// first.
    pub fn self_pairs(&self) -> &[(usize, usize)] {
        &self.pairs.asked
    }

    /// Pairs that are not asked, and why.
    pub fn excluded_pairs(&self) -> &[Excluded] {
        &self.pairs.excluded
    }

    /// How many of the chain's moving joints move a body: 0 for one on the base.
    pub fn moved_by(&self, body: usize) -> usize {
        self.mounts[body].link
    }

    pub(crate) fn mounts(&self) -> &[Mount] {
        &self.mounts
    }

    /// The levers of [`Bodies::levers`] of a body, one a moving joint.
    pub(crate) fn lasting_levers(&self, body: usize) -> &[f64] {
        let moving = self.chain.compiled().links.len();
        &self.levers[moving * body..moving * (body + 1)]
    }

    /// The bodies as balls.
    pub(crate) fn sieve(&self) -> &Sieve {
        &self.sieve
    }

    /// Room for a posture.
    pub fn room(&self) -> Placed {
        Placed::new(self)
    }

    /// Puts the bodies where they are at `q` (rad and m, one number per joint value, finite).
    ///
    /// # Errors
    ///
    /// `q` has another length, or a number that is not finite or too large.
    pub fn place(&self, q: &[f64], placed: &mut Placed) -> Result<()> {
        check_postures(&self.chain, q)?;
        if q.len() != self.chain.dof() {
            let expected = format!("{} joint values", self.chain.dof());
            return Err(Error::argument("q", expected, q.len()));
        }
        self.place_unchecked(q, placed);
        Ok(())
    }

    /// [`Bodies::place`] of joint values that are known to be sound.
    pub(crate) fn place_unchecked(&self, q: &[f64], placed: &mut Placed) {
        let mut frames = std::mem::take(&mut placed.numbers);
        frames.resize(FRAME * self.chain.compiled().links.len(), 0.0);
        moving_frames(&self.chain, q, &mut frames);
        placed.fill(self, &frames);
        placed.numbers = frames;
    }
}

/// Refuses rows of joint values that no arm can have.
pub(crate) fn check_postures(chain: &Chain, q: &[f64]) -> Result<()> {
    let dof = chain.dof();
    if !q.len().is_multiple_of(dof) {
        let expected = format!("rows of {dof} joint values");
        return Err(Error::argument("q", expected, format!("{} numbers", q.len())));
    }
    // Sines of larger angles are not known to the last digit.
    let most = |kind| match kind {
        JointKind::Prismatic => agrik_solids::shapes::LARGEST,
        _ => TURNED,
    };
    let limits: Vec<f64> = chain.variables().iter().map(|v| most(v.kind)).collect();
    let within = |row: &[f64]| row.iter().zip(&limits).all(|(x, most)| x.abs() <= *most);
    if q.chunks_exact(dof).all(within) {
        return Ok(());
    }
    let beyond = |(i, x): (usize, &f64)| !(-limits[i % dof]..=limits[i % dof]).contains(x);
    match q.iter().enumerate().position(beyond) {
        None => Ok(()),
        Some(at) => Err(Error::argument(
            "q",
            format!("finite joint values, of size {:e} at most", limits[at % dof]),
            format!("{} in row {}", q[at], at / dof),
        )),
    }
}

/// Each body as the compiled chain moves it.
fn mounts(chain: &Chain, bodies: &[Body]) -> Result<Vec<Mount>> {
    let (joints, links) = (chain.joints(), chain.compiled().links.len());
    // How a frame stands in that of the moving joint before it is the same at all postures.
    let q: Vec<f64> = chain.variables().iter().map(|v| v.near_zero()).collect();
    let poses = chain.link_poses(&q);
    let mut frames = vec![0.0; FRAME * links];
    moving_frames(chain, &q, &mut frames);
    let mount = |body: &Body| {
        let before = &joints[..body.frame.min(joints.len())];
        let link = before.iter().filter(|joint| joint.kind != JointKind::Fixed).count();
        let at = match body.frame {
            0 => chain.base().to_homogeneous(),
            frame => poses[frame - 1],
        };
        let pose = match link {
            0 => pose_of(&at),
            link => {
                let moving = isometry(&frames[FRAME * (link - 1)..][..FRAME]);
                pose_of(&(moving.inverse().to_homogeneous() * at))
            }
        };
        let solid = body.shape.placed(&pose)?;
        Ok(Mount { link, points: solid.core().extreme_points(), solid })
    };
    bodies.iter().map(mount).collect()
}

/// A pose as solids know it.
fn pose_of(m: &Matrix4<f64>) -> Pose {
    let row = |k: usize| [m[(k, 0)], m[(k, 1)], m[(k, 2)]];
    Pose { rotation: [row(0), row(1), row(2)], translation: [m[(0, 3)], m[(1, 3)], m[(2, 3)]] }
}

fn isometry(frame: &[f64]) -> IsometryMatrix3<f64> {
    let rotation = nalgebra::Matrix3::from_row_slice(&frame[..9]);
    IsometryMatrix3::from_parts(
        Translation3::new(frame[9], frame[10], frame[11]),
        Rotation3::from_matrix_unchecked(rotation),
    )
}
