//! The choice of a pair's rule, made between steps: by bounds where the bodies are well apart, by comparing
//! rules where they are close, with hysteresis against frequent changes.

use super::rule::{Kernel, Rule, RuleMemory};
use super::store::NodeKind;
use super::{Interaction, Method, Pair, Pose};
use crate::error::{Error, Result};
use crate::gravity::Near;
use crate::interrupt::InterruptCheck;
use crate::math::Vec3;
use crate::math::exchange::Exchange;
use crate::math::rotation::{rotate, rotate_back};
use crate::quadrature::{Order, closest_confocal, focal_vectors, guess_degree};

/// The highest polynomial degree of a rule; beyond it the pair counts as not converged.
pub const MAX_RULE_DEGREE: usize = 400;
/// The degrees that are compared for close bodies.
const LADDER: [usize; 16] = [8, 12, 16, 20, 26, 34, 44, 56, 72, 92, 118, 150, 192, 244, 312, MAX_RULE_DEGREE];
/// A rule stays in use while its degree exceeds the needed one by at most this much.
const SLACK: usize = 3;
/// The fraction of the smallest predicted separation down to which a kernel is prepared.
pub(super) const MARGIN: f64 = 0.9;
/// The relative difference below which two rules over nodes agree to round-off.
const AGREEMENT_OVER_NODES: f64 = 4e-15;

impl Pair {
    /// Returns the rule in use in the form that an archive keeps.
    pub fn memory(&self) -> Option<RuleMemory> {
        let series = self.series().map(|(harmonic, truncation)| RuleMemory::Harmonic {
            degrees: truncation.degrees.map(|degree| degree as u32),
            moment_degrees: harmonic.moment_degrees().map(|degree| degree as u32),
            valid_from: truncation.valid_from,
        });
        let fragments = self
            .fragments
            .as_ref()
            .map(|fragments| RuleMemory::Fragments { shares: fragments.shares, work: fragments.work });
        let rule = self.rule.as_ref().map(|rule| RuleMemory::Quadrature {
            integrated: rule.integrated as u8,
            order: [rule.order.gauss as u32, rule.order.angles as u32],
            degree: rule.degree as u32,
            valid_from: rule.valid_from,
        });
        series.or(fragments).or(rule)
    }

    /// Puts a rule from an archive in use again.
    pub fn restore_memory(
        &mut self,
        memory: Option<&RuleMemory>,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.reset();
        let Some(memory) = memory else { return Ok(()) };
        let unknown = || Error::invalid("rule of a pair", format!("{memory:?}"), "one that a pair has had");
        let (integrated, [gauss, angles], degree, valid_from) = match *memory {
            RuleMemory::Quadrature { integrated, order, degree, valid_from } => {
                (integrated, order, degree, valid_from)
            }
            RuleMemory::Harmonic { degrees, moment_degrees, valid_from } => {
                let [degrees, moment_degrees] =
                    [degrees, moment_degrees].map(|pair| pair.map(|degree| degree as usize));
                if degrees.iter().chain(&moment_degrees).any(|degree| *degree > Exchange::MAX_DEGREE) {
                    return Err(unknown());
                }
                return self.restore_series(degrees, moment_degrees, valid_from, interrupt);
            }
            RuleMemory::Fragments { shares, work } => {
                if shares == 0 || self.bodies.iter().any(|body| body.polyhedron().is_none()) {
                    return Err(unknown());
                }
                return self.restore_fragments(shares, work, interrupt);
            }
        };
        if integrated > 1 || !(1..=512).contains(&gauss) || !(1..=1024).contains(&angles) {
            return Err(unknown());
        }
        let order = Order { gauss: gauss as usize, angles: angles as usize };
        let integrated = usize::from(integrated);
        let kernel = self.kernel_of(integrated, valid_from, interrupt)?;
        let node_kind = self.node_kind(integrated, order);
        let nodes = self.nodes.get(order, node_kind, &self.bodies[integrated], self.arch, interrupt)?;
        self.rule = Some(Rule {
            integrated,
            order,
            degree: degree as usize,
            node_kind,
            points: nodes.len(),
            nodes,
            begins: Vec::new(),
            kernel,
            valid_from,
        });
        Ok(())
    }

    /// Uses the rule that another object of the same pair uses.
    pub fn copy_rule(&mut self, from: &Self) {
        self.rule.clone_from(&from.rule);
        self.fragments.clone_from(&from.fragments);
        self.truncation.clone_from(&from.truncation);
        if self.truncation.is_some() {
            self.harmonic.clone_from(&from.harmonic);
        }
    }

    /// Forgets the rule, so that the next choice does not depend on the past.
    pub fn reset(&mut self) {
        (self.rule, self.harmonic, self.truncation, self.fragments) = (None, None, None, None);
    }

    /// Chooses the rule for a pose and for all separations down to (1 - `closing`) of it. It may allocate and
    /// is called between steps only. It checks for interrupts while it compares rules and computes those of
    /// polyhedra.
    pub fn prepare(&mut self, pose: &Pose, closing: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        if self.method == Method::Point || self.multipole.is_some() {
            return Ok(());
        }
        let mut scaled = self.scaled(pose);
        scaled.separation *= 1.0 - closing;
        let reach = scaled.separation.norm();
        if self.prepare_series(pose.separation.norm() / self.unit, reach, interrupt)? {
            self.fragments = None;
            return Ok(());
        }
        if self.prepare_fragments(&self.scaled(pose), interrupt)? {
            return Ok(());
        }
        if self.bodies.iter().any(|body| body.polyhedron().is_some()) {
            return self.prepare_faceted(&scaled, reach, interrupt);
        }
        match (self.fixed, self.bounded_degrees(&scaled)) {
            (Some(order), choice) => {
                let (integrated, [degree, _]) = choice.unwrap_or_else(|| self.guessed_degrees(&scaled));
                self.adopt(integrated, degree, order, reach, interrupt)
            }
            (None, Some((integrated, degrees))) => {
                let reusable = self.rule.as_ref().filter(|rule| self.suits(rule, integrated, degrees));
                let (degree, order) = reusable.map_or_else(
                    || (degrees[0], self.order(integrated, degrees)),
                    |rule| (rule.degree, rule.order),
                );
                self.adopt(integrated, degree, order, reach, interrupt)
            }
            (None, None) => self.adopt_by_comparison(&scaled, reach, interrupt),
        }
    }

    /// Returns whether a rule stays in use where these degrees are needed.
    fn suits(&self, rule: &Rule, integrated: usize, [degree, radial]: [usize; 2]) -> bool {
        let gauss = |more: usize| self.order(integrated, [degree + more, radial + more]).gauss;
        rule.integrated == integrated
            && (degree..=degree + SLACK).contains(&rule.degree)
            && (gauss(0)..=gauss(SLACK)).contains(&rule.order.gauss)
    }

    /// Returns the body to integrate over, with the degrees in all directions and in the radius, where bounds
    /// give them.
    fn bounded_degrees(&mut self, pose: &Pose) -> Option<(usize, [usize; 2])> {
        let needed = [0, 1].map(|integrated| {
            let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
            let Some(ellipsoid) = set.ellipsoid() else {
                // The surface method integrates over a surface wherever a body has one.
                return (self.method == Method::Focal || field.ellipsoid().is_none()).then_some([0; 2]);
            };
            let (rotation, separation) = match integrated {
                0 => (&pose.rotation_first, pose.separation),
                _ => (&pose.rotation_second, -pose.separation),
            };
            let centre = rotate(&set.canonical, &rotate_back(rotation, &separation));
            let (degrees, other) = (&mut self.degrees[integrated], field.focal_axes()[0]);
            match self.method {
                Method::Surface => degrees.surface(ellipsoid, &centre, other).map(|degree| [degree; 2]),
                _ if ellipsoid.focal_axes()[0] == 0.0 => Some([0; 2]),
                _ => degrees.focal(ellipsoid, &centre, other),
            }
        });
        self.cheaper(needed, pose.separation.norm())
    }

    /// Returns the body to integrate over, with a first guess of the degrees by the rate of the confocal
    /// family.
    fn guessed_degrees(&self, pose: &Pose) -> (usize, [usize; 2]) {
        let degrees = |integrated: usize| {
            let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
            let ellipsoid = set.ellipsoid()?;
            let roles = self.roles(integrated, pose);
            let from_field = roles.rotation.transpose();
            let [p, q] = field.ellipsoid().map_or([Vec3::zeros(); 2], |e| focal_vectors(e, &from_field));
            let kappa = closest_confocal(ellipsoid, &(from_field * -roles.origin), &p, &q);
            Some([guess_degree(ellipsoid, self.method == Method::Focal, kappa, self.tolerance); 2])
        };
        self.cheaper([degrees(0), degrees(1)], pose.separation.norm()).unwrap_or((0, [MAX_RULE_DEGREE; 2]))
    }

    /// Returns the body with the lower degree; the body in use stays in use unless the other one is clearly
    /// better.
    fn cheaper(&self, degrees: [Option<[usize; 2]>; 2], reach: f64) -> Option<(usize, [usize; 2])> {
        let in_use = self.rule.as_ref().map(|rule| rule.integrated);
        let cost = |integrated: usize| {
            let hysteresis = if in_use.is_some_and(|used| used != integrated) { SLACK } else { 0 };
            let degrees = degrees[integrated].filter(|_| self.torque_keeps_digits(integrated, reach));
            degrees.map(|[degree, _]| (degree + hysteresis, integrated))
        };
        let (_, integrated) = [cost(0), cost(1)].into_iter().flatten().min()?;
        degrees[integrated].map(|degrees| (integrated, degrees))
    }

    /// Returns whether the torque on the field body keeps its digits. It is computed from differences of the
    /// R_i, which become the more equal the further away a point is in sizes of that body; only the far
    /// kernel has the differences without cancellation.
    fn torque_keeps_digits(&self, integrated: usize, reach: f64) -> bool {
        const SIZES: f64 = 30.0;
        let size = self.bodies[1 - integrated].shape.circumradius();
        reach < SIZES * size || matches!(self.kernel(integrated, MARGIN * reach), Kernel::Far(_))
    }

    /// Raises the degree until a rule agrees with a finer one.
    fn adopt_by_comparison(&mut self, pose: &Pose, reach: f64, interrupt: &mut InterruptCheck) -> Result<()> {
        let (integrated, [guess, _]) = self.guessed_degrees(pose);
        let in_use = self.rule.as_ref().filter(|rule| rule.integrated == integrated).map(|rule| rule.degree);
        let mut level = LADDER
            .iter()
            .position(|&d| d >= in_use.unwrap_or(guess))
            .unwrap_or(LADDER.len() - 2)
            .min(LADDER.len() - 2);
        self.adopt_degree(integrated, LADDER[level], reach, interrupt)?;
        let mut coarse = self.interaction_with(pose, interrupt)?;
        while level + 1 < LADDER.len() {
            self.adopt_degree(integrated, LADDER[level + 1], reach, interrupt)?;
            let fine = self.interaction_with(pose, interrupt)?;
            let difference = self.difference(&fine, &coarse);
            if difference <= self.tolerance.max(AGREEMENT_OVER_NODES) {
                // The degree is lowered only where the next coarser rule has a good margin, so that the
                // choice does not alternate.
                let lower = if difference < 1e-3 * self.tolerance { level.saturating_sub(1) } else { level };
                let degree = if lower < level
                    && self.agrees(integrated, LADDER[lower], pose, reach, &fine, interrupt)?
                {
                    LADDER[lower]
                } else {
                    LADDER[level]
                };
                return self.adopt_degree(integrated, degree, reach, interrupt);
            }
            coarse = fine;
            level += 1;
        }
        Err(Error::NotConverged {
            what: format!(
                "{} quadrature between {} and {}",
                self.method, self.bodies[0].name, self.bodies[1].name
            ),
            detail: format!(
                "at separation {} a rule of degree {MAX_RULE_DEGREE} does not reach the tolerance {:e}; use \
                 {}a larger gravity_tolerance or order=",
                pose.separation.norm() * self.unit,
                self.tolerance,
                if self.method == Method::Focal { "" } else { "gravity=\"focal\", " }
            ),
        })
    }

    fn agrees(
        &mut self,
        integrated: usize,
        degree: usize,
        pose: &Pose,
        reach: f64,
        fine: &Interaction,
        interrupt: &mut InterruptCheck,
    ) -> Result<bool> {
        self.adopt_degree(integrated, degree, reach, interrupt)?;
        Ok(self.difference(&self.interaction_with(pose, interrupt)?, fine) <= 0.1 * self.tolerance)
    }

    fn order(&self, integrated: usize, degrees: [usize; 2]) -> Order {
        order_for(self.node_kinds[integrated], degrees)
    }

    /// Puts the rule in use that is exact to one degree in all directions.
    fn adopt_degree(
        &mut self,
        integrated: usize,
        degree: usize,
        reach: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        self.adopt(integrated, degree, self.order(integrated, [degree; 2]), reach, interrupt)
    }

    /// Puts a rule in use, with a kernel for separations down to a little below `reach`.
    pub(super) fn adopt(
        &mut self,
        integrated: usize,
        degree: usize,
        order: Order,
        reach: f64,
        interrupt: &mut InterruptCheck,
    ) -> Result<()> {
        if let Some(rule) = &self.rule
            && rule.integrated == integrated
            && rule.order == order
            && (rule.valid_from == 0.0 || (1.02 * rule.valid_from..1.3 * rule.valid_from).contains(&reach))
        {
            return Ok(());
        }
        let node_kind = self.node_kind(integrated, order);
        let nodes = self.nodes.get(order, node_kind, &self.bodies[integrated], self.arch, interrupt)?;
        // Two spheres attract like points at any distance.
        let field = &self.bodies[1 - integrated];
        let everywhere = nodes.len() == 1 && field.focal_axes()[0] == 0.0 && field.polyhedron().is_none();
        let valid_from = if everywhere { 0.0 } else { MARGIN * reach };
        let kernel = self.kernel_of(integrated, valid_from, interrupt)?;
        let (points, begins) = (nodes.len(), Vec::new());
        self.rule =
            Some(Rule { integrated, order, degree, node_kind, nodes, points, begins, kernel, valid_from });
        Ok(())
    }

    /// Returns the largest difference of two evaluations: of the force relative to its size, and of the
    /// torques relative to theirs, or to a hundredth of the force times the body's radius where symmetry
    /// makes them small.
    fn difference(&self, reference: &Interaction, other: &Interaction) -> f64 {
        let force = reference.force_on_first.norm();
        let torque = |a: &Vec3, b: &Vec3, body: usize| {
            let size = a.norm().max(0.01 * force * self.bodies[body].shape.circumradius());
            if size > 0.0 { (a - b).norm() / size } else { 0.0 }
        };
        // A torque has the round-off error of its lever arm times the force.
        ((reference.force_on_first - other.force_on_first).norm() / force)
            .max(0.1 * torque(&reference.torque_first, &other.torque_first, 0))
            .max(0.1 * torque(&reference.torque_second, &other.torque_second, 1))
    }

    pub(super) fn kernel(&self, integrated: usize, distance: f64) -> Kernel {
        let set = &self.bodies[integrated];
        let radius = match self.method {
            Method::Surface => set.shape.circumradius(),
            _ => set.focal_axes()[0],
        };
        self.kernel_from(integrated, distance - radius)
    }

    /// Returns the kernel for points down to a distance from the field body's centre.
    pub(super) fn kernel_from(&self, integrated: usize, closest: f64) -> Kernel {
        let field = &self.bodies[1 - integrated];
        let closest = closest.max(0.0);
        let kappa_min = closest * closest - field.shape.circumradius().powi(2);
        match (field.series.truncation_for(kappa_min, 0.1 * self.tolerance), field.ellipsoid()) {
            (None, Some(ellipsoid)) => Kernel::Near(Near::new(ellipsoid, kappa_min)),
            (truncation, _) => Kernel::Far(truncation.unwrap_or_default()),
        }
    }
}

/// Returns the order of a rule that is exact to a degree over the angle and to another one along the radius.
pub(super) fn order_for(node_kind: NodeKind, [degree, radial]: [usize; 2]) -> Order {
    match node_kind {
        NodeKind::SurfacePotential => Order::surface(degree),
        // The density has degree 2, and the moments of the field have one degree more than those of the
        // potential.
        NodeKind::SurfaceField(_) => Order::surface(degree + 3),
        _ => Order::focal([degree, radial]),
    }
}
