//! Basis section of the demo: the spherical harmonics as balloons and on cubes.

use lobe::image::Tone;
use lobe::render::{basis_balloons, basis_crosses};

use super::Writer;

impl Writer<'_> {
    pub(super) fn basis(&mut self) -> anyhow::Result<()> {
        self.page.section("The functions themselves");
        let balloons = basis_balloons(4, self.ball * 5 / 6);
        self.write("basis-balloons.png", &balloons, &Tone::PLAIN)?;
        self.page.figure(
            "basis-balloons.png",
            balloons.width(),
            "The real spherical harmonics of bands 0 to 3 as surfaces at distance |y(s)|: red where positive, blue where \
             negative. Rows are bands, columns m = -3 .. 3; +z is up. \
             The Condon-Shortley phase is kept: m = 1 of band 1 is positive towards -x.",
        );
        let crosses = basis_crosses(4, self.ball / 4);
        self.write("basis-crosses.png", &crosses, &Tone::PLAIN)?;
        self.page.figure(
            "basis-crosses.png",
            crosses.width(),
            "The same functions painted on the unfolded cube, with lines of equal value; green is zero.",
        );
        Ok(())
    }
}
