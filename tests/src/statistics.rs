//! Tests of hypotheses: Student's t with Šidák's correction over blocks of pixels.

/// Mean and standard error of the mean of independent values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// The standard error of the mean.
    pub standard_error: f64,
    /// Degrees of freedom behind the standard error.
    pub degrees: f64,
}

impl Estimate {
    /// From at least two values.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Self { mean, standard_error: (variance / n).sqrt(), degrees: n - 1.0 }
    }

    /// A value known without error.
    pub fn exact(mean: f64) -> Self {
        Self { mean, standard_error: 0.0, degrees: f64::INFINITY }
    }

    /// A value whose standard error is known.
    pub fn known(mean: f64, standard_error: f64) -> Self {
        Self { mean, standard_error, degrees: f64::INFINITY }
    }

    /// How many standard errors of their difference lie between two estimates; 0 where both are
    /// equal and without error, infinite or NaN where something is badly wrong.
    pub fn z(&self, other: &Self) -> f64 {
        let difference = self.mean - other.mean;
        if difference == 0.0 { 0.0 } else { difference / self.standard_error.hypot(other.standard_error) }
    }

    /// Two-sided p-value of Welch's t-test against another estimate; NaN is 0.
    pub fn p_value(&self, other: &Self) -> f64 {
        let (a, b) = (self.standard_error.powi(2), other.standard_error.powi(2));
        let spread = a * a / self.degrees + b * b / other.degrees;
        let degrees = if spread > 0.0 { (a + b).powi(2) / spread } else { f64::INFINITY };
        let p = student_two_sided(self.z(other).abs(), degrees);
        if p.is_nan() { 0.0 } else { p }
    }
}

/// The level of each of `n` tests so that all together err with chance `family` (Šidák 1967).
pub fn sidak(family: f64, n: usize) -> f64 {
    1.0 - (1.0 - family).powf(1.0 / n as f64)
}

/// P(|T| > t) for Student's distribution.
pub fn student_two_sided(t: f64, degrees: f64) -> f64 {
    if t.is_infinite() {
        return 0.0;
    }
    // Beyond a million degrees the normal distribution's tail is the same to 6 digits.
    let degrees = degrees.min(1e6);
    incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t))
}

/// P(X > x) for the chi-square distribution.
pub fn chi_square_tail(x: f64, degrees: f64) -> f64 {
    1.0 - incomplete_gamma(0.5 * degrees, 0.5 * x)
}

/// ln Γ(x), x > 0 (Lanczos, g = 7).
fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let sum = (1..9).fold(C[0], |sum, i| sum + C[i] / (x + i as f64));
    let t = x + 7.5;
    0.5 * (2.0 * std::f64::consts::PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Regularised incomplete beta function I_x(a, b), by Lentz's continued fraction.
fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p()).exp() / a;
    let fraction = continued_fraction(|i| {
        let m = f64::from(i / 2);
        if i == 0 {
            1.0
        } else if i % 2 == 0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        }
    });
    front * (fraction - 1.0)
}

/// 1 + d0 / (1 + d1 / (1 + …)) by Lentz's method.
fn continued_fraction(coefficient: impl Fn(u32) -> f64) -> f64 {
    const TINY: f64 = 1e-300;
    let (mut f, mut c, mut d) = (1.0, 1.0, 0.0);
    for i in 0..10_000 {
        let a = coefficient(i);
        d = 1.0 + a * d;
        d = 1.0 / if d.abs() < TINY { TINY } else { d };
        c = 1.0 + a / c;
        c = if c.abs() < TINY { TINY } else { c };
        f *= c * d;
        if (1.0 - c * d).abs() < 1e-14 {
            break;
        }
    }
    f
}

/// Regularised lower incomplete gamma function P(a, x), by its series or its continued fraction.
fn incomplete_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for i in 1..100_000 {
            term *= x / (a + f64::from(i));
            sum += term;
            if term < sum * 1e-16 {
                break;
            }
        }
        return front * sum;
    }
    let (mut b, mut c) = (x + 1.0 - a, 1e300);
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..100_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    1.0 - front * h
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of tables.
    #[test]
    fn tails_are_those_of_the_tables() {
        for (t, degrees, p) in
            [(2.131, 15.0, 0.05), (4.073, 15.0, 0.001), (1.96, 1e9, 0.05), (12.706, 1.0, 0.05)]
        {
            let got = student_two_sided(t, degrees);
            assert!((got - p).abs() <= 2e-3 * p + 2e-5, "t {t}: {got}");
        }
        for (x, degrees, p) in [(3.841, 1.0, 0.05), (18.307, 10.0, 0.05), (149.449, 100.0, 0.001)] {
            let got = chi_square_tail(x, degrees);
            assert!((got - p).abs() <= 2e-3 * p, "chi-square {x}: {got}");
        }
    }

    #[test]
    fn nan_never_passes() {
        let good = Estimate::of(&[1.0, 1.1, 0.9]);
        assert!(good.p_value(&Estimate::exact(1.0)) > 0.5);
        assert!(good.p_value(&Estimate::exact(f64::NAN)) == 0.0);
        assert!(Estimate::of(&[1.0, f64::NAN]).p_value(&good) == 0.0);
        assert!(Estimate::of(&[1.0, 1.0]).p_value(&Estimate::exact(1.001)) == 0.0);
    }
}
