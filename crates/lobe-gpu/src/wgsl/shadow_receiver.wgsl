// A receiver of shadows: a point, its unit normal, and the part of the light that it sends back, each with a fourth number.

struct Receiver {
    position: vec4f,
    normal: vec4f,
    albedo: vec4f,
}
