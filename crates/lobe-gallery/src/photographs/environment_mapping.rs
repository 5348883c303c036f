//! Section about environment mapping: every technique under one photograph.

use lobe::env::{CubeMap, CubeMipChain, Mapping, PrefilterOptions, Resample, cube, prefilter_ggx, resample};
use lobe::figures::{EnvironmentSheetOptions, environment_mapping_sheet};
use lobe::image::{Picture, Tone};
use lobe::io::Job;

use crate::error::{Drawn, GalleryError};
use crate::page::{Canvas, Sky, sheet};

/// The size of the faces from which mirrors are blurred, and of the first level of the chain.
const SIZES: [usize; 2] = [256, 128];

/// The smallest level.
const LAST: usize = 8;

pub(crate) fn environment_mapping(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let (name, side) = (sky.bundled.name, canvas.size.ball);
    canvas.step()?;
    let chain = prefiltered(sky)?;
    let caption =
        "The cube that rough mirrors look up: the face towards +x of each level, from the mirror to roughness 1.";
    canvas.plain_figure(&sky.file("levels.png"), &levels(side, sky, &chain), caption)?;
    let samples = if side < 100 { 2 } else { 3 };
    let options = EnvironmentSheetOptions::default().size(side).samples(samples).prefiltered(&chain);
    let techniques = environment_mapping_sheet(&sky.map, &options, Job::default())?;
    let caption = "A ball and a torus; errors are measured over their visible surface.";
    canvas.plain_figure(&sky.file("environment-mapping.png"), &techniques, caption)?;
    canvas.command(&format!(
        "lobe env show bundled:{name} -o techniques.png\n\
         lobe env prefilter bundled:{name} -o rough.ktx2\n\
         lobe env prefilter bundled:{name} --lobe phong:30 --size 64 -o highlights.exr\n\
         lobe env dfg -o dfg.exr"
    ));
    Ok(())
}

/// One face of every level, all shown at the size of the first.
fn levels(side: usize, sky: &Sky, chain: &CubeMipChain) -> Picture {
    let tone = Tone::PHOTOGRAPH.fixed_for(&Picture::from(&sky.map));
    let face = |level: &CubeMap| {
        let at = |i: usize| (i as f64 + 0.5) / side as f64;
        // A face is the mirror image of a photograph: turn it around for the eye.
        let look = |x, y| level.radiance(cube::dir_from_face(0, 1.0 - at(x), at(y)));
        tone.apply(&Picture::from_fn(side, side, look))
    };
    let faces: Vec<Picture> = chain.levels().iter().map(face).collect();
    sheet(faces.len(), 4, [1.0; 3], &faces)
}

fn prefiltered(sky: &Sky) -> Result<CubeMipChain, GalleryError> {
    let [fine, size] = SIZES;
    let cube = resample(&sky.map, &Resample::to(Mapping::Cube, fine, Mapping::Cube.height_for(fine)), Job::default())?;
    let options = PrefilterOptions::default().size(size).last_size(LAST);
    Ok(prefilter_ggx(&cube.into_cube_map()?, &options, Job::default())?)
}
