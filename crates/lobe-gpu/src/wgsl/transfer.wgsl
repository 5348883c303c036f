// uses: dispatch
// Exit radiance of matte receivers, `lobe_prt::Transfer::exit_radiance`: B = sum_i L_i T_i.
//
// CHANNELS is 1 or 3, HALF 1 if numbers are stored in half precision, two in a word. Number k = channel * COEFFICIENTS + i of
// receiver r stands at k * count + r: neighbors read neighbors.

// Receivers in this piece.
@group(0) @binding(0) var<uniform> piece: vec4u;
@group(0) @binding(1) var<uniform> light: array<vec4f, COEFFICIENTS>;
@group(0) @binding(2) var<storage, read> transfer: array<u32>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;

fn transfer_number(k: u32, r: u32) -> f32 {
    if HALF == 1u {
        return unpack2x16float(transfer[(k >> 1u) * piece.x + r])[k & 1u];
    }
    return bitcast<f32>(transfer[k * piece.x + r]);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    if r >= piece.x {
        return;
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < COEFFICIENTS; i++) {
        if CHANNELS == 1u {
            sum += light[i].rgb * transfer_number(i, r);
        } else {
            let t = vec3f(
                transfer_number(i, r),
                transfer_number(COEFFICIENTS + i, r),
                transfer_number(2u * COEFFICIENTS + i, r)
            );
            sum += light[i].rgb * t;
        }
    }
    radiance[r] = vec4f(sum, 1.0);
}
