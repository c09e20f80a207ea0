//! Curves of cost on logarithmic axes, as an SVG.

use std::{fmt::Write as _, path::Path};

use crate::status::{OrStatus, Outcome, Status};

/// Pixels of one curve's picture along x and y.
const PANEL: [f64; 2] = [260.0, 200.0];
/// Around the axes.
const MARGIN: f64 = 44.0;

/// What something costs against how much of something else there is; all values above 0.
pub struct Curve {
    /// What grows.
    pub name: &'static str,
    /// How much of it, and the cost.
    pub points: Vec<[f64; 2]>,
}

impl Curve {
    /// The exponent p of cost = c nᵖ by least squares on the logarithms; 0 for fewer than two points.
    pub fn exponent(&self) -> f64 {
        let logs: Vec<[f64; 2]> = self.points.iter().map(|p| p.map(f64::ln)).collect();
        let n = logs.len() as f64;
        let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / n;
        let [x, y] = [mean(0), mean(1)];
        let covariance: f64 = logs.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
        let variance: f64 = logs.iter().map(|p| (p[0] - x).powi(2)).sum();
        if variance > 0.0 { covariance / variance } else { 0.0 }
    }
}

/// Writes the curves side by side.
///
/// # Errors
/// [`Status::Output`].
pub fn write_svg(path: &Path, cost: &str, curves: &[Curve]) -> Outcome {
    std::fs::write(path, svg(cost, curves)).or_status(Status::Output)
}

fn svg(cost: &str, curves: &[Curve]) -> String {
    let (width, height) = (PANEL[0] * curves.len() as f64, PANEL[1] + 20.0);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"10\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (i, curve) in curves.iter().enumerate() {
        let _ = writeln!(
            text,
            "<g transform=\"translate({},0)\">{}</g>",
            PANEL[0] * i as f64,
            panel(cost, curve)
        );
    }
    text + "</svg>\n"
}

fn panel(cost: &str, curve: &Curve) -> String {
    let [x, y] = [0, 1].map(|axis| range(curve.points.iter().map(|p| p[axis])));
    let place = |p: &[f64; 2]| {
        [
            MARGIN + (PANEL[0] - 1.5 * MARGIN) * (p[0].log10() - x[0]) / (x[1] - x[0]),
            PANEL[1] - MARGIN - (PANEL[1] - 1.5 * MARGIN) * (p[1].log10() - y[0]) / (y[1] - y[0]),
        ]
    };
    let places: Vec<[f64; 2]> = curve.points.iter().map(place).collect();
    let mut text = format!(
        "<text x=\"{MARGIN}\" y=\"14\">{cost} ~ n^{:.2}</text>\
         <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
        curve.exponent(),
        PANEL[0] / 2.0,
        PANEL[1] - 6.0,
        curve.name
    );
    let line: Vec<String> = places.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
    let _ = write!(
        text,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#26547c\" stroke-width=\"1.5\"/>",
        line.join(" ")
    );
    for (at, [n, value]) in places.iter().zip(&curve.points) {
        let _ = write!(
            text,
            "<circle cx=\"{0:.1}\" cy=\"{1:.1}\" r=\"2.5\" fill=\"#26547c\"/>\
             <text x=\"{0:.1}\" y=\"{2:.1}\" text-anchor=\"middle\">{3}</text>\
             <text x=\"{0:.1}\" y=\"{4:.1}\" text-anchor=\"middle\" fill=\"#777\">{5}</text>",
            at[0],
            at[1],
            PANEL[1] - MARGIN + 16.0,
            short(*n),
            at[1] - 6.0,
            three_digits(*value),
        );
    }
    text
}

/// Decimal logarithms of the least and the largest value, a little apart.
fn range(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let low = values.clone().fold(f64::INFINITY, f64::min).log10();
    let high = values.fold(0.0, f64::max).log10();
    [low, high.max(low + 0.3)]
}

/// Rounded to three digits that count.
fn three_digits(value: f64) -> String {
    let decimals = (2.0 - value.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

/// `1k`, `10M`.
fn short(n: f64) -> String {
    match n {
        n if n >= 1e6 => format!("{}M", n / 1e6),
        n if n >= 1e3 => format!("{}k", n / 1e3),
        n => format!("{n}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_has_its_exponent() {
        let points = [1.0, 10.0, 100.0, 1000.0].map(|n: f64| [n, 3.0 * n.powf(0.25)]).to_vec();
        assert!((Curve { name: "triangles", points }.exponent() - 0.25).abs() <= 1e-9);
        assert_eq!(Curve { name: "one", points: vec![[1.0, 2.0]] }.exponent(), 0.0);
    }

    #[test]
    fn the_picture_holds_every_point_within_its_panel() {
        let points = vec![[1e3, 0.5], [1e5, 2.0], [1e7, 4.0]];
        let text = svg("seconds", &[Curve { name: "triangles", points }]);
        assert_eq!(text.matches("<circle").count(), 3);
        assert!(text.contains(">0.500<") && text.contains(">4.00<"));
        assert!(text.contains(">10M<") && !text.contains("NaN") && !text.contains("inf"));
    }
}
