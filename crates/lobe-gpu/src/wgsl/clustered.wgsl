// uses: dispatch
// Exit radiance of receivers in clusters, `lobe_prt::CompressedTransfer::exit_radiance`: B = M_k.L + sum_j w_j (B_kj.L), where
// the products with the light are in `colors`, for each cluster that of the mean and those of the COMPONENTS directions.
//
// Word 0 of a receiver is its cluster, the words after it hold its weights, WEIGHTS_IN_WORD in each: 1 as f32, 2 as parts of
// 65535, 4 as parts of 255. Word w of receiver r stands at w * count + r.

@group(0) @binding(0) var<uniform> piece: vec4u;
@group(0) @binding(1) var<storage, read> colors: array<vec4f>;
@group(0) @binding(2) var<storage, read> words: array<u32>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;

fn weight(j: u32, r: u32) -> f32 {
    let word = words[(1u + j / WEIGHTS_IN_WORD) * piece.x + r];
    if WEIGHTS_IN_WORD == 4u {
        return unpack4x8unorm(word)[j & 3u];
    }
    if WEIGHTS_IN_WORD == 2u {
        return unpack2x16unorm(word)[j & 1u];
    }
    return bitcast<f32>(word);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    if r >= piece.x {
        return;
    }
    let first = words[r] * (COMPONENTS + 1u);
    var sum = colors[first].rgb;
    for (var j = 0u; j < COMPONENTS; j++) {
        sum += weight(j, r) * colors[first + 1u + j].rgb;
    }
    radiance[r] = vec4f(sum, 1.0);
}
