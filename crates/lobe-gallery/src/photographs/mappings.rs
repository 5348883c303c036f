//! Section about the sphere unfolded in eight mappings, and the error of converting between them.

use lobe::env::{MappedMap, Mapping, Resample, project_map, resample};
use lobe::figures::mapping_figure;
use lobe::image::{Picture, Tone};
use lobe::io::Job;

use crate::error::{Drawn, GalleryError};
use crate::page::{Canvas, Sky, percent, relative, sheet};

/// Rows of the maps that are compared: small enough to see what a trip there and back costs.
const ROWS: usize = 128;

/// The order of the comparison.
const ORDER: usize = 6;

pub(crate) fn mappings(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let (name, width) = (sky.bundled.name, canvas.size.picture);
    canvas.text(
        "Lat-long, OpenGL's sphere map, the photograph of a mirror ball, the light probe; two paraboloids, the octahedron, \
         the octahedron with equal areas, the cube. First where the axes lie, then the photograph.",
    );
    let figures = Mapping::ALL.map(|mapping| mapping_figure(mapping, width / 2)).to_vec();
    let maps = Mapping::ALL.into_iter().map(|mapping| unfolded(width, sky, mapping)).collect::<Result<Vec<_>, _>>()?;
    for (what, pictures) in [("mappings", figures), ("maps", maps)] {
        let drawn = (&sheet(4, 6, [1.0; 3], &pictures), &Tone::PLAIN);
        canvas.figure(&sky.file(&format!("{what}.png")), drawn, width, what)?;
    }
    table(canvas, sky)?;
    canvas.command(&format!(
        "lobe env convert bundled:{name} --to octahedral --size 256 -o octahedral.exr\n\
         lobe env convert bundled:{name} --size 256 --mips -o cube.ktx2\n\
         lobe env rotate bundled:{name} --axis 0,0,1 --angle 30 -o turned.exr"
    ));
    Ok(())
}

fn table(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    canvas.step()?;
    let to_lat_long = Resample::to(Mapping::LatLong, 2 * ROWS, ROWS);
    let source = resample(&sky.map, &to_lat_long, Job::default())?;
    let before = project_map(&source, ORDER);
    let mut rows = Vec::new();
    for mapping in Mapping::ALL {
        // About as many texels as the source has.
        let width = (source.texels().len() as f64 / mapping.height_for(1000) as f64 * 1000.0).sqrt() as usize;
        let there = resample(&source, &Resample::to(mapping, width, mapping.height_for(width)), Job::default())?;
        let back = resample(&there, &to_lat_long, Job::default())?;
        rows.push(vec![
            mapping.to_string(),
            format!("{} x {}", there.width(), there.height()),
            percent(mean_change(&source, &there)),
            percent(relative(&project_map(&there, ORDER), &before)),
            percent(relative(&project_map(&back, ORDER), &before)),
        ]);
    }
    canvas.text(
        "Every conversion takes the mean over each new texel with weights that keep the light of every old one: the mean \
         stays, and so does a sun of a few texels, at poles, seams and corners too.",
    );
    let head = ["mapping", "texels", "change of the mean", "of the 36 coefficients, there", "there and back"];
    canvas.table(&head, &rows);
    Ok(())
}

/// The photograph in a mapping, tone mapped; the cube as two rows of faces, like its figure.
fn unfolded(picture: usize, sky: &Sky, mapping: Mapping) -> Result<Picture, GalleryError> {
    let columns = mapping.faces().min(3);
    let width = picture / (2 * columns);
    let map = resample(&sky.map, &Resample::to(mapping, width, mapping.height_for(width)), Job::default())?;
    let (height, rows) = (map.height() / mapping.faces(), mapping.faces() / columns);
    let picture = Picture::from_fn(columns * width, rows * height, |x, y| {
        map.texel(x % width, (x / width + columns * (y / height)) * height + y % height)
    });
    Ok(Tone::PHOTOGRAPH.fixed_for(&Picture::from(&sky.map)).apply(&picture))
}

/// The change of the mean luminance.
fn mean_change(a: &MappedMap, b: &MappedMap) -> f64 {
    (b.mean().luminance() / a.mean().luminance() - 1.0).abs()
}
