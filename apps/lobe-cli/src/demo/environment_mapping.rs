//! Environment-mapping section of the demo: every technique under one photograph.

use lobe::env::{
    CubeMipChain, Mapping, PrefilterOptions, Resample, SunOptions, cube, extract_sun, prefilter_ggx, resample,
};
use lobe::image::{Picture, Sheet, Tone};
use lobe::io::Job;
use lobe::render::{EnvironmentSheetOptions, environment_mapping_sheet};
use lobe::sh::Rgb;

use super::{Sky, Writer, digits};

/// The size of the faces from which mirrors are blurred, and of the first level of the chain.
const SIZES: [usize; 2] = [256, 128];

/// The smallest level.
const LAST: usize = 8;

impl Writer<'_> {
    pub(super) fn environment_mapping(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        (self.progress)("prefiltered cube");
        let chain = prefiltered(sky)?;
        self.page.section(&format!("{name}: environment mapping, every technique beside the truth"));
        let file = sky.file("levels.png");
        let levels = self.levels(sky, &chain);
        self.write(&file, &levels, &Tone::PLAIN)?;
        self.page.figure(
            &file,
            levels.width(),
            "The cube that rough mirrors look up: the face towards +x of each level, from the mirror to roughness 1.",
        );
        let file = sky.file("environment-mapping.png");
        let samples = if self.ball < 100 { 2 } else { 3 };
        let options = EnvironmentSheetOptions::default().size(self.ball).samples(samples).prefiltered(&chain);
        let sheet = environment_mapping_sheet(&sky.map, &options, Job::default())?;
        self.write(&file, &sheet, &Tone::PLAIN)?;
        self.page.figure(&file, sheet.width(), "A ball and a torus; errors are measured over their visible surface.");
        self.page.command(&format!(
            "lobe env show bundled:{name} -o techniques.png\n\
             lobe env prefilter bundled:{name} -o rough.ktx2\n\
             lobe env prefilter bundled:{name} --lobe phong:30 --size 64 -o highlights.exr\n\
             lobe env dfg -o dfg.exr"
        ));
        Ok(())
    }

    /// One face of every level, all shown at the size of the first.
    fn levels(&self, sky: &Sky, chain: &CubeMipChain) -> Picture {
        let tone = Tone::PHOTOGRAPH.fixed_for(&Picture::from(&sky.map));
        let side = self.ball;
        let face = |level: &lobe::env::CubeMap| {
            let at = |i: usize| (i as f64 + 0.5) / side as f64;
            // A face is the mirror image of a photograph: turn it around for the eye.
            let look = |x, y| level.radiance(cube::dir_from_face(0, 1.0 - at(x), at(y)));
            tone.apply(&Picture::from_fn(side, side, look))
        };
        let faces: Vec<Picture> = chain.levels().iter().map(face).collect();
        Sheet { columns: faces.len(), margin: 4, background: [1.0; 3] }.compose(&faces)
    }

    /// The sun taken out of a photograph.
    pub(super) fn sun(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        (self.progress)("the sun");
        let Some(report) = extract_sun(&sky.map, &SunOptions::default()) else { return Ok(()) };
        let rest = report.rest.into_env_map()?;
        let tone = Tone::PHOTOGRAPH.fixed_for(&Picture::from(&rest));
        let file = sky.file("without-sun.png");
        let picture = Picture::from(&rest).resized(self.picture, self.picture / 2);
        self.write(&file, &picture, &tone)?;
        self.page.section(&format!("{name}: the sun as a light of its own"));
        self.page.figure(&file, self.picture, "The sky without its sun.");
        let sun = report.sun;
        let [before, after] = [sky.map.mean(), rest.mean()].map(Rgb::luminance);
        self.page.table(
            &["the sun", ""],
            &[
                vec!["towards".into(), sun.direction.to_array().map(digits).join("  ")],
                vec!["irradiance facing it, R G B".into(), sun.irradiance.to_array().map(digits).join("  ")],
                vec!["diameter".into(), format!("{}°", digits(sun.angular_diameter.to_degrees()))],
                vec!["its share of all light".into(), format!("{} %", digits(100.0 * (1.0 - after / before)))],
            ],
        );
        self.page.command(&format!("lobe env sun bundled:{name} -o sky-without-sun.exr"));
        Ok(())
    }
}

fn prefiltered(sky: &Sky) -> anyhow::Result<CubeMipChain> {
    let [fine, size] = SIZES;
    let cube = resample(&sky.map, &Resample::to(Mapping::Cube, fine, Mapping::Cube.height_for(fine)), Job::default())?;
    let options = PrefilterOptions::default().size(size).last_size(LAST);
    Ok(prefilter_ggx(&cube.into_cube_map()?, &options, Job::default())?)
}
