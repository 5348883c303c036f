//! Charts of a lightmap: the triangles that are unfolded together.

use std::collections::HashMap;

use lobe_scene::{Mesh, Scene};

use crate::receivers::vertex_key::vertex_key;

/// The chart of every triangle: those that are joined by vertices have one number.
pub(crate) fn charts(scene: &Scene) -> Vec<u32> {
    let mut charts = Vec::with_capacity(scene.triangle_count());
    let mut first = 0;
    for mesh in scene.meshes() {
        let vertices = joined_vertices(mesh);
        let mut parents: Vec<u32> = (0..vertices.len() as u32).collect();
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|i| root(&mut parents, vertices[i as usize]));
            parents[b as usize] = a;
            // b may have been c's root.
            let c = root(&mut parents, c);
            parents[c as usize] = a;
        }
        charts.extend(mesh.triangles().iter().map(|t| first + root(&mut parents, vertices[t[0] as usize])));
        first += vertices.len() as u32;
    }
    charts
}

/// For every vertex the number of the first that is the same in position, normal and place in the lightmap.
fn joined_vertices(mesh: &Mesh) -> Vec<u32> {
    let mut first_of = HashMap::new();
    let (positions, normals, uvs) = (mesh.positions(), mesh.normals(), mesh.lightmap_uvs());
    let mut joined = |i: usize| {
        let key = (vertex_key(positions[i]), vertex_key(normals[i]), vertex_key(uvs[i]));
        *first_of.entry(key).or_insert(i as u32)
    };
    (0..positions.len()).map(&mut joined).collect()
}

/// The representative of a vertex; ways to it are halved on the way.
fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let above = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = above;
        vertex = above;
    }
    vertex
}
