// A receiver of light: a point and its unit normal, each with a fourth number.

struct Receiver {
    position: vec4f,
    normal: vec4f,
}
