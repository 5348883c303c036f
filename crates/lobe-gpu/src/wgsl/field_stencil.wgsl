// uses: dispatch, shadow_receiver
// Where the fields of entities are looked up, as `lobe_shadow::FieldGrid`, and what shaders know of entities.

struct Entity {
    // Of the middle in the world, and the bounding radius there.
    center: vec4f,
    // From differences in the world to those in the entity's frame, in its radii: rows.
    to_own_x: vec4f,
    to_own_y: vec4f,
    to_own_z: vec4f,
    // The innermost sphere, the place of the bounding radius, and places per step within and beyond.
    radial: vec4f,
    // Spheres, cells, the first number of the field, its order.
    grid: vec4u,
    // The first number of its turn; 1 if it is turned.
    turn: vec4u,
}

const AT_CENTER = 1e-6;

alias Expansion = array<f32, COEFFICIENTS>;

struct LookUp {
    zonal: array<f32, ORDER>,
    rest: Expansion,
}

// The points of a field around a point and their weights: four of each of two spheres, or of one and the center.
struct Stencil {
    points: array<u32, 8>,
    weights: array<f32, 8>,
    len: u32,
}

fn sign_of(x: f32) -> f32 {
    return select(1.0, -1.0, x < 0.0);
}

// The samples around a point of the entity's frame, in its radii from the center.
fn stencil_at(entity: Entity, own: vec3f) -> Stencil {
    var stencil: Stencil;
    let relative = length(own);
    let spheres = entity.grid.x;
    let side = entity.grid.y + 1u;
    let center = spheres * side * side;
    if relative <= AT_CENTER {
        stencil.points[0] = center;
        stencil.weights[0] = 1.0;
        stencil.len = 1u;
        return stencil;
    }
    // The cell of the octahedral grid.
    let p = own.xy / (abs(own.x) + abs(own.y) + abs(own.z));
    let folded = (1.0 - abs(p.yx)) * vec2f(sign_of(p.x), sign_of(p.y));
    let c = (select(folded, p, own.z >= 0.0) + 1.0) * 0.5 * f32(entity.grid.y);
    let cell = min(vec2u(c), vec2u(entity.grid.y - 1u));
    let f = min(c - vec2f(cell), vec2f(1.0));
    // The two spheres.
    let logarithm = log(relative);
    let root = sqrt(abs(logarithm));
    let place = entity.radial.y + select(entity.radial.w * root, -entity.radial.z * root, logarithm < 0.0);
    let is_inside = place <= 0.0;
    let low = min(u32(max(place, 0.0)), spheres - 2u);
    let t = select(clamp(place - f32(low), 0.0, 1.0), 0.0, is_inside);
    let unscaled = 1.0 / (1.0 + relative * relative);
    // Between the innermost sphere and the center linearly in the distance.
    let part = select(1.0, relative / entity.radial.x, is_inside);
    for (var k = 0u; k < 8u; k++) {
        let corner = vec2u(k & 1u, (k >> 1u) & 1u);
        let across = select(1.0 - f.x, f.x, corner.x == 1u) * select(1.0 - f.y, f.y, corner.y == 1u);
        let sphere = low + (k >> 2u);
        stencil.points[k] = sphere * side * side + (cell.y + corner.y) * side + cell.x + corner.x;
        stencil.weights[k] = unscaled * part * across * select(1.0 - t, t, k > 3u);
    }
    stencil.len = 8u;
    if is_inside {
        stencil.points[4] = center;
        stencil.weights[4] = unscaled * (1.0 - part);
        stencil.len = 5u;
    }
    return stencil;
}

// Numbers of a look-up: one for each band, one for each coefficient.
const ROW = ORDER + COEFFICIENTS;

// From a difference in the world to the frame of an entity.
fn own_of(entity: Entity, offset: vec3f) -> vec3f {
    return vec3f(dot(entity.to_own_x.xyz, offset), dot(entity.to_own_y.xyz, offset), dot(entity.to_own_z.xyz, offset));
}
