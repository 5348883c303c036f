// The number of an item of a dispatch in rows of workgroups of 64.

fn item_of(id: vec3u, groups: vec3u) -> u32 {
    return id.y * groups.x * 64u + id.x;
}
