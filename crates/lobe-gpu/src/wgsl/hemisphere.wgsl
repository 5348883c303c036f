// Irradiance of the normals on one side of a surface, as `lobe_sh::encoding` has it. Normals n are unit vectors in the
// frame of the surface, with +z along its geometric normal.

// Irradiance from four coefficients of the H-basis, n in the frame of the surface, after Habel and Wimmer 2010.
// `HBasis4` has them.
fn h_basis_4_eval(c: array<vec3f, 4>, n: vec3f) -> vec3f {
    return 0.398942280401433 * c[0] + 0.690988298942671 * (c[2] * (2.0 * n.z - 1.0) - c[1] * n.y - c[3] * n.x);
}

// Irradiance from six coefficients of the H-basis, n in the frame of the surface, after Habel and Wimmer 2010.
// `HBasis6` has them.
fn h_basis_6_eval(c: array<vec3f, 6>, n: vec3f) -> vec3f {
    let affine = c[2] * (2.0 * n.z - 1.0) - c[1] * n.y - c[3] * n.x;
    let quadratic = c[4] * (n.x * n.y) + c[5] * (0.5 * (n.x * n.x - n.y * n.y));
    return 0.398942280401433 * c[0] + 0.690988298942671 * affine + 1.5450968080927583 * quadratic;
}

// The cosines of n with the three directions of radiosity normal mapping, after Mitchell, McTaggart and Green 2006.
fn hl2_cosines(n: vec3f) -> vec3f {
    let up = 0.577350269189626 * n.z;
    let back = up - 0.408248290463863 * n.x;
    return vec3f(back - 0.707106781186548 * n.y, back + 0.707106781186548 * n.y, up + 0.816496580927726 * n.x);
}

// Irradiance from three colors of radiosity normal mapping, n in the frame of the surface, weights squared.
// `Hl2` has them. E(n) = sum_i c_i w_i / sum_i w_i with w_i = max(n.b_i, 0)^2. 0 for a normal that faces away from
// all three directions.
fn hl2_eval(colors: array<vec3f, 3>, n: vec3f) -> vec3f {
    let cosines = max(hl2_cosines(n), vec3f(0.0));
    let weights = cosines * cosines;
    let sum = weights.x + weights.y + weights.z;
    return (colors[0] * weights.x + colors[1] * weights.y + colors[2] * weights.z) / select(1.0, sum, sum > 0.0);
}

// Irradiance from three colors of radiosity normal mapping, n in the frame of the surface, weights linear.
// `Hl2::linear` has them. E(n) = sum_i c_i n.b_i.
fn hl2_linear_eval(colors: array<vec3f, 3>, n: vec3f) -> vec3f {
    let cosines = hl2_cosines(n);
    return colors[0] * cosines.x + colors[1] * cosines.y + colors[2] * cosines.z;
}
