//! A pair of bodies with a method: chooses the rule between steps, evaluates within them.

use super::{Balance, Interaction, Method, Multipole, Pose, Roles, focal, surface};
use crate::error::{Error, Result};
use crate::gravity::{FarCut, FarSeries, Near};
use crate::math::Mat3;
use crate::quadrature::{Nodes, Order, closest_confocal, degree_for, focal_vectors, rate_focal, rate_surface};
use crate::shape::{Ellipsoid, Shape};
use pulp::Arch;
use std::sync::Arc;

/// Highest polynomial degree of a rule; beyond it the pair counts as not converged.
pub const MAX_RULE_DEGREE: usize = 400;
/// A rule stays in use while it has at most this many degrees more than needed.
const SLACK: usize = 3;

/// What of a body's gravity does not depend on the state.
#[derive(Debug, Clone)]
pub struct BodyGravity {
    name: String,
    shape: Shape,
    canonical: Mat3,
    series: FarSeries,
}

impl BodyGravity {
    /// Precomputes for a shape; the name is for errors.
    pub fn new(name: &str, shape: &Shape) -> Self {
        let canonical = match shape {
            Shape::Ellipsoid(e) => e.canonical(),
            Shape::Point => Mat3::identity(),
        };
        Self { name: name.to_owned(), shape: *shape, canonical, series: FarSeries::new(shape) }
    }

    fn ellipsoid(&self) -> Option<&Ellipsoid> {
        match &self.shape {
            Shape::Ellipsoid(e) => Some(e),
            Shape::Point => None,
        }
    }

    /// Semi-axes of the focal ellipse; zeros for a sphere or a point.
    fn focal_axes(&self) -> [f64; 2] {
        self.ellipsoid().map_or([0.0; 2], Ellipsoid::focal_axes)
    }
}

/// The quadrature in force: which body is integrated over, with which nodes, in which form of the other's field.
#[derive(Debug, Clone)]
pub struct Rule {
    /// 0 where the first body is integrated over.
    pub integrated: usize,
    /// The order of the rule.
    pub order: Order,
    /// The polynomial degree it was made for.
    degree: usize,
    nodes: Arc<Nodes>,
    kernel: Kernel,
    /// Smallest separation that the kernel is made for.
    valid_from: f64,
}

impl Rule {
    /// Number of points.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }
}

#[derive(Debug, Clone, Copy)]
enum Kernel {
    Far(FarCut),
    Near(Near),
}

/// Two bodies and the method of their interaction.
#[derive(Debug, Clone)]
pub struct Pair {
    method: Method,
    tolerance: f64,
    fixed: Option<Order>,
    arch: Arch,
    bodies: [BodyGravity; 2],
    multipole: Option<Multipole>,
    rule: Option<Rule>,
}

impl Pair {
    /// `tolerance` is relative to the force; `fixed` overrides the choice of nodes.
    pub fn new(
        first: BodyGravity,
        second: BodyGravity,
        method: Method,
        tolerance: f64,
        fixed: Option<Order>,
        arch: Arch,
    ) -> Self {
        let multipole = match method {
            Method::Multipole(degree) => Some(Multipole::new(&first.shape, &second.shape, degree)),
            _ => None,
        };
        Self { method, tolerance, fixed, arch, bodies: [first, second], multipole, rule: None }
    }

    /// The quadrature in force, if the method has one and a state has been seen.
    pub fn rule(&self) -> Option<&Rule> {
        self.rule.as_ref()
    }

    /// Forgets the rule, so that the next choice does not depend on the past.
    pub fn reset(&mut self) {
        self.rule = None;
    }

    /// Chooses the rule for a pose and for all separations down to (1 - `closing`) of it. May allocate: call it
    /// between steps.
    pub fn prepare(&mut self, pose: &Pose, closing: f64) -> Result<()> {
        if matches!(self.method, Method::Multipole(_) | Method::Point) {
            return Ok(());
        }
        let distance = pose.separation.norm();
        let reach = distance * (1.0 - closing);
        if let Some(rule) = &self.rule
            && (rule.valid_from..1.3 * rule.valid_from).contains(&reach)
            && self.fixed.is_some()
        {
            return Ok(());
        }
        let scaled = Pose { separation: pose.separation * (reach / distance), ..*pose };
        let (integrated, needed) = self.cheapest(&scaled);
        if self.fixed.is_none() && needed > MAX_RULE_DEGREE {
            return Err(Error::NotConverged {
                what: format!("quadrature between {} and {}", self.bodies[0].name, self.bodies[1].name),
                detail: format!(
                    "at separation {distance} a tolerance of {:e} takes a rule of degree {needed}, above the limit of \
                     {MAX_RULE_DEGREE}; use gravity=\"focal\", a larger gravity_tolerance or order=",
                    self.tolerance
                ),
            });
        }
        if let Some(rule) = &self.rule
            && rule.integrated == integrated
            && (rule.valid_from..1.3 * rule.valid_from).contains(&reach)
            && (needed..=needed + SLACK).contains(&rule.degree)
        {
            return Ok(());
        }
        let valid_from = reach * 0.97;
        let kernel = self.kernel(integrated, valid_from);
        let degree = needed + SLACK / 2;
        let order = self.fixed.unwrap_or(match self.method {
            Method::Surface => Order::surface(degree),
            _ => Order::focal(degree),
        });
        let nodes = match &self.rule {
            Some(rule) if rule.integrated == integrated && rule.order == order => rule.nodes.clone(),
            _ => Arc::new(self.nodes(integrated, order)),
        };
        let valid_from = if matches!(kernel, Kernel::Near(_)) { valid_from.min(reach * 0.9) } else { valid_from };
        self.rule = Some(Rule { integrated, order, degree, nodes, kernel, valid_from });
        Ok(())
    }

    /// Whether the rule in force holds at this separation.
    #[inline]
    pub fn covers(&self, distance: f64) -> bool {
        self.rule.as_ref().is_none_or(|rule| distance >= rule.valid_from)
    }

    /// Force and torques with the rule in force.
    pub fn interaction(&self, pose: &Pose) -> Interaction {
        if let Some(multipole) = &self.multipole {
            return multipole.interaction(pose);
        }
        let Some(rule) = &self.rule else { return monopole(pose) };
        let [field, set] = self.field_and_set(rule);
        let roles = self.roles(rule, pose);
        let balance = match &rule.kernel {
            Kernel::Far(cut) => self.balance(field.series.cut(*cut), rule, set, &roles),
            Kernel::Near(near) => self.balance(*near, rule, set, &roles),
        };
        let to_field_body = field.canonical.transpose();
        let (rotation_field, torque_set) = match rule.integrated {
            0 => (pose.rotation_second, set.canonical.transpose() * (roles.turn.transpose() * balance.torque)),
            _ => (pose.rotation_first, set.canonical.transpose() * (roles.turn.transpose() * balance.torque)),
        };
        let force = rotation_field * (to_field_body * balance.force);
        let torque_field = to_field_body * balance.torque_field;
        match rule.integrated {
            0 => Interaction { force_on_first: force, torque_first: torque_set, torque_second: torque_field },
            _ => Interaction { force_on_first: -force, torque_first: torque_field, torque_second: torque_set },
        }
    }

    /// Potential energy per unit G m m with the rule in force: negative.
    pub fn potential_energy(&self, pose: &Pose) -> f64 {
        if let Some(multipole) = &self.multipole {
            return -multipole.mutual_potential(pose);
        }
        let Some(rule) = &self.rule else { return -1.0 / pose.separation.norm() };
        let [field, set] = self.field_and_set(rule);
        let roles = self.roles(rule, pose);
        -match &rule.kernel {
            Kernel::Far(cut) => self.potential(field.series.cut(*cut), rule, set, &roles),
            Kernel::Near(near) => self.potential(*near, rule, set, &roles),
        }
    }

    fn balance(
        &self,
        kernel: impl crate::gravity::FieldKernel,
        rule: &Rule,
        set: &BodyGravity,
        roles: &Roles,
    ) -> Balance {
        match set.ellipsoid() {
            Some(e) if self.method == Method::Surface => {
                surface::force_and_torque(self.arch, kernel, &rule.nodes, e.sorted(), roles)
            }
            _ => focal::force_and_torque(self.arch, kernel, &rule.nodes, set.focal_axes(), roles),
        }
    }

    fn potential(
        &self,
        kernel: impl crate::gravity::FieldKernel,
        rule: &Rule,
        set: &BodyGravity,
        roles: &Roles,
    ) -> f64 {
        match set.ellipsoid() {
            Some(e) if self.method == Method::Surface => {
                surface::mutual_potential(self.arch, kernel, &rule.nodes, e.sorted(), roles)
            }
            _ => focal::mean_potential(self.arch, kernel, &rule.nodes, set.focal_axes(), roles),
        }
    }

    fn field_and_set(&self, rule: &Rule) -> [&BodyGravity; 2] {
        [&self.bodies[1 - rule.integrated], &self.bodies[rule.integrated]]
    }

    fn roles(&self, rule: &Rule, pose: &Pose) -> Roles {
        self.roles_of(rule.integrated, pose)
    }

    fn roles_of(&self, integrated: usize, pose: &Pose) -> Roles {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let (rotation_field, rotation_set, separation) = match integrated {
            0 => (&pose.rotation_second, &pose.rotation_first, -pose.separation),
            _ => (&pose.rotation_first, &pose.rotation_second, pose.separation),
        };
        let to_field = field.canonical * rotation_field.transpose();
        Roles { origin: to_field * separation, turn: to_field * rotation_set * set.canonical.transpose() }
    }

    /// The body that takes the lower degree to integrate over, and that degree.
    fn cheapest(&self, pose: &Pose) -> (usize, usize) {
        let degrees = [0, 1].map(|integrated| self.degree_needed(integrated, pose));
        // Stay with the body in use unless the other one is clearly better.
        match (degrees, self.rule.as_ref().map(|r| r.integrated)) {
            ([Some(d0), Some(d1)], Some(0)) => if d1 + SLACK < d0 { (1, d1) } else { (0, d0) },
            ([Some(d0), Some(d1)], Some(_)) => if d0 + SLACK < d1 { (0, d0) } else { (1, d1) },
            ([Some(d0), Some(d1)], None) => if d0 < d1 { (0, d0) } else { (1, d1) },
            ([Some(d0), None], _) => (0, d0),
            ([None, Some(d1)], _) => (1, d1),
            ([None, None], _) => (1, 0),
        }
    }

    fn degree_needed(&self, integrated: usize, pose: &Pose) -> Option<usize> {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let Some(ellipsoid) = set.ellipsoid() else {
            // The surface method integrates over a surface wherever there is one.
            return (self.method == Method::Focal).then_some(0);
        };
        if self.method == Method::Focal && ellipsoid.focal_axes()[0] == 0.0 {
            return Some(0);
        }
        let roles = self.roles_of(integrated, pose);
        let centre = roles.turn.transpose() * -roles.origin;
        let [p, q] = match field.ellipsoid() {
            Some(e) => focal_vectors(e, &roles.turn.transpose()),
            None => [crate::math::Vec3::zeros(); 2],
        };
        let kappa = closest_confocal(ellipsoid, &centre, &p, &q);
        let rate = match self.method {
            Method::Surface => rate_surface(ellipsoid, kappa),
            _ => rate_focal(ellipsoid, kappa),
        };
        Some(degree_for(rate, self.tolerance))
    }

    fn kernel(&self, integrated: usize, distance: f64) -> Kernel {
        let (field, set) = (&self.bodies[1 - integrated], &self.bodies[integrated]);
        let radius = match self.method {
            Method::Surface => set.shape.circumradius(),
            _ => set.focal_axes()[0],
        };
        let closest = (distance - radius).max(0.0);
        let kappa_min = closest * closest - field.shape.circumradius().powi(2);
        match (field.series.cut_for(kappa_min, 0.1 * self.tolerance), field.ellipsoid()) {
            (None, Some(ellipsoid)) => Kernel::Near(Near::new(ellipsoid, kappa_min)),
            (cut, _) => Kernel::Far(cut.unwrap_or_default()),
        }
    }

    fn nodes(&self, integrated: usize, order: Order) -> Nodes {
        let set = &self.bodies[integrated];
        match self.method {
            Method::Surface if set.ellipsoid().is_some() => Nodes::sphere(order),
            _ if set.focal_axes()[0] == 0.0 => Nodes::centre(),
            _ => Nodes::focal(order),
        }
    }
}

fn monopole(pose: &Pose) -> Interaction {
    let r = pose.separation.norm();
    let zero = crate::math::Vec3::zeros();
    Interaction { force_on_first: pose.separation / (r * r * r), torque_first: zero, torque_second: zero }
}
