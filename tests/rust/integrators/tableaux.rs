//! The digits of the tableaux: those beyond doubles, which no run is long enough to show.
//!
//! The files have the coefficients to some 26 digits. Here they are read from them and added in whole numbers.

use fullbody::integrate::{DORMAND_PRINCE54, Tableau, VERNER65, VERNER76, VERNER87, VERNER96, VERNER98};
use std::sync::LazyLock;

static PAIRS: [(&LazyLock<Tableau>, &str); 6] = [
    (&DORMAND_PRINCE54, include_str!("../../../src/integrate/tableaux/dormand_prince54.json")),
    (&VERNER65, include_str!("../../../src/integrate/tableaux/verner65.json")),
    (&VERNER76, include_str!("../../../src/integrate/tableaux/verner76.json")),
    (&VERNER87, include_str!("../../../src/integrate/tableaux/verner87.json")),
    (&VERNER96, include_str!("../../../src/integrate/tableaux/verner98.json")),
    (&VERNER98, include_str!("../../../src/integrate/tableaux/verner98.json")),
];

/// Decimals of the whole numbers.
const DECIMALS: usize = 32;

/// A decimal number in units of its last decimal.
fn whole(text: &str) -> i128 {
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
    let (before, after) = digits.split_once('.').unwrap_or((digits, ""));
    assert!(after.len() <= DECIMALS, "{text}");
    sign * format!("{before}{after:0<DECIMALS$}").parse::<i128>().unwrap()
}

/// The value of a double, which is a decimal number too.
fn exactly(x: f64) -> i128 {
    whole(&format!("{x:.DECIMALS$}"))
}

/// The texts of the numbers of a table in a file, row by row.
fn texts<'a>(file: &'a str, table: &str) -> Vec<Vec<&'a str>> {
    let (_, rest) = file.split_once(&format!("\"{table}\": [")).unwrap();
    let mut depth = 1;
    let end = rest.find(|c| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        depth == 0
    });
    let text = &rest[..end.unwrap()];
    let numbers =
        |row: &'a str| row.split([',', ']']).map(str::trim).filter(|part| !part.is_empty()).collect();
    if text.contains('[') { text.split('[').skip(1).map(numbers).collect() } else { vec![numbers(text)] }
}

/// The rows of a table in whole numbers.
fn rows(file: &str, table: &str) -> Vec<Vec<i128>> {
    texts(file, table).iter().map(|row| row.iter().map(|text| whole(text)).collect()).collect()
}

/// The reader rounds every decimal to the nearest double.
#[test]
fn every_number_is_the_nearest_double() {
    for (pair, file) in PAIRS {
        let check = |table: &str, found: &[Vec<f64>]| {
            let nearest = |row: &Vec<&str>| row.iter().map(|text| text.parse().unwrap()).collect();
            let expected: Vec<Vec<f64>> = texts(file, table).iter().map(nearest).collect();
            assert_eq!(found, expected, "{table} of {}", pair.name);
        };
        check("c", std::slice::from_ref(&pair.c));
        check("a", &pair.a);
        check("a_low", &pair.a_low);
        check("b", std::slice::from_ref(&pair.b));
        check("b_low", std::slice::from_ref(&pair.b_low));
        check("weights", &pair.interpolant.weights);
        check("spread", &[pair.spread.to_vec()]);
        if pair.error_order + 1 == pair.order {
            check("b_hat", std::slice::from_ref(&pair.b_hat));
        }
    }
}

/// A stage's coefficients add up to its place, and the weights to one: to 22 decimals, for coefficients of up
/// to a hundred.
#[test]
fn rows_of_tableaux_sum_to_their_nodes() {
    let allowed = 10_i128.pow(DECIMALS as u32 - 22);
    for (pair, file) in PAIRS {
        let places = &rows(file, "c")[0];
        let stages = rows(file, "a");
        assert_eq!((places.len(), stages.len()), (pair.c.len(), pair.a.len()));
        for (stage, row) in stages.iter().enumerate() {
            let sum: i128 = row.iter().sum();
            assert!((sum - places[stage]).abs() <= allowed, "{} {stage}: {sum}", pair.name);
        }
        let sum: i128 = rows(file, "b")[0].iter().sum();
        assert!((sum - whole("1")).abs() <= allowed, "{}: {sum}", pair.name);
    }
}

/// A double and its low part are the coefficient.
#[test]
fn low_parts_are_what_rounding_drops() {
    for (pair, file) in PAIRS {
        let check = |text: &[i128], high: &[f64], low: &[f64]| {
            assert_eq!((text.len(), text.len()), (high.len(), low.len()), "{}", pair.name);
            for ((text, high), low) in text.iter().zip(high).zip(low) {
                let missed = (text - exactly(*high) - exactly(*low)).abs();
                // Low parts have six digits, and the coefficients 26.
                let allowed = exactly(low.abs()) / 100_000 + exactly(high.abs()) / 10_i128.pow(25);
                assert!(missed <= allowed, "{}: {high} {low:e}", pair.name);
            }
        };
        for (stage, text) in rows(file, "a").iter().enumerate().take(pair.stages) {
            check(text, &pair.a[stage], &pair.a_low[stage]);
        }
        check(&rows(file, "b")[0], &pair.b, &pair.b_low);
    }
}
