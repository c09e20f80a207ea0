// Small maths shared by all kernels. Where the two devices must agree to rounding, functions that
// WGSL leaves loose (sin, cos, exp: up to 2^-11 off) have their own polynomials here.

const PI: f32 = 3.14159265358979;
const INV_PI: f32 = 0.318309886183791;
const PI_OVER_4: f32 = 0.785398163397448;
const PI_OVER_2: f32 = 1.57079632679490;
const LOG2_E: f32 = 1.44269504088896;
/// The largest finite f32.
const F32_MAX: f32 = 3.40282346638529e38;
/// The greatest f32 below 1.
const LAST_BELOW_ONE: f32 = 0.99999994;
/// No triangle, no light, no path, no link.
const NONE: u32 = 0xffffffffu;

fn max3(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

/// Rec. 709 luminance.
fn luminance(rgb: vec3<f32>) -> f32 {
    return dot(rgb, vec3<f32>(0.2126, 0.7152, 0.0722));
}

/// Whether x is neither NaN nor infinite; by its bits, which no optimiser assumes away.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

/// sin for |x| <= π/4, error below 1e-7 (Taylor, degree 9).
fn sin_quarter(x: f32) -> f32 {
    let s = x * x;
    return x * (1.0 + s * (-0.166666667 + s * (0.00833333333 + s * (-0.000198412698 + s * 2.75573192e-6))));
}

/// cos for |x| <= π/4, error below 1e-7 (Taylor, degree 8).
fn cos_quarter(x: f32) -> f32 {
    let s = x * x;
    return 1.0 + s * (-0.5 + s * (0.0416666667 + s * (-0.00138888889 + s * 2.48015873e-5)));
}

/// Cosine and sine of any number of turns, error below 3e-7 within one turn of 0.
fn unit_circle(turns: f32) -> vec2<f32> {
    let quarter = floor(4.0 * turns + 0.5);
    let rest = (4.0 * turns - quarter) * PI_OVER_2; // within π/4
    let c = cos_quarter(rest);
    let s = sin_quarter(rest);
    switch u32(i32(quarter)) & 3u {
        case 0u: { return vec2<f32>(c, s); }
        case 1u: { return vec2<f32>(-s, c); }
        case 2u: { return vec2<f32>(-c, -s); }
        default: { return vec2<f32>(s, -c); }
    }
}

/// The angle of the point (x, y) in [-π, π], 0 at the origin; error below 5e-7 (polynomial of
/// atanf: Moshier, Cephes).
fn angle_of(y: f32, x: f32) -> f32 {
    let larger = max(abs(x), abs(y));
    if (larger == 0.0) {
        return 0.0;
    }
    let slope = min(abs(x), abs(y)) / larger;
    let reduce = slope > 0.414213562; // tan(π/8)
    let t = select(slope, (slope - 1.0) / (slope + 1.0), reduce);
    let z = t * t;
    let p = t + t * z * (-0.333329491539 + z * (0.199777106478 + z * (-0.138776856032 + z * 0.0805374449538)));
    let octant = select(p, p + PI_OVER_4, reduce);
    let quadrant = select(octant, PI_OVER_2 - octant, abs(y) > abs(x));
    let half = select(quadrant, PI - quadrant, x < 0.0);
    return select(half, -half, y < 0.0);
}

/// exp(x) for x <= 0, relative error below 3e-7 to x = -1, and 4e-6 to x = -87; below about -88
/// at most 1e-37.
fn exp_negative(x: f32) -> f32 {
    let y = max(x * LOG2_E, -127.0);
    let whole = floor(y + 0.5);
    let f = y - whole;
    // 2^f on [-1/2, 1/2]: Taylor of exp(f ln 2) to degree 6.
    let p = 1.0 + f * (0.693147181 + f * (0.240226507 + f * (0.0555041087 + f * (0.00961812911
        + f * (0.00133335581 + f * 0.000154035304)))));
    let scale = bitcast<f32>(u32(i32(whole) + 127) << 23u);
    return p * scale;
}

/// (cos, sin) of u turns, u in [0, 1]: by octants about the nearest quarter turn.
fn cos_sin_turn(u: f32) -> vec2<f32> {
    let quarter = floor(4.0 * u + 0.5);
    let x = (u - 0.25 * quarter) * (2.0 * PI); // |x| <= π/4
    let c = cos_quarter(x);
    let s = sin_quarter(x);
    let turned = select(vec2<f32>(c, s), vec2<f32>(-s, c), (u32(quarter) & 1u) != 0u);
    return select(turned, -turned, (u32(quarter) & 2u) != 0u);
}

/// x^y for x in (0, 1] and y >= 0, relative error below 1e-6 (1 + y |ln x|): ln by the series of
/// atanh about the nearest power of 2.
fn pow_unit(x: f32, y: f32) -> f32 {
    let bits = bitcast<u32>(x);
    let upper = (bits & 0x7fffffu) > 0x3504f3u; // mantissa over √2
    let mantissa = bitcast<f32>((bits & 0x7fffffu) | select(0x3f800000u, 0x3f000000u, upper));
    let exponent = f32(i32(bits >> 23u) - 127 + select(0, 1, upper));
    let z = (mantissa - 1.0) / (mantissa + 1.0); // |z| < 0.172
    let z2 = z * z;
    let ln = 2.0 * z * (1.0 + z2 * (0.333333333 + z2 * (0.2 + z2 * (0.142857143 + z2 * 0.111111111))));
    return exp_negative(min(y * (exponent * 0.693147181 + ln), 0.0));
}

/// 1 / d with zeros replaced by a huge finite number of the same sign, so that slab tests meet no
/// 0 * infinity.
fn safe_inverse(d: vec3<f32>) -> vec3<f32> {
    let tiny = vec3<f32>(1e-20);
    let signed_tiny = select(tiny, -tiny, d < vec3<f32>(0.0));
    return vec3<f32>(1.0) / select(d, signed_tiny, abs(d) < tiny);
}

/// An orthonormal frame whose third column is the unit vector n (Duff et al. 2017, listing 3).
fn frame_from_normal(n: vec3<f32>) -> mat3x3<f32> {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z); // |s + n.z| >= 1
    let b = n.x * n.y * a;
    let x = vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    let y = vec3<f32>(b, s + n.y * n.y * a, -n.y);
    return mat3x3<f32>(x, y, n);
}

/// Moves a point on a surface off it along n, the unit geometric normal on the side that the ray
/// leaves to, by 2^-16 of its largest coordinate: 256 units in the last place, as Wächter and Binder
/// 2019 ("A fast and robust method for avoiding self-intersection") move each coordinate by its own.
/// Coordinate by coordinate a wall at x = 0 would be left by less than a shadow ray from x = 550
/// can resolve. Coordinates below 1/32 count as 1/32.
fn offset_origin(p: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    return p + n * (max(max3(abs(p)), 1.0 / 32.0) * (1.0 / 65536.0));
}
