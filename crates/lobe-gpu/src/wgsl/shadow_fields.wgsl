// uses: dispatch, product
// Precomputed shadow fields, `lobe_shadow::ShadowFields` (Zhou et al. 2005): what entities leave visible at receivers, nearest first,
//
//   V = V_own prod_k (1 - O_k)        B = sum_i L_i (V T)_i
//
// each product cut off at the order. Fields are interpolated linearly between their spheres.

struct Receiver {
    position: vec4f,
    normal: vec4f,
    albedo: vec4f,
}

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

struct Sizes {
    receivers: u32,
    entities: u32,
    // 1 if receivers have visibility of their own, whose numbers come first in `given`.
    own: u32,
    // The solid angle that may be left out.
    negligible: f32,
}

@group(0) @binding(0) var<uniform> sizes: Sizes;
@group(0) @binding(1) var<uniform> light: array<vec4f, COEFFICIENTS>;
// The factor of each band in the clamped cosine over pi.
@group(0) @binding(2) var<uniform> cosine: array<vec4f, 8>;
@group(0) @binding(3) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(4) var<storage, read> entities: array<Entity>;
@group(0) @binding(5) var<storage, read> turns: array<f32>;
@group(0) @binding(6) var<storage, read> fields: array<f32>;
// Visibility of receivers' own, then their transfer: COEFFICIENTS numbers each, and for each of CHANNELS.
@group(0) @binding(7) var<storage, read> given: array<f32>;
@group(0) @binding(8) var<storage, read_write> visibility: array<f32>;
@group(0) @binding(9) var<storage, read_write> radiance: array<vec4f>;

const TAU = 6.28318530717959;
const AT_CENTER = 1e-6;
const BELOW = -1.0;

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

fn rows_at(entity: Entity, own: vec3f) -> LookUp {
    var found: LookUp;
    var stencil = stencil_at(entity, own);
    let order = entity.grid.w;
    for (var k = 0u; k < stencil.len; k++) {
        let weight = stencil.weights[k];
        let first = entity.grid.z + stencil.points[k] * (order + order * order);
        for (var l = 0u; l < ORDER; l++) {
            found.zonal[l] += weight * fields[first + l];
        }
        for (var i = 0u; i < COEFFICIENTS; i++) {
            found.rest[i] += weight * fields[first + order + i];
        }
    }
    return found;
}

// What an entity hides from a point at `offset` from its middle, in the directions of the world.
fn occlusion_at(entity: Entity, offset: vec3f) -> Expansion {
    let own = vec3f(dot(entity.to_own_x.xyz, offset), dot(entity.to_own_y.xyz, offset), dot(entity.to_own_z.xyz, offset));
    var found = rows_at(entity, own);
    var out = found.rest;
    if entity.turn.y == 1u {
        var entry = entity.turn.x;
        for (var l = 0u; l < ORDER; l++) {
            for (var i = l * l; i < (l + 1u) * (l + 1u); i++) {
                var sum = 0.0;
                for (var j = l * l; j < (l + 1u) * (l + 1u); j++) {
                    sum += turns[entry] * found.rest[j];
                    entry++;
                }
                out[i] = sum;
            }
        }
    }
    let distance = length(offset);
    if distance > 0.0 {
        let y = basis(-offset / distance);
        for (var l = 0u; l < ORDER; l++) {
            for (var i = l * l; i < (l + 1u) * (l + 1u); i++) {
                out[i] += found.zonal[l] * y[i];
            }
        }
    }
    return out;
}

// The largest solid angle of an entity: that of its bounding sphere; BELOW if that lies below the horizon.
fn size_of(entity: Entity, at: Receiver) -> f32 {
    let towards = entity.center.xyz - at.position.xyz;
    if CHANNELS == 0u && dot(at.normal.xyz, towards) <= -entity.center.w {
        return BELOW;
    }
    let square = dot(towards, towards);
    let within = entity.center.w * entity.center.w;
    if square <= within {
        return 2.0 * TAU;
    }
    let ratio = within / square;
    return TAU * ratio / (1.0 + sqrt(1.0 - ratio));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    if r >= sizes.receivers {
        return;
    }
    let at = receivers[r];
    // Look at all entities; leave out those below the horizon and the smallest, as many as have no more than `negligible`.
    var squares: array<f32, MOST_ENTITIES>;
    var angles: array<f32, MOST_ENTITIES>;
    for (var k = 0u; k < sizes.entities; k++) {
        let towards = entities[k].center.xyz - at.position.xyz;
        squares[k] = dot(towards, towards);
        angles[k] = size_of(entities[k], at);
    }
    for (var k = 0u; k < sizes.entities; k++) {
        if angles[k] > sizes.negligible {
            continue;
        }
        var sum = 0.0;
        for (var j = 0u; j < sizes.entities; j++) {
            let is_before = angles[j] < angles[k] || (angles[j] == angles[k] && j <= k);
            sum += select(0.0, angles[j], angles[j] >= 0.0 && is_before);
        }
        if angles[k] < 0.0 || sum <= sizes.negligible {
            squares[k] = -1.0;
        }
    }
    var v: Expansion;
    v[0] = 3.54490770181103;
    if sizes.own == 1u {
        for (var i = 0u; i < COEFFICIENTS; i++) {
            v[i] = given[r * COEFFICIENTS + i];
        }
    }
    // Nearest first.
    for (var step = 0u; step < sizes.entities; step++) {
        var nearest = sizes.entities;
        for (var k = 0u; k < sizes.entities; k++) {
            if squares[k] >= 0.0 && (nearest == sizes.entities || squares[k] < squares[nearest]) {
                nearest = k;
            }
        }
        if nearest == sizes.entities {
            break;
        }
        squares[nearest] = -1.0;
        let hidden = product(v, occlusion_at(entities[nearest], at.position.xyz - entities[nearest].center.xyz));
        for (var i = 0u; i < COEFFICIENTS; i++) {
            v[i] -= hidden[i];
        }
    }
    for (var i = 0u; i < COEFFICIENTS; i++) {
        visibility[i * sizes.receivers + r] = v[i];
    }
    radiance[r] = vec4f(sent_back(at, r, v), 1.0);
}

fn sent_back(at: Receiver, r: u32, v: Expansion) -> vec3f {
    var sum = vec3f(0.0);
    var response: Expansion;
    if CHANNELS == 0u {
        let y = basis(at.normal.xyz);
        for (var l = 0u; l < ORDER; l++) {
            for (var i = l * l; i < (l + 1u) * (l + 1u); i++) {
                response[i] = cosine[l].x * y[i];
            }
        }
        let seen = product(v, response);
        for (var i = 0u; i < COEFFICIENTS; i++) {
            sum += seen[i] * light[i].rgb;
        }
        return sum * at.albedo.rgb;
    }
    let first = sizes.own * sizes.receivers * COEFFICIENTS + r * CHANNELS * COEFFICIENTS;
    for (var c = 0u; c < CHANNELS; c++) {
        for (var i = 0u; i < COEFFICIENTS; i++) {
            response[i] = given[first + c * COEFFICIENTS + i];
        }
        let seen = product(v, response);
        for (var i = 0u; i < COEFFICIENTS; i++) {
            if CHANNELS == 1u {
                sum += seen[i] * light[i].rgb;
            } else {
                sum[c] += seen[i] * light[i][c];
            }
        }
    }
    return sum;
}
