// Irradiance of all normals in few numbers, as `lobe_sh::encoding` has them. Expansions e are of the irradiance,
// bands 0 and 1.

// Irradiance from bands 0 and 1 by a power of the cosine, never negative, after Geomerics (Hazel 2015).
// `NonLinearL1` has the bands.
// E(n) = pi R0 (a + (1 - a)(p + 1) q^p) for each channel, n a unit vector.
fn non_linear_l1_eval(e: array<vec3f, 4>, n: vec3f) -> vec3f {
    return vec3f(
        non_linear_l1_channel(e[0].x, vec3f(-e[3].x, -e[1].x, e[2].x), n),
        non_linear_l1_channel(e[0].y, vec3f(-e[3].y, -e[1].y, e[2].y), n),
        non_linear_l1_channel(e[0].z, vec3f(-e[3].z, -e[1].z, e[2].z), n)
    );
}

// One channel: R0 = mean/sqrt(4 pi)/pi, R1 = slope/(2 pi/3)/sqrt(12 pi), r = |R1|/R0 <= 1, q = (1 + n.R1/|R1|)/2,
// p = 1 + 2r, a = (1 - r)/(1 + r). 0 where the mean is not above 0.
fn non_linear_l1_channel(mean: f32, slope: vec3f, n: vec3f) -> f32 {
    let middle = 0.0897935610625833 * mean;
    if middle <= 0.0 {
        return 0.0;
    }
    let steepest = length(slope);
    let r = min(0.0777635049764663 * steepest / middle, 1.0);
    let cosine = select(0.0, dot(slope, n) / max(steepest, 1e-30), steepest > 0.0);
    let p = 1.0 + 2.0 * r;
    let a = (1.0 - r) / (1.0 + r);
    let q = max(0.5 + 0.5 * cosine, 0.0);
    return 3.14159265358979 * middle * (a + (1.0 - a) * (p + 1.0) * pow(q, p));
}

// Irradiance from bands 0 and 1 and a zonal coefficient of band 2 about one axis, after Roughton et al. 2024.
// `Zh3` has them; the axis d is that of the luminance of band 1.
// E(n) = sum_{i<4} e_i y_i(n) + zonal sqrt(5/16pi) (3 (n.d)^2 - 1), n a unit vector.
fn zh3_eval(e: array<vec3f, 4>, zonal: vec3f, n: vec3f) -> vec3f {
    let shared_axis = vec3f(-zh3_luminance(e[3]), -zh3_luminance(e[1]), zh3_luminance(e[2]));
    return zh3_linear(e, n) + 0.31539156525252 * zonal * zh3_quadratic(shared_axis, n);
}

// Irradiance from bands 0 and 1 and a zonal coefficient of band 2 about the axis of each channel.
// `Zh3` has them with `Zh3Axis::PerChannel`.
fn zh3_per_channel_eval(e: array<vec3f, 4>, zonal: vec3f, n: vec3f) -> vec3f {
    let p = vec3f(
        zh3_quadratic(vec3f(-e[3].x, -e[1].x, e[2].x), n),
        zh3_quadratic(vec3f(-e[3].y, -e[1].y, e[2].y), n),
        zh3_quadratic(vec3f(-e[3].z, -e[1].z, e[2].z), n)
    );
    return zh3_linear(e, n) + 0.31539156525252 * zonal * p;
}

// The zonal coefficient for zh3_eval, guessed from bands 0 and 1 alone.
// As `Zh3::hallucinated`:
// z = pi/4 L0 r (0.08 + 0.6 r), r = |L1.d|/L0 <= sqrt(3), L0 = e_0/pi and L1 = e_1/(2 pi/3); 0 for L0 <= 0.
fn zh3_hallucinated_zonal(e: array<vec3f, 4>) -> vec3f {
    let shared_axis = vec3f(-zh3_luminance(e[3]), -zh3_luminance(e[1]), zh3_luminance(e[2]));
    let span = length(shared_axis);
    let d = select(vec3f(0.0), shared_axis / max(span, 1e-30), span > 0.0);
    let along = abs(e[2] * d.z - e[3] * d.x - e[1] * d.y);
    return vec3f(
        zh3_hallucinated_channel(e[0].x, along.x),
        zh3_hallucinated_channel(e[0].y, along.y),
        zh3_hallucinated_channel(e[0].z, along.z)
    );
}

// The zonal coefficient for zh3_per_channel_eval, guessed from bands 0 and 1 alone.
fn zh3_hallucinated_zonal_per_channel(e: array<vec3f, 4>) -> vec3f {
    let along = sqrt(e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
    return vec3f(
        zh3_hallucinated_channel(e[0].x, along.x),
        zh3_hallucinated_channel(e[0].y, along.y),
        zh3_hallucinated_channel(e[0].z, along.z)
    );
}

// One channel, from its mean coefficient and the length of its linear one.
fn zh3_hallucinated_channel(mean: f32, along: f32) -> f32 {
    if mean <= 0.0 {
        return 0.0;
    }
    let r = min(1.5 * along / mean, 1.73205080756888);
    return 0.25 * mean * r * (0.08 + 0.6 * r);
}

// Bands 0 and 1 towards n.
fn zh3_linear(e: array<vec3f, 4>, n: vec3f) -> vec3f {
    return 0.282094791773878 * e[0] + 0.48860251190292 * (e[2] * n.z - e[3] * n.x - e[1] * n.y);
}

// 3 (n.d)^2 - 1 for d along a vector of any length; 0 for a vector whose square is 0 in single precision.
fn zh3_quadratic(slope: vec3f, n: vec3f) -> f32 {
    let squared = dot(slope, slope);
    let cosine = dot(slope, n);
    return select(0.0, 3.0 * cosine * cosine / max(squared, 1e-38) - 1.0, squared > 0.0);
}

// Of Rec. 709.
fn zh3_luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

// Irradiance from the six colors +x -x +y -y +z -z of an ambient cube, after McTaggart 2004.
// `AmbientCube` has them. E(n) = sum_f c_f max(n.a_f, 0)^2, n a unit vector.
fn ambient_cube_eval(faces: array<vec3f, 6>, n: vec3f) -> vec3f {
    let weights = n * n;
    return weights.x * select(faces[1], faces[0], n.x > 0.0)
        + weights.y * select(faces[3], faces[2], n.y > 0.0)
        + weights.z * select(faces[5], faces[4], n.z > 0.0);
}

// Irradiance from an ambient color, a highlight and its direction: that of a constant and one directional light.
// `Ahd` has them. E(n) = A + H max(n.d, 0), d and n unit vectors.
fn ahd_eval(ambient: vec3f, highlight: vec3f, direction: vec3f, n: vec3f) -> vec3f {
    return ambient + highlight * max(dot(n, direction), 0.0);
}
