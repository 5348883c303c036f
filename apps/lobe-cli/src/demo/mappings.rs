//! Mappings section of the demo: the sphere unfolded in eight mappings, and the error of converting between them.

use lobe::env::{MappedMap, Mapping, Resample, project_map, resample};
use lobe::image::{Picture, Sheet, Tone};
use lobe::io::Job;
use lobe::render::mapping_figure;
use lobe::sh::{Expansion as _, Rgb, ShVec};

use super::{Sky, Writer, digits};

/// Rows of the maps that are compared: small enough to see what a trip there and back costs.
const ROWS: usize = 128;

/// The order of the comparison.
const ORDER: usize = 6;

impl Writer<'_> {
    pub(super) fn mappings(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        let width = self.picture / 2;
        let figures = Mapping::ALL.map(|mapping| mapping_figure(mapping, width));
        let shown = Mapping::ALL.map(|mapping| self.unfolded(sky, mapping));
        self.page.section("Eight ways to lay the sphere out");
        self.page.text(
            "Lat-long, OpenGL's sphere map, the photograph of a mirror ball, the light probe; two paraboloids, the octahedron, \
             the octahedron with equal areas, the cube. First where the axes lie, then the photograph.",
        );
        for (what, pictures) in [("mappings", figures), ("maps", shown)] {
            let file = sky.file(&format!("{what}.png"));
            let sheet = Sheet { columns: 4, margin: 6, background: [1.0; 3] }.compose(&pictures);
            self.write(&file, &sheet, &Tone::PLAIN)?;
            self.page.figure(&file, self.picture, what);
        }
        (self.progress)("a trip through each mapping");
        let source = resample(&sky.map, &Resample::to(Mapping::LatLong, 2 * ROWS, ROWS), Job::default())?;
        let before = project_map(&source, ORDER);
        let mut rows = Vec::new();
        for mapping in Mapping::ALL {
            // About as many texels as the source has.
            let width = (source.texels().len() as f64 / mapping.height_for(1000) as f64 * 1000.0).sqrt() as usize;
            let there = resample(&source, &Resample::to(mapping, width, mapping.height_for(width)), Job::default())?;
            let back = resample(&there, &Resample::to(Mapping::LatLong, 2 * ROWS, ROWS), Job::default())?;
            rows.push(vec![
                mapping.to_string(),
                format!("{} x {}", there.width(), there.height()),
                percent(mean_change(&source, &there)),
                percent(relative(&project_map(&there, ORDER), &before)),
                percent(relative(&project_map(&back, ORDER), &before)),
            ]);
        }
        self.page.text(
            "Every conversion takes the mean over each new texel with weights that keep the light of every old one: the mean \
             stays, and so does a sun of a few texels, at poles, seams and corners too.",
        );
        let head = ["mapping", "texels", "change of the mean", "of the 36 coefficients, there", "there and back"];
        self.page.table(&head, &rows);
        self.page.command(&format!(
            "lobe env convert bundled:{name} --to octahedral --size 256 -o octahedral.exr\n\
             lobe env convert bundled:{name} --size 256 --mips -o cube.ktx2\n\
             lobe env rotate bundled:{name} --axis 0,0,1 --angle 30 -o turned.exr"
        ));
        Ok(())
    }

    /// The photograph in a mapping, tone mapped; the cube as two rows of faces, like its figure.
    fn unfolded(&self, sky: &Sky, mapping: Mapping) -> Picture {
        let columns = mapping.faces().min(3);
        let width = self.picture / (2 * columns);
        let to = Resample::to(mapping, width, mapping.height_for(width));
        let map = resample(&sky.map, &to, Job::default())
            .unwrap_or_else(|error| unreachable!("the size fits the mapping: {error}"));
        let (height, rows) = (map.height() / mapping.faces(), mapping.faces() / columns);
        let picture = Picture::from_fn(columns * width, rows * height, |x, y| {
            map.texel(x % width, (x / width + columns * (y / height)) * height + y % height)
        });
        Tone::PHOTOGRAPH.fixed_for(&Picture::from(&sky.map)).apply(&picture)
    }
}

/// The change of the mean luminance.
fn mean_change(a: &MappedMap, b: &MappedMap) -> f64 {
    (b.mean().luminance() / a.mean().luminance() - 1.0).abs()
}

/// `|f - g| / |g|`.
fn relative(f: &ShVec<Rgb<f64>>, g: &ShVec<Rgb<f64>>) -> f64 {
    let difference = f - g;
    let norm = |f: &ShVec<Rgb<f64>>| {
        let e = f.dot(f);
        (e.r + e.g + e.b).sqrt()
    };
    norm(&difference) / norm(g)
}

fn percent(x: f64) -> String {
    format!("{} %", digits(100.0 * x))
}
