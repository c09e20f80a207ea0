// Owen-scrambled Sobol points of four dimensions: one sequence for each path and dimension (purpose
// and depth), shuffled and scrambled by a hash, so that all the samples of a pixel are spread evenly
// in each draw and independent between draws, pixels and light paths.
// Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020; Sobol matrices of Joe and Kuo 2008.

/// Bits of a sample's number that address one sequence; beyond them the next one begins, scrambled
/// anew.
const SOBOL_BITS: u32 = 16u;
const SOBOL_MASK: u32 = 0xffffu;

/// Owen scrambling of bits in reverse order, as a permutation in which each bit is flipped by a hash
/// of the lower ones (Laine and Karras 2011, constants by Vegdahl 2021).
fn laine_karras(bits: u32, seed: u32) -> u32 {
    var x = bits;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// As laine_karras, of four numbers.
fn laine_karras4(bits: vec4<u32>, seed: vec4<u32>) -> vec4<u32> {
    var x = bits;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> vec4<u32>(16u)) | vec4<u32>(1u);
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// `column` where the bit of the index is set.
fn sobol_column(index: u32, bit: u32, column: u32) -> u32 {
    return (0u - ((index >> bit) & 1u)) & column;
}

/// The second dimension, bits in reverse order: Pascal's triangle modulo 2, each bit the sum of
/// those of the index whose place holds its own.
fn sobol_second(index: u32) -> u32 {
    var x = index;
    x ^= (x >> 1u) & 0x5555u;
    x ^= (x >> 2u) & 0x3333u;
    x ^= (x >> 4u) & 0x0f0fu;
    x ^= (x >> 8u) & 0x00ffu;
    return x;
}

/// The third dimension in the low half, the fourth in the high one, bits in reverse order.
fn sobol_third_and_fourth(index: u32) -> u32 {
    let a = sobol_column(index, 0u, 0x00010001u) ^ sobol_column(index, 1u, 0x00030003u)
        ^ sobol_column(index, 2u, 0x00040006u) ^ sobol_column(index, 3u, 0x000a0009u);
    let b = sobol_column(index, 4u, 0x001f0017u) ^ sobol_column(index, 5u, 0x002e003au)
        ^ sobol_column(index, 6u, 0x00450071u) ^ sobol_column(index, 7u, 0x00c900a3u);
    let c = sobol_column(index, 8u, 0x011b0116u) ^ sobol_column(index, 9u, 0x02a40339u)
        ^ sobol_column(index, 10u, 0x079a0677u) ^ sobol_column(index, 11u, 0x0b6709aau);
    let d = sobol_column(index, 12u, 0x101e1601u) ^ sobol_column(index, 13u, 0x302d3903u)
        ^ sobol_column(index, 14u, 0x40417706u) ^ sobol_column(index, 15u, 0xa0c3aa09u);
    return a ^ b ^ c ^ d;
}

/// The bits of a draw: as draw_bits, for the samples of one path together.
fn sobol_bits(path: u32, sample: u32, dim: u32, seed: u32) -> vec4<u32> {
    let scramble = draw_bits(path, sample >> SOBOL_BITS, dim, seed);
    // Shuffled: the order of samples in one draw says nothing of that in another.
    let index = reverseBits(laine_karras(reverseBits(sample & SOBOL_MASK), mix32(scramble.x))) & SOBOL_MASK;
    let rest = sobol_third_and_fourth(index);
    let point = vec4<u32>(index, sobol_second(index), rest & SOBOL_MASK, rest >> 16u);
    return reverseBits(laine_karras4(point, scramble));
}
