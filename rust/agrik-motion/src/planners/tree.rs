//! A tree of postures.

use super::metric::Metric;

/// Postures that are joined by ways which are proven free.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    dof: usize,
    /// All postures, one after the other.
    q: Vec<f64>,
    /// The node that each hangs on; itself for a root.
    parents: Vec<u32>,
}

impl Tree {
    pub fn new(dof: usize) -> Self {
        Self { dof, q: Vec::new(), parents: Vec::new() }
    }

    pub fn len(&self) -> usize {
        self.parents.len()
    }

    pub fn node(&self, index: usize) -> &[f64] {
        &self.q[index * self.dof..(index + 1) * self.dof]
    }

    /// Adds a node below another; a root without one.
    pub fn add(&mut self, q: &[f64], parent: Option<usize>) -> usize {
        let index = self.len();
        self.q.extend_from_slice(q);
        self.parents.push(parent.unwrap_or(index) as u32);
        index
    }

    /// The node nearest to a posture, the first of several.
    pub fn nearest(&self, q: &[f64], metric: &Metric) -> usize {
        let mut best = (f64::INFINITY, 0);
        for (index, node) in self.q.chunks_exact(self.dof).enumerate() {
            let square = metric.square(node, q);
            if square < best.0 {
                best = (square, index);
            }
        }
        best.1
    }

    /// Nodes from one of them up to its root.
    pub fn to_root(&self, mut index: usize) -> Vec<usize> {
        let mut way = vec![index];
        while self.parents[index] as usize != index {
            index = self.parents[index] as usize;
            way.push(index);
        }
        way
    }
}
