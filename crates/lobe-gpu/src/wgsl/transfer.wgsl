// uses: dispatch, stored_numbers
// Exit radiance of matte receivers, `lobe_prt::Transfer::exit_radiance`: B = sum_i L_i T_i.
//
// CHANNELS is 1 or 3. Number k = channel * COEFFICIENTS + i of a receiver is coefficient i of a channel.

@group(0) @binding(1) var<uniform> light: array<vec4f, COEFFICIENTS>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    if r >= piece.x {
        return;
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < COEFFICIENTS; i++) {
        if CHANNELS == 1u {
            sum += light[i].rgb * stored_number(i, r);
        } else {
            let t = vec3f(
                stored_number(i, r),
                stored_number(COEFFICIENTS + i, r),
                stored_number(2u * COEFFICIENTS + i, r)
            );
            sum += light[i].rgb * t;
        }
    }
    radiance[r] = vec4f(sum, 1.0);
}
