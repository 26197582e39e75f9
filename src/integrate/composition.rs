//! Compositions of two flows that are each solved exactly.
//!
//! The schemes are symmetric, and symplectic where both flows are. S. Blanes, F. Casas, A. Farres, J. Laskar, J. Makazaga
//! & A. Murua (2013), Appl. Numer. Math. 68, 58: for A + epsilon B, ABA(8,6,4) has errors of the size
//! epsilon h^8 + epsilon^2 h^6 + epsilon^3 h^4, and ABA(10,6,4) epsilon h^10 in the first of these.

use crate::error::{Error, Result};
use crate::patience::Patience;
use std::str::FromStr;

/// Two flows over a vector `high` + `low`.
pub trait Flows {
    /// Called between steps, before a step of size `step`. May allocate.
    fn prepare(&mut self, time: f64, y: &[f64], step: f64, patience: &mut Patience) -> Result<()>;

    /// The large part, A.
    fn drift(&mut self, size: f64, high: &mut [f64], low: &mut [f64], patience: &mut Patience) -> Result<()>;

    /// The small part, B, which does not change what it depends on. Gives the number of evaluations that it took.
    fn kick(&mut self, size: f64, high: &mut [f64], low: &mut [f64], patience: &mut Patience) -> Result<u64>;

    /// Brings an accepted vector back onto its constraints.
    fn restore(&mut self, high: &mut [f64], low: &mut [f64]);
}

/// A symmetric composition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Half a drift, a kick, half a drift: second order.
    Leapfrog,
    /// Half a kick, a drift, half a kick: second order.
    KickDriftKick,
    /// ABA(8,6,4): seven kicks.
    Aba864,
    /// ABA(10,6,4): eight kicks.
    Aba1064,
}

/// Fractions of a step up to its middle, which are mirrored there. The last drift of an even number of kicks, and the last
/// kick of an odd number, stand alone.
struct Half {
    drifts: &'static [f64],
    kicks: &'static [f64],
}

static LEAPFROG: Half = Half { drifts: &[0.5], kicks: &[1.0] };

static ABA864: Half = Half {
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

static ABA1064: Half = Half {
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

impl Scheme {
    /// Kicks of one step.
    pub fn kicks(self) -> usize {
        match self {
            Self::Leapfrog => 1,
            Self::KickDriftKick => 2,
            Self::Aba864 => 7,
            Self::Aba1064 => 8,
        }
    }

    /// The name that scripts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Leapfrog => "leapfrog",
            Self::KickDriftKick => "kick-drift-kick",
            Self::Aba864 => "ABA864",
            Self::Aba1064 => "ABA1064",
        }
    }

    /// One step. Gives the number of evaluations.
    pub fn step(
        self,
        flows: &mut impl Flows,
        size: f64,
        high: &mut [f64],
        low: &mut [f64],
        patience: &mut Patience,
    ) -> Result<u64> {
        let half = match self {
            Self::KickDriftKick => {
                let before = flows.kick(0.5 * size, high, low, patience)?;
                flows.drift(size, high, low, patience)?;
                return Ok(before + flows.kick(0.5 * size, high, low, patience)?);
            }
            Self::Leapfrog => &LEAPFROG,
            Self::Aba864 => &ABA864,
            Self::Aba1064 => &ABA1064,
        };
        let kicks = self.kicks();
        let mut evaluations = 0;
        for k in 0..kicks {
            flows.drift(size * half.drifts[k.min(kicks - k)], high, low, patience)?;
            let part = size * half.kicks[k.min(kicks - 1 - k)];
            evaluations += flows.kick(part, high, low, patience)?;
        }
        flows.drift(size * half.drifts[0], high, low, patience)?;
        Ok(evaluations)
    }
}

impl FromStr for Scheme {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        [Self::Leapfrog, Self::Aba864, Self::Aba1064]
            .into_iter()
            .find(|scheme| scheme.name() == text)
            .ok_or_else(|| {
                Error::invalid("scheme", format!("{text:?}"), "\"leapfrog\", \"ABA864\" or \"ABA1064\"")
            })
    }
}
