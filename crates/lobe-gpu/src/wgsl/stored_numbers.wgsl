// Numbers of a piece of receivers: number k of receiver r stands at k * count + r, so that neighbors read neighbors. HALF is 1 if
// they are stored in half precision, numbers 2k and 2k + 1 in one word.

// Receivers in this piece.
@group(0) @binding(0) var<uniform> piece: vec4u;
@group(0) @binding(2) var<storage, read> numbers: array<u32>;

fn stored_number(k: u32, r: u32) -> f32 {
    if HALF == 1u {
        return unpack2x16float(numbers[(k >> 1u) * piece.x + r])[k & 1u];
    }
    return bitcast<f32>(numbers[k * piece.x + r]);
}
