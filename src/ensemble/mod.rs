//! Many simulations over cores.
//!
//! Takes members one after the other from a [`Caller`], each a system, a state, an integrator and a time, and gives each
//! one's [`Answer`] back to it as soon as it is there. A simulation is made, moved and dropped within one thread, and shares
//! with others only what none of them changes: what is recorded has the same bits for any number of threads.

mod crew;
mod member;

pub use crew::{Caller, Progress, run};
pub use member::{Answer, Member, Ran};
