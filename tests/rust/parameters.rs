//! The parameters of a system: their values, and the changes that lead from one system to another.

use fullbody::dynamics::{Settings, System};
use fullbody::forces::{Byorp, Force, Path, ThirdBody, Tide, WhoseOrbit, Yorp};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::orbit::KeplerElements;
use fullbody::shape::{Body, InputPart, Polyhedron, Shape};
use std::collections::BTreeMap;

const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// The numbers of a system of an ellipsoid, two lobes and a tetrahedron under five forces, as its maker has
/// them.
#[derive(Clone, Copy)]
struct Numbers {
    g: f64,
    mass: f64,
    axes: [f64; 3],
    lobe: f64,
    arm: f64,
    size: f64,
    corner: f64,
    sun: f64,
    semi_major_axis: f64,
    node: f64,
    k2: f64,
    radius: f64,
    torques: [f64; 2],
    push: f64,
}

const NUMBERS: Numbers = Numbers {
    g: 6.5,
    mass: 2.0,
    axes: [0.9, 0.7, 0.8],
    lobe: 1.5,
    arm: 0.4,
    size: 0.3,
    corner: 1.0,
    sun: 1e6,
    semi_major_axis: 300.0,
    node: 0.0,
    k2: 0.02,
    radius: 0.8,
    torques: [1e-3, 2e-3],
    push: 1e-5,
};

fn system(with: Numbers) -> System {
    let lobe = |mass, x| InputPart {
        shape: Shape::ellipsoid([0.3, 0.2, 0.1]).unwrap(),
        mass,
        position: [x, 0.1 * x, 0.0],
        attitude: [1.0, 0.0, 0.0, 0.0],
    };
    let corners = [[with.corner, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [-1.0, -1.0, -1.0]];
    let corners = corners.map(|corner| Vec3::from(corner) * with.size);
    let rock = Polyhedron::new(&corners, &FACES.map(|[a, b, c]| [a, c, b]), &mut InterruptCheck::never());
    let bodies = vec![
        Body::with_mass("Egg", Shape::ellipsoid(with.axes).unwrap(), with.mass).unwrap(),
        Body::composite("Pair", vec![lobe(with.lobe, with.arm), lobe(0.5, -0.6)]).unwrap(),
        Body::with_mass("Rock", Shape::Polyhedron(rock.unwrap()), 0.1).unwrap(),
    ];
    let elements = KeplerElements {
        semi_major_axis: with.semi_major_axis,
        eccentricity: 0.1,
        inclination: 0.2,
        longitude_of_node: with.node,
        argument_of_periapsis: 0.3,
        mean_anomaly: 0.4,
    };
    let (name, on, by) = (str::to_owned, "Egg".to_owned(), "Pair".to_owned());
    let forces = vec![
        Force::ThirdBody(ThirdBody {
            name: name("Sun"),
            mu: with.g * with.sun,
            mass: Some(with.sun),
            of: WhoseOrbit::System,
            path: Path::Orbit { elements, time: 5.0 },
        }),
        Force::Tide(Tide { name: name("tide"), on, by, k2: with.k2, lag: 0.3, radius: with.radius }),
        Force::Yorp(Yorp {
            name: name("steady"),
            on: name("Egg"),
            pole: [0.0, 0.0, 1.0],
            obliquity: Vec::new(),
            along: vec![2e-3],
            across: vec![0.0],
        }),
        Force::Yorp(Yorp {
            name: name("table"),
            on: name("Rock"),
            pole: [0.0, 0.0, 1.0],
            obliquity: vec![0.0, 1.0, 2.0, std::f64::consts::PI],
            along: vec![with.torques[0]; 4],
            across: [0.0, 1.0, 1.0, 0.0].map(|shape| shape * with.torques[1]).to_vec(),
        }),
        Force::Byorp(Byorp {
            name: name("push"),
            on: name("Pair"),
            about: name("Egg"),
            force: [0.0, with.push, 0.0],
            torque: [0.0; 3],
        }),
    ];
    System::new(bodies, with.g, Settings::default()).unwrap().with_forces(forces).unwrap()
}

#[test]
fn values_are_what_the_system_was_made_of() {
    let values: BTreeMap<_, _> = system(NUMBERS).parameter_values().into_iter().collect();
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.9 * 0.7 * 0.8;
    let expected = [
        ("G", 6.5),
        ("mass of Egg", 2.0),
        ("density of Egg", 2.0 / volume),
        ("semi-axis a of Egg", 0.9),
        ("semi-axis b of Egg", 0.7),
        ("semi-axis c of Egg", 0.8),
        ("mass of Pair", 2.0),
        ("mass of part 0 of Pair", 1.5),
        ("position x of part 0 of Pair", 0.4),
        ("position x of part 1 of Pair", -0.6),
        ("mass of Rock", 0.1),
        ("scale of Rock", 1.0),
        ("mass of Sun", 1e6),
        ("a of Sun", 300.0),
        ("e of Sun", 0.1),
        ("i of Sun", 0.2),
        ("Omega of Sun", 0.0),
        ("omega of Sun", 0.3),
        ("M of Sun", 0.4),
        ("time of Sun", 5.0),
        ("k2 of tide", 0.02),
        ("lag of tide", 0.3),
        ("along of steady", 2e-3),
        ("across of steady", 0.0),
        ("factor of table", 1.0),
        ("force of push", 1e-5),
    ];
    for (name, value) in expected {
        let found = values.get(name).unwrap_or_else(|| panic!("no {name} among {:?}", values.keys()));
        assert!((found - value).abs() <= 1e-15 * value.abs(), "{name} is {found}, not {value}");
    }
}

/// Each of many numbers changes alone, and then all of them together.
#[test]
fn changes_of_parameters_lead_from_one_system_to_another() {
    let base = system(NUMBERS);
    type Change = fn(&mut Numbers);
    let single: [(Change, &[(&str, f64)]); 12] = [
        (|n| n.g *= 1.5, &[("G", 3.25)]),
        (|n| n.mass += 0.25, &[("mass of Egg", 0.25)]),
        (|n| n.axes[1] += 0.5, &[("semi-axis b of Egg", 0.5)]),
        // The whole of the pair gains what its part gains, which is not counted twice.
        (|n| n.lobe += 0.5, &[("mass of part 0 of Pair", 0.5)]),
        (
            |n| n.arm += 0.125,
            &[("position x of part 0 of Pair", 0.125), ("position y of part 0 of Pair", 0.0125)],
        ),
        (|n| n.size *= 1.75, &[("scale of Rock", 0.75)]),
        (|n| n.sun += 1e4, &[("mass of Sun", 1e4)]),
        (|n| n.semi_major_axis += 1.0, &[("a of Sun", 1.0)]),
        (|n| n.node += 1e-3, &[("Omega of Sun", 1e-3)]),
        (|n| n.k2 += 0.01, &[("k2 of tide", 0.01)]),
        (|n| n.torques = n.torques.map(|torque| 1.2 * torque), &[("factor of table", 0.2)]),
        (|n| n.push -= 1e-6, &[("force of push", -1e-6)]),
    ];
    let check = |other: &System, expected: &[(&str, f64)]| {
        let found = base.parameter_changes(other).unwrap();
        assert_eq!(found.unexplained, None);
        let changes: BTreeMap<_, _> = found.changes.iter().map(|(name, by)| (name.as_str(), *by)).collect();
        let expected: BTreeMap<_, _> = expected.iter().copied().collect();
        assert!(changes.keys().eq(expected.keys()), "{changes:?} are not {expected:?}");
        for (name, by) in &expected {
            assert!((changes[name] - by).abs() <= 1e-9 * by.abs(), "{name}: {} is not {by}", changes[name]);
        }
    };
    check(&system(NUMBERS), &[]);
    let (mut all, mut together) = (NUMBERS, Vec::new());
    for (change, expected) in single {
        let mut one = NUMBERS;
        change(&mut one);
        check(&system(one), expected);
        change(&mut all);
        together.extend(expected);
    }
    check(&system(all), &together);
}

#[test]
fn what_no_parameter_changes_is_named() {
    let base = system(NUMBERS);
    let place = |with| base.parameter_changes(&system(with)).unwrap().unexplained;
    assert_eq!(place(Numbers { radius: 0.8 * (1.0 + 1e-11), ..NUMBERS }).unwrap(), "forces[1] radius");
    let moved = place(Numbers { corner: 1.0 + 1e-9, mass: 3.0, ..NUMBERS }).unwrap();
    assert!(moved.starts_with("bodies[2] semi_axes vertices["), "{moved}");
    let torques = [2e-3, 2e-3];
    assert!(place(Numbers { torques, ..NUMBERS }).unwrap().starts_with("forces[3] a"));
    let fewer = System::new(base.bodies()[..2].to_vec(), 6.5, Settings::default()).unwrap();
    assert_eq!(base.parameter_changes(&fewer).unwrap().unexplained.unwrap(), "bodies");
    // Rounding errors are no changes.
    let rounded = Numbers { radius: 0.8 * (1.0 + 3e-16), mass: 2.0 + 4e-16, ..NUMBERS };
    let found = base.parameter_changes(&system(rounded)).unwrap();
    assert_eq!((found.changes, found.unexplained), (Vec::new(), None));
}
