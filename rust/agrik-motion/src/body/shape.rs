//! What a body is.

use agrik_solids::{Core, Cover, Cuboid, Point, Pose, Solid, Split};

/// One body of an arm: a solid that stands still in one of its frames.
#[derive(Debug, Clone)]
pub struct Body {
    /// Its name, which no other body of the arm has.
    pub name: String,
    /// The frame: 0 is the base frame, `k` that of the link behind joint `k` of
    /// [`Chain::joints`](agrik::chain::Chain::joints) counted from 1 (fixed ones too), and the
    /// one after the last of them the tool frame.
    pub frame: usize,
    /// The solid, in that frame.
    pub shape: Shape,
    /// True for a tool or a held object that was put on at run time.
    pub attached: bool,
}

impl Body {
    /// A body of an arm itself.
    pub fn new(name: impl Into<String>, frame: usize, shape: impl Into<Shape>) -> Self {
        Self { name: name.into(), frame, shape: shape.into(), attached: false }
    }
}

/// The solid of a body, and how the scene sees it.
#[derive(Debug, Clone)]
pub enum Shape {
    /// As it is. Half-spaces are none: a body has bounds.
    Exact(Solid),
    /// A box that meets the scene as spheres round its cells, as the paper on cucumber picking
    /// has it, and other bodies as the box that it is.
    Cover {
        /// The box.
        cuboid: Cuboid,
        /// Its covers of all levels.
        cover: Cover,
        /// Which of them counts.
        level: usize,
        /// Radius round the box, m, which all spheres have on top of their own.
        radius: f64,
    },
}

impl Shape {
    /// A box that meets the scene as its cover of a level, 8^level spheres.
    ///
    /// # Errors
    ///
    /// `radius` is no finite number from 0 to [`agrik_solids::shapes::LARGEST`], or the level
    /// above [`agrik_solids::cover::FINEST`].
    pub fn cover(cuboid: Cuboid, level: usize, split: Split, radius: f64) -> crate::Result<Self> {
        let finest = agrik_solids::cover::FINEST;
        if level > finest {
            let expected = format!("a whole number, 0 to {finest}");
            return Err(crate::Error::argument("level", expected, level));
        }
        Solid::new(Core::Cuboid(cuboid), radius)?;
        Ok(Self::Cover { cuboid, cover: Cover::new(&cuboid, split), level, radius })
    }

    /// The solid itself.
    pub(super) fn solid(&self) -> crate::Result<Solid> {
        match self {
            Self::Exact(solid) => Ok(solid.clone()),
            Self::Cover { cuboid, radius, .. } => Solid::new(Core::Cuboid(*cuboid), *radius),
        }
    }

    /// Points whose hull the core is, m.
    pub(super) fn extreme_points(&self) -> Vec<Point> {
        match self {
            Self::Exact(solid) => solid.core().extreme_points(),
            Self::Cover { cuboid, .. } => cuboid.corners().to_vec(),
        }
    }

    /// The solid of a frame that lies at `pose`.
    pub(super) fn placed(&self, pose: &Pose) -> crate::Result<Solid> {
        Ok(self.solid()?.placed(pose))
    }
}

impl From<Solid> for Shape {
    fn from(solid: Solid) -> Self {
        Self::Exact(solid)
    }
}
