// Elementary functions to the last digits: WGSL allows its own errors of 4096 last places (atan2) and of 5e-4 (sin).

const PI = 3.14159265358979;

// atan x for 0 <= x <= 1: above tan(pi/8) by atan x = pi/4 + atan((x - 1)/(x + 1)), then the series of 1/(2k + 1), whose
// first missing term is below 2e-8.
fn atan_unit(x: f32) -> f32 {
    let far = x > 0.414213562373095;
    let t = select(x, (x - 1.0) / (x + 1.0), far);
    let q = t * t;
    var sum = -1.0 / 15.0;
    sum = sum * q + 1.0 / 13.0;
    sum = sum * q - 1.0 / 11.0;
    sum = sum * q + 1.0 / 9.0;
    sum = sum * q - 1.0 / 7.0;
    sum = sum * q + 1.0 / 5.0;
    sum = sum * q - 1.0 / 3.0;
    return t + t * q * sum + select(0.0, 0.25 * PI, far);
}

// The angle of (x, y) in (-pi, pi], 0 for (0, 0); either sign of zero is zero.
fn angle_of(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    if max(ax, ay) == 0.0 {
        return 0.0;
    }
    var a = atan_unit(min(ax, ay) / max(ax, ay));
    a = select(a, 0.5 * PI - a, ay > ax);
    a = select(a, PI - a, x < 0.0);
    return select(a, -a, y < 0.0);
}

// (sin pi t, cos pi t) for |t| <= 2, exact where either is 0, 1 or -1.
fn sin_cos_pi(t: f32) -> vec2f {
    let quarters = round(2.0 * t);
    let x = PI * (t - 0.5 * quarters);
    let q = x * x;
    let s = x * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0 + q / 362880.0))));
    let c = 1.0 + q * (-0.5 + q * (1.0 / 24.0 + q * (-1.0 / 720.0 + q * (1.0 / 40320.0 - q / 3628800.0))));
    switch (i32(quarters) & 3) {
        case 0: { return vec2f(s, c); }
        case 1: { return vec2f(c, -s); }
        case 2: { return vec2f(-s, -c); }
        default: { return vec2f(-c, s); }
    }
}

// 1 or -1; 1 for both zeros.
fn side_of(x: f32) -> f32 {
    return select(1.0, -1.0, x < 0.0);
}
