//! Section about the spherical harmonics as balloons and on cubes.

use lobe::figures::{basis_balloons, basis_crosses};

use crate::error::Drawn;
use crate::page::Canvas;

pub(crate) fn basis(canvas: &mut Canvas<'_>) -> Drawn {
    let ball = canvas.size.ball;
    canvas.plain_figure(
        "basis-balloons.png",
        &basis_balloons(4, ball * 5 / 6),
        "The real spherical harmonics of bands 0 to 3 as surfaces at distance |y(s)|: red where positive, blue where \
         negative. Rows are bands, columns m = -3 .. 3; +z is up. \
         The Condon-Shortley phase is kept: m = 1 of band 1 is positive towards -x.",
    )?;
    let caption = "The same functions painted on the unfolded cube, with lines of equal value; green is zero.";
    canvas.plain_figure("basis-crosses.png", &basis_crosses(4, ball / 4), caption)
}
