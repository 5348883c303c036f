// uses: dispatch
// Incident light of glossy receivers, blurred by the lobe of the reflection, `lobe_prt::TransferMatrices::exit_radiance`:
// coefficient i is alpha_l (M L)_i, with alpha_l of the band of i in the fourth number of the light.
//
// Number k = (channel * COEFFICIENTS + i) * COEFFICIENTS + j of receiver r stands at k * count + r, coefficient i of receiver r of
// all `receivers` at i * receivers + r.

// Receivers in this piece, the first of them, all receivers.
@group(0) @binding(0) var<uniform> piece: vec4u;
@group(0) @binding(1) var<uniform> light: array<vec4f, COEFFICIENTS>;
@group(0) @binding(2) var<storage, read> matrices: array<u32>;
@group(0) @binding(3) var<storage, read_write> incident: array<vec4f>;

fn matrix_number(k: u32, r: u32) -> f32 {
    if HALF == 1u {
        return unpack2x16float(matrices[(k >> 1u) * piece.x + r])[k & 1u];
    }
    return bitcast<f32>(matrices[k * piece.x + r]);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let item = item_of(id, groups);
    if item >= piece.x * COEFFICIENTS {
        return;
    }
    let r = item % piece.x;
    let i = item / piece.x;
    const SQUARE = COEFFICIENTS * COEFFICIENTS;
    var sum = vec3f(0.0);
    for (var j = 0u; j < COEFFICIENTS; j++) {
        let k = i * COEFFICIENTS + j;
        if CHANNELS == 1u {
            sum += light[j].rgb * matrix_number(k, r);
        } else {
            let m = vec3f(matrix_number(k, r), matrix_number(SQUARE + k, r), matrix_number(2u * SQUARE + k, r));
            sum += light[j].rgb * m;
        }
    }
    incident[i * piece.z + piece.y + r] = vec4f(light[i].w * sum, 0.0);
}
