// Elementary functions to the last digits: WGSL allows its own errors of 4096 last places (atan2) and of 5e-4 (sin).

const PI = 3.14159265358979;

// The angle of (x, y) in (-pi, pi], 0 for (0, 0); either sign of zero is zero.
//
// Of the smaller over the larger side, above tan(pi/8) by atan x = pi/4 + atan((x - 1)/(x + 1)), then the series of
// 1/(2k + 1), whose first missing term is below 2e-8.
fn angle_of(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let low = min(ax, ay);
    let high = max(ax, ay);
    if high == 0.0 {
        return 0.0;
    }
    let far = low > 0.414213562373095 * high;
    let t = select(low, low - high, far) / select(high, low + high, far);
    let q = t * t;
    var sum = -1.0 / 15.0;
    sum = sum * q + 1.0 / 13.0;
    sum = sum * q - 1.0 / 11.0;
    sum = sum * q + 1.0 / 9.0;
    sum = sum * q - 1.0 / 7.0;
    sum = sum * q + 1.0 / 5.0;
    sum = sum * q - 1.0 / 3.0;
    var a = t + t * q * sum + select(0.0, 0.25 * PI, far);
    a = select(a, 0.5 * PI - a, ay > ax);
    a = select(a, PI - a, x < 0.0);
    return select(a, -a, y < 0.0);
}

// (sin x, cos x) for |x| <= pi/4: the series, whose first missing terms are below 2e-9.
fn sin_cos_eighth(x: f32) -> vec2f {
    let q = x * x;
    let s = x * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0 + q / 362880.0))));
    let c = 1.0 + q * (-0.5 + q * (1.0 / 24.0 + q * (-1.0 / 720.0 + q * (1.0 / 40320.0 - q / 3628800.0))));
    return vec2f(s, c);
}

// 1 or -1; 1 for both zeros.
fn side_of(x: f32) -> f32 {
    return select(1.0, -1.0, x < 0.0);
}
