//! What is done to attributes once they are decompressed.

/// Applies a filter in place, to elements of `stride` bytes.
pub(super) fn apply(filter: &str, bytes: &mut [u8], stride: usize) -> Result<(), &'static str> {
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => bytes.as_chunks_mut::<4>().0.iter_mut().for_each(octahedral_bytes),
        ("OCTAHEDRAL", 8) => bytes.as_chunks_mut::<8>().0.iter_mut().for_each(octahedral_words),
        ("QUATERNION", 8) => bytes.as_chunks_mut::<8>().0.iter_mut().for_each(quaternion),
        ("EXPONENTIAL", _) => bytes.as_chunks_mut::<4>().0.iter_mut().for_each(exponential),
        ("OCTAHEDRAL" | "QUATERNION", _) => return Err("the filter does not go with this stride"),
        _ => return Err("a filter is NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL"),
    }
    Ok(())
}

fn octahedral_bytes(element: &mut [u8; 4]) {
    let [x, y, one] = [0, 1, 2].map(|i| f32::from(element[i] as i8));
    let unit = octahedral(x, y, one, 127.0);
    (0..3).for_each(|i| element[i] = unit[i] as i8 as u8);
}

fn octahedral_words(element: &mut [u8; 8]) {
    let [x, y, one] = [0, 1, 2].map(|i| f32::from(word(element, i)));
    let unit = octahedral(x, y, one, 32767.0);
    (0..3).for_each(|i| set_word(element, i, unit[i] as i16));
}

/// A unit vector times `most`, from its place on an octahedron of the size `one`.
fn octahedral(x: f32, y: f32, one: f32, most: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    // The lower half is folded outwards.
    let fold = z.min(0.0);
    let x = x + if x >= 0.0 { fold } else { -fold };
    let y = y + if y >= 0.0 { fold } else { -fold };
    let length = (x * x + y * y + z * z).sqrt();
    let scale = if length > 0.0 { most / length } else { 0.0 };
    [x, y, z].map(|c| (c * scale).round())
}

/// Three components of which the largest, left out, follows from the length.
fn quaternion(element: &mut [u8; 8]) {
    let last = word(element, 3);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(last | 3);
    let [x, y, z] = [0, 1, 2].map(|i| f32::from(word(element, i)) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let largest = (last & 3) as usize;
    for (i, component) in [w, x, y, z].into_iter().enumerate() {
        set_word(element, (largest + i) % 4, (component * 32767.0).round() as i16);
    }
}

/// A mantissa of 24 bits and an exponent of 8.
fn exponential(element: &mut [u8; 4]) {
    let bits = i32::from_le_bytes(*element);
    let (exponent, mantissa) = (bits >> 24, (bits << 8) >> 8);
    let value = f64::from(mantissa) * 2f64.powi(exponent);
    *element = (value as f32).to_le_bytes();
}

fn word(element: &[u8; 8], i: usize) -> i16 {
    i16::from_le_bytes([element[2 * i], element[2 * i + 1]])
}

fn set_word(element: &mut [u8; 8], i: usize, value: i16) {
    element[2 * i..2 * i + 2].copy_from_slice(&value.to_le_bytes());
}
