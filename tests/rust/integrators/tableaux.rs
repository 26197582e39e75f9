//! The digits of the tableaux: those beyond doubles, which no run is long enough to show.
//!
//! The source has the coefficients to some 26 digits. Here they are read from it and added in whole numbers.

use fullbody::integrate::{DORMAND_PRINCE54, Tableau, VERNER65, VERNER76, VERNER87, VERNER96, VERNER98};

const PAIRS: [(&Tableau, &str); 6] = [
    (&DORMAND_PRINCE54, include_str!("../../../src/integrate/dormand_prince54.rs")),
    (&VERNER65, include_str!("../../../src/integrate/verner65.rs")),
    (&VERNER76, include_str!("../../../src/integrate/verner76.rs")),
    (&VERNER87, include_str!("../../../src/integrate/verner87.rs")),
    (&VERNER96, include_str!("../../../src/integrate/verner98.rs")),
    (&VERNER98, include_str!("../../../src/integrate/verner98.rs")),
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

/// The rows of a table in the source.
fn rows(source: &str, table: &str) -> Vec<Vec<i128>> {
    let (_, rest) = source.split_once(&format!("\nstatic {table}: ")).unwrap();
    let (_, rest) = rest.split_once('=').unwrap();
    let (text, _) = rest.split_once(';').unwrap();
    let numbers = |row: &str| {
        let parts = row.split([',', '[', ']', '&']).map(str::trim);
        parts.filter(|part| !part.is_empty()).map(whole).collect()
    };
    if text.contains('&') { text.split('&').skip(1).map(numbers).collect() } else { vec![numbers(text)] }
}

/// A stage's coefficients add up to its place, and the weights to one: to 22 decimals, for coefficients of up
/// to a hundred.
#[test]
fn rows_add_up() {
    let allowed = 10_i128.pow(DECIMALS as u32 - 22);
    for (pair, source) in PAIRS {
        let places = &rows(source, "C")[0];
        let stages = rows(source, "A");
        assert_eq!((places.len(), stages.len()), (pair.c.len(), pair.a.len()));
        for (stage, row) in stages.iter().enumerate() {
            let sum: i128 = row.iter().sum();
            assert!((sum - places[stage]).abs() <= allowed, "{} {stage}: {sum}", pair.name);
        }
        let sum: i128 = rows(source, "B")[0].iter().sum();
        assert!((sum - whole("1")).abs() <= allowed, "{}: {sum}", pair.name);
    }
}

/// A double and its low part are the coefficient.
#[test]
fn low_parts_are_what_rounding_drops() {
    for (pair, source) in PAIRS {
        let check = |text: &[i128], high: &[f64], low: &[f64]| {
            assert_eq!((text.len(), text.len()), (high.len(), low.len()), "{}", pair.name);
            for ((text, high), low) in text.iter().zip(high).zip(low) {
                let missed = (text - exactly(*high) - exactly(*low)).abs();
                // Low parts have six digits, and the coefficients 26.
                let allowed = exactly(low.abs()) / 100_000 + exactly(high.abs()) / 10_i128.pow(25);
                assert!(missed <= allowed, "{}: {high} {low:e}", pair.name);
            }
        };
        for (stage, text) in rows(source, "A").iter().enumerate().take(pair.stages) {
            check(text, pair.a[stage], pair.a_low[stage]);
        }
        check(&rows(source, "B")[0], pair.b, pair.b_low);
    }
}
