//! Compositions of two flows, each of which is solved exactly.
//!
//! The schemes are symmetric, and symplectic where both flows are. They are those of S. Blanes, F. Casas, A.
//! Farres, J. Laskar, J. Makazaga & A. Murua (2013), Appl. Numer. Math. 68, 58. For A + epsilon B, ABA(8,6,4)
//! has errors of the size epsilon h^8 + epsilon^2 h^6 + epsilon^3 h^4; in ABA(10,6,4) the first term is
//! epsilon h^10.

use crate::error::Result;
use crate::interrupt::InterruptCheck;
use crate::names::Named;

/// The two flows of a splitting, which act on a vector `high` + `low`.
pub trait Flows {
    /// Prepares a step of size `step` from an accepted vector. It may allocate, and is called between steps
    /// only.
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, interrupt: &mut InterruptCheck) -> Result<()>;

    /// Advances the vector by the flow of the larger part, A.
    fn drift(&mut self, size: f64, vector: [&mut [f64]; 2], interrupt: &mut InterruptCheck) -> Result<()>;

    /// Advances the vector by the flow of the smaller part, B, which does not change the numbers on which it
    /// depends. Returns the number of evaluations.
    fn kick(&mut self, size: f64, vector: [&mut [f64]; 2], interrupt: &mut InterruptCheck) -> Result<u64>;

    /// Projects an accepted vector back onto its constraints.
    fn restore(&mut self, high: &mut [f64], low: &mut [f64]);
}

/// A symmetric composition of drifts and kicks, as fractions of a step up to its middle; the second half
/// mirrors the first. With an even number of kicks the last drift is at the middle, with an odd number the
/// last kick is.
#[derive(Debug)]
pub struct Composition {
    drifts: &'static [f64],
    kicks: &'static [f64],
}

/// The composition of second order of half a kick, a drift and half a kick.
pub static KICK_DRIFT_KICK: Composition = Composition { drifts: &[0.0, 1.0], kicks: &[0.5] };

/// The composition of second order of half a drift, a kick and half a drift.
static LEAPFROG: Composition = Composition { drifts: &[0.5], kicks: &[1.0] };

/// The scheme ABA(8,6,4).
static ABA864: Composition = Composition {
    drifts: &[
        0.071133426498223117777938730006,
        0.241153427956640098736487795326,
        0.521411761772814789212136078068,
        -0.333698616227678005726562603400,
    ],
    kicks: &[
        0.183083687472197221961703757166,
        0.310782859898574869507522291054,
        -0.026564618511958800697212137916,
        0.065396142282373418455972179391,
    ],
};

/// The scheme ABA(10,6,4).
static ABA1064: Composition = Composition {
    drifts: &[
        0.038094497422412195456975322309,
        0.145298716116913749294020072661,
        0.207627695725541250716205611325,
        0.435909703651526159223154862401,
        -0.653861225832786709380711737391,
    ],
    kicks: &[
        0.095858880837075210610771503771,
        0.204446153142998780680507783916,
        0.217070347978991101714338592431,
        -0.017375381959065093005617880119,
    ],
};

/// A composition of the flows of a larger part A and a smaller part B, as scripts name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scheme {
    /// The composition of second order of half a drift, a kick and half a drift.
    Leapfrog,
    /// The scheme ABA(8,6,4), with seven kicks.
    Aba864,
    /// The scheme ABA(10,6,4), with eight kicks.
    Aba1064,
}

impl Named for Scheme {
    const WHAT: &'static str = "scheme";
    const NAMES: &'static [(&'static str, Self)] =
        &[("ABA864", Self::Aba864), ("ABA1064", Self::Aba1064), ("leapfrog", Self::Leapfrog)];
}

impl Scheme {
    /// Returns the fractions of the scheme.
    pub fn composition(self) -> &'static Composition {
        match self {
            Self::Leapfrog => &LEAPFROG,
            Self::Aba864 => &ABA864,
            Self::Aba1064 => &ABA1064,
        }
    }
}

impl Composition {
    /// Takes one step. Returns the number of evaluations.
    pub fn step(
        &self,
        flows: &mut impl Flows,
        size: f64,
        [high, low]: [&mut [f64]; 2],
        interrupt: &mut InterruptCheck,
    ) -> Result<u64> {
        let kicks = self.drifts.len() + self.kicks.len() - 1;
        let mut evaluations = 0;
        for k in 0..=kicks {
            let drift = self.drifts[k.min(kicks - k)];
            if drift != 0.0 {
                flows.drift(size * drift, [&mut *high, &mut *low], interrupt)?;
            }
            if k < kicks {
                evaluations += flows.kick(
                    size * self.kicks[k.min(kicks - 1 - k)],
                    [&mut *high, &mut *low],
                    interrupt,
                )?;
            }
        }
        Ok(evaluations)
    }
}
