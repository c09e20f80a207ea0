const LIMIT: u32 = 10u;
const TABLE = array<f32, 3>(0.5, -0.0, 0x1p-20);

struct Sum { total: f32, gen: u32 }

fn sum_up(values: ptr<function, array<f32, 4>>, box: u32) -> Sum {
    var sum = Sum();
    for (var i = 0u; i < 4u && sum.total < 1e10; i++) {
        if i == box { continue; }
        let part = (*values)[i];
        sum.total += part * TABLE[i];
        switch i {
            case 0u, 1u: { if part < 0.0 { break; } sum.gen |= 1u << i; }
            default: { sum.gen %= LIMIT; }
        }
    }
    loop {
        let half = 0.5 * sum.total;
        if half < 1.0 { break; }
        continuing {
            sum.total = half;
            break if sum.gen == 3u;
        }
    }
    if sum.gen == 0u { return Sum(1.0, 7u / LIMIT); } else if sum.gen == 1u { sum.gen = 2u; } else { sum.gen = 5u; }
    return sum;
}
