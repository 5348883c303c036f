// Irradiance of orders 3 and 5 as polynomials of the normal, as `lobe_sh::encoding` has them: exact rearrangements of
// the expansion.

// Irradiance of order 3 from the seven vectors cAr cAg cAb cBr cBg cBb cC, after Sloan 2008 A10.
// `PackedIrradiance::to_vectors` has the vectors in this order.
// E(n) = A.(x, y, z, 1) + B.(xy, yz, zz, zx) + C (xx - yy) for each channel, n a unit vector.
fn packed_irradiance_eval(vectors: array<vec4f, 7>, n: vec3f) -> vec3f {
    let affine = vec4f(n, 1.0);
    let quadratic = n.xyzz * n.yzzx;
    return vec3f(dot(vectors[0], affine), dot(vectors[1], affine), dot(vectors[2], affine))
        + vec3f(dot(vectors[3], quadratic), dot(vectors[4], quadratic), dot(vectors[5], quadratic))
        + vectors[6].xyz * (n.x * n.x - n.y * n.y);
}

// Irradiance of order 5 from fourteen vectors: the seven, then cDr cDg cDb cFr cFg cFb cG.
// `PackedIrradiance5::to_vectors` has the vectors in this order.
// E(n) = A.(x, y, z, 1) + (B + zz D + d F).(xy, yz, zz, zx) + (C + d G) d, d = xx - yy, for each channel, n a unit
// vector.
fn packed_irradiance_5_eval(vectors: array<vec4f, 14>, n: vec3f) -> vec3f {
    let affine = vec4f(n, 1.0);
    let quadratic = n.xyzz * n.yzzx;
    let d = n.x * n.x - n.y * n.y;
    let high = n.z * n.z * quadratic;
    let turned = d * quadratic;
    return vec3f(dot(vectors[0], affine), dot(vectors[1], affine), dot(vectors[2], affine))
        + vec3f(dot(vectors[3], quadratic), dot(vectors[4], quadratic), dot(vectors[5], quadratic))
        + vec3f(dot(vectors[7], high), dot(vectors[8], high), dot(vectors[9], high))
        + vec3f(dot(vectors[10], turned), dot(vectors[11], turned), dot(vectors[12], turned))
        + (vectors[6].xyz + d * vectors[13].xyz) * d;
}

// Irradiance of order 3 from a symmetric matrix for each channel, after Ramamoorthi and Hanrahan 2001.
// `IrradianceMatrix` has the matrices. E(n) = p.M p with p = (x, y, z, 1), n a unit vector.
fn irradiance_matrix_eval(red: mat4x4f, green: mat4x4f, blue: mat4x4f, n: vec3f) -> vec3f {
    let p = vec4f(n, 1.0);
    return vec3f(dot(p, red * p), dot(p, green * p), dot(p, blue * p));
}

// Irradiance of order 3 from nine radiances, by the polynomial of Ramamoorthi and Hanrahan 2001.
// `IrradiancePolynomial` has the radiances, in the order L00 L1-1 L10 L11 L2-2 L2-1 L20 L21 L22 and without the
// Condon-Shortley phase. The constants are c_1 to c_5 of the paper, n is a unit vector.
fn irradiance_polynomial_eval(l: array<vec3f, 9>, n: vec3f) -> vec3f {
    let affine = l[3] * n.x + l[1] * n.y + l[2] * n.z;
    let mixed = l[4] * (n.x * n.y) + l[7] * (n.x * n.z) + l[5] * (n.y * n.z);
    let pure = l[8] * (0.429042765404892 * (n.x * n.x - n.y * n.y))
        + l[6] * (0.743123868301127 * n.z * n.z - 0.247707956100376);
    return pure + 0.886226925452758 * l[0] + 0.858085530809784 * mixed + 1.02332670794649 * affine;
}
