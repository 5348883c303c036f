// Rotation of expansions of order 3, as `lobe_sh::Rotation::apply_into`, without tables: band 1 is a vector, which
// turns with R, and band 2 a symmetric matrix Q without trace, f(s) = s.Q.s, which becomes R Q R^T.

// The expansion turned by the rotation that takes +x, +y and +z to the unit vectors x, y and z.
// g(s) = f(R^-1 s), where x, y and z are the columns of R.
fn order_3_rotated(f: array<vec3f, 9>, x: vec3f, y: vec3f, z: vec3f) -> array<vec3f, 9> {
    let row_x = vec3f(x.x, y.x, z.x);
    let row_y = vec3f(x.y, y.y, z.y);
    let row_z = vec3f(x.z, y.z, z.z);
    return array<vec3f, 9>(
        f[0],
        f[3] * row_y.x + f[1] * row_y.y - f[2] * row_y.z,
        f[2] * row_z.z - f[3] * row_z.x - f[1] * row_z.y,
        f[3] * row_x.x + f[1] * row_x.y - f[2] * row_x.z,
        2.0 * order_3_quadratic_form(f, row_x, row_y),
        -2.0 * order_3_quadratic_form(f, row_y, row_z),
        1.73205080756888 * order_3_quadratic_form(f, row_z, row_z),
        -2.0 * order_3_quadratic_form(f, row_z, row_x),
        order_3_quadratic_form(f, row_x, row_x) - order_3_quadratic_form(f, row_y, row_y)
    );
}

// u.Q v of band 2, in units of sqrt(15/4pi).
fn order_3_quadratic_form(f: array<vec3f, 9>, u: vec3f, v: vec3f) -> vec3f {
    let pure = u * v;
    let mixed = u * v.yzx + u.yzx * v;
    let zonal = 0.288675134594813 * (2.0 * pure.z - pure.x - pure.y);
    return 0.5 * (f[4] * mixed.x - f[5] * mixed.y - f[7] * mixed.z + f[8] * (pure.x - pure.y)) + zonal * f[6];
}
