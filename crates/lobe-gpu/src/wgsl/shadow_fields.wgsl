// uses: field_stencil, product
// Precomputed shadow fields, `lobe_shadow::ShadowFields` (Zhou et al. 2005): what entities leave visible at receivers, nearest first,
//
//   V = V_own prod_k (1 - O_k)        B = sum_i L_i (V T)_i
//
// each product cut off at the order. Fields are interpolated linearly between their spheres.

struct Sizes {
    receivers: u32,
    entities: u32,
    // 1 if receivers have visibility of their own.
    own: u32,
    // The solid angle that may be left out.
    negligible: f32,
}

@group(0) @binding(0) var<uniform> sizes: Sizes;
@group(0) @binding(1) var<uniform> light: array<vec4f, COEFFICIENTS>;
@group(0) @binding(2) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(3) var<storage, read> entities: array<Entity>;
@group(0) @binding(4) var<storage, read> turns: array<f32>;
// The numbers of all fields; where LOOKED_UP is 1, what `look_up_fields` found in them.
@group(0) @binding(5) var<storage, read> fields: array<f32>;
// Transfer of receivers: COEFFICIENTS numbers for each of CHANNELS, of which there are none where visibility alone is asked for.
@group(0) @binding(6) var<storage, read> given: array<f32>;
// Number i of receiver r, here and in `visibility`, is at i * receivers + r.
@group(0) @binding(7) var<storage, read> own: array<f32>;
@group(0) @binding(8) var<storage, read_write> visibility: array<f32>;
// Where there is transfer.
@group(0) @binding(9) var<storage, read_write> radiance: array<vec4f>;

const TAU = 6.28318530717959;
const BELOW = -1.0;

// What receiver r finds in the field of entity k.
fn rows_at(k: u32, r: u32, there: vec3f) -> LookUp {
    var found: LookUp;
    if LOOKED_UP == 1u {
        let first = k * ROW * sizes.receivers + r;
        for (var l = 0u; l < ORDER; l++) {
            found.zonal[l] = fields[first + l * sizes.receivers];
        }
        for (var i = 0u; i < COEFFICIENTS; i++) {
            found.rest[i] = fields[first + (ORDER + i) * sizes.receivers];
        }
        return found;
    }
    let entity = entities[k];
    var stencil = stencil_at(entity, there);
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

// What entity k hides from receiver r at `offset` from its middle, in the directions of the world.
fn occlusion_at(k: u32, r: u32, offset: vec3f) -> Expansion {
    let entity = entities[k];
    var found = rows_at(k, r, own_of(entity, offset));
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
        var y = basis(-offset / distance);
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
            v[i] = own[i * sizes.receivers + r];
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
        var hidden = product(v, occlusion_at(nearest, r, at.position.xyz - entities[nearest].center.xyz));
        for (var i = 0u; i < COEFFICIENTS; i++) {
            v[i] -= hidden[i];
        }
    }
    for (var i = 0u; i < COEFFICIENTS; i++) {
        visibility[i * sizes.receivers + r] = v[i];
    }
    if CHANNELS > 0u {
        radiance[r] = vec4f(sent_back(at, r, v), 1.0);
    }
}

fn sent_back(at: Receiver, r: u32, v: Expansion) -> vec3f {
    var sum = vec3f(0.0);
    var response: Expansion;
    let first = r * CHANNELS * COEFFICIENTS;
    for (var c = 0u; c < CHANNELS; c++) {
        for (var i = 0u; i < COEFFICIENTS; i++) {
            response[i] = given[first + c * COEFFICIENTS + i];
        }
        var seen = product(v, response);
        for (var i = 0u; i < COEFFICIENTS; i++) {
            if CHANNELS == 1u {
                sum += seen[i] * light[i].rgb;
            } else {
                sum[c] += seen[i] * light[i][c];
            }
        }
    }
    return sum * at.albedo.rgb;
}
