//! Lightmap lookup: bilinear between the texels of one chart.

use lobe_scene::{Hit, Scene};

use crate::error::PrtError;
use crate::receivers::charts::charts;
use crate::receivers::texel_receivers::TexelReceivers;

/// The texels of a lightmap that show a place of its scene, and their weights.
///
/// Light is linear between the four texels around a place, as in any picture, but only between those of the chart that
/// the place is in: however near charts lie, nothing bleeds over a seam. Triangles are of one chart if they share a
/// vertex, its position, normal and place in the lightmap; so a hard edge is a seam, too, even if the unfolding does
/// not cut it.
///
/// A triangle so thin that other charts have all texels around it shows what these have.
#[derive(Clone, Debug, PartialEq)]
pub struct Lightmap {
    width: usize,
    chart_of_texel: Vec<u32>,
    chart_of_triangle: Vec<u32>,
}

impl Lightmap {
    /// The lightmap of `width` × `width` texels that [`TexelReceivers::new`] bakes.
    ///
    /// # Errors
    /// As [`TexelReceivers::new`].
    pub fn new(scene: &Scene, width: usize) -> Result<Self, PrtError> {
        Ok(Self::of(&TexelReceivers::as_unfolded(scene, width)?, &charts(scene)))
    }

    /// That of texels of a scene with these charts.
    pub(crate) fn of(texels: &TexelReceivers, charts: &[u32]) -> Self {
        let chart_of = |receiver: u32| charts[texels.triangles()[receiver as usize] as usize];
        let chart_of_texel = texels.dilated().into_iter().map(chart_of).collect();
        Self { width: texels.width(), chart_of_texel, chart_of_triangle: charts.to_vec() }
    }

    /// Width and height in texels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The chart that each texel shows, row after row.
    #[must_use]
    pub fn charts_of_texels(&self) -> &[u32] {
        &self.chart_of_texel
    }

    /// The chart of each triangle of the scene.
    #[must_use]
    pub fn charts_of_triangles(&self) -> &[u32] {
        &self.chart_of_triangle
    }

    /// Four texels, `y · width + x`, and their weights at a place, which sum to 1.
    ///
    /// ```text
    ///   w_k ∝ (1 - |x_k - x|) (1 - |y_k - y|)  for texels k of the place's chart, else 0;  centers x_k at i + 1/2
    /// ```
    ///
    /// # Panics
    /// If the place is not on the scene.
    #[must_use]
    pub fn texels_at(&self, scene: &Scene, hit: &Hit) -> [(usize, f64); 4] {
        let (mesh, number) = scene.locate(hit.triangle as usize);
        let mesh = &scene.meshes()[mesh];
        let corners = mesh.triangles()[number].map(|i| mesh.lightmap_uvs()[i as usize].map(f64::from));
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        let last = (self.width - 1) as f64;
        let [x, y] = [0, 1].map(|k| {
            let place = (1.0 - u - v) * corners[0][k] + u * corners[1][k] + v * corners[2][k];
            (place * self.width as f64 - 0.5).clamp(0.0, last)
        });
        let [left, top] = [x, y].map(|c| c.floor().min((last - 1.0).max(0.0)));
        let (across, down) = (x - left, y - top);
        let next = usize::from(self.width > 1);
        let first = top as usize * self.width + left as usize;
        let around = [
            (first, (1.0 - across) * (1.0 - down)),
            (first + next, across * (1.0 - down)),
            (first + next * self.width, (1.0 - across) * down),
            (first + next * self.width + next, across * down),
        ];
        let chart = self.chart_of_triangle[hit.triangle as usize];
        let own = around.map(|(texel, part)| (texel, if self.chart_of_texel[texel] == chart { part } else { 0.0 }));
        let sum: f64 = own.iter().map(|&(_, part)| part).sum();
        if sum > 0.0 { own.map(|(texel, part)| (texel, part / sum)) } else { around }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::{Mesh, MeshParts};

    fn of(parts: Vec<MeshParts>) -> Scene {
        Scene::new(parts.into_iter().map(|p| Mesh::new(p).unwrap()).collect(), vec![], vec![]).unwrap()
    }

    /// Two squares that share an edge in space and in the lightmap, whose left half one fills and whose right half the
    /// other; `joined` says whether they share its vertices, too.
    fn two_squares(joined: bool) -> Scene {
        let column = |x: f32| [[x, 0.0, 0.0], [x, 1.0, 0.0]];
        let mut positions = [column(0.0), column(1.0), column(2.0)].concat();
        let mut triangles = vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
        let mut normals = vec![[0.0, 0.0, 1.0]; 6];
        if !joined {
            positions.extend(column(1.0));
            normals.extend([[0.6, 0.0, 0.8]; 2]);
            triangles[2..].copy_from_slice(&[[6, 4, 5], [6, 5, 7]]);
        }
        let uvs = [positions.iter().map(|p| [p[0] / 2.0, p[1]]).collect(), vec![]];
        of(vec![MeshParts { positions, normals, triangles, uvs, ..MeshParts::default() }])
    }

    #[test]
    fn within_a_chart_light_is_linear_and_over_a_seam_it_is_not() {
        for (joined, charts_expected) in [(true, 1), (false, 2)] {
            let scene = two_squares(joined);
            let mut found = charts(&scene);
            found.dedup();
            assert_eq!(found.len(), charts_expected, "charts, joined: {joined}");
            let lightmap = Lightmap::new(&scene, 8).unwrap();
            // At x = 1 - 1/16 on the left square: a quarter of a texel left of the seam.
            let place = Hit { t: 0.0, triangle: 0, u: 0.9375 - 0.5, v: 0.5 };
            let texels = lightmap.texels_at(&scene, &place);
            let beyond: f64 = texels.iter().filter(|(texel, _)| texel % 8 >= 4).map(|&(_, part)| part).sum();
            let expected = if joined { 0.25 } else { 0.0 };
            assert!((beyond - expected).abs() < 1e-6, "joined {joined}: {beyond} of {texels:?} is beyond the seam");
            let all: f64 = texels.iter().map(|&(_, part)| part).sum();
            assert!((all - 1.0).abs() < 1e-12, "{texels:?} sum to {all}");
        }
    }

    #[test]
    fn vertices_at_zero_and_minus_zero_are_of_one_chart() {
        for zeros in [[0.0_f32, 0.0, 0.0], [-0.0, 0.0, 0.0], [0.0, -0.0, 0.0], [0.0, 0.0, -0.0]] {
            // Two triangles meet at the origin, where each has a vertex of its own.
            let [position, normal, uv] = zeros;
            let mut uvs: Vec<[f32; 2]> = vec![[0.0; 2], [1.0, 0.0], [1.0, 0.5], [0.0; 2], [0.5, 1.0], [0.0, 1.0]];
            let mut positions: Vec<[f32; 3]> = uvs.iter().map(|&[x, y]| [x, y, 0.0]).collect();
            let mut normals = vec![[0.0, 0.0, 1.0]; 6];
            (positions[3][0], normals[3][0], uvs[3][0]) = (position, normal, uv);
            let (uvs, triangles) = ([uvs, vec![]], vec![[0, 1, 2], [3, 4, 5]]);
            let scene = of(vec![MeshParts { positions, normals, triangles, uvs, ..MeshParts::default() }]);
            let found = charts(&scene);
            assert_eq!(found[1], found[0], "charts with {zeros:?} in position, normal and texture coordinates");
        }
    }

    #[test]
    fn the_texels_around_a_place_are_found_up_to_the_border() {
        let scene = two_squares(true);
        for width in [1, 2, 8] {
            let lightmap = Lightmap::new(&scene, width).unwrap();
            for (triangle, u, v) in
                [(0, 0.0, 0.0), (0, 0.3, 0.2), (1, 0.1, 0.9), (2, 1.0, 0.0), (3, 0.5, 0.5), (2, 0.0, 1.0)]
            {
                let hit = Hit { t: 0.0, triangle, u, v };
                let place = scene.surface(&hit).position;
                let mean = |k: fn(usize, usize) -> usize| {
                    let parts = lightmap.texels_at(&scene, &hit);
                    parts.iter().map(|&(texel, part)| part * (k(texel, width) as f64 + 0.5)).sum::<f64>()
                };
                let found = [mean(|t, w| t % w), mean(|t, w| t / w)];
                for (found, uv) in found.into_iter().zip([place[0] / 2.0, place[1]]) {
                    let expected = (f64::from(uv) * width as f64).clamp(0.5, width as f64 - 0.5);
                    assert!((found - expected).abs() < 1e-5, "{place:?} of {width}: {found}, not {expected}");
                }
            }
        }
    }
}
