// Exit radiance of receivers in clusters, as `lobe_prt::CompressedTransfer::exit_radiance`, without buffers.

// The exit radiance of a receiver with clustered transfer, four components at a time: B = sum + sum_j w_j (B_j.L).
// The colors are the products of the light with four directions of the cluster. The sum is the product with the mean
// of the cluster, M.L, or the result of the call for the four components before.
fn clustered_exit_radiance(sum: vec3f, weights: vec4f, colors: array<vec3f, 4>) -> vec3f {
    return sum + weights.x * colors[0] + weights.y * colors[1] + weights.z * colors[2] + weights.w * colors[3];
}
