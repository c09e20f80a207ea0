//! Area lights: one for each emissive triangle with area, chosen by power through an alias table.

use midway_scene::{Material, Sides, WorldTriangle};

/// One emissive triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Index of the triangle in the world's order.
    pub triangle: u32,
    /// Its area.
    pub area: f32,
    /// What it is chosen by: emitted power (luminance, both sides where both emit), relative.
    pub power: f64,
}

/// The lights of a scene, with the alias table that draws them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// The lights.
    pub lights: Vec<AreaLight>,
    /// For each light its chance, threshold and alias.
    pub table: Vec<AliasEntry>,
}

/// An entry of an alias table (Vose 1991).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AliasEntry {
    /// The chance of drawing this entry in all.
    pub pmf: f32,
    /// Below it the cell's own entry is drawn, else the alias.
    pub threshold: f32,
    /// The other entry.
    pub alias: u32,
}

impl Lights {
    /// Collects the emissive triangles, each given with its index.
    pub fn collect(triangles: impl Iterator<Item = (u32, WorldTriangle)>, materials: &[Material]) -> Lights {
        let lights: Vec<AreaLight> = triangles
            .filter_map(|(index, triangle)| {
                let material = &materials[triangle.material as usize];
                let e = material.emission.value.as_dvec3();
                let area = triangle.area();
                let sides = if material.emits == Sides::Both { 2.0 } else { 1.0 };
                let luminance = 0.2126 * e.x + 0.7152 * e.y + 0.0722 * e.z;
                let power = luminance * f64::from(area) * sides;
                (power > 0.0 && power.is_finite()).then_some(AreaLight { triangle: index, area, power })
            })
            .collect();
        let table = alias_table(&lights.iter().map(|l| l.power).collect::<Vec<_>>());
        Lights { lights, table }
    }
}

/// Vose's construction. All weights are finite and positive.
pub fn alias_table(weights: &[f64]) -> Vec<AliasEntry> {
    let total: f64 = weights.iter().sum();
    let n = weights.len();
    let mut scaled: Vec<f64> = weights.iter().map(|w| w / total * n as f64).collect();
    let mut table: Vec<AliasEntry> = (0u32..)
        .zip(weights)
        .map(|(i, w)| AliasEntry { pmf: (w / total) as f32, threshold: 1.0, alias: i })
        .collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| scaled[i] < 1.0);
    while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
        table[s].threshold = scaled[s] as f32;
        table[s].alias = l as u32;
        scaled[l] -= 1.0 - scaled[s];
        if scaled[l] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::alias_table;

    #[test]
    fn the_table_draws_each_entry_by_its_weight() {
        let weights = [3.0, 1.0, 0.5, 7.0, 1e-3, 2.0];
        let table = alias_table(&weights);
        let total: f64 = weights.iter().sum();
        for (i, weight) in weights.iter().enumerate() {
            let mut chance = 0.0;
            for (cell, entry) in table.iter().enumerate() {
                let own = f64::from(entry.threshold);
                chance += if cell == i { own } else { 0.0 };
                chance += if entry.alias as usize == i { 1.0 - own } else { 0.0 };
            }
            chance /= weights.len() as f64;
            assert!((chance - weight / total).abs() <= 1e-7, "{i}: {chance}");
            assert!((f64::from(table[i].pmf) - weight / total).abs() <= 1e-7);
        }
    }
}
