// uses: dispatch, stored_numbers
// Incident light of glossy receivers, blurred by the lobe of the reflection, `lobe_prt::TransferMatrices::exit_radiance`:
// coefficient i is alpha_l (M L)_i, with alpha_l of the band of i in the fourth number of the light.
//
// Number k = (channel * COEFFICIENTS + i) * COEFFICIENTS + j of a receiver is entry i, j of a channel's M; the coefficients of a receiver
// are written side by side, so that those of any receivers that follow each other can be bound alone.

@group(0) @binding(1) var<uniform> light: array<vec4f, COEFFICIENTS>;
@group(0) @binding(3) var<storage, read_write> incident: array<vec4f>;

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
            sum += light[j].rgb * stored_number(k, r);
        } else {
            let m = vec3f(stored_number(k, r), stored_number(SQUARE + k, r), stored_number(2u * SQUARE + k, r));
            sum += light[j].rgb * m;
        }
    }
    incident[r * COEFFICIENTS + i] = vec4f(light[i].w * sum, 0.0);
}
