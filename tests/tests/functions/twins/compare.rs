//! The comparison of what two devices computed, and proofs that it fails where it should.

/// What one device computed, for one invocation after another.
#[derive(Clone, Debug)]
pub struct Results {
    /// The device's name.
    pub device: String,
    /// `stride` numbers for each invocation.
    pub words: Vec<u32>,
}

/// How far two devices may be apart.
#[derive(Clone, Copy, Debug)]
pub enum Tolerance {
    /// Not at all: integers, and floats made of exact operations.
    Exact,
    /// Each number by `relative` of the larger magnitude, or by `absolute`; but in `outliers` of the
    /// invocations, where rounding chose another branch, by anything that is a number.
    Float { relative: f64, absolute: f64, outliers: f64 },
}

/// Compares the results of two devices, `stride` words an invocation.
///
/// # Errors
/// What is wrong first.
pub fn compare(a: &Results, b: &Results, stride: usize, tolerance: Tolerance) -> Result<(), String> {
    if a.device == b.device {
        return Err(format!("{} was compared with itself", a.device));
    }
    if a.words.len() != b.words.len() || a.words.is_empty() || !a.words.len().is_multiple_of(stride) {
        return Err(format!("{} and {} words at stride {stride}", a.words.len(), b.words.len()));
    }
    if a.words.iter().all(|word| *word == 0) {
        return Err("nothing was computed: all words are 0".into());
    }
    let mut apart = Vec::new();
    for (i, (x, y)) in a.words.chunks(stride).zip(b.words.chunks(stride)).enumerate() {
        if let Some(difference) = first_difference(x, y, tolerance)? {
            apart.push(format!("invocation {i}, {difference}"));
        }
    }
    let allowed = match tolerance {
        Tolerance::Exact => 0.0,
        Tolerance::Float { outliers, .. } => outliers * (a.words.len() / stride) as f64,
    };
    if apart.len() as f64 <= allowed {
        return Ok(());
    }
    let first = apart.iter().take(5).cloned().collect::<Vec<_>>().join("\n");
    Err(format!("{} invocations differ, {allowed} may:\n{first}", apart.len()))
}

/// Where two invocations' numbers are too far apart.
///
/// # Errors
/// If one is not a finite number.
fn first_difference(a: &[u32], b: &[u32], tolerance: Tolerance) -> Result<Option<String>, String> {
    for (field, (&x, &y)) in a.iter().zip(b).enumerate() {
        let Tolerance::Float { relative, absolute, .. } = tolerance else {
            if x != y {
                return Ok(Some(format!("word {field}: {x:#x} and {y:#x}")));
            }
            continue;
        };
        let (x, y) = (f64::from(f32::from_bits(x)), f64::from(f32::from_bits(y)));
        if !x.is_finite() || !y.is_finite() {
            return Err(format!("word {field}: {x} and {y} are not both finite"));
        }
        let near = (x - y).abs() <= absolute.max(relative * x.abs().max(y.abs()));
        if !near {
            return Ok(Some(format!("word {field}: {x:e} and {y:e}")));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod must_fail {
    use super::*;

    const FLOAT: Tolerance = Tolerance::Float { relative: 1e-5, absolute: 1e-6, outliers: 0.01 };

    fn results(device: &str, values: &[f32]) -> Results {
        Results { device: device.into(), words: values.iter().map(|value| value.to_bits()).collect() }
    }

    fn ramp(device: &str) -> Results {
        results(device, &(0..400).map(|i| i as f32 * 0.25 + 1.0).collect::<Vec<_>>())
    }

    #[test]
    fn what_is_alike_passes() {
        assert_eq!(compare(&ramp("a"), &ramp("b"), 4, FLOAT), Ok(()));
        assert_eq!(compare(&ramp("a"), &ramp("b"), 4, Tolerance::Exact), Ok(()));
        let mut near = ramp("b");
        near.words.iter_mut().for_each(|word| *word += 1);
        assert_eq!(compare(&ramp("a"), &near, 4, FLOAT), Ok(()));
        assert!(compare(&ramp("a"), &near, 4, Tolerance::Exact).is_err());
    }

    #[test]
    fn a_device_is_not_compared_with_itself() {
        assert!(compare(&ramp("a"), &ramp("a"), 4, FLOAT).is_err());
    }

    #[test]
    fn nan_and_infinity_fail_even_as_one_outlier_and_on_both_sides() {
        for bad in [f32::NAN, f32::INFINITY] {
            let (mut a, mut b) = (ramp("a"), ramp("b"));
            b.words[7] = bad.to_bits();
            assert!(compare(&a, &b, 4, FLOAT).is_err(), "{bad} on one side");
            a.words[7] = bad.to_bits();
            assert!(compare(&a, &b, 4, FLOAT).is_err(), "{bad} on both");
        }
    }

    #[test]
    fn swapped_scaled_zeroed_and_cut_results_fail() {
        let mut swapped = ramp("b");
        swapped.words.chunks_mut(4).for_each(|row| row.swap(0, 1));
        let mut reversed = ramp("b");
        reversed.words.reverse();
        let mut scaled = ramp("b");
        scaled.words.iter_mut().for_each(|word| *word = (f32::from_bits(*word) * 1.01).to_bits());
        let zero = results("b", &[0.0; 400]);
        let mut cut = ramp("b");
        cut.words.truncate(396);
        for (what, wrong) in [
            ("swapped", swapped),
            ("reversed", reversed),
            ("scaled", scaled),
            ("zero", zero.clone()),
            ("cut", cut),
        ] {
            assert!(compare(&ramp("a"), &wrong, 4, FLOAT).is_err(), "{what}");
        }
        assert!(compare(&results("a", &[0.0; 400]), &zero, 4, FLOAT).is_err(), "both zero");
        assert!(compare(&results("a", &[]), &results("b", &[]), 4, FLOAT).is_err(), "both empty");
    }

    #[test]
    fn outliers_beyond_their_share_fail() {
        let with = |n: usize| {
            let mut other = ramp("b");
            (0..n).for_each(|i| other.words[i * 4] = 5e5f32.to_bits());
            compare(&ramp("a"), &other, 4, FLOAT)
        };
        assert_eq!(with(1), Ok(()));
        assert!(with(2).is_err());
    }
}
