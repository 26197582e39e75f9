//! Roots and extrema of a function of one variable.
//!
//! The methods are those of R. P. Brent (1973), Algorithms for Minimization without Derivatives, chapters 4
//! and 5.

/// Returns the root between `a` and `b`, where the function has values `fa` and `fb` of opposite sign, to the
/// last bits.
///
/// The values at the ends are taken as given, so that intervals with a common end agree about the sign there.
pub fn root<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
) -> Result<f64, E> {
    let (mut c, mut fc) = (a, fa);
    let (mut step, mut previous_step) = (b - a, b - a);
    for _ in 0..200 {
        if (fb > 0.0) == (fc > 0.0) {
            (c, fc) = (a, fa);
            (step, previous_step) = (b - a, b - a);
        }
        if fc.abs() < fb.abs() {
            (a, fa) = (b, fb);
            (b, fb) = (c, fc);
            (c, fc) = (a, fa);
        }
        let tolerance = f64::EPSILON * b.abs() + f64::MIN_POSITIVE;
        let half = 0.5 * (c - b);
        if fb == 0.0 || half.abs() <= tolerance {
            break;
        }
        if previous_step.abs() < tolerance || fa.abs() <= fb.abs() {
            (step, previous_step) = (half, half);
        } else {
            let s = fb / fa;
            let (mut p, mut q) = if a == c {
                (2.0 * half * s, 1.0 - s)
            } else {
                let (q, r) = (fa / fc, fb / fc);
                (s * (2.0 * half * q * (q - r) - (b - a) * (r - 1.0)), (q - 1.0) * (r - 1.0) * (s - 1.0))
            };
            if p > 0.0 {
                q = -q;
            }
            p = p.abs();
            if 2.0 * p < (3.0 * half * q - (tolerance * q).abs()).min((previous_step * q).abs()) {
                previous_step = step;
                step = p / q;
            } else {
                (step, previous_step) = (half, half);
            }
        }
        (a, fa) = (b, fb);
        b += if step.abs() > tolerance { step } else { tolerance.copysign(half) };
        fb = f(b)?;
    }
    Ok(b)
}

/// The largest number of times that an interval between roots of a polynomial is halved; roots that are
/// nearer to each other count as a double root.
const HALVINGS: u32 = 44;

/// Finds the simple roots above -1 and up to 1, in rising order, of a polynomial of the eighth degree at
/// most.
///
/// The roots are separated by Descartes' rule: an interval contains no more roots than there are changes of
/// sign in the Bernstein coefficients, and exactly one root for one change. Other intervals are halved.
pub fn polynomial_roots(polynomial: &[f64], take_root: &mut dyn FnMut(f64)) {
    let n = polynomial.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    // The polynomial (1 + v)^n p((v - 1) / (v + 1)) has the Bernstein coefficients times the binomial ones.
    let (mut sum, mut power) = ([0.0; 9], [0.0; 9]);
    (sum[0], power[0]) = (polynomial[n], 1.0);
    for k in 1..=n {
        let c = polynomial[n - k];
        for j in (1..=k).rev() {
            power[j] += power[j - 1];
            sum[j] = sum[j - 1] - sum[j] + c * power[j];
        }
        sum[0] = c - sum[0];
    }
    (0..=n).for_each(|j| sum[j] /= power[j]);
    separate(&polynomial[..=n], &sum, (-1.0, 1.0), HALVINGS, take_root);
    if sum[n] == 0.0 && sum[0] != 0.0 {
        take_root(1.0);
    }
}

/// Finds the roots within an interval, for which the polynomial has these Bernstein coefficients.
fn separate(
    polynomial: &[f64],
    b: &[f64; 9],
    (low, high): (f64, f64),
    halvings_left: u32,
    take_root: &mut dyn FnMut(f64),
) {
    let n = polynomial.len() - 1;
    let (mut changes, mut previous_sign) = (0, b[0]);
    for c in &b[1..=n] {
        changes += u32::from(previous_sign * c < 0.0);
        previous_sign = if *c == 0.0 { previous_sign } else { *c };
    }
    if changes == 1 && b[0] * b[n] < 0.0 {
        let value = |t: f64| {
            Ok::<_, std::convert::Infallible>(polynomial.iter().rev().fold(0.0, |sum, c| sum * t + c))
        };
        let Ok(t) = root(value, (low, b[0]), (high, b[n]));
        take_root(t);
    } else if changes > 0 && halvings_left > 0 {
        let (mut first, mut second) = ([0.0; 9], *b);
        for k in 0..=n {
            first[k] = second[0];
            (0..n - k).for_each(|j| second[j] = 0.5 * (second[j] + second[j + 1]));
        }
        let middle = 0.5 * (low + high);
        separate(polynomial, &first, (low, middle), halvings_left - 1, take_root);
        if second[0] == 0.0 {
            take_root(middle);
        }
        separate(polynomial, &second, (middle, high), halvings_left - 1, take_root);
    }
}

/// Returns the abscissa and the value of the minimum between `a` and `b` of a function that has one minimum
/// there.
///
/// The search stops as soon as a value is below zero, since callers need only to know whether the function
/// becomes negative.
pub fn minimum<E>(mut f: impl FnMut(f64) -> Result<f64, E>, a: f64, b: f64) -> Result<(f64, f64), E> {
    const GOLDEN: f64 = 0.381_966_011_250_105_15;
    let (mut a, mut b) = (a, b);
    let mut x = a + GOLDEN * (b - a);
    let mut fx = f(x)?;
    let (mut w, mut fw, mut v, mut fv) = (x, fx, x, fx);
    let (mut d, mut e): (f64, f64) = (0.0, 0.0);
    for _ in 0..80 {
        let middle = 0.5 * (a + b);
        // The function is flat at its minimum: half the digits of the abscissa give all digits of the value.
        let tolerance = 1e-9 * x.abs() + 1e-12;
        if fx < 0.0 || (x - middle).abs() <= 2.0 * tolerance - 0.5 * (b - a) {
            break;
        }
        let mut golden = true;
        if e.abs() > tolerance {
            let r = (x - w) * (fx - fv);
            let mut q = (x - v) * (fx - fw);
            let mut p = (x - v) * q - (x - w) * r;
            q = 2.0 * (q - r);
            if q > 0.0 {
                p = -p;
            }
            q = q.abs();
            if p.abs() < (0.5 * q * e).abs() && p > q * (a - x) && p < q * (b - x) {
                e = d;
                d = p / q;
                golden = false;
            }
        }
        if golden {
            e = if x < middle { b - x } else { a - x };
            d = GOLDEN * e;
        }
        let u = x + if d.abs() >= tolerance { d } else { tolerance.copysign(d) };
        let fu = f(u)?;
        if fu <= fx {
            if u < x {
                b = x
            } else {
                a = x
            }
            (v, fv, w, fw, x, fx) = (w, fw, x, fx, u, fu);
        } else {
            if u < x {
                a = u
            } else {
                b = u
            }
            if fu <= fw || w == x {
                (v, fv, w, fw) = (w, fw, u, fu);
            } else if fu <= fv || v == x || v == w {
                (v, fv) = (u, fu);
            }
        }
    }
    Ok((x, fx))
}

/// The number of equal intervals at whose ends [`first_fall_below_zero`] samples a function, which may have one
/// extremum in each.
const INTERVALS: usize = 8;

/// The distance of two further samples from the start and the end, as a fraction of the whole interval.
const NEAR: f64 = 1e-3;

/// Returns the first root between 0 and `end` at which a function falls below zero, and an abscissa after it at
/// which the function is negative. At 0 the function is not negative.
pub fn first_fall_below_zero<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    end: f64,
) -> Result<Option<(f64, f64)>, E> {
    let abscissa = |k: usize| match k {
        1 => NEAR * end,
        k if k == INTERVALS + 1 => (1.0 - NEAR) * end,
        k if k > INTERVALS => end,
        k => k.saturating_sub(1) as f64 / INTERVALS as f64 * end,
    };
    let (mut earlier, mut last) = (None, (0.0, f(0.0)?.max(0.0)));
    for k in 1..INTERVALS + 3 {
        let next = (abscissa(k), f(abscissa(k))?);
        // Between three values of which the middle one is the least there is a minimum.
        if let Some((from, above)) = earlier
            && last.1 < above
            && last.1 <= next.1
        {
            let (lowest, value): (f64, f64) = minimum(&mut f, from, next.0)?;
            if value < 0.0 {
                return Ok(Some((root(&mut f, (from, above), (lowest, value))?, lowest)));
            }
        }
        if next.1 < 0.0 {
            return Ok(Some((root(&mut f, last, next)?, next.0)));
        }
        (earlier, last) = (Some(last), next);
    }
    Ok(None)
}
